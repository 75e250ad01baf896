"""The ladder of models, simplest first, and the choice of one by what the rows can tell apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...contract import Floats
from .model import KS, KT, MORTAR, PLAUSIBLE, ROCK, Problem, plausible, to_scale
from .rigid import LAW, has_closed_form
from .series import CyclicSeries, Rigid, Series
from .shear_test import ShearTest, cycles, independent_rows, pressures
from .squares import Solution
from .thresholds import APART, BRITTLE, GAIN, NOISE, ROWS_EACH, SOFT_CYCLES, STIFF, STIFF_CONTACT


class Cyclic(Problem):
    """Cycles, in which the elastic slip is that of the joint."""

    @cached_property
    def ends(self) -> Floats:
        """Bounds of the free constants on their scales, (2, p)."""
        ranges = PLAUSIBLE | {KS: (PLAUSIBLE[KS][0], SOFT_CYCLES)}
        return np.transpose([to_scale(name, plausible(name, *self.size, ranges)) for name in self.free])

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """Curves as of any problem.

        Raises ValueError for a bond that counts as rigid, which takes too many increments in each cycle.
        """
        if "sigma0" in values:
            stress, length = self.size
            stiffness = values["sigma0"] ** 2 / (2.0 * values["Gc"] * (1.0 - values["eta"]))
            if stiffness > STIFF * stress / length:
                raise ValueError(f"sigma0 = {values['sigma0']:g}: a bond of the stiffness {stiffness:g}")
        return super().curves(values)


@dataclass(frozen=True)
class Model:
    """Free constants, planes of the pattern, and constants that are not those of the usual model.

    shape: name of that of slope and softening; but for that of the law in closed form, without cycles.
    exact: whether the closed form of the law is not near enough to it.
    """

    free: tuple[str, ...]
    sides: int = 2
    fixed: Mapping[str, float] = field(default_factory=dict)
    name: str = ""
    shape: str = LAW
    exact: bool = False

    @property
    def bond(self) -> bool:
        """Whether the joint has a bond."""
        return "sigma0" in {*self.free, *self.fixed}

    @property
    def series(self) -> bool:
        """Whether the joint is rigid with a spring in series."""
        return KT in {*self.free, *self.fixed}

    def problem(
        self, tests: Sequence[ShearTest], weight: float = 1.0, direction: float = 0.0, law: bool = False
    ) -> Problem:
        """Problem of these tests; what is not free is rigid, or is not there.

        A rigid joint without reversals has a closed form in place of the law, but for law and exact.
        """
        rest = {"theta": 0.0, "flat": 0.0, "height": 0.0, "crush": 0.0, "W0": 0.0, "closure": 0.0}
        rest |= {"damage0": 0.0, "sigma02": 0.0, "Gc2": 0.0} if self.bond else {}
        rest |= {"kc": 1.0 if self.bond and self.series else STIFF_CONTACT}
        if self.bond:
            rest["eta"] = BRITTLE if self.series else 0.9
        elif self.series:
            stress = max(float(np.abs(test.tau).max()) for test in tests)
            rest[KS] = (SOFT_CYCLES if cycles(tests) else STIFF) * stress
            rest[KS] /= max(float(np.abs(test.slip).max()) for test in tests)
        values = {name: value for name, value in (rest | dict(self.fixed)).items() if name not in self.free}
        sloped = {"theta"} & {*self.free} or self.fixed.get("theta")
        sides = self.sides if sloped else 0
        rigid = not (law or self.exact) and self.series and not cycles(tests)
        if self.shape or (rigid and has_closed_form(self.free, values, sides, direction)):
            return Rigid(list(tests), self.free, values, sides, direction, weight=weight, shape=self.shape)
        if cycles(tests):
            kind: type[Problem] = CyclicSeries if self.series else Cyclic
        else:
            kind = Series if self.series else Problem
        return kind(list(tests), self.free, values, sides, direction, weight=weight)

    def without(self, name: str, **fixed: float) -> Model:
        """The model without a free constant, with others fixed."""
        free = tuple(constant for constant in self.free if constant != name)
        return replace(self, free=free, fixed=dict(self.fixed) | fixed)

    def instead(self, old: str, new: str, **fixed: float) -> Model:
        """The model with one free constant in place of another."""
        free = tuple(new if constant == old else constant for constant in self.free)
        return replace(self, free=free, fixed=dict(self.fixed) | fixed)


def ladder(tests: Sequence[ShearTest], joint: str, known: Mapping[str, float], sides: int) -> list[Model]:
    """Models that the tests may show, simplest first; known: values that the user has given.

    Rock: friction, a slope, its height, crushed asperities at several pressures, wear in cycles.  Mortar: the
    same with a bond.  An elastic spring lies in series with the joint; in cycles a bond is itself elastic.
    """
    dilates = any(test.s_N is not None and np.ptp(test.s_N) > 0.0 for test in tests)
    levels = sorted({round(-test.pressed, 9) for test in tests})
    # a box with a stiffness raises the pressure that crushes
    reached = sorted(float(np.max(pressures(test))) for test in tests)
    several, reversed_ = len(levels) > 1 and reached[-1] > APART * reached[0], cycles(tests)
    # one curve of the strength does not show a slope beside the friction, unless it climbs and descends
    shown = sides > 0 and (dilates or len(levels) > 1)
    slope = ("theta", "height") if shown else ("theta",) if reversed_ and sides else ()
    slopes: list[tuple[str, ...]] = [(), *(slope[: i + 1] for i in range(len(slope)))]
    crushed = [("theta", "height", "crush")] if several and sides else []
    worn = [("theta", "W0"), ("theta", "height", "W0")][: 1 + dilates] if reversed_ and sides else []
    bonded = slopes if dilates else slopes[:1]
    constants = []
    if joint != MORTAR:
        constants += [(KT, "mu", *more) for more in slopes + crushed + worn]
    if joint != ROCK:
        constants += [(*(() if reversed_ else (KT,)), "sigma0", "Gc", "mu", *more) for more in bonded]
    if not reached[-1] > 0.0:
        # without a pressure a bond alone carries
        constants = [free for free in constants if "sigma0" in free]
    rows = sum(test.slip.size * (1 + (test.s_N is not None)) for test in tests)
    models: list[Model] = []
    for free in constants:
        fixed = dict(known)
        # a stiffness of the joint that the user gives stands in place of a spring in series
        kept = tuple(name for name in free if name not in known and not (name == KT and KS in known))
        inclined = "theta" in {*free, *known}
        left_out = not inclined and any(known.get(name) for name in ("height", "crush", "W0"))
        if not left_out and ROWS_EACH * len(kept) <= rows and not any(model.free == kept for model in models):
            models.append(Model(kept, sides, fixed))
    return models


def independent(solution: Solution) -> dict[str, float]:
    """Number of independent data of tau and of the dilation."""
    counts = {"tau": 0.0, "dilation": 0.0}
    for (_, name), rows in solution.problem.rows.groupby(["test", "name"]).indices.items():
        counts[str(name)] += independent_rows(solution.residuals[rows])
    return counts


def is_noise(solution: Solution) -> bool:
    """Whether the residuals are noise, so that a larger model has nothing to explain."""
    least = min(test.slip.size for test in solution.problem.tests)
    return least > 20 and sum(independent(solution).values()) > NOISE * solution.residuals.size


def criteria(solutions: Sequence[Solution]) -> list[float]:
    """Information criterion (BIC) of each model, with the independent data of the one that fits best."""
    squares = [solution.mean_squares for solution in solutions]
    floor = 1e-12
    sums = [sum(np.log(max(value, floor)) for value in square.values()) for square in squares]
    best = int(np.argmin(sums))
    counts = independent(solutions[best])
    total = np.log(max(sum(counts.values()), 2.0))
    return [
        float(sum(counts[name] * np.log(max(value, floor) / max(squares[best][name], floor))
                  for name, value in square.items() if name in squares[best]) + solution.x.size * total)
        for solution, square in zip(solutions, squares, strict=True)
    ]  # fmt: skip


def choose(solutions: Sequence[Solution]) -> tuple[int, list[float]]:
    """The smallest model that no larger one beats by GAIN for each constant it adds; and the criteria."""
    bic = criteria(solutions)
    best = int(np.argmin(bic))
    order = sorted(range(len(solutions)), key=lambda i: (solutions[i].x.size, bic[i]))
    fewer = (
        i for i in order if bic[i] <= bic[best] + GAIN * max(0, solutions[best].x.size - solutions[i].x.size)
    )
    return next(fewer, best), bic
