"""What the figures of ships share: style, colors, ship outlines, directions, saving."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Okabe & Ito's colors, which people with any color vision tell apart (https://jfly.uni-koeln.de/color), less yellow.
BLUE, VERMILLION, GREEN, PURPLE, SKY, ORANGE = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"
COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, "black")

# Actuators by panel: {label: {quantity: (symbol, color, line style)}}.
ACTUATORS = {
    "rudder [deg]": {
        "delta": (r"$\delta$", BLUE, "-"),
        "delta_p": (r"$\delta_P$", VERMILLION, "-"),
        "delta_s": (r"$\delta_S$", BLUE, "--"),
    },
    "revolutions [1/s]": {
        "n_p": (r"$n_P$", BLUE, "-"),
        "n_bt": (r"$n_{BT}$", VERMILLION, "--"),
        "n_st": (r"$n_{ST}$", GREEN, ":"),
        "n_az1": (r"$n_{az1}$", BLUE, "-"),
        "n_az2": (r"$n_{az2}$", VERMILLION, "--"),
    },
    "pitch current [-]": {"i_bt": (r"$i_{BT}$", VERMILLION, "-")},
    "azimuth [deg]": {
        "az1": (r"az$_1$", BLUE, "-"),
        "az2": (r"az$_2$", VERMILLION, "--"),
    },
}
VELOCITIES = {"u": "$u$ [m/s]", "vm": "$v_m$ [m/s]", "r": "$r$ [deg/s]"}
TIME = "$t$ [s]"
START = dict(marker="o", markersize=4.5, markerfacecolor="white", linestyle="none")

plt.rcParams.update({
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "axes.axisbelow": True, "legend.frameon": False,
    "legend.fontsize": 8, "lines.solid_capstyle": "round", "svg.hashsalt": "leeway",
})


def outline(x0, y0, psi_deg, length, beam):
    """A ship seen from above, as (y0, x0) polygon: square stern, rounded bow."""
    bow = np.linspace(0.0, 1.0, 9)
    side_x = np.concatenate(([-0.5], 0.2 + 0.3 * np.sin(0.5 * np.pi * bow)))
    side_y = np.concatenate(([0.5], 0.5 * np.cos(0.5 * np.pi * bow)))
    x = length * np.concatenate((side_x, side_x[::-1]))
    y = beam * np.concatenate((side_y, -side_y[::-1]))
    return placed(x, y, x0, y0, psi_deg)


def arrowhead(x0, y0, psi_deg, length):
    """A heading, as (y0, x0) polygon."""
    x = length * np.array([0.5, -0.5, -0.25, -0.5])
    y = length * np.array([0.0, 0.3, 0.0, -0.3])
    return placed(x, y, x0, y0, psi_deg)


def placed(x, y, x0, y0, psi_deg):
    """Ship-fixed points at a pose, as (y0, x0)."""
    cos, sin = np.cos(np.radians(psi_deg)), np.sin(np.radians(psi_deg))
    return np.column_stack((y0 + x * sin + y * cos, x0 + x * cos - y * sin))


def thinned(*curves, bins=2000):
    """Indices of the samples that a drawing needs: of each bin the first, the last, each curve's lowest and highest.

    Curves of at most 4 bins samples stay whole. No two samples become neighbors that a gap (nan) lies between.
    """
    samples = len(curves[0])
    if samples <= 4 * bins:
        return np.arange(samples)
    size = -(-samples // bins)
    starts = np.arange(0, samples, size)
    kept = [starts, np.minimum(starts + size, samples) - 1]
    for curve in curves:
        rows = np.full((len(starts), size), np.nan)
        rows.flat[:samples] = curve
        for extreme in (np.where(np.isnan(rows), np.inf, rows).argmin(axis=1),
                        np.where(np.isnan(rows), -np.inf, rows).argmax(axis=1)):
            kept.append(np.minimum(starts + extreme, samples - 1))
    kept = np.unique(np.concatenate(kept))
    gaps = np.flatnonzero(np.isnan(curves).any(axis=0))
    if len(gaps) > 0:
        after = gaps[np.minimum(np.searchsorted(gaps, kept[:-1]), len(gaps) - 1)]
        kept = np.union1d(kept, after[(after >= kept[:-1]) & (after < kept[1:])])
    return kept


def plot_line(axes, x, y, **style):
    """A line over samples that may have gaps; a sample between two gaps is a dot."""
    chosen = thinned(x, y)
    x, y = x[chosen], y[chosen]
    axes.plot(x, y, **style)
    present = np.concatenate(([False], np.isfinite(x) & np.isfinite(y), [False]))
    alone = present[1:-1] & ~present[:-2] & ~present[2:]
    if alone.any():
        dots = {"color": style.get("color"), "zorder": style.get("zorder", 2)}
        axes.plot(x[alone], y[alone], linestyle="none", marker=".", markersize=3.0, markeredgewidth=0.0, **dots)


def name_track_axes(axes):
    axes.set_xlabel("$y_0$, east [m]")
    axes.set_ylabel("$x_0$, north [m]")


def plain(text):
    """A text that is not read as a formula."""
    return text.replace("$", r"\$")


def label(name):
    """A name in a legend, which takes no very long ones, and none with a leading underscore."""
    short = name if len(name) <= 56 else f"{name[:30]}...{name[-23:]}"
    return (" " if short.startswith("_") else "") + plain(short)


def mean_direction(*directions_deg):
    """The direction [deg] of the sum of unit vectors; missing samples are left out."""
    every = np.concatenate(directions_deg)
    return np.degrees(np.angle(np.nansum(np.exp(1j * np.radians(every)))))


def around(center_deg, direction_deg):
    """Directions within half a turn to either side of a center, so that a steady wind makes one band."""
    return center_deg - 180.0 + np.mod(direction_deg - center_deg + 180.0, 360.0)


def direction_scale(axes, ticks_deg):
    """Limits a vertical axis to the ticks, and writes them as directions from 0 to 360."""
    axes.set_ylim(ticks_deg[0], ticks_deg[-1])
    axes.set_yticks(ticks_deg, [f"{np.mod(tick, 360.0):g}" for tick in ticks_deg])


def save(figure, path):
    """Writes under a temporary name and renames, so that no half figure is ever met."""
    kind = path.suffix[1:]
    target = path.resolve() if path.is_symlink() else path  # a link keeps pointing to its target
    temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(temporary, format=kind, dpi=150, metadata=metadata)
        os.replace(temporary, target)
    except FileExistsError as error:
        raise OSError(error.errno, "a file stands where a folder is needed", str(path)) from error
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        if temporary.is_file():
            temporary.unlink()
