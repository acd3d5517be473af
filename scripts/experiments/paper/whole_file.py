"""Files that appear whole or not at all, so that make never meets half a result."""

import json
import os


def write_text(path, text):
    temporary = path.with_name(f"{path.name}.tmp")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, path)


def write_json(path, value):
    write_text(path, json.dumps(value, indent=2) + "\n")
