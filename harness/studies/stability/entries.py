"""Failure modes of the search for equilibrium, of the law and of its arithmetic.

An entry is one method that fails on a load case, and one that does not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from asperity import case_files, contract
from asperity.contract import Floats
from asperity.installed import named_case
from asperity.interface import Interface
from asperity.pattern import Pattern, direction_vector
from numpy.typing import ArrayLike

from harness.studies.paper.fracture_energy import MATERIAL as TABLE_2

from ..extensions import locked
from ..newton import NewtonStudy, newton_path, newton_study, work_along
from .explicit import Vumat, fly

S_F, S_0, K = TABLE_2.s_f, TABLE_2.s_0, TABLE_2.K
"""Separations at complete rupture and at onset, mm, and stiffness of the bond (12), MPa/mm."""

FLAT, RP_4 = Pattern.regular(0, 0.0), Pattern.regular(4, 30.0)

RUPTURE = contract.statev_index("rupture")
LEDGER = [contract.statev_index(name) for name in ("stored", "rupture", "friction")]
"""Places of the energies in STATEV."""


class Trial(NamedTuple):
    """A method on a load case, whether it succeeds, and the measured values."""

    method: str
    survives: bool
    measured: str

    def __str__(self) -> str:
        """Line of the page."""
        return f"- *{'Survives' if self.survives else 'Fails'}:* {self.method} ({self.measured})."


@dataclass(frozen=True)
class FailureMode:
    """A failure mode of the law or of its solvers: description, and the two trials that show it."""

    name: str
    happens: str
    run: Callable[[], tuple[Trial, Trial]]

    def section(self, trials: Iterable[Trial]) -> str:
        """Section of docs/results/stability.md."""
        return "\n".join([f"### {self.name}", "", self.happens, "", *map(str, trials)])


def as_expected(trials: tuple[Trial, Trial]) -> bool:
    """Whether the first method fails and the second one does not."""
    return [trial.survives for trial in trials] == [False, True]


MODES: dict[str, FailureMode] = {}
"""Entries by name, in the order of the page."""

Pair = tuple[Trial, Trial]
"""Trial of a method that fails, and of one that does not."""


def mode(name: str, happens: str) -> Callable[[Callable[[], Pair]], Callable[[], Pair]]:
    """Add the entry whose trials a function returns."""

    def add(trials: Callable[[], Pair]) -> Callable[[], Pair]:
        MODES[name] = FailureMode(name, happens, trials)
        return trials

    return add


def ramp(*corners: ArrayLike, steps: int) -> Floats:
    """Values from the first corner, which is left out, to the last, in `steps` steps from one to the next."""
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(corners)])


def plain(label: str, study: NewtonStudy, remark: str = "") -> Trial:
    """Trial of Newton's method without safeguards."""
    if study.converged:
        mean = sum(study.iterations) / len(study.iterations)
        text = f"{mean:.1f} iterations per increment, at most {max(study.iterations)}"
    else:
        text = f"increment {len(study.iterations)}: {study.end}"
    return Trial(f"plain Newton, {label}", study.converged, f"{text}{remark and f'; {remark}'}")


def drive(case: str) -> tuple[dict[str, Any], bool, int]:
    """Results of the driver for a case of the catalogue: columns, whether it ends, row of its last snap."""
    columns = case_files.drive(named_case(f"stability/{case}"))[None].columns()
    snaps = [row for row, text in enumerate(columns["event"]) if "snap" in text.split("+")]
    return columns, "lost" not in columns["event"][-1], [0, *snaps][-1]


@mode(
    "snap",
    "Fine and steep patterns have no neighbouring equilibrium where their last planes open.",
)
def snap() -> Pair:
    """Plain Newton and the solver at the fold."""
    fine = Interface(TABLE_2, Pattern.regular(16, 30.0))
    study = newton_study(fine, ramp(0.0, S_F, steps=1000), 0.0, preload=1)
    run, ends, row = drive("snap")
    s_n, stored = run["s_N"], run["stored"]
    measured = (
        f"event snap at s_L = {run['s_Tx'][row]:.4f} mm: s_N {s_n[row - 1]:.4f} to {s_n[row]:.4f} "
        f"mm; the stored energy falls by {stored[row - 1] - stored[row]:.1e} N/mm"
    )
    return (
        plain("RP-16, 1000 steps to s_f", study, f"s_L = {study.separation[-1, 1]:.4f} mm"),
        Trial("solver, RP-16, 2000 steps to s_f", ends, measured),
    )


@mode(
    "chatter",
    "The iterates alternate across s_n = 0, where the stiffness of a plane jumps.",
)
def chatter() -> Pair:
    """Plain Newton and the solver at the fold of a steep pattern."""
    steep = Interface(replace(TABLE_2, mu=0.6), Pattern.regular(6, 50.0))
    study = newton_study(steep, ramp(0.0, 0.2, steps=50), -0.05, preload=10, most=60)
    sizes = " and ".join(f"{size:.1e}" for size in study.residuals[-1][-2:])
    run, ends, row = drive("chatter")
    text = f"event snap from s_N = {run['s_N'][row - 1]:.3f} to {run['s_N'][row]:.3f} mm; "
    text += f"the path goes on to s_L = {run['s_Tx'][-1]:g} mm"
    return (
        plain(
            "RP-6, 50°, -0.05 MPa, 60 iterations",
            study,
            f"the residual alternates between {sizes} of the stress scale",
        ),
        Trial("solver, RP-6, 50°, -0.05 MPa", ends, text),
    )


@mode(
    "full-damage",
    "An open and fully damaged interface has no stiffness: under tension there is no solution, under "
    "pressure one to which no tangent leads.",
)
def full_damage() -> Pair:
    """Pressure on an open interface without bond."""
    climbed = np.column_stack([np.zeros(110), ramp(0.0, 0.4, 0.3, steps=55), np.zeros(110)])
    pressed = newton_path(Interface(TABLE_2, RP_4), np.vstack([climbed, [[-1.0, 0.3, 0.0]]]))
    closes, ends, _ = drive("full_damage_closes")
    text = f"closes: s_N = {closes['s_N'][-1]:.5f} mm, t_N = {closes['t_N'][-1]:.6f} MPa"
    return (
        plain("-1 MPa on the open interface", pressed),
        Trial("solver, t_N = -1 MPa from s_N = 1 mm", ends, text),
    )


@mode(
    "unloading",
    "A first step back of more than |s_n|/sin(theta), where s_n is the closure of the facing planes, opens "
    "these, and the joint has no stiffness.",
)
def unloading() -> Pair:
    """Slip back after a dilation, with a contact stiffer than the bond."""
    rough = Interface(replace(TABLE_2, kc=100.0), RP_4)

    def back(steps: int) -> NewtonStudy:
        slips = np.concatenate([ramp(0.0, 0.8, steps=100), ramp(0.8, 0.4, steps=steps)])
        targets = np.column_stack([np.full(len(slips), -1.0), slips, np.zeros(len(slips))])
        return newton_path(rough, np.vstack([np.outer(ramp(0.0, -1.0, steps=10), [1.0, 0.0, 0.0]), targets]))

    coarse, fine = back(400), back(1000)
    facing = np.array([np.cos(np.radians(30.0)), -np.sin(np.radians(30.0)), 0.0])
    limit = -float(facing @ fine.separation[109]) / np.sin(np.radians(30.0))
    return (
        plain("slip back in steps of 0.001 mm", coarse, f"limit {limit:.4f} mm"),
        plain("slip back in steps of 0.0004 mm", fine),
    )


@mode(
    "softening",
    "The bond softens in mode I by K_s = K (1 - eta)/eta. Surroundings softer than K_s snap back with every "
    "step size.",
)
def softening() -> Pair:
    """Tension through the peak through springs around the critical stiffness."""
    critical = K * (1.0 - TABLE_2.eta) / TABLE_2.eta

    def through(share: float, steps: int) -> Trial:
        k = share * critical
        targets = np.outer(k * ramp(0.0, 1.5 * S_F + TABLE_2.sigma0 / k, steps=steps), [1.0, 0.0, 0.0])
        study = newton_path(Interface(TABLE_2, FLAT), targets, spring=(k, 0.0, 0.0))
        return plain(f"spring of {share:g} K_s, {steps} steps", study)

    return through(0.9, 2000), through(1.1, 20)


@mode(
    "tangents",
    "RP-4 under 1 MPa is sheared through springs of 0.3 K in 10 increments, with mu = 0.1 to 1.3 and theta "
    "= 0 to 45°.",
)
def tangents() -> Pair:
    """Two tangents on nine interfaces: three unknowns, as in an FE code."""
    k = 0.3 * K
    targets = np.outer(np.linspace(0.0, S_F + TABLE_2.sigma0 / k, 11), [0.0, *(k * direction_vector(20.0))])
    targets[:, 0] = -1.0

    def pulled(mu: float, theta: float, tangent: str) -> NewtonStudy:
        rough = Interface(replace(TABLE_2, mu=mu, kc=20.0), Pattern.regular(4, theta))
        return newton_path(rough, targets, (True, True, True), tangent, spring=(0.0, k, k))

    def tried(tangent: str) -> Trial:
        studies = [pulled(mu, theta, tangent) for mu in (0.1, 0.5, 1.3) for theta in (0.0, 10.0, 45.0)]
        good = [study for study in studies if study.converged]
        cost = np.mean([np.mean(study.iterations) for study in good])
        text = f"{len(good)} of {len(studies)} paths; {cost:.1f} iterations per increment"
        return Trial(f"{tangent} tangent", len(good) == len(studies), text)

    return tried("symmetrised"), tried("consistent")


@mode(
    "steps",
    "A slip of 10 s_f under 1 MPa: the work by the tractions of start and end of an increment is wrong where "
    "the joint breaks in it.",
)
def steps() -> Pair:
    """Slip of 10 s_f in few and in many steps."""
    rough = Interface(replace(TABLE_2, kc=20.0), RP_4)
    studies = {n: newton_study(rough, ramp(0.0, 10.0 * S_F, steps=n), -1.0) for n in (1, 100, 1000)}

    def judged(n: int) -> Trial:
        study, exact = studies[n], studies[1000].traction[-1]
        off = np.abs(study.traction[-1] - exact).max() / np.abs(exact).max()
        work = work_along(study.separation, study.traction)[-1]
        error = abs(work - study.state[-1, LEDGER].sum()) / abs(work)
        text = f"traction off by {off:.1g}, energies by {error:.3g} times the work"
        return Trial(f"steps: {n}", bool(max(off, error) < 0.01), text)

    return judged(1), judged(100)


@mode(
    "locking",
    "RT of 60° with mu tan(theta) = 1.39 slips by 1 mm under 1 MPa.",
)
def locking() -> Pair:
    """Slide the steep RT of the page on extensions by 1 mm, with an asperity height or without."""

    def slid(height: float) -> Trial:
        history = locked(height)
        at, last = np.interp((0.1, 1.0), history.separation[:, 1], history.traction[:, 1])
        end = f"height = {height:g} mm" if height else "infinitely high asperities"
        return Trial(end, bool(last < at), f"{at:.4g} MPa at 0.1 mm, {last:.4g} MPa at 1 mm")

    return slid(0.0), slid(0.2)


@mode(
    "second-law",
    "A plane slips to s_1, is closed to s_N and slips back to -r. For mu |s_N| > s_1 (kc = 1) its damage "
    "then grows with a negative dissipation.",
)
def second_law() -> Pair:
    """Damage while a slipped joint is pressed: the law of the paper, and its guard."""
    corners = [[0.0, 0.0, 0.0], [0.0, 0.03, 0.0], [-0.2, 0.03, 0.0], [-0.2, -0.05, 0.0]]

    def judged(label: str, guard: bool) -> Trial:
        flat = Interface(replace(TABLE_2, guard=guard), FLAT)
        rupture = flat.replay(ramp(*corners, steps=1000)).state[:, RUPTURE]
        text = f"rupture energy {rupture[1999]:.4f}, then {rupture[-1]:.4f} N/mm"
        return Trial(label, bool(np.diff(rupture).min() >= -1e-12), text)

    path = "slip to 0.03 mm, closure by 0.2 mm, slip back to -0.05 mm"
    return judged(f"the law as published: {path}", False), judged("the same with guard = True", True)


@mode(
    "stiffness",
    "The elastic tangent of the virgin joint diverges as soon as the contact is more than twice as stiff as "
    "the bond, here in 400 iterations.",
)
def stiffness() -> Pair:
    """Close a flat joint by 1 MPa."""

    def closing(kc: float, tangent: str) -> Trial:
        flat = Interface(replace(TABLE_2, kc=kc), FLAT)
        study = newton_path(flat, [[-1.0, 0.0, 0.0]], tangent=tangent, most=400)
        return plain(f"{tangent} tangent, closing with kc = {kc:g}", study)

    return closing(2.1, "elastic"), closing(1e4, "consistent")


@mode(
    "single-precision",
    "An explicit code passes increments. In single precision those below 6e-8 of the separation are lost.",
)
def single() -> Pair:
    """VUMATs of both precisions: a long slip, then small elastic increments back."""
    back, n, far = 2e-3, 1000, 100.0

    def judged(kind: str) -> Trial:
        point = Vumat(Interface(TABLE_2, FLAT), kind == "single")
        point.step(np.array([-1.0 / K, 0.0, 0.0]))
        for _ in range(200):
            before = point.step(np.array([0.0, far / 200, 0.0]))
        for _ in range(n):
            after = point.step(np.array([0.0, -back / n, 0.0]))
        change, exact = float(before[1]) - float(after[1]), K * back
        text = f"the traction falls by {100 * change / exact:.1f} % of the exact {exact:.4f} MPa"
        path = f", slip of {far:g} mm, then back by {back:g} mm in steps of {back / n:g} mm"
        label = f"{kind} precision" + (path if kind == "single" else "")
        return Trial(label, abs(change - exact) < 0.1 * exact, text)

    return judged("single"), judged("double")


@mode(
    "explicit",
    "Central differences are stable below dt = 2/omega, with omega^2 = K/m for the bond and kc K/m for the "
    "contact, here with kc = 100. Above, the interface breaks without any load.",
)
def explicit() -> Pair:
    """A mass that oscillates about its closure and never opens, with time steps around the critical one."""
    kc, pressure = 100.0, 0.3
    stiff = Interface(replace(TABLE_2, kc=kc), FLAT)
    closed, push = -pressure / (kc * K), 0.05 * pressure / np.sqrt(kc * K)
    probe = 1e-6 * S_0
    stiffest = float(Vumat(stiff).step(np.array([probe, 0.0, 0.0]), time=0.0)[0]) / probe

    def judged(label: str, stiffness: float) -> Trial:
        largest, damage = fly(stiff, 0.99 * 2.0 / np.sqrt(stiffness), 400, push, -pressure, closed)
        text = f"damage {damage:.2g}, largest |s| {largest / S_0:.2g} s_0"
        return Trial(f"dt = 0.99 x 2/omega of {label}", damage == 0.0, text)

    return judged("the bond", K), judged("the VUMAT's probe", stiffest)
