"""Parts of a set of cases that are made, run and scored apart: 3/8 is the third of eight.

Each part has a folder of its own, OUT/shard-3-of-8, with its own keys and seal, so that no two jobs write to one; score takes them together."""

import argparse
import pathlib


def parsed(text):
    """(3, 8) of "3/8"."""
    try:
        k, n = (int(x) for x in text.split("/"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected K/N, such as 3/8, got {text!r}") from None
    if not 1 <= k <= n:
        raise argparse.ArgumentTypeError(f"expected K from 1 to N, got {text!r}")
    return k, n


def part(cases, shard):
    """Every n-th case, so that all parts have some of each family; parts are disjoint and make up the whole."""
    return list(cases) if shard is None else list(cases)[shard[0] - 1::shard[1]]


def folders(output):
    """The folders of a run: its shards, or itself."""
    output = pathlib.Path(output)
    return sorted(output.glob("shard-*-of-*"), key=lambda f: [int(x) for x in f.name.split("-")[1::2]]) or [output]
