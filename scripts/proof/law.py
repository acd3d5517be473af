"""The law that generated a case, as somebody knows it who has read campaign.py but not the key.

    scene = Scene(key, track)                 a case's track, spectra, gradients of coefficients, constants of forms
    scene.change(name, level, plans)          changes of accelerations (or kinematic residuals) by a class, whitened: (plans, numbers)
    Deck(scene, name, level)                  a class as a mixture of components: nodes, coefficients, tangents (see bayes.py)

Known: the track, the noise, the model error's size, level and ship, whether there is a wind column, and the laws of everything else.
Hidden: the class (and with it the family), shape and strength, how wrong the coefficients are, which member of the level 2 forms it is.
All is linear in coefficients and forms at the truth. Strength: d' of 3, 6, 12 or 30 up to what is plausible, as campaign.py seeks it, within SPREAD.
Left out: how a gust turned out in wind that is nowhere recorded, feedback on the track, faults of sensors in the accelerations.
"""

import json
import math

import numpy as np

import campaign
import model as m
import physics
import recording
import separability as sep

SPREAD = 0.15  # log-sd of d' about what is sought: campaign.py corrects where it misses by more than 0.3
RING = 12  # directions of a class that acts in one
SHAPES = 6  # draws of a shape that is neither sign nor direction
GRID = (0.01, 0.05, 0.2, 0.5, 1.0)  # of the largest plausible strength, between which d' is interpolated
OUTSIDE_KEYS = {"hs", "wave_from", "bank_CY", "bank_CN", "bank_D", "bank_dir", "tug", "tug_dir", "tug_x", "tug_start", "tug_end", "moor_k", "moor_x", "moor_y",
                "moor_l", "fender_k", "fender_D", "fender_dir", "magnet", "magnet_x", "magnet_y", "body_X", "body_Y", "body_N", "earth_X", "earth_Y", "ice", "tank",
                "flutter", "stiction"}
DIRECTED = ("steady-current", "unmeasured-wind", "wave-drift", "body-force", "earth-force", "lever-arm")
DRAWN = ("varying-current", "bank", "tug", "mooring", "fender", "rudder-stall", "magnetic-tether")
UNKNOWN = "unknown"
# Coefficients that the tool frees beyond those that the truth draws (docs/gap-locate.md): place in the ship file, log-sd that it states of them.
FREED = {"single": ((("hull", "X_0A"), 0.1), (("propeller", "K_T", 1), 0.1), (("propeller", "K_T", 2), 0.1), (("propeller", "w_P", 1), 0.2), (("propeller", "w_P", 2), 0.2),
                    (("propeller", "K_T_reversed", 0), 0.1), (("rudder", "t_R"), 0.2), (("rudder", "x_H"), 0.1), (("rudder", "epsilon"), 0.05), (("rudder", "k_x"), 0.1),
                    (("rudder", "gamma_R_negative"), 0.2), (("rudder", "gamma_R_positive"), 0.2)),
         "vectwin": ((("hull", "X_0A"), 0.1), (("propeller", "K_T_ahead", 1), 0.1), (("propeller", "K_T_ahead", 2), 0.1), (("propeller", "a", 1), 0.1),
                     (("propeller", "a", 2), 0.1), (("propeller", "b", 0), 0.2), (("propeller", "c", 1), 0.1), (("propeller", "c", 2), 0.1), (("propeller", "d", 0), 0.2),
                     (("rudder", "k_x"), 0.1))}
FREED_FORMS = {"resistance_power": 0.1, "rudder_curve": 2.0}  # its hull.resistance_slow; its rudder.gain_35deg, 0.2 of C_N where the curves differ by a tenth


def near(name, shape, scene):
    """Neighbors of a drawn shape, each one step off in one of its numbers, and the probability that the law puts a shape within such steps."""
    L, turn = scene.L, 2.0 * math.pi
    moved = lambda **new: {**shape, **new}
    cell = lambda step, width: min(1.0, step * math.sqrt(turn) / width)
    if name == "tug":
        length = shape["end"] - shape["start"]
        return [moved(angle=shape["angle"] + 0.2), moved(start=shape["start"] + 0.02 * scene.duration), moved(end=shape["end"] + 0.02 * scene.duration)], \
            0.5 * cell(0.2, turn) * cell(0.02, 0.35) * cell(0.02, 0.15) * (1.0 if length > 0 else 0.0)
    if name == "varying-current":
        return [moved(w=shape["w"] * 1.05), moved(phase=shape["phase"] + 0.2)], cell(0.05 * shape["w"], turn / 100.0 - turn / 300.0) * cell(0.2, 6.28)
    if name == "bank":
        angle = shape["angle"] + 0.1
        x, y = scene.track["x"], scene.track["y"]
        return [moved(angle=angle, D=float(np.max(x * math.cos(angle) + y * math.sin(angle))) + 0.25 * L)], cell(0.1, turn)
    if name in ("mooring", "magnetic-tether"):
        middle = float(np.mean(scene.track["x"])), float(np.mean(scene.track["y"]))
        angle = math.atan2(shape["y"] - middle[1], shape["x"] - middle[0]) + 0.1
        x, y = middle[0] + L * math.cos(angle), middle[1] + L * math.sin(angle)
        there = moved(x=x, y=y, farthest=float(np.max(np.hypot(scene.track["x"] - x, scene.track["y"] - y))))
        if name == "magnetic-tether":
            return [there], cell(0.1, turn)
        return [there, moved(stiffness=shape["stiffness"] * 1.2)], cell(0.1, turn) * cell(0.2 * shape["stiffness"], 1.5)
    if name == "fender":
        return [moved(reach=shape["reach"] + 0.02 * L), moved(stiffness=shape["stiffness"] * 1.2)], cell(0.05, turn) * cell(0.2 * shape["stiffness"], 1.5)
    return [moved(angle=shape["angle"] + 1.5)], cell(1.5, 10.0)  # rudder-stall


class Scene:
    def __init__(self, key, track):
        self.key, self.level, self.ship_name = key, key["level"], key["ship"]
        self.ship = m.read_ship(self.ship_name)
        self.T, self.L = physics.scale(self.ship), self.ship["particulars"]["L_pp_m"]
        self.track = {k: track[k] for k in track.files if k not in ("t", "channels")}
        self.track["t"], self.track["channels"] = track["t"], tuple(str(c) for c in track["channels"])
        self.R, self.n, self.duration = key["trains"], len(track["t"]), float(track["t"][-1])
        self.factors, self.forms = key["factors"], key["forms"]
        self.noise, self.tau = key["noise"], key["tau_s"]
        self.has_column = key["wind"] == "measured"
        R = self.R
        one = lambda a: a[..., :R, :].reshape(*a.shape[:-2], 1, -1)
        self.states = {k: one(self.track[k]) for k in ("x", "y", "psi", "u", "v", "r", "q")} | {"t": np.tile(self.track["t"], R)[None]}
        self.acts = {c: one(self.track[f"a_{c}"]) for c in self.track["channels"]}
        self.wind = (one(self.track["wx"]), one(self.track["wy"])) if self.has_column else (np.zeros((1, R * self.n)),) * 2
        self.columns = [recording.columns_of(self.track, r) for r in range(R)]
        self.omega, self.kin_S = sep.kinematic_spectra(self.track["t"], self.noise, self.T)
        self.plain = [sep.kinematic_residuals(c) for c in self.columns]
        self.base = {level: self.accelerations(level) for level in {1, self.level}}
        self.gradients = {level: np.concatenate([self.accelerations(level, factors={**self.factors, k: self.factors[k] * math.exp(sep.STEP)}) - self.base[level]
                                                 for k in m.FACTORS]) / sep.STEP for level in {1, self.level}}
        error = np.array([key["error"], key["error"], key["error"] / (0.25 * self.L)])
        self.lack = self.base[self.level] - self.base[1]
        flat = lambda a: np.moveaxis(a, 1, 0).reshape(3, len(a), -1)
        structural = sep.left_after_refit(flat(self.lack)[:, 0], np.moveaxis(flat(self.gradients[self.level]), 0, 1)) if self.level == 2 else np.zeros(3)
        own = {k: track[k] for k in ("t",)}
        self.truths_S = sep.spectra(own, self.noise, self.T, error, self.tau, self.L)[1]
        self.tools_S = sep.spectra(own, self.noise, self.T, np.hypot(error, structural), self.tau, self.L)[1]
        self.measured_S = sep.spectra(own, self.noise, self.T, np.zeros(3), self.tau, self.L)[1]

    # --- accelerations ---------------------------------------------------------------------------------------------
    def accelerations(self, level, effects=None, wind=None, acts=None, factors=None, forms=None, raw=False):
        """(N, 3, recordings, samples); without `forms` the center of their law."""
        truth = m.Model(self.ship, level, factors or self.factors, effects or {}, forms)
        a = truth.change_by_outside(self.states, self.acts) if raw else truth.accelerations(self.states, acts or self.acts, wind or self.wind)
        n = max(np.shape(x)[0] if np.ndim(x) == 2 else 1 for x in a)
        return np.stack([np.broadcast_to(x, (n, self.R * self.n)) for x in a], 1).reshape(n, 3, self.R, self.n)

    def structure(self):
        """Change of accelerations by one standard deviation of each constant of the level 2 forms."""
        if self.level == 1:
            return np.zeros((0, 3, self.R, self.n))
        return np.concatenate([0.5 * (self.accelerations(2, forms={**m.FORM_CENTER, k: c + sd}) - self.accelerations(2, forms={**m.FORM_CENTER, k: c - sd}))
                               for k, (c, sd) in m.FORMS.items()])

    def freed(self):
        """Changes by one standard deviation of what else the tool frees, in its forms."""
        rows = []
        for path, sd in FREED["vectwin" if self.ship["rudder"]["type"].startswith("vectwin") else "single"]:
            ship = json.loads(json.dumps(self.ship))
            place = ship
            for word in path[:-1]:
                place = place[word]
            place[path[-1]] *= 1.01
            own, self.ship = self.ship, ship
            rows.append((self.accelerations(1) - self.base[1]) * sd / 0.01)
            self.ship = own
        if self.level == 2:
            structure = dict(zip(m.FORMS, self.structure()))
            rows += [structure[k][None] * sd / m.FORMS[k][1] for k, sd in FREED_FORMS.items()]
        return np.concatenate(rows)

    def own_structure(self):
        """Standard normal numbers of the case's own member of the forms."""
        return np.array([(self.forms[k] - c) / sd for k, (c, sd) in m.FORMS.items()]) if self.level == 2 else np.zeros(0)

    def change(self, name, level, plans, forms=None):
        """(plans, 3, recordings, samples): change of accelerations, for a sensor's fault of kinematic residuals, by plans of (shape, strength)."""
        effect = physics.ALL.get(name)
        if name in physics.SENSORS:
            return np.stack([np.stack([sep.kinematic_residuals(recording.with_faults(c, effect.at(s, shape, self.ship)[1])) - p
                                       for c, p in zip(self.columns, self.plain)], 1) for shape, s in plans])
        if name == "unmeasured-wind":
            wind = [np.array([[s * self.T * f(shape["angle"])] for shape, s in plans]) * np.ones(self.R * self.n) for f in (math.cos, math.sin)]
            return self.accelerations(level, wind=wind, forms=forms) - self.accelerations(level, forms=forms)
        if name in ("anemometer", "convention"):
            out = []
            for shape, s in plans:
                faulty = [recording.with_faults(c, {"wind_to": True} if name == "convention" else effect.at(s, shape, self.ship)[1]) for c in self.columns]
                U, xi = (np.concatenate([c[k] for c in faulty]) for k in ("wind_speed_mps", "wind_dir_deg"))
                out.append(np.stack([U * np.cos(np.radians(xi)), U * np.sin(np.radians(xi))]))
            wind = np.stack(out, 1)
            return self.accelerations(level, forms=forms) - self.accelerations(level, wind=(wind[0], wind[1]), forms=forms)
        numbers = [effect.at(s, {**shape, "level": level}, self.ship)[0] for shape, s in plans]
        keys = sorted({k for x in numbers for k in x})
        effects = {k: np.array([[x.get(k, m.NEUTRAL[k])] for x in numbers], float) for k in keys}
        if name == "tug":  # one recording only
            effects["tug"] = effects["tug"] * (np.arange(self.R * self.n) < self.n)
        if set(keys) <= OUTSIDE_KEYS:
            return self.accelerations(level, effects, raw=True, forms=forms)
        acts = None
        if effect.kind == "actuator":
            late = [[sep.acting(self.track, r, x) for r in range(self.R)] for x in numbers]
            acts = {c: np.stack([np.concatenate([a[c][0] for a in rows]) for rows in late]) for c in self.track["channels"]}
        return self.accelerations(level, effects, acts=acts, forms=forms) - self.accelerations(level, forms=forms)

    # --- whitened --------------------------------------------------------------------------------------------------
    def white(self, a, S):
        """(N, numbers) of (N, 3, recordings, samples), noise of one by unit spectra S by axis."""
        numbers = self.R * 2 * len(self.omega)
        if S is not self.kin_S:
            a = sep.seen(a)
        return np.concatenate([sep.whitened(a[:, axis], self.omega, S[axis]).reshape(len(a), numbers) for axis in range(3)], 1)

    def primes(self, name, changes):
        """d' of changes, as campaign.py computes it."""
        if name in physics.SENSORS:
            return np.sqrt(np.sum(self.white(changes, self.kin_S) ** 2, 1))
        if not hasattr(self, "_project"):
            X = self.white(self.gradients[self.level], self.tools_S)
            self._project = X, np.linalg.inv(np.linalg.cholesky(X @ X.T + np.diag([1.0 / m.PRIOR[k] ** 2 for k in m.FACTORS]))).T
        X, root = self._project
        y = self.white(changes, self.tools_S)
        return np.sqrt(np.maximum(np.sum(y * y, 1) - np.sum((y @ X.T @ root) ** 2, 1), 1e-12))

    def shapes(self, name, rng):
        """Shapes of a class: (list, number in each ring of directions or 1)."""
        effect = physics.ALL.get(name)
        if effect is None:
            return [{}], 1
        if name in DIRECTED:
            return [{"angle": 2.0 * math.pi * k / RING} for k in range(RING)], RING
        if name == "rudder-effectiveness":
            return [{"which": w} for w in (("k_R", "k_P", "k_S") if self.ship["rudder"]["type"].startswith("vectwin") else ("k_R",))], 1
        if name == "shallow-water":
            return [{"slack": [0.0] * 6, "level": self.level}], 1
        if name == "rudder-stall":
            return [{"angle": a} for a in np.linspace(12.8, 21.2, SHAPES)], 1
        if name in DRAWN:
            reach = {**{k: self.track[k] for k in ("x", "y", "psi")}, "duration": self.duration}
            drawn = [effect.draw(rng, self.ship, reach) for _ in range(SHAPES)]
            if name == "tug":
                return [{**d, "angle": 2.0 * math.pi * k / 8} for d in drawn for k in range(8)], 8
            return drawn, 1
        half = {1: effect.at(0.3 * effect.most, {"sign": 1.0}, self.ship), -1: effect.at(0.3 * effect.most, {"sign": -1.0}, self.ship)}
        return [{"sign": float(s)} for s in (1, -1)] if half[1] != half[-1] else [{"sign": 1.0}], 1

    def eligible(self, name):
        """Weight of a class for this ship and wind column, as the design deals it."""
        effect = physics.ALL.get(name)
        if name == "convention":
            return 1.0 / 3.0 if self.has_column else 0.0  # the design does not ask for the column: where there is none nothing is wrong
        if not effect.fits(self.ship_name):
            return 0.0
        column = {"wind": (1.0, 0.0), "hidden": (0.0, 1.0), None: (2.0 / 3.0, 1.0 / 3.0)}[effect.needs][0 if self.has_column else 1]
        return column * (1.0 if effect.ships else 0.5)


class Deck:
    """A class on a scene as a mixture. nodes[level]: (n, numbers) not whitened changes; C, T: coefficients of components; weights."""

    def __init__(self, scene, name, primes, levels, truth=None):
        self.name, self.is_sensor = name, name in physics.SENSORS
        rng = np.random.default_rng(campaign.seed_of("deck", scene.key["id"], name))
        shapes, ring = scene.shapes(name, rng)
        effect = physics.ALL.get(name)
        if effect is None:
            plans, powers, primes, self.slopes = [({}, 1.0)], [0.0], (0.0,), [1.0]
        else:
            low = 1.05 / effect.most if name == "actuator-rate" else 0.0
            grid = np.array([effect.most * max(g, low + (1.0 - low) * g if low else g) for g in GRID])
            every = max(1, ring // 2)  # all directions at one strength, two of them at all
            seen = lambda plans: np.log(np.maximum(scene.primes(name, scene.change(name, scene.level, plans)), 1e-6))
            some = range(0, len(shapes), every)
            curves = seen([(shapes[k], s) for k in some for s in grid]).reshape(-1, len(grid))
            d = np.repeat(curves, every, 0)[:len(shapes)]
            if every > 1:
                d = d + (seen([(shape, grid[2]) for shape in shapes]) - d[:, 2])[:, None]
            plans, powers, self.slopes = [], [], []
            for shape, row in zip(shapes, d):
                row = np.maximum.accumulate(row + 1e-9 * np.arange(len(row)))
                for p in primes:
                    slopes = np.diff(row) / np.diff(np.log(grid))
                    if math.log(p) <= row[0]:  # below the grid: as the power there
                        k = max(slopes[0], 0.5)
                        s = math.exp(math.log(grid[0]) - (row[0] - math.log(p)) / k)
                    else:
                        s = math.exp(np.interp(math.log(p), row, np.log(grid)))
                        k = slopes[min(max(np.searchsorted(row, math.log(p)) - 1, 0), len(slopes) - 1)]
                    plans.append((shape, max(s, 1.0) if name == "actuator-rate" else s))
                    self.slopes.append(k)
                    powers.append(0.02 if s >= 0.999 * effect.most else k)
        self.plans, self.ring, self.primes = plans, ring, primes
        P, K = len(primes), len(plans)
        eye = np.eye(K)
        tangents = [SPREAD * eye * np.array(powers)[:, None]]
        if ring > 1:  # directions lie a step apart; between them the change is nearly linear
            at = np.arange(K).reshape(-1, ring, P)
            step = 2.0 * math.pi / ring
            turned = np.zeros((K, K))
            ahead, behind = np.roll(at, -1, 1).ravel(), np.roll(at, 1, 1).ravel()
            turned[at.ravel(), ahead], turned[at.ravel(), behind] = 0.5, -0.5
            tangents.append(turned * (0.4 * step / math.sin(step)))
        extra, C = [], eye
        T = np.stack(tangents, 1) if effect is not None else np.zeros((K, 0, K))
        weights = np.full(K, 1.0 / K)
        if name == "shallow-water" and scene.level == 2:  # six slacks of 10 %
            extra = [({**shape, "slack": [0.1 * (i == j) for j in range(6)]}, s) for shape, s in plans for i in range(6)]
            t = T.shape[1]
            C, T = np.pad(C, ((0, 0), (0, 6 * K))), np.pad(T, ((0, 0), (0, 6), (0, 6 * K)))
            for k in range(K):
                for i in range(6):
                    T[k, t + i, K + 6 * k + i], T[k, t + i, k] = 1.0, -1.0
        if truth is not None and name in DRAWN:  # the cell of the law in which the truth's own shape lies
            shape, strength = truth["shape"], truth["strength"]
            steps, mass = near(name, shape, scene)
            extra = [(shape, strength)] + [(s, strength) for s in steps]
            n, t = len(extra), T.shape[1]
            C, T = np.pad(C, ((0, 1), (0, n))), np.pad(T, ((0, 1), (0, max(0, n - t)), (0, n)))
            C[K, K], T[K, 0, K] = 1.0, SPREAD
            for i in range(1, n):
                T[K, i, K + i], T[K, i, K] = 1.0, -1.0
            weights = np.append(weights * (1.0 - mass / P), mass / P)
        self.C, self.T, self.weights = C, T, weights
        self.nodes = {level: scene.change(name, level, plans + extra) for level in levels}
