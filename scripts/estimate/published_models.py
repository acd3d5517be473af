"""Published maneuvering models that stem from captive tests, as equations of their own: what a ship does by them.

Each model has L [m], U [m/s], the rudder's rate [rad/s], the largest rudder angle that it is made for [deg] and rates(state, delta), the time derivatives of (u, v, r, p, phi). delta > 0 turns
to starboard. The numbers are those of the public MSS toolbox (cybergalactic/MSS), which names the papers; the equations are theirs.
"""

import math

DEGREE = math.pi / 180.0


class Container:
    """S175 after Son & Nomoto (1981), J. SNAJ 150, with roll; revolutions that hold U on a straight run."""

    name, L, U, rate, largest_deg = "s175", 175.0, 8.0, 5.0 * DEGREE, 35
    source = "Son & Nomoto (1981), with roll"

    def __init__(self):
        low, high = 0.1, 5.0
        for _ in range(60):
            self.n = 0.5 * (low + high)
            if self.rates((self.U, 0.0, 0.0, 0.0, 0.0), 0.0)[0] < 0.0:
                low = self.n
            else:
                high = self.n

    def rates(self, state, delta):
        L, g, rho = self.L, 9.81, 1025.0
        u, v, r, p, phi = state
        U = math.hypot(u, v)
        u, v, r, p = u / U, v / U, r * L / U, p * L / U
        m, mx, my, ly, alphay = 0.00792, 0.000238, 0.007049, 0.0313, 0.05
        Ix, Jx, Iz, Jz = 0.0000176, 0.0000034, 0.000456, 0.000419
        W, GM = rho * g * 21222.0 / (rho * L**2 * U**2 / 2), 0.3 / L
        kk, epsilon, wp, tau, xp, aH, xH, xR, zR = 0.631, 0.921, 0.184, 1.09, -0.526, 0.237, -0.48, -0.5, 0.033
        D, AR, aspect = 6.533, 33.0376, 1.8219
        vR = 0.088 * v - 0.156 * r - 0.275 * r**3 + 1.96 * r**2 * v
        uP = u * ((1 - wp) + tau * (v + xp * r) ** 2)
        J = uP * U / (self.n * D)
        KT = 0.527 - 0.455 * J
        uR = uP * epsilon * math.sqrt(max(0.0, 1 + 8 * kk * KT / (math.pi * J**2)))
        FN = -(6.13 * aspect / (aspect + 2.25)) * (AR / L**2) * (uR**2 + vR**2) * math.sin(delta + math.atan2(vR, uR))
        T = 2 * D**4 / (U**2 * L**2) * KT * self.n * abs(self.n)
        X = (-0.0004226 * u**2 + (1 - 0.175) * T - 0.00311 * v * r - 0.00386 * v**2 + 0.0002 * r**2 - 0.0002 * phi**2
             + 0.71 * FN * math.sin(delta) + (m + my) * v * r)
        Y = (-0.0116 * v + 0.00242 * r - 0.000063 * phi - 0.109 * v**3 + 0.00177 * r**3 + 0.0214 * v**2 * r - 0.0405 * v * r**2
             + 0.04605 * v**2 * phi + 0.00304 * v * phi**2 + 0.009325 * r**2 * phi - 0.001368 * r * phi**2
             + (1 + aH) * FN * math.cos(delta) - (m + mx) * u * r)
        K = (0.0003026 * v - 0.000063 * r - 0.0000075 * p - 0.000021 * phi + 0.002843 * v**3 - 0.0000462 * r**3
             - 0.000588 * v**2 * r + 0.0010565 * v * r**2 - 0.0012012 * v**2 * phi - 0.0000793 * v * phi**2
             - 0.000243 * r**2 * phi + 0.00003569 * r * phi**2 - (1 + aH) * zR * FN * math.cos(delta) + mx * 0.0313 * u * r
             - W * GM * phi)
        N = (-0.0038545 * v - 0.00222 * r + 0.000213 * p - 0.0001424 * phi + 0.001492 * v**3 - 0.00229 * r**3 - 0.0424 * v**2 * r
             + 0.00156 * v * r**2 - 0.019058 * v**2 * phi - 0.0053766 * v * phi**2 - 0.0038592 * r**2 * phi
             + 0.0024195 * r * phi**2 + (xR + aH * xH) * FN * math.cos(delta))
        # (m + my) v' - my alphay p' = Y,  -my ly v' + (Ix + Jx) p' = K in the source's signs, which couple sway, roll and yaw weakly.
        m22, m32, m42, m33, m44 = m + my, -my * ly, my * alphay, Ix + Jx, Iz + Jz
        det = m22 * m33 * m44 - m32**2 * m44 - m42**2 * m33
        dv = -((-m33 * m44 * Y + m32 * m44 * K + m42 * m33 * N) / det)
        dr = (-m42 * m33 * Y + m32 * m42 * K + N * m22 * m33 - N * m32**2) / det
        dp = (-m32 * m44 * Y + K * m22 * m44 - K * m42**2 + m32 * m42 * N) / det
        a = U**2 / L
        return X * a / (m + mx), dv * a, dr * a / L, dp * a / L, state[3]


class Mariner:
    """Mariner class after Chislett & Stroem-Tejsen (1965), HyA report Hy-6; perturbations about U. A cubic in the rudder angle, there for
    angles up to 30 deg."""

    name, L, U, rate, largest_deg = "mariner", 160.93, 7.7175, 65.0 / 28.0 * DEGREE, 30
    source = "Chislett & Strøm-Tejsen (1965)"

    def rates(self, state, delta):
        L, d = self.L, -delta
        full = math.hypot(state[0], state[1])
        u, v, r = (state[0] - self.U) / full, state[1] / full, state[2] * L / full
        m, Iz, xG = 798.0, 39.2, -0.023
        X = (-184 * u - 110 * u**2 - 215 * u**3 - 899 * v**2 + 18 * r**2 + 798 * r * v - 95 * d**2 - 190 * u * d**2 + 93 * v * d
             + 93 * u * v * d)
        Y = (-1160 * v - 499 * r - 8078 * v**3 + 15356 * v**2 * r - 1160 * v * u - 499 * r * u + 278 * d - 90 * d**3 + 556 * u * d
             + 278 * u**2 * d - 4 * v * d**2 + 1190 * v**2 * d - 4 - 8 * u - 4 * u**2)
        N = (-264 * v - 166 * r + 1636 * v**3 - 5483 * v**2 * r - 264 * v * u - 166 * r * u - 139 * d + 45 * d**3 - 278 * u * d
             - 139 * u**2 * d + 13 * v * d**2 - 489 * v**2 * d + 3 + 6 * u + 3 * u**2)
        m22, m23, m32, m33 = m + 748, m * xG + 9.354, m * xG - 4.646, Iz + 43.8
        det = m22 * m33 - m23 * m32
        a = full**2 / L
        return X * a / (m + 42), (m33 * Y - m23 * N) * a / det, (m22 * N - m32 * Y) * a / (det * L), 0.0, 0.0


class Tanker:
    """Tanker of 190 000 t dwt after van Berlekom & Goddard (1972), Trans. SNAME 80, in deep water."""

    name, L, U, rate, largest_deg = "tanker-190k", 304.8, 8.23, 2.33 * DEGREE, 35
    source = "van Berlekom & Goddard (1972)"

    def __init__(self):
        low, high = 0.1, 5.0
        for _ in range(60):
            self.n = 0.5 * (low + high)
            if self.rates((self.U, 0.0, 0.0, 0.0, 0.0), 0.0)[0] < 0.0:
                low = self.n
            else:
                high = self.n

    def rates(self, state, delta):
        L, n = self.L, self.n
        u, v, r = state[:3]
        beta = math.atan2(v, u)
        gT = -0.00695 / L * u**2 - 0.00063 * u * n + L * 0.0000354 * abs(n) * n
        c2 = 0.605 * u * n + 38.2 * n**2
        gX = (-0.0377 * u**2 + L * 2.020 * v * r + 0.3 * v**2 - 0.093 * c2 * delta**2 + 0.152 * c2 * beta * delta
              + L * gT * (1 - 0.22)) / L
        gY = (-1.205 * u * v - 2.4 * abs(v) * v + 0.208 * c2 * delta - L * 0.752 * u * r - 2.16 * c2 * abs(beta) * beta * abs(delta)
              + 0.04 * gT * L) / L
        gLN = (-0.451 * u * v - L * 0.3 * abs(v) * r - 0.098 * c2 * delta - L * 0.231 * u * r
               + 0.688 * c2 * abs(beta) * beta * abs(delta) - L * 0.02 * gT)
        return gX / 1.05, gY / 2.02, gLN / (L**2 * 0.1232), 0.0, 0.0


def sign_of_rudder(model):
    """1 where delta > 0 turns to starboard by the model's own sign of r."""
    return 1.0 if model.rates((model.U, 0.0, 0.0, 0.0, 0.0), 5 * DEGREE)[2] > 0 else -1.0


def run(model, order, duration_s, dt_s=0.25):
    """(t, x, y, psi [rad]) of a maneuver: order(psi, delta) gives the ordered rudder angle, positive to starboard."""
    turns = sign_of_rudder(model)
    state, x, y, psi, delta, track = [model.U, 0.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0, 0.0, []
    for k in range(int(duration_s / dt_s)):
        track.append((k * dt_s, x, y, psi))
        wanted = order(psi, delta)
        delta += max(-model.rate * dt_s, min(model.rate * dt_s, wanted - delta))
        first = model.rates(state, turns * delta)
        middle = [a + 0.5 * dt_s * b for a, b in zip(state, first)]
        second = model.rates(middle, turns * delta)
        u, v, r = middle[:3]
        half = psi + 0.25 * dt_s * (state[2] + r)
        x += dt_s * (u * math.cos(half) - v * math.sin(half))
        y += dt_s * (u * math.sin(half) + v * math.cos(half))
        psi += dt_s * r
        state = [a + dt_s * b for a, b in zip(state, second)]
    return track


def turning(model, angle_deg=35.0, duration_s=1500.0):
    """Advance and tactical diameter in lengths."""
    track = run(model, lambda psi, delta: angle_deg * DEGREE, duration_s)
    sign = 1 if angle_deg > 0 else -1

    def at(heading, column):
        i = next(k for k, row in enumerate(track) if sign * row[3] >= heading)
        a, b = track[i - 1], track[i]
        weight = (heading - sign * a[3]) / (sign * (b[3] - a[3]))
        return a[column] + weight * (b[column] - a[column])

    return {"A_D": at(math.pi / 2, 1) / model.L, "D_T": sign * at(math.pi, 2) / model.L}


def zigzag(model, angle_deg, duration_s=2500.0):
    """First and second overshoot [deg], first to starboard."""
    side, executes = [1], []

    def order(psi, delta):
        if side[0] * psi >= angle_deg * DEGREE:
            side[0] = -side[0]
            executes.append(None)
        return side[0] * angle_deg * DEGREE

    psi = [row[3] / DEGREE for row in run(model, order, duration_s)]
    second = next(i for i, a in enumerate(psi) if a >= angle_deg)
    third = next(i for i in range(second, len(psi)) if psi[i] <= -angle_deg)
    fourth = next(i for i in range(third, len(psi)) if psi[i] >= angle_deg)
    return {"first": max(psi[second:third]) - angle_deg, "second": -min(psi[third:fourth]) - angle_deg}


MODELS = {model.name: model for model in (Container, Mariner, Tanker)}
