"""What the figures of ships share: style, colors, ship outlines, directions, saving."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Okabe & Ito's colors, which people with any color vision tell apart (https://jfly.uni-koeln.de/color); no yellow on white.
BLUE, VERMILLION, GREEN, PURPLE, SKY, ORANGE = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"

# Actuators by panel: {label: {quantity: (symbol, color, line style)}}.
ACTUATORS = {
    "rudder [deg]": {
        "delta": (r"$\delta$", BLUE, "-"),
        "delta_p": (r"$\delta_P$", VERMILLION, "-"),
        "delta_s": (r"$\delta_S$", BLUE, "--"),
    },
    "revolutions [1/s]": {
        "n_p": (r"$n_P$", BLUE, "-"),
        "n_bt": (r"$n_{BT}$", VERMILLION, "-"),
        "n_st": (r"$n_{ST}$", GREEN, "--"),
    },
}
VELOCITIES = {"u": "$u$ [m/s]", "vm": "$v_m$ [m/s]", "r": "$r$ [deg/s]"}
TIME = "$t$ [s]"

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
    cos, sin = np.cos(np.radians(psi_deg)), np.sin(np.radians(psi_deg))
    return np.column_stack((y0 + x * sin + y * cos, x0 + x * cos - y * sin))


def name_track_axes(axes):
    axes.set_xlabel("$y_0$, east [m]")
    axes.set_ylabel("$x_0$, north [m]")


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
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(temporary, format=kind, dpi=150, metadata=metadata)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
