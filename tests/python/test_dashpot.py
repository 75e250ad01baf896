"""The dashpot on the closed contact (PROPS 24): impacts, base motion, rocking in closed form; losses, doors.

Units of the dynamic tests: m, MN, s, kt.  Each test has its own mass on a joint, and integrates in time by
central differences, or lets a rigid block rock on a row of points.
"""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Step
from asperity.installed import driver
from support_calls import LIBRARY, umat, vumat
from support_driver import call
from test_oracle import OPTIONS

from harness.studies.validation.shaken_points import (
    ALPHA,
    LONG,
    MASS,
    RADIUS,
    G,
    energy,
    joint,
    pulse,
    rest,
    restitution,
    ride,
    rock,
    shaken,
)

# --- a mass on a joint --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("xi", "theta"), [(0.1, 0.0), (0.3, 0.0), (0.7, 0.0), (0.99, 0.0), (2.0, 0.0), (0.3, 20.0)]
)
def test_impacts(xi: float, theta: float) -> None:
    """The ratio of restitution is that of the closed form; friction obeys impulses: d v_t = mu (1 + e) v_n.

    On an inclined plane the components are those along its normal and its line of steepest ascent.
    """
    kn, mu, v_n, v_t = 2e4, 0.3, 0.01, 0.1
    omega = np.sqrt(kn / MASS)
    law = joint(theta, mu, kn, 2.0 * xi * np.sqrt(kn * MASS))
    a = np.radians(theta)
    axes = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0]])
    none = np.zeros(3)
    _, v, _ = ride(law, 2e-3 / omega, 2600, lambda _: none, none, [-v_n, v_t] @ axes)
    after = axes @ v[-1]
    e = restitution(xi)
    # of the step: omega dt = .002
    assert after[0] / v_n == pytest.approx(e, abs=5e-4)
    assert v_t - after[1] == pytest.approx(mu * (1.0 + after[0] / v_n) * v_n, rel=1e-3)


@pytest.mark.parametrize("xi", [0.0, 0.1, 0.5, 1.0])
def test_explicit_step(xi: float) -> None:
    """A mass that stays in contact is stable up to (2/omega)(sqrt(1 + xi^2) - xi), and not much further."""
    kn = 2e4
    law, omega = joint(0.0, 0.5, kn, 2.0 * xi * np.sqrt(kn * MASS)), np.sqrt(kn / MASS)
    down = np.array([-G, 0.0, 0.0])
    at, limit = rest(law), 2.0 / omega * (np.sqrt(1.0 + xi**2) - xi)
    for share, stable in ((0.97, True), (1.03, False)):
        start = at * [1.001, 1.0, 1.0]
        s, _, _ = ride(law, share * limit, 300, lambda _: down, start, np.zeros(3))
        largest = np.abs(s[-30:, 0] - at[0]).max()
        assert (largest < 2e-3 * abs(at[0])) == stable


# --- base motion --------------------------------------------------------------------------------------------


def test_pulse_on_a_flat_joint() -> None:
    """Newmark's sliding block, and the error that the spring makes: C/(omega t0)."""
    mu, A, t0, kn, dt = 0.5, 1.0, 0.1, 2e5, 1e-4
    V = A * G * t0
    rigid = V**2 / (2.0 * mu * G) * (1.0 - mu / A)
    phi = np.arccos(1.0 - mu / A)
    C = 2.0 * (A * np.sin(phi) - (A - mu) * phi) / (A - mu)
    error = C / (np.sqrt(0.4 * kn / MASS) * t0)
    s, ledger = shaken(joint(0.0, mu, kn), pulse(A, t0, dt), 0.35, dt)
    assert 1e3 * rigid == pytest.approx(49.05)
    assert s[-1, 1] == pytest.approx(rigid * (1.0 + error), rel=2e-4)
    assert ledger < 1e-5
    # with the critical dashpot the stuck mass does not swing on
    damped, ledger = shaken(joint(0.0, mu, kn, 2.0 * np.sqrt(kn * MASS)), pulse(A, t0, dt), 0.35, dt)
    assert rigid < damped[-1, 1] < rigid * (1.0 + 0.5 * error)
    assert ledger < 1e-3


def test_harmonic_base() -> None:
    """Den Hartog's always sliding block, mu .25: peak to peak 38.453 mm, and .82 % more on this spring."""
    mu, A, kn, dt = 0.25, 0.5, 2e5, 2e-4
    w = 4.0 * np.pi
    closed = 2.0 * A * G / w**2 * np.sqrt(1.0 - (0.5 * np.pi * mu / A) ** 2)
    # each of 6 cycles of .5 s; the start dies out
    s, _ = shaken(joint(0.0, mu, kn), lambda t: A * G * np.sin(w * t), 3.0, dt)
    last = s[-round(0.5 / dt) :, 1]
    assert 1e3 * closed == pytest.approx(38.453, abs=5e-4)
    assert np.ptp(last) / closed - 1.0 == pytest.approx(0.0082, abs=0.0015)


def test_pulse_on_an_inclined_plane() -> None:
    """The block climbs to the closed height; with the dashpot it stays where it ends."""
    theta, mu, A, t0, kn, dt = 10.0, 0.5, 1.5, 0.1, 2e5, 2e-4
    sine, cosine = np.sin(np.radians(theta)), np.cos(np.radians(theta))
    up = A * G * cosine - G * sine - mu * G * (cosine + A * sine)
    length = 0.5 * up * t0**2 * (1.0 + up / (G * sine + mu * G * cosine))
    assert 1e3 * length == pytest.approx(67.544, abs=5e-4)
    s, _ = shaken(joint(theta, mu, kn), pulse(A, t0, dt), 0.4, dt)
    assert 1e3 * s[:, 0].max() == pytest.approx(11.78, abs=0.01)
    assert s[:, 0].max() == pytest.approx(length * sine, rel=5e-3)
    dt = 1e-4  # the dashpot lowers the stable increment
    s, _ = shaken(joint(theta, mu, kn, 2.0 * np.sqrt(kn * MASS)), pulse(A, t0, dt), 0.4, dt)
    assert np.hypot(*s[-1, :2]) == pytest.approx(length, rel=2e-3)
    assert np.ptp(s[-200:], axis=0).max() < 1e-5 * length


# --- a block that rocks -------------------------------------------------------------------------------------


def test_rocking_on_two_edges() -> None:
    """Housner's period and ratio of angular velocities, if only the edges touch, and do not bounce."""
    share, p = 0.5, np.sqrt(0.75 * G / RADIUS)
    period, ratio = rock(2, 1.0, share)
    assert period == pytest.approx(4.0 * np.arccosh(1.0 / (1.0 - share)) / p, rel=2e-3)
    assert ratio == pytest.approx(1.0 - 1.5 * np.sin(ALPHA) ** 2, abs=1e-3)


def test_rocking_on_a_full_base() -> None:
    """A base of many points loses less: between the plastic limit, .9640, and 1."""
    assert rock(21, 1.0, 0.3)[1] == pytest.approx(0.974, abs=0.003)


# --- the law ------------------------------------------------------------------------------------------------


def walk(law: Interface, seed: int, steps: int = 30, points: int = 40) -> list[tuple[np.ndarray, ...]]:
    """Increments (s, state, s_old, dt) of random walks of points, most of them under pressure."""
    rng, size = np.random.default_rng(seed), law.material.s_0
    s_old, state, made = np.zeros((points, 3)), np.zeros((points, law.nstatv)), []
    for _ in range(steps):
        s = s_old + size * 10 ** rng.uniform(-1.5, 0.5, (points, 1)) * rng.standard_normal((points, 3))
        s[:, 0] -= 0.2 * size
        dt = float(0.1 * 10 ** rng.uniform(-2, 2))
        made.append((s, state, s_old, dt))
        state, s_old = law.update(s, state, s_old, dt).state, s
    return made


@pytest.mark.parametrize("option", [name for name in OPTIONS if "dashpot" not in name])
def test_without_effect(option: str) -> None:
    """A dashpot does nothing in a long increment or in one without duration: the law is as it is."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    pattern = Pattern.regular(4, 35.0, 0.2, 10.0)
    plain, damped = (Interface(Material(**constants | more), pattern) for more in ({}, {"c": 7.0}))
    with_none = Interface(Material(**constants | {"c": 1e-30}), pattern)
    for s, state, s_old, dt in walk(plain, 7, steps=12):
        size = np.abs(s).max(axis=1)[:, None] * plain.material.K * max(1.0, plain.material.kc)
        for law, time in ((with_none, dt), (damped, 0.0), (damped, LONG)):
            if time != dt and plain.material.tau_v:
                continue
            without, with_law = (joint.update(s, state, s_old, time) for joint in (plain, law))
            size = size + np.abs(without.traction).max()
            assert (np.abs(with_law.traction - without.traction) <= 1e-9 * size).all()
            # a dashpot keeps the trapezoidal rule for rupture and friction of increments of any length
            accounts = [2, 3]
            if "crush" in constants and "W0" not in constants:
                accounts += [*range(8 + 3 * plain.n_planes + 1, plain.nstatv, 2)]
            ours, theirs = (np.delete(end.state, accounts, axis=1) for end in (with_law, without))
            assert ours == pytest.approx(theirs, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("option", [name for name in OPTIONS if "dashpot" in name])
def test_losses_and_bounds(option: str) -> None:
    """No loss is negative and no energy comes from nothing in closed loops."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    law = Interface(Material(**constants), Pattern.regular(4, 35.0, 0.2, 10.0))
    for s, state, s_old, dt in walk(law, 11):
        end = law.update(s, state, s_old, dt)
        assert (end.state[:, 3] - state[:, 3] >= -1e-12 * np.maximum(1.0, state[:, 3])).all()
        assert np.isfinite(end.tangent).all()


def test_bound_of_friction() -> None:
    """On a flat joint the stress along it stays within mu times the total pressure, which is no tension."""
    law = Interface(Material.from_joint(kn=50.0, ks=20.0, mu=0.6, c=4.0), Pattern.regular(0, 0.0))
    clipped = 0
    for s, state, s_old, dt in walk(law, 13):
        t = law.update(s, state, s_old, dt).traction
        p = np.maximum(0.0, 50.0 * np.maximum(-s[:, 0], 0.0)
                       + 4.0 / dt * (np.maximum(-s[:, 0], 0.0) - np.maximum(-s_old[:, 0], 0.0)))  # fmt: skip
        p[s[:, 0] > 0.0] = 0.0
        clipped += int(((p == 0.0) & (s[:, 0] < 0.0)).sum())
        assert -t[:, 0] == pytest.approx(p, rel=1e-12, abs=1e-12 * p.max())
        assert (np.hypot(t[:, 1], t[:, 2]) <= 0.6 * p * (1.0 + 1e-12) + 1e-300).all()
    assert clipped > 20


def test_ledger() -> None:
    """Work of the traction = stored + spent, with an error that falls with the increments."""
    law = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=5.0, damage0=0.6, c=2.0), Pattern.regular(4, 30.0))
    errors = []
    for parts in (250, 1000, 4000):
        t = np.linspace(0.0, 1.0, parts + 1)
        s = np.column_stack([-0.02 * np.sin(9.0 * t), 0.05 * np.sin(5.0 * t), 0.02 * t])
        state, work, old = np.zeros((1, law.nstatv)), 0.0, np.zeros((1, 3))
        for a, b in itertools.pairwise(s):
            end = law.update(b[None], state, a[None], 1.0 / parts)
            work += 0.5 * float((old + end.traction)[0] @ (b - a))
            state, old = end.state, end.traction
        errors.append(abs(work - energy(state)[0]) / abs(work))
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2] and errors[2] < 2e-3, errors


# --- doors --------------------------------------------------------------------------------------------------


def test_a_static_step_is_harmless() -> None:
    """In a step of the time 1 the closure is short by a share c/(kn dt)."""
    kn, c, n = 2e4, 24.0, 50
    test = joint(0.0, 0.5, kn, c).run(Step(t_N=-1.0, increments=n, time=1.0))
    assert test.separation[-1, 0] == pytest.approx(-1.0 / kn, rel=1.1 * c / kn)
    assert test.separation[-1, 0] > -1.0 / kn


@pytest.mark.parametrize("xi", [0.2, 1.5])
def test_card_prints_the_stable_increment(xi: float) -> None:
    """The card of Abaqus/Explicit has the share of the stable increment that the dashpot leaves."""
    kn, density, h = 2e4, 0.0024, 0.5
    law = joint(0.0, 0.5, kn, 2.0 * xi * np.sqrt(kn * density * h))
    share = re.findall(r"scale factor=([\d.]+)", law.card("abaqus", explicit=True, density=density, h=h))
    assert [float(value) for value in share] == pytest.approx([np.sqrt(1.0 + xi**2) - xi], rel=1e-3)
    for text in (law.card("abaqus"), joint(0.0, 0.5, kn).card("abaqus", explicit=True, density=density)):
        assert "scale factor" not in text


def test_vumat() -> None:
    """The VUMATs of both precisions follow the law in Python; the packager's call knows no dashpot."""
    law = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=2.0, damage0=0.7, c=1.5), Pattern.regular(4, 30.0))
    for kind, tolerance in ((np.float64, 1e-10), (np.float32, 2e-3)):
        s_old, state, stress = np.zeros((40, 3)), np.zeros((40, law.nstatv)), np.zeros((40, 3))
        theirs = state.copy()
        for s, _, _, dt in walk(law, 17, steps=8):
            end = law.update(s, state, s_old, dt)
            strain = (s - s_old)[:, [0, 2, 1]] * [1.0, 0.5, 0.5]
            props = law.props().astype(kind)
            out = vumat(LIBRARY, props, np.ones(40, kind), (1.0, dt), strain, stress, theirs)
            got = np.asarray(out.stress, float)[:, [0, 2, 1]]
            assert got == pytest.approx(end.traction, abs=tolerance * np.abs(end.traction).max())
            stress, theirs, s_old, state = out.stress, out.state, s, end.state


def test_durations() -> None:
    """A duration that is missing, negative or too short for the dashpot is refused with its name."""
    law = joint(0.0, 0.5, 2e4, 24.0)
    s = np.array([[-1e-5, 0.0, 0.0]])
    wrong = {
        None: "dt is missing: expected for a dashpot, c = 24",
        -1.0: "dt = -1",
        1e-14: r"dt = 1e-14: expected .* \(dashpot, c = 24: 0, or more than 1e-10 c/\(kc Kn\)\)",
    }
    for dt, words in wrong.items():
        with pytest.raises(ValueError, match=words):
            law.update(s, dt=dt)
    with pytest.raises(ValueError, match="c = -1: expected >= 0"):
        Material.from_joint(2e4, 8e3, 0.5, c=-1.0)
    none = np.zeros(3)
    out = umat(LIBRARY, law.props(), none, np.zeros(law.nstatv), none, none, None)
    assert np.isnan(out.stress).all()


CASE = """&case title = 'Dashpot' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 10.0, damage0 = 1.0, c = 50.0 /
&pattern sides = 0 /
&step s_N = -0.001, increments = 1, time = {time} /
&expect t_N = {t_N}, tolerance = 1e-9 /
"""


def test_case(tmp_path: Path) -> None:
    """A step of the driver presses in a time: kc K s + c s/t."""
    for time in (0.01, 10.0):
        t_N = -0.001 * (10.0 * 150.0 + 50.0 / time)
        (tmp_path / "damped.nml").write_text(CASE.format(time=time, t_N=t_N), encoding="utf-8")
        done = call(driver(), "damped.nml", folder=tmp_path)
        assert done.returncode == 0, done.stderr
    branch = (
        CASE.format(time=1.0, t_N=0.0)
        .replace("s_N = -0.001", "t_N = -1.0")
        .replace("increments = 1", "arc = 0.001, follow = 'branch'")
    )
    (tmp_path / "branch.nml").write_text(branch, encoding="utf-8")
    done = call(driver(), "branch.nml", folder=tmp_path)
    assert done.returncode == 1
    assert "c = 50: expected 0, as no time passes on a branch" in done.stderr
