"""Failure modes of the search for equilibrium: snaps, chatter, full damage, softening, tangents."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.material import Material
from asperity.pattern import Pattern, direction_vector
from numpy.typing import ArrayLike

from ..newton import NewtonStudy, newton_path, newton_study, work_along
from .branches import draw as draw_branches
from .branches import steep_snap
from .modes import S_0, S_F, TABLE_2, K, Trial, drive, mode, plain, rows_with

BALANCE = 0.01
"""Accuracy of the energies of a snap and of its branch, over K s_0^2."""

SPRING = 0.3
"""Stiffness of the springs that shear the point of `pulled`, over K."""


def ramp(*corners: ArrayLike, steps: int) -> Floats:
    """Values from the first corner, which is left out, to the last, in `steps` steps from one to the next."""
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(corners)])


def pulled(
    mu: float, theta: float, tangent: str, steps: int = 10, most: int = 25, direction: float = 20.0
) -> NewtonStudy:
    """RP-4 under 1 MPa, sheared at `direction` by springs of 0.3 K: three unknowns, as in an FE code."""
    rough = Interface(replace(TABLE_2, mu=mu, kc=20.0), Pattern.regular(4, theta))
    k = SPRING * K
    ends = np.linspace(0.0, S_F + TABLE_2.sigma0 / k, steps + 1)
    targets = np.outer(ends, [0.0, *(k * direction_vector(direction))])
    targets[:, 0] = -1.0
    return newton_path(rough, targets, (True, True, True), tangent, most=most, spring=(0.0, k, k))


@mode(
    "snap",
    "Fold of the slip path at low pressure",
    "Fine patterns (m >= 13 at 30°) and steep ones have no neighbouring equilibrium where their last "
    "planes open.",
    draw=draw_branches,
)
def snap() -> Iterator[Trial]:
    """Compare plain Newton and the solver at the fold."""
    for sides, steps, survives in ((32, 100, True), (32, 1500, False), (16, 100, False), (16, 1000, False)):
        rough = Interface(TABLE_2, Pattern.regular(sides, 30.0))
        study = newton_study(rough, 0.0, ramp(0.0, S_F, steps=steps), 0.0, preload=1)
        place = (
            "one step passes over the fold" if study.converged else f"s_L = {study.separation[-1, 1]:.4f} mm"
        )
        yield plain(f"plain Newton, RP-{sides}, {steps} steps to s_f", study, survives, place)
    run = drive("snap")
    row = rows_with(run, "snap")[-1]
    s_n, stored = run["s_N"], run["stored"]
    measured = (
        f"event snap at s_L = {run['s_Tx'][row]:.4f} mm: s_N {s_n[row - 1]:.4f} to {s_n[row]:.4f} "
        f"mm; the stored energy falls by {stored[row - 1] - stored[row]:.1e} N/mm"
    )
    yield Trial("solver, RP-16, 2000 steps to s_f", True, "lost" not in run["event"][-1], measured)
    whole = drive("snap_branch")
    places = ", ".join(f"{whole['s_Tx'][turn]:.4f} mm" for turn in rows_with(whole, "turn"))
    measured = f"the slip turns at {places}; {len(whole['event'])} rows"
    yield Trial("whole branch, RP-16", True, "lost" not in whole["event"][-1], measured)
    for mu in (0.0, 0.5):
        steep = steep_snap(mu)
        measured = (
            f"area between branch and jump {steep.area:.2e} N/mm, the jump releases {steep.released:.2e} N/mm"
        )
        if mu > 0.0:
            measured += f" and dissipates {steep.dissipated_more:.1e} N/mm more than the branch"
        balance = steep.area - steep.released - steep.dissipated_more
        label = f"whole branch, RP-8 of 60°, mu = {mu:g}"
        yield Trial(label, True, abs(balance) <= BALANCE * K * S_0**2, measured)
    viscous = Interface(replace(TABLE_2, tau_v=0.003), Pattern.regular(16, 30.0))
    for steps in (100, 1000):
        study = newton_study(viscous, 0.0, ramp(0.0, S_F, steps=steps), 0.0, preload=1, dt=1.0 / steps)
        work = work_along(study.separation, study.traction)[-1]
        more = 100.0 * (work / run["work"][-1] - 1.0)
        label = f"plain Newton, RP-16, {steps} steps, tau_v = 0.003 times the duration of the test"
        yield plain(label, study, True, f"{more:.1f} % more work")


@mode(
    "chatter",
    "Iterates that alternate across s_n = 0",
    "The stiffness of a plane jumps at s_n = 0. Iterates alternate at a fold, or with a tangent that "
    "leaves out the contact.",
)
def chatter() -> Iterator[Trial]:
    """Iterates that alternate across s_n = 0."""
    steep = Interface(Material(3.0, 0.3, 0.9, 0.6), Pattern.regular(6, 50.0))
    study = newton_study(steep, 0.0, ramp(0.0, 0.2, steps=50), -0.05, preload=10, most=60)

    def closing(kc: float, tangent: str) -> NewtonStudy:
        flat = Interface(replace(TABLE_2, kc=kc), Pattern.regular(0, 0.0))
        return newton_path(flat, [[-1.0, 0.0, 0.0]], tangent=tangent, most=400)

    run = drive("chatter")
    row = rows_with(run, "snap")[-1]
    s_n = run["s_N"]
    yield Trial(
        "plain Newton, RP-6, 50°, -0.05 MPa",
        False,
        study.converged,
        f"s_L = {study.separation[-1, 1]:.3f} mm: the residual alternates between "
        f"{' and '.join(f'{size:.1e}' for size in study.residuals[-1][-2:])} of the stress scale",
    )
    yield plain("elastic tangent, closing with kc = 1.9, 400 iterations", closing(1.9, "elastic"), True)
    yield plain("elastic tangent, closing with kc = 2.1, 400 iterations", closing(2.1, "elastic"), False)
    yield plain("consistent tangent, closing with kc = 1e4", closing(1e4, "consistent"), True)
    yield Trial(
        "solver, RP-6, 50°, -0.05 MPa",
        True,
        "lost" not in run["event"][-1],
        f"event snap from s_N = {s_n[row - 1]:.3f} to {s_n[row]:.3f} mm; the path goes on to s_L = "
        f"{run['s_Tx'][-1]:g} mm",
    )


@mode(
    "full-damage",
    "Fully damaged interface under a prescribed traction",
    "An open and fully damaged interface has no stiffness: under tension there is no solution, under "
    "pressure one to which no tangent leads.",
)
def full_damage() -> Iterator[Trial]:
    """Tension and pressure on an interface without bond."""
    rough = Interface(TABLE_2, Pattern.regular(4, 30.0))
    broken = rough.update([[1.0, 0.0, 0.0]]).state
    openings = np.concatenate([np.linspace(-10.0, 10.0, 20001), np.geomspace(10.0, 1e4, 1000)])
    s = np.column_stack([openings, np.zeros((len(openings), 2))])
    best = rough.update(s, np.repeat(broken, len(s), axis=0)).traction[:, 0].max()
    climbed = np.column_stack([np.zeros(110), ramp(0.0, 0.4, 0.3, steps=55), np.zeros(110)])
    pressed = newton_path(rough, np.vstack([climbed, [[-1.0, 0.3, 0.0]]]))
    lost, closes = drive("full_damage"), drive("full_damage_closes")
    found = f"no solution: the largest t_N over {len(s)} openings from -10 to 10^4 mm is {best:g} MPa"
    yield Trial("any method, t_N = +0.1 MPa", False, best >= 0.1, found)
    yield plain("plain Newton, -1 MPa on the open, fully damaged interface", pressed, False)
    found = f"reports the event lost and writes all {len(lost['event'])} rows"
    yield Trial("solver, t_N = +0.1 MPa", False, "lost" not in lost["event"][-1], found)
    found = f"closes: s_N = {closes['s_N'][-1]:.5f} mm, t_N = {closes['t_N'][-1]:.6f} MPa"
    yield Trial("solver, t_N = -1 MPa from s_N = 1 mm", True, "lost" not in closes["event"][-1], found)


@mode(
    "unloading",
    "Reversal of a slip with dilation",
    "Only the facing planes are in contact. A first step back of more than |s_n|/sin(theta), where s_n is "
    "their closure, opens them, and the joint has no stiffness.",
)
def unloading() -> Iterator[Trial]:
    """Slip back after a dilation, with a contact stiffer than the bond."""
    rough = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=100.0), Pattern.regular(4, 30.0))

    def back(steps: int, spring: float = 0.0) -> NewtonStudy:
        slips = np.concatenate([ramp(0.0, 0.8, steps=100), ramp(0.8, 0.4, steps=steps)])
        targets = np.column_stack([np.full(len(slips), -1.0), slips, np.zeros(len(slips))])
        targets = np.vstack([np.outer(ramp(0.0, -1.0, steps=10), [1.0, 0.0, 0.0]), targets])
        return newton_path(rough, targets, spring=(spring, 0.0, 0.0))

    crest = back(1).separation[109]
    facing = np.array([np.cos(np.radians(30.0)), -np.sin(np.radians(30.0)), 0.0])
    limit = -float(facing @ crest) / np.sin(np.radians(30.0))
    for n, ok in ((100, False), (400, False), (1000, True)):
        label = f"plain Newton, slip back in steps of {0.4 / n:g} mm"
        yield plain(label, back(n), ok, f"limit {limit:.4f} mm" * (n == 100))
    soft = back(100, 1e-6 * K)
    error = abs(float(soft.traction[-1, 0]) + 1.0)
    label = "with a spring of 1e-6 K beside the joint, steps of 0.004 mm"
    yield plain(label, soft, True, f"error of t_N {error:.0e} MPa")
    run = drive("unloading")
    measured = f"t_N = {run['t_N'][-1]:.6f} MPa at s_L = {run['s_Tx'][-1]:g} mm"
    yield Trial("solver, steps of 0.004 mm", True, "lost" not in run["event"][-1], measured)


@mode(
    "softening",
    "Softening after the peak",
    "The bond softens in mode I by K_s = K (1 - eta)/eta. A traction above the strength has no equilibrium; "
    "surroundings softer than K_s snap back with every step size.",
)
def softening() -> Iterator[Trial]:
    """Tension through the peak: by traction, through springs around the critical stiffness, by separation."""
    critical = K * (1.0 - TABLE_2.eta) / TABLE_2.eta

    def through(share: float, steps: int, tau_v: float = 0.0) -> NewtonStudy:
        flat = Interface(replace(TABLE_2, tau_v=tau_v), Pattern.regular(0, 0.0))
        k = share * critical
        targets = np.zeros((steps, 3))
        targets[:, 0] = k * ramp(0.0, 1.5 * S_F + TABLE_2.sigma0 / k, steps=steps)
        return newton_path(flat, targets, spring=(k, 0.0, 0.0), dt=1.0 / steps)

    run = drive("softening_traction")
    measured = f"event lost at t_N = {run['t_N'][-1]:.3f} MPa, the strength"
    yield Trial("traction control to 1.1 sigma0", False, "lost" not in run["event"][-1], measured)
    for share, steps, survives in ((0.9, 20, False), (0.9, 2000, False), (1.1, 20, True), (1.1, 2000, True)):
        study = through(share, steps)
        yield plain(f"plain Newton, spring of {share:g} K_s, {steps} steps", study, survives)
    study = through(0.9, 20, tau_v=0.01)
    peak = f"peak {study.traction[:, 0].max():.2f} MPa"
    label = "plain Newton, spring of 0.9 K_s, 20 steps, tau_v = 0.01 times the duration of the test"
    yield plain(label, study, True, peak)
    run = drive("softening_separation")
    measured = f"rupture energy {run['rupture'][-1]:.5f} N/mm, Gc = {TABLE_2.Gc:g} N/mm"
    yield Trial("separation control", True, "lost" not in run["event"][-1], measured)


FRICTIONS, SLOPES = (0.1, 0.5, 1.3), (0.0, 10.0, 45.0)
"""Values of mu and theta in the trials of tangents."""

NAMES = {
    "lagged": "modified Newton (tangent of the start of the increment)",
    "elastic": "tangent of the virgin joint",
}


@mode(
    "tangents",
    "Symmetric and elastic tangents",
    "Friction makes the tangent unsymmetric, softening indefinite (RP-4 under 1 MPa, sheared through "
    "springs of 0.3 K, mu = 0.1 to 1.3, theta = 0 to 45°).",
)
def tangents() -> Iterator[Trial]:
    """Run every tangent on nine interfaces."""
    for tangent, increments, most, survives in (
        ("consistent", 10, 25, True), ("symmetrised", 10, 25, False), ("symmetrised", 100, 100, False),
        ("secant", 10, 100, False), ("lagged", 10, 100, False), ("elastic", 10, 100, False),
    ):  # fmt: skip
        studies = [pulled(mu, theta, tangent, increments, most) for mu in FRICTIONS for theta in SLOPES]
        good = [study for study in studies if study.converged]
        found = f"{len(good)} of {len(studies)} paths"
        if good:
            cost = np.mean([np.mean(study.iterations) for study in good])
            found += f"; {cost:.1f} iterations per increment"
        label = NAMES.get(tangent, f"{tangent} tangent")
        label += f", {increments} increments of at most {most} iterations"
        yield Trial(label, survives, len(good) == len(studies), found)
