"""The record of looks at the second house: docs/proof-looks.json, [{"family", "commit", "builds", "cases", "of"}].

Whoever has seen how a tool fares on the cases of a seed family can choose numbers by it, so a family is spent once it is scored, and the next
set is of the next one. Nobody may choose a number by a look."""

import json
import pathlib

FILE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "proof-looks.json"


class Spent(ValueError):
    """A seed family was looked at with another tool."""


def spent(file=FILE):
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else []


def next_family(file=FILE):
    """The first family that nobody has looked at."""
    return 1 + max((look["family"] for look in spent(file)), default=0)


def spend(family, commit, builds, cases, of, file=FILE):
    """Notes a look. One that sees more cases of the same family, by the same commit and the same builds of it (SHA-256) or more, replaces that before; Spent for
    another one."""
    for look in spent(file):
        if look["family"] == family and (look["commit"] != commit or not set(look.get("builds", [None])) <= set(builds)):
            raise Spent(f"seed family {family} was looked at before, with the tool of {look['commit'][:12]}: it is spent")
    rest = [look for look in spent(file) if (look["family"], look["commit"]) != (family, commit)]
    looks = sorted([*rest, {"family": family, "commit": commit, "builds": builds, "cases": cases, "of": of}], key=lambda look: (look["family"], look["commit"]))
    file.write_text(json.dumps(looks, indent=1) + "\n", encoding="utf-8")
    return looks


def table(looks):
    lines = ["| look | seed family | commit | cases |", "|---|---|---|---|"]
    return lines + [f"| {k + 1} | {look['family']} | {look['commit'][:12]} | {look['cases']} of {look['of']} |" for k, look in enumerate(looks)] if looks else ["No look has been taken yet."]
