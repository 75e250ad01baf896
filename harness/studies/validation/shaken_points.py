"""A rigid mass on a joint, and a block that rocks on a row of points, in time; m, MN, s, kt."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from asperity.contract import N_POINT_STATEV, Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern
from asperity.steps import Step

G = 9.81
MASS = 0.0072
"""Per area of the joint: 3 m of rock."""
SIDE, HALF_HEIGHT, DENSITY = 0.1, 0.5, 0.0024
"""Half width, half height and density of the rocking block."""
LONG = 1e12
"""Duration of an increment in which a dashpot does nothing."""


def joint(theta: float, mu: float, kn: float, c: float = 0.0) -> Interface:
    """Joint without bond, flat or with one plane that faces a motion along Tx, with ks = 0.4 kn."""
    a = np.radians(theta)
    pattern = Pattern.planes([[np.cos(a), -np.sin(a), 0.0]], [1.0]) if theta else Pattern.regular(0, 0.0)
    return Interface(Material.from_joint(kn=kn, ks=0.4 * kn, mu=mu, c=c), pattern)


def energy(state: Floats) -> Floats:
    """Energy that a state has stored and spent."""
    return state[:, 1:4].sum(axis=1)


def ride(
    law: Interface,
    dt: float,
    steps: int,
    force: Callable[[int], Floats],
    start: Floats,
    v: Floats,
) -> tuple[Floats, Floats, float]:
    """Separations (steps, 3) and velocities of a mass from a separation on; largest error of its ledger.

    Central differences.  force: per mass, of a step.  The ledger is work of the force = energy of the joint +
    kinetic energy, over the largest of them.
    """
    s, state, rows, speeds = start[None], law.update(start[None], dt=LONG).state, [], []
    first, work, worst, largest = energy(state)[0] + 0.5 * MASS * v @ v, 0.0, 0.0, 0.0
    traction, applied = law.update(s, state, s, LONG).traction[0], force(0)
    for i in range(steps):
        v = v + (0.5 if i == 0 else 1.0) * dt * (applied - traction / MASS)
        new = s + dt * v
        end = law.update(new, state, s, dt)
        following = force(i + 1)
        work += 0.5 * MASS * (applied + following) @ (new - s)[0]
        s, state, applied, traction = new, end.state, following, end.traction[0]
        w = v + 0.5 * dt * (applied - traction / MASS)
        kinetic = 0.5 * MASS * w @ w
        largest = max(largest, abs(work), kinetic)
        worst = max(worst, abs(work + first - energy(state)[0] - kinetic))
        rows.append(s[0])
        speeds.append(w)
    return np.array(rows), np.array(speeds), worst / largest


def rest(law: Interface) -> Floats:
    """Separation under the own weight."""
    return law.run(Step(t_N=-MASS * G, time=LONG)).separation[-1]


def restitution(xi: float) -> float:
    """Velocity after over that before an impact on a spring and a dashpot that do not pull."""
    if xi > 1.0:
        root = np.sqrt(xi**2 - 1.0)
        return float(np.exp(-xi / root * np.log((xi + root) / (xi - root))))
    return float(np.exp(-xi * (np.pi - 2.0 * np.arcsin(xi)) / np.sqrt(1.0 - xi**2)))


def shaken(law: Interface, base: Callable[[float], float], end: float, dt: float) -> tuple[Floats, float]:
    """Separations, from those at rest on, of a mass with a base in motion, and the error of the ledger.

    base: acceleration of the mass against it over a step, so that impulses are exact; its mean over the step.
    """
    at = rest(law)
    force = [np.array([-G, base(i * dt), 0.0]) for i in range(round(end / dt) + 2)]
    s, _, ledger = ride(law, dt, round(end / dt), force.__getitem__, at, np.zeros(3))
    return s - at, ledger


def pulse(A: float, t0: float, dt: float) -> Callable[[float], float]:
    """Acceleration A g for a time t0; the mean over a step about t."""
    return lambda t: A * G * (1.0 if t == 0.0 else float(np.clip((t0 - t) / dt + 0.5, 0.0, 1.0)))


RADIUS, ALPHA = np.hypot(SIDE, HALF_HEIGHT), np.arctan2(SIDE, HALF_HEIGHT)


@cache
def rock(n: int, xi: float, share: float) -> tuple[float, float]:
    """Period, and ratio of the angular velocities at the first impact, of a block on n points.

    The block starts from rest at an angle, share of the one at which it would fall, and turns exactly.
    xi: damping by the mass of the block over its base.
    """
    kn, m = 2e4, DENSITY * 4.0 * SIDE * HALF_HEIGHT
    c = 2.0 * xi * np.sqrt(kn * m / (2.0 * SIDE))
    law = joint(0.0, 0.7, kn, c)
    x, area = np.linspace(-SIDE, SIDE, n), np.full(n, 2.0 * SIDE / (n - 1))
    area[[0, -1]] /= 2.0
    k, d = 8.0 * SIDE * kn / m, 8.0 * SIDE * c / m
    dt = 1.0 / (d + np.sqrt(d * d + 4.0 * k))
    q, v, best, peaks, sign, t, quarter = (
        np.array([0.0, 0.0, -share * ALPHA]),
        np.zeros(3),
        0.0,
        [],
        -1,
        0.0,
        0.0,
    )
    mass, centre = m * np.array([1.0, 1.0, RADIUS**2 / 3.0]), np.array([HALF_HEIGHT, 0.0])

    def corners(q: Floats) -> Floats:
        """Places (n, 2) of the base, up and sideways."""
        sine, cosine = np.sin(q[2]), np.cos(q[2])
        places = np.empty((n, 2))
        places[:, 0] = q[0] + HALF_HEIGHT + sine * x - HALF_HEIGHT * cosine
        places[:, 1] = q[1] + cosine * x + HALF_HEIGHT * sine
        return places

    low = corners(q)
    # the corner that carries the weight
    q[:2] -= low[-1, 0] + m * G / (kn * area[-1]), low[-1, 1] - SIDE
    places, at_rest = corners(q), np.column_stack([0.0 * x, x])
    s, new = np.zeros((2, n, 3))
    s[:, :2] = places - at_rest
    state = np.zeros((n, law.nstatv))
    state[:, N_POINT_STATEV + 1] = s[:, 1]  # no shear at the start
    end = law.update(s, state, s, LONG)
    out = end.traction.copy(), end.state.copy(), np.empty((n, 3, 3))
    while len(peaks) < 2:
        f = -area[:, None] * out[0][:, :2]
        arm = places - (q[:2] + centre)
        force = np.array([f[:, 0].sum() - m * G, f[:, 1].sum(), arm[:, 1] @ f[:, 0] - arm[:, 0] @ f[:, 1]])
        v = v + dt * force / mass
        q, t = q + dt * v, t + dt
        places = corners(q)
        new[:, :2] = places - at_rest
        law.update(new, out[1], s, dt, out=out)
        s, new, best = new, s, max(best, abs(q[2]))
        if q[2] * sign < -1e-6:
            quarter = quarter or t
            peaks.append(best if peaks else share * ALPHA)
            best, sign = 0.0, -sign
    high = np.cos(ALPHA - np.array(peaks)) - np.cos(ALPHA)
    return 4.0 * quarter, float(np.sqrt(high[1] / high[0]))
