"""Parts of a set of cases that are made, run and scored apart: 3/8 is the third of eight.

Each part has a folder of its own, OUT/shard-3-of-8, with its own keys and seal, so that no two jobs write to one; score takes them together."""

import argparse
import gzip
import hashlib
import json
import pathlib
import zlib


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


def parts(output):
    """The parts of a set: folders of its shards, files of those that were kept (judged.py), or its own folder. ValueError where they are not of one set."""
    output = pathlib.Path(output)
    if output.is_file():
        return [output]
    number = lambda f: [int(x) for x in f.name.split(".")[0].split("-")[1::2]]
    found = sorted((f for f in output.glob("shard-*-of-*") if f.is_dir() or f.name.endswith(".json.gz")), key=number)
    if not found:
        return [output]
    if (output / "keys.sha256").exists():
        raise ValueError(f"{output}: holds a set of its own beside shards; score one of them")
    designs, seen = {}, {}
    for part in found:
        shard = "/".join(map(str, number(part)))
        design = design_of(part)
        if design and design.get("shard") != shard:
            raise ValueError(f"{part}: its design is of the shard {design.get('shard')}")
        if shard in seen:
            raise ValueError(f"{part} and {seen[shard]} are the same shard; take one away")
        seen[shard] = part
        designs.setdefault(json.dumps({**design, "shard": shard.split("/")[1]}, sort_keys=True) if design else None, part)
    designs.pop(None, None)
    if len(designs) > 1:
        one, other, *_ = designs.items()
        differ = [k for k, v in json.loads(one[0]).items() if json.loads(other[0]).get(k) != v]
        raise ValueError(f"{one[1]} and {other[1]} are not parts of one set: they differ in {', '.join(differ)}")
    return found


def design_of(part):
    """What was asked of generate; {} where nothing was made yet."""
    if part.is_dir():
        file = part / "design.json"
        return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    try:
        return json.loads(gzip.decompress(part.read_bytes()))["design"]
    except (OSError, EOFError, KeyError, TypeError, UnicodeDecodeError, json.JSONDecodeError, zlib.error):
        return {}  # judged.read says what is wrong
