"""Failure modes of the law and its arithmetic: steps, locking, second law, precision, time step."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from asperity import contract
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material, ModelWarning
from asperity.pattern import Pattern
from asperity.slip_curves import slip_curves
from numpy.typing import NDArray

from ..extensions import locked
from ..newton import NewtonStudy, newton_study, work_along
from .explicit import Flight, Vumat, fly
from .modes import S_0, S_F, TABLE_2, K, Trial, mode
from .solver_modes import ramp

ACCEPTED = 0.01
"""Accepted error of a trial of accuracy."""


RUPTURE = contract.statev_index("rupture")
LEDGER = [contract.statev_index(name) for name in ("stored", "rupture", "friction")]
"""Names of the energies in STATEV."""


def ledger_error(study: NewtonStudy) -> float:
    """Energy balance: work less stored and dissipated energy at the end, over the work."""
    work = work_along(study.separation, study.traction)[-1]
    return float(abs(work - study.state[-1, LEDGER].sum()) / abs(work))


@mode(
    "steps",
    "Large increments",
    "A step of 10 s_f through onset, rupture and sliding converges to the right traction under a constant "
    "pressure. The energies are wrong, and so are the tractions if the path reverses while planes slide.",
)
def steps() -> Iterator[Trial]:
    """Compare one step of 10 s_f with 1000 steps, and prescribed separations in a few steps with many."""
    rough = Interface(replace(TABLE_2, kc=20.0), Pattern.regular(4, 30.0))
    exact = newton_study(rough, 0.0, ramp(0.0, 10.0 * S_F, steps=1000), -1.0)
    for n, energies in ((1, False), (10, False), (100, True), (1000, True)):
        study = newton_study(rough, 0.0, ramp(0.0, 10.0 * S_F, steps=n), -1.0)
        off = np.abs(study.traction[-1] - exact.traction[-1]).max() / np.abs(exact.traction[-1]).max()
        error, rupture = ledger_error(study), study.state[-1, RUPTURE]
        label = f"slip of 10 s_f under -1 MPa in {n} step{'s' * (n > 1)}"
        if n == 1:
            found = f"{max(study.iterations)} iterations; relative difference from 1000 steps {off:.1g}"
            yield Trial(f"{label}: traction", True, off < ACCEPTED, found)
        found = f"work - stored - rupture - friction = {error:.3g} times the work; rupture {rupture:.4g} N/mm"
        yield Trial(f"{label}: energies", energies, error < ACCEPTED, found)
    for name, corners in (
        ("closing from 10 s_f", [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-0.01, 0.0, 0.0]]),
        (
            "slip of 10 s_f and back while the joint is closed",
            [[0, 0, 0], [-0.01, 0, 0], [-0.01, 2, 0], [-0.01, -2, 0]],
        ),
    ):
        for n, survives in ((1, False), (1000, True)):
            ends = [rough.replay(ramp(*corners, steps=steps)).traction[-1] for steps in (n, 2000)]
            off = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1]).max()
            label = f"{name}, {n} step{'s' * (n > 1)} for each straight part: traction"
            found = f"relative difference from 2000 steps {off:.2g}"
            yield Trial(label, survives, off < ACCEPTED, found)


FAR = 1e12
"""Residual strength over |sigma_N| beyond which the strength counts as infinite."""


def locks(interface: Interface, directions: Floats) -> NDArray[np.bool_]:
    """Whether the traction of the fully damaged interface grows with the slip at a large slip."""
    far = 1e4 * S_F
    # one step of 10 s_f damages every plane fully
    found = slip_curves(interface, directions, [10 * S_F, 0.5 * far, far], -0.01, preload=1)
    before, after = np.hypot(found.tau_L, found.tau_across).T[1:]
    return after > 1.5 * before  # 2 if proportional to the slip, 1 if constant


@mode(
    "locking",
    "Locking at mu tan(theta) = 1",
    "Friction prevents any sliding up: the traction grows with the slip, without limit where the "
    "asperities are infinitely high.",
)
def locking() -> Iterator[Trial]:
    """Use the closed form as a coefficient of friction, and run the law in all directions."""
    theta = 30.0
    slope = np.tan(np.radians(theta))
    for ratio, survives in ((0.9, True), (1.1, False)):
        mu = ratio / slope
        value = (mu + slope) / (1.0 - mu * slope)
        found = f"residual strength {value:.3g} |sigma_N|"
        label = f"closed form as friction of a smooth interface, mu tan(theta) = {ratio}"
        yield Trial(label, survives, value > 0.0, found)
    patterns, ratios = (2, 3, 4, 6, 16), (0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 2.0)
    directions = np.arange(0.0, 360.0, 5.0)
    agree = locked = 0
    for sides in patterns:
        for ratio in ratios:
            rough = Interface(replace(TABLE_2, mu=ratio / slope), Pattern.regular(sides, theta))
            # the angle to the nearest plane that faces the slip
            away = (directions + 180.0 / sides) % (360.0 / sides) - 180.0 / sides
            strength = rough.material.residual_strength(theta, away)
            predicted = strength > FAR
            found = locks(rough, directions)
            agree += int(np.sum(found == predicted))
            locked += int(np.sum(found))
    total = len(patterns) * len(ratios) * len(directions)
    label = "the law for RT, RP-3, RP-4, RP-6, RP-16, mu tan(theta) = 0.5 to 2, every 5°"
    found = f"{agree} of {total} runs agree with the closed form ({locked} of them lock)"
    yield Trial(label, True, agree == total, found)
    yield from (_steep(height) for height in (0.0, 0.2))


def _steep(height: float) -> Trial:
    """Slide the steep RT of the page on extensions by 1 mm, with an asperity height or without."""
    history = locked(height)
    at, last = (
        float(value) for value in np.interp((0.1, 1.0), history.separation[:, 1], history.traction[:, 1])
    )
    end = f"height = {height:g} mm" if height else "infinitely high asperities"
    label = f"RT of 60°, mu tan(theta) = 1.39, {end}, slip of 1 mm under -1 MPa"
    return Trial(label, height > 0.0, bool(last < at), f"{at:.4g} MPa at 0.1 mm, {last:.4g} MPa at 1 mm")


def clamped_reversal(flat: Interface, clamp: Floats, back: Floats, slip: float, steps: int) -> Floats:
    """Decrease of the rupture energy, stress*length, if a flat plane slips, is closed, and slips back.

    slip: first slip; clamp, back (n,): closure and slip at the end of each path, all positive, length. The
    result (n,) is the largest fall of the rupture energy below an earlier value, >= 0.
    """
    corners = np.zeros((4, len(clamp), 3))
    corners[1:3, :, 1], corners[2:, :, 0], corners[3, :, 1] = slip, -clamp, -back
    state, s, rupture = np.zeros((len(clamp), flat.nstatv)), corners[0], []
    for after in ramp(*corners, steps=steps):
        state, s = flat.update(after, state, s).state, after
        rupture.append(state[:, RUPTURE])
    return (np.maximum.accumulate(rupture) - rupture).max(axis=0)


@mode(
    "second-law",
    "Damage of a joint that is closed between two slips",
    "A plane slips to s_1, is closed to s_N and slips back to -r. For mu |s_N| > s_1 (kc = 1) its damage "
    "then grows with a negative dissipation.",
)
def second_law() -> Iterator[Trial]:
    """Damage while a slipped joint is pressed: the law of the paper, the closed-form region, the guard."""
    flat = Interface(TABLE_2, Pattern.regular(0, 0.0))
    corners = [[0.0, 0.0, 0.0], [0.0, 0.03, 0.0], [-0.2, 0.03, 0.0], [-0.2, -0.05, 0.0]]
    state = flat.replay(ramp(*corners, steps=1000)).state[:, RUPTURE]
    yield Trial(
        "the law as published: slip to 0.03 mm, closure by 0.2 mm, slip back to -0.05 mm",
        False,
        bool(np.diff(state).min() >= -1e-12),
        f"rupture energy {state[1999]:.4f}, then {state[-1]:.4f} N/mm",
    )
    guarded = Interface(replace(TABLE_2, guard=True), Pattern.regular(0, 0.0))
    kept = guarded.replay(ramp(*corners, steps=1000)).state[:, RUPTURE]
    found = f"rupture energy {kept[1999]:.4f}, then {kept[-1]:.4f} N/mm"
    yield Trial("the same path with guard = True", True, bool(np.diff(kept).min() >= -1e-12), found)
    clamp, back = (
        axis.ravel() for axis in np.meshgrid(np.linspace(0.005, 0.2, 14), np.linspace(0.005, 0.1, 14))
    )
    fall = clamped_reversal(flat, clamp, back, 0.03, 200)
    predicted = (TABLE_2.mu * clamp > 0.03) & (back > 0.03)
    agree = int(np.sum((fall > 1e-9) == predicted))
    yield Trial(
        "the closed form of the region of this failure: mu |s_N| > s_1 and r > s_1",
        True,
        agree == len(fall),
        f"{agree} of {len(fall)} paths agree ({int(predicted.sum())} of them lose rupture "
        f"energy, up to {fall.max():.3f} N/mm)",
    )
    fall = clamped_reversal(guarded, clamp, back, 0.03, 200)
    found = f"largest decrease {fall.max():.1g} N/mm"
    yield Trial(f"these {len(fall)} paths with the guard", True, bool(fall.max() <= 1e-12), found)


def traction_error(material: Material, slips: Floats, sigma_N: float) -> float:
    """Largest error of the prescribed normal traction over sigma0 in a slip test; inf: it is refused."""
    rough = Interface(material, Pattern.regular(4, 30.0))
    try:
        history = rough.confined_slip(20.0, slips, sigma_N, preload=10)
    except ValueError:
        return np.inf
    return float(np.abs(history.traction[:, 0] - sigma_N).max() / material.sigma0)


@mode(
    "stiffness",
    "Stiffness ratios",
    "With a contact 1e9 times as stiff as the bond the traction has seven digits of 16. An elastic "
    "tangent diverges beyond a ratio of two.",
)
def stiffness() -> Iterator[Trial]:
    """Stiffness ratios of contact to bond and of mode II to mode I from 1e-9 to 1e9."""
    ratios = 10.0 ** np.arange(-9, 10, 3)
    slips = ramp(0.0, 2.0 * S_F, steps=100)
    closing, shear, plain_closing, plain_shear = [], [], [], []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        for ratio in ratios:
            contact, sigma_N = replace(TABLE_2, kc=ratio), -min(1.0, 0.1 * ratio * K * S_F)
            closing.append(traction_error(contact, slips, sigma_N))
            rough = Interface(contact, Pattern.regular(4, 30.0))
            plain_closing.append(newton_study(rough, 20.0, slips, sigma_N, 10).converged)
            mode_2 = replace(TABLE_2, sigma02=TABLE_2.sigma0, Gc2=TABLE_2.Gc / ratio)
            reach = max(1.0, 0.25 / ratio)  # longer slips are refused
            shear.append(traction_error(mode_2, slips * reach, -1.0))
            rough = Interface(mode_2, Pattern.regular(4, 30.0))
            plain_shear.append(newton_study(rough, 20.0, slips * reach, -1.0, 10).converged)
        stiff = newton_study(
            Interface(replace(TABLE_2, kc=1e3), Pattern.regular(4, 30.0)), 20.0, slips, -1.0, 10, "elastic"
        )
    found = f"increment {len(stiff.iterations)}: {stiff.end}"
    yield Trial("elastic tangent, kc = 1e3", False, stiff.converged, found)
    for name, errors, good in (("kc", closing, plain_closing), ("K_t/K_n", shear, plain_shear)):
        listed = ", ".join(f"{ratio:.0e}" for ratio, yes in zip(ratios, good, strict=True) if not yes)
        yield Trial(f"plain Newton, {name} from 1e-9 to 1e9", False, all(good), f"fails at {listed}")
        worst = max(errors[:-1])
        found = f"error of t_N up to {worst:.0e} sigma0"
        yield Trial(f"solver, {name} from 1e-9 to 1e6", True, worst < 1e-6, found)
        if errors[-1] < np.inf:
            found = f"error of t_N {errors[-1]:.0e} sigma0: some hundred rounding errors of K s"
        else:
            found = "the slips are refused, as their rounding errors times the stiffness exceed the pressure"
        yield Trial(f"solver, {name} = 1e9", False, errors[-1] < 1e-9, found)


@mode(
    "single-precision",
    "Single precision",
    "An explicit code passes increments. In single precision those below 6e-8 of the separation are lost.",
)
def single() -> Iterator[Trial]:
    """VUMATs of both precisions: a long slip, then small elastic increments back."""
    flat = Interface(TABLE_2, Pattern.regular(0, 0.0))
    back, n = 2e-3, 1000
    for far, is_single, survives in ((1.0, True, True), (100.0, True, False), (100.0, False, True)):
        point = Vumat(flat, is_single)
        point.step(np.array([-1.0 / K, 0.0, 0.0]))
        for _ in range(200):
            before = point.step(np.array([0.0, far / 200, 0.0]))
        for _ in range(n):
            after = point.step(np.array([0.0, -back / n, 0.0]))
        change, exact = float(before[1]) - float(after[1]), K * back
        found = f"the traction falls by {100 * change / exact:.1f} % of the exact {exact:.4f} MPa"
        kind = "single" if is_single else "double"
        label = f"{kind} precision, slip of {far:g} mm, then back by {back:g} mm in steps of {back / n:g} mm"
        yield Trial(label, survives, abs(change - exact) < 0.1 * exact, found)


@mode(
    "explicit",
    "Time step of an explicit code",
    "Central differences are stable below dt = 2/omega, with omega^2 = K/m for the bond and kc K/m for "
    "the contact. Above, the interface breaks without any load.",
)
def explicit() -> Iterator[Trial]:
    """A mass on the bond and on a stiff contact, with time steps around the critical one."""
    mass = 1.0
    omega = np.sqrt(K / mass)
    velocity = 0.05 * S_0 * omega
    energy = 0.5 * mass * velocity**2

    def judged(label: str, flight: Flight, scale: float, share: float, survives: bool) -> Trial:
        # bound for a linear oscillator whose kinetic energy is that of the mean velocity
        bound = 1.0 / (1.0 - share**2) if share < 1.0 else np.inf
        growth = np.abs(flight.energy).max() / scale
        reach = np.abs(flight.separation).max() / S_0
        found = f"energy up to {growth:.3g} times the initial one, damage {flight.damage:.2g}, "
        found += f"largest |s| {reach:.2g} s_0"
        found += f"; closed form of the largest energy {bound:.3g}" if share < 1.0 else ""
        good = growth < (1.0 + ACCEPTED) * bound and flight.damage == 0.0
        return Trial(label, survives, bool(good), found)

    bond = Interface(TABLE_2, Pattern.regular(0, 0.0))
    for share, survives in ((0.99, True), (1.01, False)):
        start = np.array([velocity, 0.0, 0.0])
        flight = fly(bond, mass, share * 2.0 / omega, 400, start, np.zeros(3))
        yield judged(f"bond, dt = {share:g} x 2/omega", flight, energy, share, survives)
    # With an initial closure and a velocity the mass oscillates about its closure and never opens.
    kc, pressure = 100.0, 0.3
    stiff = Interface(replace(TABLE_2, kc=kc), Pattern.regular(0, 0.0))
    closed, push = -pressure / (kc * K), 0.05 * pressure / np.sqrt(kc * K * mass)
    probe = np.array([1e-6 * S_0, 0.0, 0.0])
    stiffest = float(Vumat(stiff).step(probe, time=0.0)[0]) / probe[0]
    for label, dt, survives in (
        ("0.99 x 2/omega of the bond", 0.99 * 2.0 / omega, False),
        ("0.99 x 2/omega of the VUMAT's probe", 0.99 * 2.0 * np.sqrt(mass / stiffest), True),
    ):
        vectors = ([value, 0.0, 0.0] for value in (push, -pressure, closed))
        flight = fly(stiff, mass, dt, 400, *map(np.array, vectors))
        own = dt * np.sqrt(kc) * omega / 2.0
        yield judged(f"contact, kc = {kc:g}, dt = {label}", flight, 0.5 * mass * push**2, own, survives)
