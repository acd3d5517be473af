"""Parts of a set of cases that are made, run and scored apart: 3/8 is the third of eight.

Each part has a folder of its own, OUT/shard-3-of-8, with its own keys and seal, so that no two jobs write to one; score takes them together."""

import argparse
import hashlib
import json
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
    """The folders of a run: its shards, or itself. ValueError where they are not parts of one set."""
    output = pathlib.Path(output)
    found = sorted(output.glob("shard-*-of-*"), key=lambda f: [int(x) for x in f.name.split("-")[1::2]])
    if not found:
        return [output]
    if (output / "keys.sha256").exists():
        raise ValueError(f"{output}: holds a set of its own beside shards; score one of them")
    designs = {}
    for folder in found:
        file = folder / "design.json"
        design = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        if design and design.get("shard") != "/".join(folder.name.split("-")[1::2]):
            raise ValueError(f"{folder}: its design is of the shard {design.get('shard')}")
        designs.setdefault(json.dumps({**design, "shard": folder.name.split("-")[3]}, sort_keys=True) if design else None, folder)
    designs.pop(None, None)
    if len(designs) > 1:
        one, other, *_ = designs.items()
        differ = [k for k, v in json.loads(one[0]).items() if json.loads(other[0]).get(k) != v]
        raise ValueError(f"{one[1]} and {other[1]} are not parts of one set: they differ in {', '.join(differ)}")
    return found
