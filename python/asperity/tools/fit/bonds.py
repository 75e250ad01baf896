"""Whether tests show a bond: no joint without bond explains them as well, and rows carry it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...contract import Floats
from .model import Problem
from .search import Solution, independent, residuals, solve
from .thresholds import GAIN, GOOD, ROOT, SEARCHED


def guessed(
    chosen: Solution,
    solutions: Sequence[Solution],
    bic: Sequence[float],
    measured: bool,
) -> Iterator[str]:
    """Reason why a bond is a guess: a joint without bond explains the tests as well.

    measured: whether the tests have a dilation.  Without one the softening of asperities may be that of a
    bond, and only its dependence on the pressure tells them apart.
    """
    rock, bond = _best(solutions, bic)
    if rock < bond + GAIN or not (measured or _constant(chosen)):
        what = "ladder of models" if measured else "strength alone"
        help_ = "" if measured else "a measured dilation, "
        yield (
            f"the {what} does not tell a bond from asperities that end: --joint mortar or rock, {help_}"
            "or pressures further apart"
        )


def is_near_bond(solutions: Sequence[Solution], bic: Sequence[float]) -> bool:
    """Whether a joint with a bond explains the tests nearly as well as the best one without.

    That is no reason against the latter: a bond needs a proof, and one that the tests hardly show leaves the
    friction and the asperities as they are.
    """
    rock, bond = _best(solutions, bic)
    return bond < rock + GAIN


def _best(solutions: Sequence[Solution], bic: Sequence[float]) -> tuple[float, float]:
    """Smallest criterion of the joints without and with a bond."""
    rock, bond = (
        min(
            (value for solution, value in zip(solutions, bic, strict=True) if solution.model.bond == kind),
            default=np.inf,
        )
        for kind in (False, True)
    )
    return rock, bond


@dataclass(frozen=True, eq=False)
class Scaled(Problem):
    """Problem whose bond grows with the root of the pressure of the test, as asperities do; kind: of it."""

    kind: type[Problem] = Problem

    @cached_property
    def each(self) -> list[tuple[float, Problem]]:
        """Factor of the bond and problem of each test."""
        pressed = np.array([max(abs(test.pressed), 1e-300) for test in self.tests])
        factors = (pressed / np.exp(np.mean(np.log(pressed)))) ** ROOT
        rest = (self.free, self.fixed, self.sides, self.direction, self.increments, self.weight)
        return [
            (float(factor), self.kind([test], *rest))
            for factor, test in zip(factors, self.tests, strict=True)
        ]

    @cached_property
    def paths(self) -> list[tuple[Floats, np.ndarray]]:
        """Slips and rows of each test."""
        return [problem.paths[0] for _, problem in self.each]

    def curves(self, values: Mapping[str, float]) -> list[tuple[Floats, Floats, int]]:
        """tau, s_N and the number of converged rows of each test."""
        return [
            problem.curves({**values, **{name: factor * values[name] for name in ("sigma0", "Gc")}})[0]
            for factor, problem in self.each
        ]


def _scaled(problem: Problem) -> Scaled:
    rest = (problem.sides, problem.direction, problem.increments, problem.weight)
    return Scaled(problem.tests, problem.free, problem.fixed, *rest, kind=type(problem))


def _constant(chosen: Solution) -> bool:
    """Whether the tests exclude asperities with the softening of the bond and a strength that grows."""
    if np.ptp([abs(test.pressed) for test in chosen.problem.tests]) == 0.0:
        return False
    scaled, ratio = _scaled(chosen.problem), np.inf
    coarse, mean_square = _scaled(chosen.problem.coarse()), max(chosen.mean_squares["tau"], 1e-12)
    for x in (chosen.x, solve(coarse, chosen.x, SEARCHED)[0]):
        ratio = min(ratio, float(np.mean(residuals(scaled, x) ** 2)) / mean_square)
    return independent(chosen)["tau"] * float(np.log(max(ratio, 1e-12))) >= GAIN


def share_of_bond(solution: Solution) -> float:
    """Largest part that the bond carries in a row, over the largest tau of its test.

    It is the part which the same joint with a broken bond lacks.
    """
    problem, share = solution.problem, 0.0
    broken = problem.curves(solution.values | {"damage0": 1.0})
    for test, (_, rows), (tau, _, _), (rest, _, _) in zip(
        problem.tests, problem.paths, problem.curves(solution.values), broken, strict=True
    ):
        share = max(share, float(np.abs(tau - rest)[rows].max() / np.abs(test.tau).max()))
    return share


def unseen_bond(chosen: Solution, auto: bool, of_user: Mapping[str, float]) -> tuple[str, str]:
    """Reason and note, empty where there is none, of a bond that no row shows.

    auto: whether the ladder chose it; of_user: values of the user, which are accepted.
    """
    share = share_of_bond(chosen)
    if share >= GOOD:
        return "", ""
    text = f"the rows do not show the bond, which carries at most {share:.1%} of the largest traction"
    if {"sigma0", "Gc"} <= {*of_user}:
        return "", f"{text}: its constants are assumed"
    help_ = "--joint rock" if auto else "--set sigma0= and Gc="
    return f"{text}: {help_}, or rows at smaller slips", ""
