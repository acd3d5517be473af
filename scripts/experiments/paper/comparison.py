"""The table of docs/paper.md that lays the ensemble beside what a user would otherwise take."""

from claim import NAMES, number
from results import SAMPLINGS, SETS


def compared(results):
    """(model, scores of its metrics file, CPU seconds of its training or None) of each."""
    last = results.members
    ensemble = results.train_seconds("models/pool", last)
    yield "initial velocity held", "comparison/hold-scores", None
    yield "MMG, coefficients 10 to 20 % wrong", "comparison/start-scores", None
    yield "MMG, fitted to Train-B from there", "comparison/fitted-scores", results.train_seconds("comparison/fitted")
    yield "linear regression of accelerations", "comparison/linear-scores", results.train_seconds("comparison/linear")
    for kind in SAMPLINGS:
        yield f"ensemble, M = {last}, {NAMES[kind]}", f"sampling/{kind}-{last}-1", ensemble
    yield f"MMG 10 to 20 % wrong + ensemble (`--base`), M = {last}, TS∞", "comparison/residual-scores", results.train_seconds("models/residual", last)
    yield "*the true ship, inputs held*", "comparison/true-scores", None


def comparison_table(results):
    lines = ["| model | data set | L_Eucl | L_Maha | in the 50 % region | 90 % | 99 % | training [CPU s] |", "|---" * 8 + "|"]
    for model, file, seconds in compared(results):
        scores = results.scores(file)
        for row, data in enumerate(SETS):
            entry = scores[data]
            maha = "–" if entry["L_maha"] is None else number(entry["L_maha"])
            coverage = ["–" if entry["L_maha"] is None else f"{entry['coverage'][level]:.0%}" for level in ("50", "90", "99")]
            time = ("–" if seconds is None else f"{seconds:.3g}") if row == 0 else ""
            lines.append(f"| {model if row == 0 else ''} | {data} | {number(entry['L_eucl'])} | {maha} | {' | '.join(coverage)} | {time} |")
    return lines
