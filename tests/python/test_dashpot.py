"""The dashpot on the closed contact (PROPS 24): losses, bounds, doors; test_shaken_points.py has motions."""

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

LONG = 1e12
"""Duration of an increment in which a dashpot does nothing."""


def joint(kn: float, c: float = 0.0) -> Interface:
    """Flat joint without bond."""
    return Interface(Material.from_joint(kn=kn, ks=0.4 * kn, mu=0.5, c=c), Pattern.regular(0, 0.0))


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
        # without viscous damage the duration has no effect on the law without a dashpot
        without = plain.update(s, state, s_old, dt)
        for law, time in ((with_none, dt), (damped, 0.0), (damped, LONG)):
            if time != dt and plain.material.tau_v:
                continue
            with_law = law.update(s, state, s_old, time)
            size = size + np.abs(without.traction).max()
            assert (np.abs(with_law.traction - without.traction) <= 1e-9 * size).all()
            ours, theirs = with_law.state, without.state
            assert (np.abs(ours - theirs) <= np.maximum(1e-8 * np.abs(theirs), 1e-9)).all()


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
        errors.append(abs(work - state[0, 1:4].sum()) / abs(work))
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2] and errors[2] < 2e-3, errors


# --- doors --------------------------------------------------------------------------------------------------


def test_a_static_step_is_harmless() -> None:
    """In a step of the time 1 the closure is short by a share c/(kn dt)."""
    kn, c, n = 2e4, 24.0, 50
    test = joint(kn, c).run(Step(t_N=-1.0, increments=n, time=1.0))
    assert test.separation[-1, 0] == pytest.approx(-1.0 / kn, rel=1.1 * c / kn)
    assert test.separation[-1, 0] > -1.0 / kn


@pytest.mark.parametrize("xi", [0.2, 1.5])
def test_card_prints_the_stable_increment(xi: float) -> None:
    """The card of Abaqus/Explicit has the share of the stable increment that the dashpot leaves."""
    kn, density, h = 2e4, 0.0024, 0.5
    law = joint(kn, 2.0 * xi * np.sqrt(kn * density * h))
    share = re.findall(r"scale factor=([\d.]+)", law.card("abaqus", explicit=True, density=density, h=h))
    assert [float(value) for value in share] == pytest.approx([np.sqrt(1.0 + xi**2) - xi], rel=1e-3)
    for text in (law.card("abaqus"), joint(kn).card("abaqus", explicit=True, density=density)):
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
    law = joint(2e4, 24.0)
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


@pytest.mark.parametrize("lag", [1e-3, 0.3, 10.0, 1e3, 1e5])
@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_losses_of_jumps_and_their_parts(mu: float, lag: float) -> None:
    """A jump of any duration loses what its parts lose, also where it releases an elastic slip."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": mu, "damage0": 1.0, "kc": 5.0}
    c = lag * Material(**constants).K * 5.0
    joint = Interface(Material(**constants, c=c), Pattern.regular(0, 0.0))
    targets = [[-0.022, 0.12, -0.06], [-0.0226, -0.05, -0.05], [0.03, 0.1, 0.1], [-0.05, 0.0, 0.3]]
    state, start = np.zeros((1, joint.nstatv)), np.zeros((1, 3))
    for s in np.array([*targets, [-0.03, 0.05, 0.25], [0.01, 0.05, 0.25]])[:, None]:
        once, parts = joint.update(s, state, start, 1.0).state, state
        for i in range(300):
            before, after = (start + (s - start) * part / 300 for part in (i, i + 1))
            parts = joint.update(after, parts, before, 1.0 / 300).state
        assert once[0, 3] - state[0, 3] == pytest.approx(parts[0, 3] - state[0, 3], rel=0.02)
        state, start = once, s
