"""The plot scripts' side of the command line: checks of options, errors of one line each, the tools' exit codes."""

import argparse
import math
import pathlib
import sys

FIGURE_SUFFIXES = (".png", ".svg", ".pdf")


class UsageError(Exception):
    """The command line asks for what is not there: exit code 2."""


class InputError(Exception):
    """A file's contents are wrong: exit code 3."""


class Parser(argparse.ArgumentParser):
    """Answers a wrong command line with one line, as the tools do."""

    def error(self, message):
        self.exit(2, f"{self.prog}: error: {message}. Try '{self.prog} --help'.\n")


def number(text) -> float:
    """A finite number, as type= of an option."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"expected a finite number, got '{text}'")
    return value


def positive(text) -> float:
    """A number > 0, as type= of an option."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"expected a number > 0, got {text}")
    return value


def count(text) -> int:
    """A whole number >= 0, as type= of an option."""
    if not (text.isascii() and text.isdigit()):
        raise argparse.ArgumentTypeError(f"expected a whole number >= 0, got '{text}'")
    return int(text)


def figure_file(text) -> pathlib.Path:
    """The path of a figure, as type= of an option; its end says the format."""
    path = pathlib.Path(text)
    if path.suffix not in FIGURE_SUFFIXES:
        raise argparse.ArgumentTypeError(f"the output must end with {', '.join(FIGURE_SUFFIXES)}, got '{text}'")
    return path


def add_figure_options(parser):
    """The options that every figure of ships has."""
    parser.add_argument("-o", "--output", metavar="FILE", required=True, type=figure_file,
                        help="figure: .png, .svg or .pdf")
    parser.add_argument("--columns", metavar="MAP",
                        help="columns map of foreign recordings: a file or a shipped map's name")
    parser.add_argument("--ship", metavar="SHIP", help="ship JSON, or the name of a shipped one: size of the outlines")
    parser.add_argument("--length-m", metavar="L", type=positive, help="length of the ship [m] (default: of --ship)")
    parser.add_argument("--beam-m", metavar="B", type=positive,
                        help="beam of the ship [m] (default: of --ship, or L/6.2)")
    parser.add_argument("--title", help="title of the figure")


def run(program, draw) -> int:
    """Calls draw() and turns its errors into one line and an exit code."""
    try:
        draw()
    except UsageError as error:
        return report(program, error, 2)
    except InputError as error:
        return report(program, error, 3)
    except OSError as error:
        return report(program, f"{error.filename}: {error.strerror}" if error.filename else error, 4)
    return 0


def report(program, problem, exit_code) -> int:
    print(f"{program}: error: {problem}", file=sys.stderr)
    return exit_code
