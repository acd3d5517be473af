"""What no table holds: gusts of several scales, a limit cycle, a step, and the wind.

paths are functions of time made of sums of sines, one set of numbers per recording: (recordings, time) without a grid."""

import math

import numpy as np

KINDS = ("gusts", "limit-cycle", "step", "all")


class ModelError:
    """Accelerations (surge, sway, yaw) that the vessel's equations lack; yaw as sway over a quarter of a length.

    gusts        band-limited noise of three scales (periods of 4 to 12, 20 to 60, 100 to 300 s at 3 m), the slow ones larger
    limit-cycle  a nonlinear oscillation of sway and yaw whose period wanders by some percent
    step         a level that changes once and stays
    """

    def __init__(self, rngs, sd, kinds, duration, scale, L):
        n = len(rngs)
        self.sd, self.L, self.scale = np.asarray(sd, float), L, scale
        self.of = lambda kind: np.array([k in (kind, "all") for k in kinds], float)
        periods, shares = ((4.0, 12.0), (20.0, 60.0), (100.0, 300.0)), (0.35, 0.6, 0.72)
        self.w, self.phase, self.gain = np.empty((n, 3, 18)), np.empty((n, 3, 18)), np.empty((n, 3, 18))
        self.cycle, self.step = np.empty((n, 3)), np.empty((n, 4))
        for i, rng in enumerate(rngs):
            for b, ((low, high), share) in enumerate(zip(periods, shares)):
                at = slice(6 * b, 6 * b + 6)
                self.w[i, :, at] = 2.0 * math.pi / (np.exp(rng.uniform(math.log(low), math.log(high), (3, 6))) * scale)
                self.gain[i, :, at] = share * math.sqrt(2.0 / 6.0)
            self.phase[i] = rng.uniform(0.0, 2.0 * math.pi, (3, 18))
            self.cycle[i] = (2.0 * math.pi / (rng.uniform(18.0, 45.0) * scale), rng.uniform(0.0, 6.28), rng.uniform(0.02, 0.08))
            direction = rng.standard_normal(3)
            self.step[i] = (rng.uniform(0.3, 0.7) * duration, *(direction / np.linalg.norm(direction) * math.sqrt(3.0)))

    def at(self, t):
        """(3, recordings)."""
        noise = np.sum(self.gain * np.sin(self.w * t + self.phase), 2).T * self.of("gusts")
        w, phase, wander = self.cycle.T
        angle = w * t + phase + wander * np.sin(0.13 * w * t) * 6.0
        wave = np.sin(angle) + 0.25 * np.sin(3.0 * angle)  # flatter than a sine, as a van der Pol oscillator's
        cycle = np.stack([0.0 * wave, 0.9 * wave, 1.2 * wave]) * self.of("limit-cycle")
        on = (t > self.step[:, 0]) * self.of("step")
        sides = np.array([1.0, 1.0, 4.0 / self.L])[:, None]
        several = np.where(self.of("gusts") + self.of("limit-cycle") + self.of("step") > 1.5, 1.0 / math.sqrt(3.0), 1.0)
        return self.sd * several * sides * (noise + cycle + self.step[:, 1:].T * on)


class Wind:
    """True wind, as vector to where it comes from: mean, gusts of three scales in speed and direction; 0 where calm."""

    def __init__(self, rngs, speed, direction, scale):
        n = len(rngs)
        self.speed, self.direction = np.asarray(speed, float), np.asarray(direction, float)
        self.w, self.phase = np.empty((n, 2, 9)), np.empty((n, 2, 9))
        for i, rng in enumerate(rngs):
            for b, (low, high) in enumerate(((3.0, 9.0), (15.0, 50.0), (80.0, 250.0))):
                self.w[i, :, 3 * b:3 * b + 3] = 2.0 * math.pi / (np.exp(rng.uniform(math.log(low), math.log(high), (2, 3))) * scale)
            self.phase[i] = rng.uniform(0.0, 2.0 * math.pi, (2, 9))

    def at(self, t):
        g = np.sum(np.sin(self.w * t + self.phase), 2) * math.sqrt(2.0 / 9.0)
        U = self.speed * np.maximum(1.0 + 0.13 * g[:, 0], 0.0)
        a = self.direction + 0.12 * g[:, 1]
        return U * np.cos(a), U * np.sin(a)
