"""Compressive strength of a joint: the reference, closed forms, energies, tangents, none without fc."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern, Step, contract
from support_calls import LIBRARY, errors, umat
from test_oracle import OPTIONS, POINTS, assert_within, by_c, by_umat, traction_by_c

from tests.oracle import accounts, cap, implex, reference

# CTest has no markers, and pytest need not repeat it
pytestmark = [pytest.mark.filterwarnings("ignore::asperity.ModelWarning"), pytest.mark.long]

SEED = 69
CAPS = (
    {"fc": 6.0, "Gfc": 0.4},
    {"fc": 3.0, "Gfc": 2.0, "kp": 0.02, "Css": 2.0, "fcr": 0.3},
    {"fc": 12.0, "Gfc": 0.3, "kp": 0.1, "Css": 0.0, "fcr": 0.0},
)
"""Strengths of a joint with sigma0 = 3 and s_f = 0.2: brittle, ductile, and without shear and residual."""
K = 82.0
MASONRY = {"sigma0": 0.25, "Gc": 0.018, "eta": 1.0 - 0.25**2 / (2.0 * 0.018 * K), "mu": 0.75, "sigma02": 0.35}
"""Mortar joint with the stiffness K in opening and closing."""


def flat(**strength: float) -> Interface:
    """Mortar joint of one plane with a compressive strength."""
    return Interface(Material(**MASONRY, Gc2=0.125, **strength), Pattern.regular(0, 0.0))


def walk(rng: np.random.Generator, joint: Interface, s: np.ndarray) -> np.ndarray:
    """Separations (n, 3) after a random step, more often closing than opening."""
    sizes = joint.material.s_0 * 10 ** rng.uniform(-1.0, 0.7, (len(s), 1))
    step: np.ndarray = sizes * rng.standard_normal((len(s), 3)) - [0.5 * joint.material.s_0, 0.0, 0.0]
    return s + step


PATTERNS = [(0, 1.0), (2, 0.0), (5, 0.3)]
"""Sides and share of the flat plane, one for each of CAPS."""
SOAK = int(os.environ.get("ASPERITY_CALLS", "0")) >= 10**6
"""Whether `make soak` runs: all of CAPS for each option; else one of them, and an option for the aim."""
DRAWN = [(o, k) for i, o in enumerate(OPTIONS) for k in range(len(CAPS)) if SOAK or k == i % len(CAPS)]


@pytest.mark.parametrize(("option", "k"), DRAWN)
def test_reference(option: str, k: int) -> None:
    """Tractions and states are those of the bisection, the closure never falls, nor does its energy.

    The tangent is the derivative of the traction where both sides of a step take the same branch.
    """
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    parameters, rng = reference.Parameters(**constants), np.random.default_rng(SEED)
    (sides, share), strength, off, crushed, tried, missed = PATTERNS[k], CAPS[k], 0, 0, 0, 0
    joint = Interface(Material(**constants, **strength), Pattern.regular(sides, 30.0, share, 20.0))
    planes = reference.regular_pattern(sides, 30.0, share, 20.0)
    s_old, state = np.zeros((POINTS, 3)), np.zeros((POINTS, joint.nstatv))
    # the energy that crushing takes is part of the friction
    crushes = parameters.crush > 0.0 and parameters.W0 == 0.0
    works = range(9 + 3 * joint.n_planes, joint.nstatv - 2, 2) if crushes else ()
    for _ in range(6):
        s = walk(rng, joint, s_old)
        dt = float(rng.choice([0.0, 0.1 * 10 ** rng.uniform(-3, 3)], p=[0.1, 0.9]))
        ours = by_c(joint.props(), s, state, s_old, dt)
        kappa, tangent = ours[1][:, -2], ours[2]
        theirs, new = cap.update(parameters, cap.Cap(**strength), planes, s, state, s_old, dt, kappa)
        # accounts of long increments are judged by test_jumps; the crushing is what they leave
        before, after = s_old.copy(), s.copy()
        before[:, 0] += state[:, -2]
        after[:, 0] += new[:, -2]
        long = accounts.long(parameters, before, after, dt)
        if parameters.c:  # a joint that is crushed is summed over parts of the step itself
            long |= accounts.long(replace(parameters, tau_v=0.0), s_old, s, dt)
        left_out = long[:, None] & np.isin(np.arange(joint.nstatv), [2, 3, joint.nstatv - 1, *works])
        total = np.linalg.norm(s, axis=1) + new[:, -2]
        size = (
            np.abs(theirs).max(axis=1) + parameters.Kn * max(1.0, parameters.kc) * total + joint.material.fc
        )
        # where the excess falls to zero and rises again, a smaller closure is not always found
        same = np.flatnonzero(kappa <= new[:, -2] + 1e-9 * parameters.s0)
        missed += POINTS - len(same)
        few = same[:10]
        by_points = by_umat(joint.props(), s[few], state[few], s_old[few], dt)
        for (traction, ends, _), some in ((tuple(a[same] for a in ours), same), (by_points, few)):
            assert_within("traction", traction, theirs[some], 1e-10 * size[some, None])
            scale = 1.0 + size * (total + joint.material.s_f) + np.abs(new).max(axis=1)
            judged = np.where(left_out[some], new[some], ends)
            assert_within("state", judged, new[some], 1e-10 * scale[some, None])
            assert (ends[:, -2:] >= state[some, -2:]).all()
        step = 1e-6 * joint.material.s_0
        for i, axis in enumerate(np.eye(3)):
            above, below = (
                traction_by_c(joint.props(), s + sign * step * axis, state, s_old, dt) for sign in (1, -1)
            )
            wrong = np.abs((above - below) / (2.0 * step) - tangent[:, :, i]).max(axis=1)
            off += int((wrong > 1e-4 * (np.abs(tangent).max(axis=(1, 2)) + joint.material.K)).sum())
            tried += POINTS
        crushed += int((new[:, -2] > state[:, -2]).sum())
        state, s_old = new, s
    assert crushed > POINTS and missed <= 1, (crushed, missed)
    # a kink within the step: contact, onset of slip or crushing, trial slip of almost zero
    assert off <= 0.01 * tried, (off, tried)


SMALLEST = {
    "brittle": (
        {"eta": 0.9, "fc": 10.0, "Gfc": 0.1, "Css": 0.0, "fcr": 0.0}, (5, 0.3), 0.0,
        ([-5.0, -10.0, -8.0], [-2.5, 10.0, 8.0]),
    ),
    "sheared back": (
        {"eta": 0.99, "fc": 4.0, "Gfc": 4.0}, (0, 1.0), 10.0, ([-6.0, -6.0, -6.0], [0.0, 6.0, 6.0])
    ),
}  # fmt: skip
"""Constants, planes, and what is drawn: size of a separation, then the ends of a step, over s_0."""


@pytest.mark.parametrize("name", SMALLEST)
def test_smallest_closure(name: str) -> None:
    """A joint takes the smallest closure, not a larger one at which it is broken."""
    constants, (sides, share), far, ends = SMALLEST[name]
    bond = {"sigma0": 3.0, "Gc": 0.3, "mu": 0.5, "eta": constants["eta"]}
    strength = {key: value for key, value in constants.items() if key not in bond}
    joint = Interface(Material(**bond, **strength), Pattern.regular(sides, 30.0, share))
    rng, n, s_0 = np.random.default_rng(SEED), 10 * POINTS, joint.material.s_0
    virgin, origin = np.zeros((n, joint.nstatv)), np.zeros((n, 3))
    s_old = s_0 * far * rng.uniform([-1.0, -1.0, -1.0], [0.0, 1.0, 1.0], (n, 3))
    state = by_c(joint.props(), s_old, virgin, origin, 1.0)[1]
    s = s_old + s_0 * rng.uniform(*ends, (n, 3))
    traction, new, _ = by_c(joint.props(), s, state, s_old, 1.0)
    parameters, kappa = reference.Parameters(**bond), new[:, -2]
    planes = reference.regular_pattern(sides, 30.0, share, 0.0)
    theirs, expected = cap.update(parameters, cap.Cap(**strength), planes, s, state, s_old, 1.0, kappa)
    assert (expected[:, -2] > state[:, -2]).sum() > n / 4
    assert_within("closure", kappa, expected[:, -2], 1e-9 * s_0)
    assert_within("traction", traction, theirs, 1e-10 * joint.material.fc)


@pytest.mark.parametrize(("kp", "fcr"), [(0.0, 0.0), (0.09, 0.1)])
def test_prism(kp: float, fcr: float) -> None:
    """A pressed joint reaches fc, and the energy under the curve is that of its parts.

    Parabola: kp fc (1 + pi/2)/3; softening: Gfc up to its end, and the residual share times fc of the way.
    """
    fc, Gfc, increments = 10.5, 5.0, 4000
    joint = flat(fc=fc, Gfc=Gfc, kp=kp, fcr=fcr)
    rows = joint.run(Step(s_N=-6.0, increments=increments))
    p, kappa = -rows.traction[:, 0], rows.kappa - kp
    # the first row beyond the peak has softened over an increment at most
    assert fc - ((1.0 - fcr) * fc) ** 2 / Gfc * 6.0 / increments <= p.max() <= fc * (1.0 + 1e-12)
    assert np.allclose(kappa + kp + p / K, -rows.separation[:, 0], rtol=1e-12)
    after = kappa > 0.0
    falls = (1.0 - fcr) * fc
    assert np.allclose(p[after], fcr * fc + falls * np.exp(-kappa[after] * falls / Gfc), rtol=1e-9)
    spent = (
        Gfc * (1.0 - np.exp(-kappa[-1] * falls / Gfc))
        + fcr * fc * kappa[-1]
        + kp * fc * (1.0 + np.pi / 2.0) / 3.0
    )
    # the trapezoidal rule, second order in the increment
    assert rows.crushing[-1] == pytest.approx(spent, rel=1e-5)
    ledger = rows.stored + rows.rupture + rows.friction + rows.crushing
    assert np.allclose(rows.work, ledger, rtol=1e-10)


@pytest.mark.parametrize("kp", [0.0, 0.09])
def test_couplet(kp: float) -> None:
    """Sheared under a constant pressure, a joint carries no more than its friction and the ellipse.

    Beyond the ellipse the softening has no equilibrium under this pressure, which is reported.
    """
    fc = 10.5
    joint = flat(fc=fc, Gfc=5.0, kp=kp)
    for p in (6.0, 8.0, 10.0):
        with pytest.raises(EquilibriumLost, match="none found") as lost:
            joint.run([Step(t_N=-p, increments=10), Step(slip=0.5, increments=2000)])
        rows = lost.value.history
        ellipse = np.sqrt((fc**2 - p**2) / 9.0)
        assert rows.tau.max() <= ellipse * (1.0 + 1e-9)
        s_02 = 2.0 * (1.0 - joint.material.eta) * joint.material.Gc2 / joint.material.sigma02
        # the last row before the peak is less than an increment of K slip below it
        assert rows.tau.max() > ellipse - 2.0 * 0.5 / 2000 * joint.material.sigma02 / s_02
    weak = joint.run([Step(t_N=-1.0, increments=10), Step(slip=1.0, increments=200)])
    assert weak.tau[-1] == pytest.approx(0.75, rel=1e-9) and weak.kappa[-1] == 0.0


def test_without_strength_nothing_changes() -> None:
    """Without fc the other constants change no bit, and the state has no more numbers."""
    rng, without = np.random.default_rng(SEED), {"Gfc": 2.0, "Css": 3.0, "kp": 0.1, "fcr": 0.5}
    for option in ("paper", "crush and wear", "all and a dashpot"):
        constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
        joints = [
            Interface(Material(**constants, **more), Pattern.regular(5, 30.0)) for more in ({}, without)
        ]
        assert joints[0].nstatv == joints[1].nstatv
        s = walk(rng, joints[0], np.zeros((POINTS, 3)))
        ends = [joint.update(s, dt=0.3) for joint in joints]
        for name in ("traction", "state", "tangent"):
            assert np.array_equal(getattr(ends[0], name), getattr(ends[1], name))


def test_energies_of_random_walks() -> None:
    """Work and energies agree to second order in the increment, and no crushing gives energy back."""
    rng = np.random.default_rng(SEED)
    for option, strength in (("damage0", CAPS[0]), ("without bond", CAPS[1]), ("crush and height", CAPS[1])):
        constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
        joint = Interface(Material(**constants, **strength), Pattern.regular(4, 30.0))
        corners = np.cumsum(joint.material.s_0 * (rng.standard_normal((20, 50, 3)) - [0.4, 0.0, 0.0]), axis=0)
        errors = []
        for parts in (16, 64):
            s_old, state = np.zeros((50, 3)), np.zeros((50, joint.nstatv))
            t_old, work = np.zeros((50, 3)), np.zeros(50)
            begin = np.zeros((50, 3))
            for end in corners:
                for i in range(1, parts + 1):
                    s = begin + (end - begin) * i / parts
                    now = joint.update(s, state, s_old, 1.0)
                    assert (now.kappa >= state[:, -2]).all() and (now.crushing >= state[:, -1]).all()
                    work += 0.5 * ((now.traction + t_old) * (s - s_old)).sum(axis=1)
                    s_old, state, t_old = s, now.state.copy(), now.traction
                begin = end
            assert (now.kappa > 0.0).sum() > 25
            ledger = now.stored + now.rupture + now.friction + now.crushing
            errors.append(np.abs(work - ledger).max() / np.abs(work).max())
        assert errors[1] < 2e-3 and errors[1] < errors[0] / 3.0, (option, errors)


@pytest.mark.parametrize("option", OPTIONS if SOAK else ["all and a dashpot"])
def test_aim(option: str) -> None:
    """With the variables of an aim the traction is the gradient of a convex energy, with its bound."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    parameters, rng, bounded = reference.Parameters(**constants), np.random.default_rng(SEED), 0
    for (sides, share), strength in zip(((0, 1.0), (2, 0.0), (5, 0.3)), CAPS, strict=True):
        joint = Interface(Material(**constants, **strength), Pattern.regular(sides, 30.0, share, 20.0))
        planes = reference.regular_pattern(sides, 30.0, share, 20.0)
        s_old, state = np.zeros((POINTS, 3)), np.zeros((POINTS, joint.nstatv))
        for _ in range(4):
            s, dt = walk(rng, joint, s_old), 0.1
            aim = s_old + rng.choice([0.0, 1.0, 1.5], (POINTS, 1)) * (s - s_old)
            plain, ends = joint.update(s, state, s_old, dt), joint.update(s, state, s_old, dt, aim=aim)
            kappa = joint.update(aim, state, s_old, dt).kappa
            given = aim, s, state, s_old, dt, kappa
            theirs = cap.frozen_traction(parameters, cap.Cap(**strength), planes, *given)
            total = np.linalg.norm(s, axis=1) + np.linalg.norm(aim, axis=1) + plain.kappa + joint.material.s_f
            size = np.abs(theirs).max(axis=1) + parameters.Kn * max(1.0, parameters.kc) * total
            assert_within("traction", ends.traction, theirs, 1e-9 * size[:, None])
            assert np.array_equal(ends.state, plain.state)
            assert np.array_equal(ends.tangent, ends.tangent.transpose(0, 2, 1))
            values = np.linalg.eigvalsh(ends.tangent)
            assert (values[:, 0] >= -1e-12 * (values[:, 2] + joint.material.K)).all()
            bounded += int((ends.tangent[:, 0] == 0.0).all(axis=1).sum())
            there = joint.update(s, state, s_old, dt, aim=s)
            assert_within("traction", there.traction, plain.traction, 1e-9 * size[:, None])
            state, s_old = plain.state, s
    assert bounded > POINTS


@pytest.mark.parametrize("kind", range(3))
@pytest.mark.parametrize("option", ["paper", "crush and wear", "dashpot and bond", "all and a dashpot"])
def test_implex(option: str, kind: int) -> None:
    """Traction, errors and state of IMPL-EX are those of the reference; the strength comes last in STATEV."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | OPTIONS[option]
    parameters, rng, crushed = reference.Parameters(**constants), np.random.default_rng([SEED, kind]), 0
    (sides, share), strength = ((0, 1.0), (2, 0.0), (5, 0.3))[kind], CAPS[kind]
    joint = Interface(Material(**constants, **strength), Pattern.regular(sides, 30.0, share, 20.0))
    planes, props = reference.regular_pattern(sides, 30.0, share, 20.0), joint.props(implex=0.1)
    names = contract.umat_names(*contract.check(props), 0.1, yields=True)
    of_law = [*range(joint.nstatv - 2), len(names) - 2, len(names) - 1]
    assert names[-2:] == ("kappa", "crushing") and len(names) == joint.nstatv + 7 + joint.n_planes
    s, state, own = np.zeros(3), np.zeros(len(names)), implex.Own.virgin(joint.n_planes)
    for step in range(20):
        dt = float(10 ** rng.uniform(-1.0, 0.5))
        end, first = walk(rng, joint, s[None])[0], step in (0, 7)
        law = state[of_law]
        given = s[None], end[None], law[None], own, first, dt, cap.Cap(**strength)
        (expected,), own = implex.step(parameters, planes, *given)
        kinc = 1 if first else step + 1
        out = umat(LIBRARY, props, np.zeros(3), state, s, end - s, dt, kinc=kinc)
        # the separation at the end is the sum of STRAN and DSTRAN
        plain = joint.update(s[None] + (end - s)[None], law[None], s[None], dt)
        size = np.abs([*expected, *plain.traction[0]]).max() + parameters.Kn * max(1.0, parameters.kc) * (
            np.abs([*end, *s, *own.aim[0]]).max() + plain.kappa[0] + joint.material.s_f
        )
        scale = 1.0 + size * joint.material.s_f + np.abs(plain.state).max()
        assert_within("state", out.state[of_law], plain.state[0], 1e-10 * scale)
        assert_within("traction", out.stress, expected, 1e-9 * size)
        values = dict(zip(names, out.state.tolist(), strict=True))
        assert values["e_t"] == pytest.approx(own.e_t[0], abs=1e-8 * size / constants["sigma0"])
        crushed += values["kappa"] > law[-2]
        state, s = out.state, end
    assert crushed > 2
    state[:] = np.nan
    with errors() as said:
        out = umat(LIBRARY, props, np.zeros(3), state, s, np.zeros(3), 1.0)
        assert f"STATEV({len(names) - 1}) kappa = NaN" in said()
    assert np.isnan(out.stress).all() and np.array_equal(out.state, state, equal_nan=True)


def test_refusals() -> None:
    """A strength has an energy, a residual share is below 1, and a state is in its range."""
    with pytest.raises(ValueError, match=r"fc = 10.*expected Gfc > 0 beside it"):
        Material(**MASONRY, fc=10.0)
    with pytest.raises(ValueError, match=r"fcr = 1.*expected 0 <= fcr < 1"):
        Material(**MASONRY, fc=10.0, Gfc=5.0, fcr=1.0)
    joint = flat(fc=10.5, Gfc=5.0)
    state = np.zeros((1, joint.nstatv))
    state[0, -2] = -1e-3
    with pytest.raises(ValueError, match=r"STATEV\(12\) kappa = -0\.001: expected a finite number from 0"):
        joint.update([[0.0, 0.0, 0.0]], state)


@pytest.mark.parametrize("kp", [0.0, 1e-9, 0.01])
@pytest.mark.parametrize("Gfc", [1e11, 1e16, 1e40])
def test_softening_without_end(Gfc: float, kp: float) -> None:
    """A strength that hardly softens stays fc, however long its softening: the closure keeps its digits."""
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5, fc=10.0, Gfc=Gfc, kp=kp), Pattern.regular(0, 0.0))
    state, s_old = np.zeros((1, joint.nstatv)), np.zeros((1, 3))
    for closure in (0.1, 0.4):
        s = np.array([[-closure, 0.0, 0.0]])
        traction, state, _ = by_c(joint.props(), s, state, s_old, 0.0)
        s_old = s
        # fc falls by fc^2/Gfc times the closure beyond kp
        assert traction[0, 0] == pytest.approx(-10.0, rel=1e-9)
        assert state[0, -2] == pytest.approx(closure - 10.0 / joint.material.K, rel=1e-8)


def test_initial_states() -> None:
    """A joint carries an initial pressure up to fc, and has its closure; the message names the rest."""
    joint = flat(fc=10.5, Gfc=5.0, kp=0.09)
    state = joint.initial([-9.0, 0.0, 0.0])
    again = joint.update([[0.0, 0.0, 0.0]], state[None])
    assert again.traction[0, 0] == pytest.approx(-9.0, rel=1e-9)
    strength = cap.Cap(10.5, 5.0, kp=0.09).strength(state[-2:-1])
    assert strength[0] == pytest.approx(9.0, rel=1e-6) and state[-1] == 0.0
    with pytest.raises(ValueError, match=r"initial t_N = -11: .*it carries t_N = -10\.49"):
        joint.initial([-11.0, 0.0, 0.0])
