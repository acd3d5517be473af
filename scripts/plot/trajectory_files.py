"""Reads the tools' files (docs/formats.md) for figures: trajectories, predictions, columns maps, a ship's size.

Figures have m, m/s, degrees, degrees per second and 1/s; files are converted to them here. Errors are InputError
(a file's contents) and UsageError (what is asked for is not there); a file that cannot be opened raises OSError.
"""

import csv
import json
import math
import pathlib
import sys

import numpy as np

from command_line import InputError, UsageError

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"

# Quantities as in docs/formats.md: base name -> factors to the figures' unit from the units that files may have.
ANGLE = {"deg": 1.0, "rad": math.degrees(1.0)}
RATE = {"degps": 1.0, "radps": math.degrees(1.0)}
SPEED = {"mps": 1.0, "kn": 1852.0 / 3600.0}
QUANTITIES = {
    "t": {"s": 1.0},
    "u": SPEED,
    "vm": SPEED,
    "r": RATE,
    "x0": {"m": 1.0},
    "y0": {"m": 1.0},
    "psi": ANGLE,
    "delta": ANGLE,
    "delta_p": ANGLE,
    "delta_s": ANGLE,
    "n_p": {"rps": 1.0},
    "n_bt": {"rps": 1.0},
    "n_st": {"rps": 1.0},
    "i_bt": {"": 1.0},
    "n_az1": {"rps": 1.0},
    "az1": ANGLE,
    "n_az2": {"rps": 1.0},
    "az2": ANGLE,
    "wind_speed": SPEED,
    "wind_dir": ANGLE,
    "app_wind_speed": SPEED,
    "app_wind_dir": ANGLE,
}
REQUIRED = ("t", "u", "vm", "r")
PREDICTION_COLUMNS = (
    "recording,sequence,step,t_s,particle,member,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps".split(",")
)


def read_text(file):
    """The text of a file, or of the standard input for '-'."""
    if file == "-":
        data = sys.stdin.buffer.read()
    else:
        with open(file, "rb") as stream:
            data = stream.read()
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(f"{file}:{line}: not UTF-8 text") from error


def split(line):
    """The fields of a record."""
    return line.split(",") if '"' not in line else next(csv.reader([line]))


class Table:
    """A CSV file: `header` with the columns' names, and the records below it."""

    def __init__(self, file):
        self.file = file
        self.records = []
        self.line_numbers = []
        text = read_text(file)
        lines = enumerate(text.split("\n"), start=1)
        for number, line in lines:
            if line and not line.startswith("#"):
                self.header = [name.strip() for name in split(line)]
                break
        else:
            raise InputError(f"{file}: the file is empty, expected a header row")
        for i, name in enumerate(self.header):
            if not name:
                raise InputError(f"{file}:{number}: column {i + 1} has no name")
            if name in self.header[:i]:
                raise InputError(f"{file}:{number}: column '{name}' stands twice")
        quoted = '"' in text
        commas = len(self.header) - 1
        for number, line in lines:
            if not line:
                continue
            start = number
            while quoted and line.count('"') % 2 == 1:  # a line end inside a field
                number, rest = next(lines, (number, None))
                if rest is None:
                    raise InputError(f"{file}:{start}: a quotation mark is not closed")
                line += " " + rest
            if line.count(",") != commas and len(split(line)) != commas + 1:
                raise InputError(f"{file}:{start}: expected {commas + 1} fields, found {len(split(line))}")
            self.records.append(line)
            self.line_numbers.append(start)
        if not self.records:
            raise InputError(f"{file}: no data row below the header")

    def texts(self, column):
        """The fields of one column."""
        index = self.header.index(column)
        return [split(record)[index].strip() for record in self.records]

    def numbers(self, columns, missing=frozenset(), rows=None):
        """The named columns of all or some rows as (rows, columns); nan where a field is one of the texts `missing`."""
        indices = [self.header.index(column) for column in columns]
        rows = range(len(self.records)) if rows is None else rows
        records = [self.records[row] for row in rows]
        if all(finite(text) is None for text in missing):
            try:
                values = np.loadtxt(records, delimiter=",", quotechar='"', comments=None, usecols=indices, ndmin=2)
                if np.isfinite(values).all():
                    return values
            except ValueError:
                pass
        # Some field is missing or wrong: slower, one by one.
        values = np.full((len(records), len(columns)), np.nan)
        for k, record in enumerate(records):
            fields = split(record)
            for j, i in enumerate(indices):
                text = fields[i].strip()
                if text in missing:
                    continue
                value = finite(text)
                if value is None:
                    where = f"{self.file}:{self.line_numbers[rows[k]]}: column '{columns[j]}'"
                    raise InputError(f"{where}: expected a finite number, got '{text[:40]}'")
                values[k, j] = value
        return values


def finite(text):
    """The finite number that a field holds, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def split_name(column):
    """'psi_rad' -> ('psi', 'rad'); (None, None) for a column that is not ours."""
    for quantity, units in QUANTITIES.items():
        for unit in units:
            if column == (f"{quantity}_{unit}" if unit else quantity):
                return quantity, unit
    return None, None


def find_config(folder, name):
    """The path of a JSON file: `name` itself, or the shipped one of that name in configs/<folder>."""
    if "/" in name or name.endswith(".json") or pathlib.Path(name).is_file():
        return name
    shipped = CONFIGS / folder / f"{name}.json"
    if not shipped.is_file():
        known = ", ".join(sorted(path.stem for path in shipped.parent.glob("*.json")))
        missing = f"no file '{name}', and no shipped configuration of that name in configs/{folder}"
        raise UsageError(f"{missing}; shipped: {known}")
    return str(shipped)


def read_json(file):
    """The object in a JSON file."""
    try:
        value = json.loads(read_text(file))
    except json.JSONDecodeError as error:
        raise InputError(f"{file}:{error.lineno}:{error.colno}: not valid JSON: {error.msg}") from error
    if not isinstance(value, dict):
        raise InputError(f"{file}: expected an object")
    return value


def read_ship_size(name):
    """Length and beam [m] from a ship JSON, or the shipped one of that name."""
    file = find_config("ships", name)
    particulars = read_json(file).get("particulars")
    if not isinstance(particulars, dict):
        raise InputError(f"{file}: /particulars: expected an object with L_pp_m and B_m")
    size = []
    for key in ("L_pp_m", "B_m"):
        value = particulars.get(key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < math.inf:
            found = "missing" if key not in particulars else f"got {json.dumps(value)[:40]}"
            raise InputError(f"{file}: /particulars/{key}: expected a number > 0 [m], {found}")
        size.append(float(value))
    return tuple(size)


def ship_size(arguments):
    """Length and beam [m] of the ship that --ship, --length-m and --beam-m name; None where they do not."""
    length, beam = read_ship_size(arguments.ship) if arguments.ship else (None, None)
    if arguments.length_m:
        length, beam = arguments.length_m, beam and beam * arguments.length_m / length
    if length is None:
        if arguments.beam_m:
            raise UsageError("--beam-m needs the ship's length: --length-m or --ship")
        return None
    return length, arguments.beam_m or beam or length / 6.2


class ColumnsMap:
    """Names of a foreign recording's columns, from a map's file or a shipped map's name."""

    def __init__(self, name):
        self.file = find_config("columns", name)
        self.columns = {}  # foreign name -> (quantity, factor)
        entries = read_json(self.file)
        missing = entries.get("missing", [])
        if not isinstance(missing, list) or not all(isinstance(text, str) for text in missing):
            raise InputError(f"{self.file}: /missing: expected an array of texts")
        self.missing = {text.strip() for text in missing}
        for key, entry in entries.items():
            if key in ("description", "source", "missing"):
                continue
            where = f"{self.file}: /{key}"
            quantity, unit = split_name(key)
            if quantity is None:
                raise InputError(f"{where}: unknown column name; docs/formats.md lists the names")
            if isinstance(entry, dict):
                for inner in entry:
                    if inner not in ("from", "unit"):
                        raise InputError(f"{where}/{inner}: unknown key; known here: from, unit")
                unit = entry.get("unit", unit)
                entry = entry.get("from")
            if not isinstance(entry, str):
                raise InputError(f"{where}: expected a column's name, or an object with it in 'from'")
            if unit not in QUANTITIES[quantity]:
                raise InputError(f"{where}/unit: unknown unit '{unit}'; known: {', '.join(QUANTITIES[quantity])}")
            if entry in self.columns:
                raise InputError(f"{where}: the column '{entry}' is already taken by another key")
            self.columns[entry] = (quantity, QUANTITIES[quantity][unit])

    def name_of(self, quantity):
        """The foreign name of a quantity, None where the map has none."""
        return next((name for name, (found, _) in self.columns.items() if found == quantity), None)


def is_prediction(table):
    return all(column in table.header for column in PREDICTION_COLUMNS)


def read_trajectory(table, columns_map=None):
    """{quantity: values} of a trajectory, its heading unwrapped; nan is a missing sample.

    A columns map serves the files that have its columns, so that a foreign recording and leeway's own files can be
    read by one command. Rows of missing fields only are passed over.
    """
    ours = {name: split_name(name) for name in table.header}
    columns = {name: (quantity, QUANTITIES[quantity][unit]) for name, (quantity, unit) in ours.items() if quantity}
    missing = {""}
    if columns_map is not None:
        foreign = {name: columns_map.columns[name] for name in table.header if name in columns_map.columns}
        if has_required(foreign) or not has_required(columns):
            columns = foreign
            missing |= columns_map.missing
    place = {}
    for name, (quantity, _) in columns.items():
        if quantity in place:
            raise InputError(f"{table.file}:1: column '{name}': holds the same quantity as column '{place[quantity]}'")
        place[quantity] = name
    for quantity in REQUIRED:
        if quantity not in place:
            expected = columns_map.name_of(quantity) if columns_map else None
            what = f"no column '{expected}' for {quantity}" if expected else f"no column for {quantity}"
            hint = "" if columns_map else "; a foreign recording needs --columns"
            raise InputError(f"{table.file}:1: {what}; found {', '.join(table.header)}{hint}")

    values = table.numbers(list(columns), missing)
    result = {quantity: factor * column for (quantity, factor), column in zip(columns.values(), values.T)}
    time = result["t"]
    timed = np.isfinite(time)
    for row in np.flatnonzero(~timed):
        if any(field.strip() not in missing for field in split(table.records[row])):
            where = f"{table.file}:{table.line_numbers[row]}: column '{place['t']}'"
            raise InputError(f"{where}: expected a finite number [s], got a missing sample")
    if not timed.any():
        raise InputError(f"{table.file}: no data row below the header")
    late = np.flatnonzero(np.diff(time[timed]) <= 0.0)
    if len(late):
        before, after = time[timed][late[0] : late[0] + 2]
        where = f"{table.file}:{table.line_numbers[np.flatnonzero(timed)[late[0] + 1]]}: column '{place['t']}'"
        raise InputError(f"{where}: time must increase, but {after:g} s follows {before:g} s")
    result = {quantity: column[timed] for quantity, column in result.items()}
    if "psi" in result:
        result["psi"] = unwrapped(result["psi"])
    return result


def has_required(columns):
    quantities = [quantity for quantity, _ in columns.values()]
    return all(quantity in quantities for quantity in REQUIRED)


def read_prediction(table, recording=None, wanted=None):
    """Name of the recording, and {sequence: {column: (steps, particles)}}, with t_s as (steps,).

    A file of several recordings needs the name of one; without the numbers that are wanted all sequences are read.
    """
    for column in PREDICTION_COLUMNS:
        if column not in table.header:
            raise InputError(f"{table.file}:1: no column '{column}'; found {', '.join(table.header)}")
    names = table.texts("recording")
    known = list(dict.fromkeys(names))
    if recording is None:
        if len(known) > 1:
            raise UsageError(f"{table.file} holds several recordings; choose one with --recording: {', '.join(known)}")
        recording = known[0]
    if recording not in known:
        raise UsageError(f"{table.file} holds no recording '{recording}'; it holds {', '.join(known)}")
    rows = [row for row, name in enumerate(names) if name == recording]
    columns = PREDICTION_COLUMNS[1:]
    values = table.numbers(columns, rows=rows)
    of_sequence = values[:, columns.index("sequence")]
    sequences = np.unique(of_sequence)
    if wanted is not None:
        for number in wanted:
            if number not in sequences:
                known = ", ".join(f"{number:g}" for number in sequences)
                raise UsageError(f"{table.file}: recording '{recording}' has no sequence {number}; it has {known}")
        sequences = np.array(wanted)

    result = {}
    for number in sequences:
        chosen = np.flatnonzero(of_sequence == number)
        flat = dict(zip(columns, values[chosen].T))
        steps, step = np.unique(flat["step"], return_inverse=True)
        particles, particle = np.unique(flat["particle"], return_inverse=True)
        grids = {}
        for name, column in flat.items():
            grids[name] = np.full((len(steps), len(particles)), np.nan)
            grids[name][step, particle] = column
        _, first = np.unique(step * len(particles) + particle, return_index=True)
        if len(first) < len(chosen):
            row = np.setdiff1d(np.arange(len(chosen)), first)[0]
            line = table.line_numbers[rows[chosen[row]]]
            what = f"sequence {number:g}, step {flat['step'][row]:g}, particle {flat['particle'][row]:g}"
            raise InputError(f"{table.file}:{line}: {what}: stands twice")
        grids["t_s"] = np.nanmin(grids["t_s"], axis=1)
        result[int(number)] = grids
    return recording, result


def unwrapped(angle_deg):
    """An angle's history without jumps of a turn, over missing samples."""
    result = angle_deg.copy()
    good = np.isfinite(result)
    result[good] = np.degrees(np.unwrap(np.radians(result[good])))
    return result
