"""Parts of a set of cases that are made, run and scored apart: 3/8 is the third of eight.

Each part has a folder of its own, OUT/shard-3-of-8, with its own keys and seal, so that no two jobs write to one; score takes them together."""

import argparse
import hashlib
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
    """Every n-th case of each family, in an order that knows nothing of how classes follow each other; parts are disjoint and make up the whole."""
    if shard is None:
        return list(cases)
    name = lambda case: case["id"] if isinstance(case, dict) else pathlib.Path(case).stem
    key = lambda case: (name(case).rsplit("-", 1)[0], hashlib.sha256(name(case).encode()).hexdigest())
    chosen = {name(case) for case in sorted(cases, key=key)[shard[0] - 1::shard[1]]}
    return [case for case in cases if name(case) in chosen]


def folders(output):
    """The folders of a run: its shards, or itself."""
    output = pathlib.Path(output)
    return sorted(output.glob("shard-*-of-*"), key=lambda f: [int(x) for x in f.name.split("-")[1::2]]) or [output]
