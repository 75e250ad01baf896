"""Shear tests by laws that are not that of asperity, with noise, and data that no law meets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

Floats = np.ndarray


class Test(NamedTuple):
    """Slip, tau and dilation (T,), or no dilation; pressure; normal stiffness; mm and MPa."""

    slip: Floats
    tau: Floats
    dilation: Floats | None
    pressure: float
    k_N: float = 0.0


class Drawn(NamedTuple):
    """Tests, and what is true of them.

    truth: ends of the range in which a constant with the same meaning in the law of asperity lies.  numbers:
    of each test by name.  held: a test without noise at a pressure between those of the tests, or none.
    """

    tests: list[Test]
    truth: dict[str, tuple[float, float]]
    numbers: list[dict[str, float]]
    held: Test | None = None


Asperities = Callable[[float, float], tuple[float, float]]
"""Slope and dilation at a slip >= 0 of the joint and a work of friction per area."""

Law = Callable[[np.random.Generator, float, float], tuple[Asperities, dict[str, float]]]
"""Asperities, drawn, of a first slope and the largest slip, and their true constants beside mu and theta."""


def exactly(**values: float) -> dict[str, tuple[float, float]]:
    """Constants that have one true value."""
    return {name: (float(value), float(value)) for name, value in values.items()}


def between(pressures: Sequence[float]) -> float:
    """A pressure between the smallest and the largest one, 0 where there is one alone."""
    return float(np.sqrt(pressures[0] * pressures[-1])) if len(pressures) > 1 else 0.0


def noisy(rng: np.random.Generator, test: Test, noise: float, dilates: bool = True) -> Test:
    """A test with noise, a fraction of the largest tau and dilation."""
    tau = test.tau + rng.normal(0.0, noise * np.abs(test.tau).max(), test.slip.size)
    dilation = None
    if dilates and test.dilation is not None:
        size = noise * max(float(np.abs(test.dilation).max()), 1e-6)
        dilation = test.dilation + rng.normal(0.0, size, test.slip.size)
    return test._replace(tau=tau, dilation=dilation)


def slips_behind_spring(slips: Floats, strength: Callable[[float], float], stiffness: float) -> Floats:
    """Slip of a joint behind a spring: slip = u + strength(u)/stiffness, 0 below the strength."""
    joint_slips = []
    for slip in slips:
        holds = strength(0.0) / stiffness >= slip
        joint_slips.append(
            0.0 if holds else brentq(lambda u, s=slip: u + strength(u) / stiffness - s, 0.0, slip)
        )
    return np.array(joint_slips)


def behind_spring(
    end: float,
    rows: int,
    state: Callable[[float], tuple[float, float]],
    stiffness: float,
    pressure: float,
    k_N: float = 0.0,
) -> Test:
    """Test of a joint behind a spring up to a slip, in equal steps.

    state: strength and dilation of the joint alone, at its slip.
    """
    slips = np.linspace(end / rows, end, rows)
    slips_of_joint = slips_behind_spring(slips, lambda u: state(u)[0], stiffness)
    tau = [state(u)[0] if u > 0.0 else stiffness * s for u, s in zip(slips_of_joint, slips, strict=True)]
    return Test(slips, np.array(tau), np.array([state(u)[1] for u in slips_of_joint]), pressure, k_N)


def mohr_coulomb(rng: np.random.Generator, count: int = 0, length: int = 0) -> Drawn:
    """Friction on a slope that decays with the slip, behind a spring; CNL or CNS.

    count, length, here and below: number of tests, and of their rows, 0 where they are drawn, too.
    """
    mu, theta, height = rng.uniform(0.45, 0.75), rng.uniform(8.0, 22.0), rng.uniform(0.3, 1.2)
    stiffness, k_N, tests = rng.uniform(5.0, 12.0), float(rng.choice([0.0, 0.0, 3.0])), []
    slope = float(np.tan(np.radians(theta)))

    def state(u: float, pressure: float) -> tuple[float, float]:
        remaining = np.exp(-u * slope / height)
        opening, now = height * (1.0 - remaining), slope * remaining
        return (pressure + k_N * opening) * (mu + now) / (1.0 - mu * now), opening

    def test(pressure: float, rows: int) -> Test:
        end = 4.0 * height / slope
        return behind_spring(end, rows, lambda u: state(u, pressure), stiffness, pressure, k_N)

    pressures = sorted(rng.uniform(0.4, 2.5, count or int(rng.integers(1, 5))).tolist())
    for pressure in pressures:
        tests.append(
            noisy(rng, test(pressure, length or int(rng.integers(30, 201))), rng.uniform(0.01, 0.05))
        )
    held = test(between(pressures), 100) if len(pressures) > 1 else None
    return Drawn(tests, exactly(mu=mu, theta=theta, height=height), [], held)


def without_dilation(
    rng: np.random.Generator, law: Callable[[np.random.Generator], Drawn] = mohr_coulomb
) -> Drawn:
    """Tests of a law whose dilation was not measured; such a joint has no bond."""
    drawn = law(rng)
    tests = [test._replace(dilation=None) for test in drawn.tests]
    held = drawn.held._replace(dilation=None) if drawn.held else None
    truth = {name: drawn.truth[name] for name in ("mu", "theta")} | exactly(sigma0=0.0)
    return Drawn(tests, truth, [], held)


def gauges(rng: np.random.Generator) -> Drawn:
    """Mohr-Coulomb or parabolic asperities, by gauges that start up to a tenth of their range apart from 0.

    A first row at rest is part of half of the sets.
    """
    drawn = (mohr_coulomb, parabola)[int(rng.integers(2))](rng)
    kinds, rests, tests = rng.integers(4), bool(rng.random() < 0.5), []
    for test in drawn.tests:
        slip = rng.uniform(0.0, 0.1) * np.ptp(test.slip) * (kinds in (1, 3))
        opening = rng.uniform(-0.1, 0.1) * np.ptp(test.dilation) * (kinds in (2, 3))
        slips, tau, dilation = test.slip, test.tau, test.dilation
        if rests:
            slips, tau, dilation = (np.append(0.0, column) for column in (slips, tau, dilation))
        tests.append(test._replace(slip=slips + slip, tau=tau, dilation=dilation + opening))
    truth = {name: drawn.truth[name] for name in ("mu", "theta", "height")}
    return drawn._replace(tests=tests, truth=truth, held=None)


def specimens(rng: np.random.Generator, least: int = 3, most: int = 6) -> Drawn:
    """Rough joints of which each pressure has another specimen, as laboratories have them; CNL.

    The slope falls exponentially, or along a straight line in half of the sets.  mu, theta in degrees and the
    logarithm of the height of the specimens have standard deviations of 0.04, 2 and 0.15.  The truth is the
    mean of all specimens, and the held test is that of the mean joint.
    """
    mu, theta, height = rng.uniform(0.45, 0.75), rng.uniform(8.0, 22.0), rng.uniform(0.3, 1.2)
    stiffness, line, tests = rng.uniform(5.0, 12.0), bool(rng.random() < 0.5), []

    def test(pressure: float, rows: int, mu: float, theta: float, height: float) -> Test:
        slope = float(np.tan(np.radians(theta)))

        def state(u: float) -> tuple[float, float]:
            remaining = (
                max(0.0, 1.0 - 0.5 * u * slope / height) if line else float(np.exp(-u * slope / height))
            )
            now, rest = slope * remaining, remaining**2 if line else remaining
            return pressure * (mu + now) / (1.0 - mu * now), height * (1.0 - rest)

        end = 4.0 * height / slope
        return behind_spring(end, rows, state, stiffness, pressure)

    pressures = sorted(rng.uniform(0.4, 3.0, int(rng.integers(least, most + 1))).tolist())
    for pressure in pressures:
        own_theta = max(1.0, theta + 2.0 * rng.normal())
        specimen = (mu + 0.04 * rng.normal(), own_theta, height * float(np.exp(0.15 * rng.normal())))
        tests.append(
            noisy(rng, test(pressure, int(rng.integers(30, 201)), *specimen), rng.uniform(0.01, 0.05))
        )
    held = test(between(pressures), 100, mu, theta, height)
    return Drawn(tests, exactly(mu=mu, theta=theta, height=height), [], held)


def parabola(rng: np.random.Generator) -> Drawn:
    """Asperities whose slope falls along a straight line and ends."""
    return ended(rng, lambda part: (1.0 - part, 1.0 - (1.0 - part) ** 2))


def wave(rng: np.random.Generator) -> Drawn:
    """Asperities whose slope is that of half a wave, cos^2, flat at first and at its end."""
    return ended(
        rng, lambda part: (float(np.cos(0.5 * np.pi * part)) ** 2, part + float(np.sin(np.pi * part)) / np.pi)
    )


def ended(rng: np.random.Generator, profile: Callable[[float], tuple[float, float]]) -> Drawn:
    """Friction on asperities whose slope ends, behind a spring; no bond.

    profile: slope over the largest one and dilation over the height, at parts of the length, of which a
    constant slope would need half.
    """
    mu, theta, length = rng.uniform(0.45, 0.75), rng.uniform(8.0, 35.0), rng.uniform(0.1, 4.0)
    stiffness, slope = rng.uniform(5.0, 12.0) * rng.choice([1.0, 10.0]), float(np.tan(np.radians(theta)))
    height, tests = 0.5 * slope * length, []

    def state(u: float, pressure: float) -> tuple[float, float]:
        left, risen = profile(min(1.0, u / length))
        return pressure * (mu + slope * left) / (1.0 - mu * slope * left), height * risen

    def test(pressure: float, rows: int) -> Test:
        end = length * rng.uniform(1.5, 4.0)
        return behind_spring(end, rows, lambda u: state(u, pressure), stiffness, pressure)

    pressures = sorted(rng.uniform(0.1, 2.5, int(rng.integers(1, 5))).tolist())
    for pressure in pressures:
        tests.append(noisy(rng, test(pressure, int(rng.integers(30, 201))), rng.uniform(0.01, 0.05)))
    held = test(between(pressures), 100) if len(pressures) > 1 else None
    return Drawn(tests, exactly(mu=mu, theta=theta, height=height, sigma0=0.0), [], held)


def one_curve(rng: np.random.Generator) -> Drawn:
    """The strength of such asperities at the first pressure alone."""
    drawn = without_dilation(rng, parabola)
    return drawn._replace(tests=drawn.tests[:1], held=None)


def cohesion(rng: np.random.Generator, count: int = 0, length: int = 0) -> Drawn:
    """Cohesion with linear softening and friction, to which the dilation adds none; half have no dilation."""
    bond, energy, mu = rng.uniform(0.3, 1.2), rng.uniform(0.03, 0.2), rng.uniform(0.6, 0.9)
    stiffness, slope, decay = rng.uniform(30.0, 120.0), rng.uniform(0.1, 0.4), rng.uniform(3.0, 10.0)
    dilates, tests = bool(rng.random() < 0.5), []

    def test(pressure: float, rows: int) -> Test:
        end = max(10.0 * energy / bond, 3.0 / decay * dilates)
        slips = np.linspace(end / rows, end, rows)

        def strength(u: float) -> float:
            return max(0.0, bond * (1.0 - u * bond / (2.0 * energy))) + mu * pressure

        slips_of_joint = slips_behind_spring(slips, strength, stiffness)
        tau = np.array(
            [strength(u) if u > 0.0 else stiffness * s for u, s in zip(slips_of_joint, slips, strict=True)]
        )
        dilation = slope / decay * (1.0 - np.exp(-decay * slips_of_joint))
        return Test(slips, tau, dilation if dilates else None, pressure)

    pressures = sorted(rng.uniform(0.1, 1.5, count or int(rng.integers(1, 5))).tolist())
    for pressure in pressures:
        drawn = test(pressure, length or int(rng.integers(30, 201)))
        tests.append(noisy(rng, drawn, rng.uniform(0.01, 0.05), dilates))
    truth = exactly(mu=mu, sigma0=bond, Gc=energy)
    if dilates:
        truth |= exactly(theta=np.degrees(np.arctan(slope)), height=slope / decay)
    held = test(between(pressures), 100) if len(pressures) > 1 else None
    return Drawn(tests, truth, [], held)


def barton_bandis(rng: np.random.Generator, count: int = 0, length: int = 0) -> Drawn:
    """Barton and Bandis with a mobilised JRC; the dilation angle is half of the roughness part.

    Residual and dilation are means over the last tenth of the rows, as in a fit.  The friction without
    dilation, phi_r and the other half, falls from the peak at the smallest pressure to the end at the
    largest.
    """
    jrc, jcs, phi_r = rng.uniform(5.0, 15.0), rng.uniform(30.0, 120.0), rng.uniform(26.0, 33.0)
    tests, numbers = [], []
    peak_slip = 100.0 / 500.0 * (jrc / 0.1) ** 0.33
    at = np.array([0.0, 0.3, 0.6, 1.0, 2.0, 4.0, 10.0])

    def test(pressure: float, rows: int) -> Test:
        end, angle = 8.0 * peak_slip, jrc * np.log10(jcs / pressure)
        share = np.array([-phi_r / angle, 0.0, 0.75, 1.0, 0.85, 0.7, 0.5])
        slips, fine = np.linspace(end / rows, end, rows), np.linspace(0.0, end, 4001)
        slope = np.tan(np.radians(0.5 * angle * np.maximum(np.interp(fine / peak_slip, at, share), 0.0)))
        opening = np.append(0.0, np.cumsum(slope[1:] * np.diff(fine)))
        tau = pressure * np.tan(np.radians(phi_r + np.interp(slips / peak_slip, at, share) * angle))
        return Test(slips, tau, np.interp(slips, fine, opening), pressure)

    pressures = sorted(
        np.exp(rng.uniform(np.log(0.3), np.log(4.0), count or int(rng.integers(1, 5)))).tolist()
    )
    for pressure in pressures:
        exact = test(pressure, length or int(rng.integers(30, 201)))
        tests.append(noisy(rng, exact, rng.uniform(0.01, 0.05)))
        end = slice(-max(3, round(0.1 * exact.slip.size)), None)
        means = {"residual": float(exact.tau[end].mean()), "dilation": float(exact.dilation[end].mean())}
        numbers.append({"peak": float(exact.tau.max()), **means})
    high, low = (jrc * np.log10(jcs / pressure) for pressure in (pressures[0], pressures[-1]))
    mobilised = np.interp(8.0, at, [0.0, 0.0, 0.75, 1.0, 0.85, 0.7, 0.5])
    ends = (phi_r + 0.5 * mobilised * low, phi_r + 0.5 * high)
    truth = {"mu": (float(np.tan(np.radians(ends[0]))), float(np.tan(np.radians(ends[1]))))}
    held = test(between(pressures), 100) if len(pressures) > 1 else None
    return Drawn(tests, truth, numbers, held)


def strokes(rng: np.random.Generator, count: int, length: int, law: Law) -> Drawn:
    """Cycles on asperities that are alike to both sides, behind a spring; CNL."""
    mu, theta, stiffness = rng.uniform(0.45, 0.75), rng.uniform(8.0, 22.0), rng.uniform(5.0, 12.0)
    amplitude, cycles = rng.uniform(2.0, 6.0), int(rng.integers(1, 4))
    asperities, further = law(rng, float(np.tan(np.radians(theta))), amplitude)
    rows = round(length / (2.0 * cycles + 0.5)) if length else int(rng.integers(40, 121))

    def test(pressure: float) -> Test:
        way = np.concatenate(
            [
                np.linspace(a, b, rows // 2 if a == 0.0 else rows)[1:] * amplitude
                for a, b in [(0.0, 1.0), *[(1.0, -1.0), (-1.0, 1.0)] * cycles]
            ]
        )
        u, done, tau, taus, openings = 0.0, 0.0, 0.0, [], []
        before = 0.0
        for x in way:
            for part in np.linspace(before, x, 21)[1:]:
                forward = 1.0 if stiffness * (part - u) > 0.0 else -1.0
                rise = asperities(abs(u), done)[0] * (1.0 if u * forward >= 0.0 else -1.0)
                strength = forward * pressure * (mu + rise) / (1.0 - mu * rise)
                tau = stiffness * (part - u)
                if tau * forward > strength * forward:
                    step = (tau - strength) / stiffness
                    u, tau = u + step, strength
                    done += abs(strength * step) - pressure * rise * abs(step)
            before = x
            taus.append(tau)
            openings.append(asperities(abs(u), done)[1])
        return Test(way, np.array(taus), np.array(openings), pressure)

    tests = [
        noisy(rng, test(float(pressure)), rng.uniform(0.01, 0.05))
        for pressure in sorted(rng.uniform(0.4, 2.5, count or int(rng.integers(1, 3))))
    ]
    return Drawn(tests, exactly(mu=mu, theta=theta, **further), [])


def plesha(rng: np.random.Generator, count: int = 0, length: int = 0) -> Drawn:
    """Cycles on two saw teeth that the work of friction flattens (Plesha 1987), behind a spring; CNL.

    The slope is tan(theta) exp(-W/W0), W the work of friction per area of the joint, and the opening the
    slope times the slip.
    """

    def law(rng: np.random.Generator, slope: float, amplitude: float) -> tuple[Asperities, dict[str, float]]:
        work = float(np.exp(rng.uniform(np.log(1.0), np.log(20.0)))) * amplitude

        def asperities(u: float, done: float) -> tuple[float, float]:
            now = slope * float(np.exp(-done / work))
            return now, now * u

        return asperities, {}

    return strokes(rng, count, length, law)


def parabolic_strokes(rng: np.random.Generator) -> Drawn:
    """Cycles on asperities whose slope falls along a straight line from the middle to both sides; CNL."""

    def law(rng: np.random.Generator, slope: float, amplitude: float) -> tuple[Asperities, dict[str, float]]:
        height = slope * amplitude * rng.uniform(0.2, 0.6)

        def asperities(u: float, _: float) -> tuple[float, float]:
            remaining = max(0.0, 1.0 - 0.5 * u * slope / height)
            return slope * remaining, height * (1.0 - remaining**2)

        return asperities, {"height": height}

    return strokes(rng, 0, 0, law)


def nonsense(rng: np.random.Generator) -> Drawn:
    """Data that no joint gives: noise, a strength that halves or only rises, shuffled rows, wrong signs.

    And elastic lines, random walks, a single row, a constant strength with one spike, rows in reversed order.
    """
    rows = int(rng.choice([8, 9, 12, 14, 20, 40]))
    slips = np.linspace(0.1, 2.0, rows)

    def of_tractions(tau: Floats, pressure: float = 1.0, dilation: Floats | None = None) -> Test:
        return Test(slips, tau, dilation, pressure)

    kind = int(rng.integers(14))
    noise = rng.normal(0.0, 0.01, rows)
    if kind == 0:
        tests = [of_tractions(np.abs(rng.normal(0.5, 0.2, rows)))]
    elif kind == 1:
        tests = [of_tractions(np.linspace(0.9, 0.4, rows) + noise)]
    elif kind == 2:
        tests = [of_tractions(np.linspace(0.1, 1.2, rows) + noise)]
    elif kind == 3:
        tests = [of_tractions(rng.permutation(slips) * 0.5)]
    elif kind == 4:
        tests = [
            of_tractions(np.abs(rng.normal(0.5 * p, 0.2 * p, rows)), p, rng.normal(0.0, 0.1, rows))
            for p in (0.5, 1.0, 2.0)
        ]
    elif kind == 5:
        tests = [of_tractions(np.linspace(0.9, 0.4, rows) * p + noise, p) for p in (0.5, 1.0)]
    elif kind == 6:
        rise = 1.0 - np.exp(-slips / 0.1)
        tests = [
            of_tractions(strength * rise + noise, p) for p, strength in ((0.5, 1.2), (1.0, 0.8), (2.0, 0.5))
        ]
    elif kind == 9:
        tests = [of_tractions(0.8 * slips + rng.normal(0.0, 0.01, rows), p) for p in (0.5, 1.0)]
    elif kind == 10:
        tests = [of_tractions(np.abs(np.cumsum(rng.normal(0.0, 0.2, rows))) + 0.1)]
    elif kind == 11:
        tests = [Test(slips[:1], np.array([0.5]), None, 1.0)]
    elif kind == 12:
        tests = [of_tractions(np.where(np.arange(rows) == rows // 2, 0.9, 0.3), p) for p in (0.5, 1.0, 2.0)]
    else:
        sound = mohr_coulomb(rng).tests
        if kind == 13:
            tests = [test._replace(slip=test.slip[::-1], tau=test.tau[::-1], dilation=None) for test in sound]
        elif kind == 7:
            tests = [test._replace(dilation=-test.dilation, k_N=0.0) for test in sound]
        else:
            tests = [test._replace(tau=test.tau * (-1.0) ** i) for i, test in enumerate(sound + sound[:1])]
    return Drawn(tests, exactly(kind=kind), [])


def bond_slip(rng: np.random.Generator) -> Drawn:
    """One to six bonds that are pulled without any pressure, behind the elastic slip of a machine.

    The stress rises along a line and falls along another one, or exponentially, or rises with the power 0.4
    of the Model Code and falls along a line.  Strength and slip of the specimens differ by 5 % in half of
    the sets.
    """
    strength, end = (
        np.exp(rng.uniform(np.log(0.5), np.log(12.0))),
        np.exp(rng.uniform(np.log(0.1), np.log(4.0))),
    )
    soft, rise, law = np.exp(rng.uniform(np.log(0.02), np.log(0.3))), rng.uniform(0.02, 0.25), rng.integers(3)
    count, differ = int(rng.integers(1, 7)), float(rng.choice([0.0, 0.05]))

    def test() -> Test:
        top, far = (float(x * np.exp(differ * (count > 1) * rng.normal())) for x in (strength, end))
        u, first = np.linspace(0.0, 2.0 * far, 4001), rise * far / (4.0 if law == 1 else 1.0)
        falls = np.exp(-4.0 * np.maximum(0.0, u - first) / far) if law == 1 else (far - u) / (far - first)
        stress = top * np.clip(np.minimum((u / first) ** (0.4 if law == 2 else 1.0), falls), 0.0, 1.0)
        # what the spring gives back at once is passed at one slip
        outside = np.maximum.accumulate(u + soft * end * stress / strength) + 1e-9 * u
        rows = int(rng.integers(40, 201))
        last = far * (1.3 if law == 1 else float(rng.uniform(1.05, 1.5)))
        slips = np.linspace(last / rows, last, rows)
        return noisy(rng, Test(slips, np.interp(slips, outside, stress), None, 0.0), rng.uniform(0.01, 0.03))

    parts = (0.5, 0.25 * (1.0 + 0.5 * rise), rise / 1.4 + 0.5 * (1.0 - rise))
    truth = exactly(sigma0=strength, Gc=float(strength * end * parts[int(law)]))
    return Drawn([test() for _ in range(count)], truth, [])


KINDS = {
    "Mohr-Coulomb, decaying dilation": mohr_coulomb,
    "dilation not measured": without_dilation,
    "parabolic asperities": parabola,
    "wave-shaped asperities": wave,
    "specimens, 2 tests": lambda rng: specimens(rng, 2, 2),
    "specimens, 3 to 6 tests": specimens,
    "gauges not set to zero": gauges,
    "parabolic asperities, no dilation": lambda rng: without_dilation(rng, parabola),
    "one parabolic curve, --joint mortar": one_curve,
    "cohesion, linear softening": cohesion,
    "cohesion, --joint mortar": cohesion,
    "bond-slip, no pressure": bond_slip,
    "Barton-Bandis": barton_bandis,
    "Plesha, cycles": plesha,
    "cycles on parabolic asperities": parabolic_strokes,
    "nonsense": nonsense,
}
"""Laws by name, which ends with the form of the joint where that is known."""
