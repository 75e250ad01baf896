"""Constants that a fit may identify, and models of shear-box tests: residuals over the constants."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import contract
from ...contract import Floats
from ...interface import Interface
from ...load_path import columns_of
from ...material import Material
from ...pattern import Pattern, direction_vector
from ...steps import slip_path, thinned
from .rigid import LAW, SHAPES, has_closed_form, rigid_curve
from .shear_test import ShearTest, cycles
from .thresholds import (
    BRITTLE,
    CANDIDATES,
    FARTHEST,
    INCREMENTS,
    LEAST_RANGE,
    MOST_SEARCHED,
    PENALTY,
    ROUNDS,
    SOFT_CYCLES,
    STIFF,
    STIFF_CONTACT,
)

Curve: TypeAlias = tuple[Floats, Floats, int]
"""tau and s_N of a test, (P,) each, and the number of rows with equilibrium."""

Constants: TypeAlias = tuple[tuple[str, float], ...]
"""Values of constants with their names."""

TIMELESS = tuple(
    row
    for row in contract.owned("law", "pattern")
    if row.scale != "whole" and row.lower >= 0.0 and "time" not in row.unit
)
"""Constants that can be identified: numbers >= 0 that matter in tests without a time."""

MATERIAL = tuple(row.name for row in TIMELESS if row.owner == "law")
"""Constants of the material; the others are those of the pattern."""

KS, KT = "ks", "kT"
"""Shear stiffness of a joint without bond, a constant in place of those of the bond; and that of a spring in
series with the joint, along the slip: specimen, box and matedness.
"""

SPRINGS = (KS, KT)
"""Stiffnesses of the elastic slip, on which the other constants do not depend."""

INCLINED = tuple(row.name for row in TIMELESS if row.inclined)
"""Constants of inclined planes."""

CRUSHING = ("fc", "Gfc", "Css", "kp", "fcr")
"""Constants of a compressive strength, which a fit leaves out: tests that it ends have no curves."""

ROCK, MORTAR, AUTO = "rock", "mortar", "auto"
"""Forms of a joint: without bond, with bond, and that of the two which the tests support."""

SCALES = {row.name: row.scale for row in TIMELESS} | dict.fromkeys((KS, KT), "log")
UNITS = {row.name: row.unit for row in TIMELESS} | dict.fromkeys((KS, KT), "stress/length")
PLAUSIBLE = {row.name: row.plausible for row in TIMELESS} | dict.fromkeys((KS, KT), (1e-2, 1e5))
PLAUSIBLE |= {"kn": (1e-2, 1e8)}
"""Scale, unit and plausible range of a constant; the range is in multiples of the size of its unit."""

SIDES, PRELOAD, KEPT = 2, 10, 64
"""Inclined planes of the default pattern, along the slip; increments of sigma_N before the slip; and runs of
the law that a problem keeps.
"""


def to_scale(name: str, value: ArrayLike) -> Floats:
    """Value on the scale of the constant, on which a fit works: its logarithm, logit or itself."""
    values, scale = np.asarray(value, dtype=float), SCALES.get(name, "log")
    if scale == "linear":
        return values
    x: Floats = np.log(values / (1.0 - values) if scale == "logit" else values)
    return x


def from_scale(name: str, x: ArrayLike) -> Floats:
    """Value of a constant from that on its scale, within the range of doubles."""
    places, scale = np.clip(np.asarray(x, dtype=float), -700.0, 700.0), SCALES.get(name, "log")
    value: Floats = places
    if scale != "linear":
        value = 1.0 / (1.0 + np.exp(-places)) if scale == "logit" else np.exp(places)
    return value


def material_of(values: Mapping[str, float]) -> Material:
    """Material of constants by name, or their defaults; with ks that of a joint without bond."""
    constants = {name: values[name] for name in MATERIAL if name in values}
    if KS not in values:
        return Material(**constants)
    return Material.from_joint(kn=constants.pop("kc") * values[KS], ks=values[KS], **constants)


def rows_of(test: ShearTest, rows: slice | NDArray[np.intp]) -> ShearTest:
    """Some rows of a test."""
    s_N, path_N = (None if column is None else column[rows] for column in (test.s_N, test.path_N))
    return replace(test, slip=test.slip[rows], tau=test.tau[rows], s_N=s_N, path_N=path_N, lines=())


def plausible(
    name: str, stress: float, length: float, ranges: Mapping[str, tuple[float, float]] = PLAUSIBLE
) -> tuple[float, float]:
    """Ends of what joints have, or of other ranges, in tests of this largest stress and length."""
    sizes = {"stress": stress, "length": length, "stress*length": stress * length}
    size = (sizes | {"stress/length": stress / length}).get(UNITS.get(name, "stress/length"), 1.0)
    low, high = ranges[name]
    return low * size, high * size


def slip_curve(
    props: Floats,
    test: ShearTest,
    slips: Floats,
    rows: np.ndarray,
    direction: float,
    preload: int,
    spring: float = 0.0,
) -> Curve:
    """tau along the slip and s_N since its start, (P,) each, and the number of converged rows.

    The model of a shear box: `Interface.confined_slip` under sigma_N and k_N of the test, without its state
    and events. props: of the interface. slips, rows: as in `Problem.paths`. A measured normal traction is
    prescribed, straight between the rows of the test. Rows without equilibrium repeat the last one. spring:
    stiffness in series, stress/length, of which the slips are the far end; 0: none.
    """
    n, along = slips.size, direction_vector(direction)
    load, slide = slip_path(direction, slips, test.sigma_N, preload, test.k_N)
    if spring:
        slide = replace(slide, slip=None, direction=None, k_Tx=spring, k_Ty=spring)
        slide = replace(slide, t_Tx=spring * along[0] * slips, t_Ty=spring * along[1] * slips)
    if test.path_N is not None:
        slide = replace(slide, t_N=np.interp(np.arange(n), [0, *rows], [test.sigma_N, *test.path_N]))
    step, s_N, t_x, t_y = columns_of(props, [load, slide], ("step", "s_N", "t_Tx", "t_Ty"))
    first = int(np.sum(step <= 1.0))
    done = step.size - first
    if done == 0:
        return np.zeros(n), np.zeros(n), 0
    place = first + np.minimum(np.arange(n), done - 1)
    return (along[0] * t_x + along[1] * t_y)[place], (s_N - s_N[first])[place], done


@dataclass(frozen=True, eq=False)
class Rows:
    """Row of every residual, (n,) each: number of its test, name of its column, row there, measured value and
    scale.
    """

    test: NDArray[np.intp]
    name: NDArray[np.str_]
    row: NDArray[np.intp]
    measured: Floats
    scale: Floats


@dataclass(frozen=True, eq=False)
class Problem:
    """Residuals of measured tests as a function of the constants on their scales.

    tests: the measured tests.  free: names of the constants to identify.  fixed: values of the others.
    sides: inclined planes of the pattern.  direction: of the slip, degrees.  increments: smallest number
    along a test.  weight: of the residuals of the dilation.
    """

    tests: Sequence[ShearTest]
    free: tuple[str, ...]
    fixed: Mapping[str, float]
    sides: int = SIDES
    direction: float = 0.0
    increments: int = INCREMENTS
    weight: float = 1.0

    @property
    def size(self) -> tuple[float, float]:
        """Largest stress and length of the tests, with which the ranges of the constants are multiplied."""
        stress = max(float(np.abs(test.tau).max()) for test in self.tests)
        return stress, max(float(np.abs(test.slip).max()) for test in self.tests)

    @cached_property
    def ends(self) -> Floats:
        """Bounds of the free constants on their scales, the plausible ranges, (2, p)."""
        return np.transpose([to_scale(name, plausible(name, *self.size)) for name in self.free])

    @cached_property
    def paths(self) -> list[tuple[Floats, np.ndarray]]:
        """Slips (P,) of the model for each test, from zero on, and which of them are rows of the test."""
        paths = []
        for test in self.tests:
            nodes = np.append(0.0, test.slip)
            lengths = np.abs(np.diff(nodes))
            parts = np.maximum(1, np.ceil(lengths / lengths.sum() * self.increments - 1e-9).astype(int))
            rows = np.cumsum(np.append(0, parts))
            paths.append((np.interp(np.arange(rows[-1] + 1), rows, nodes), rows[1:]))
        return paths

    @cached_property
    def rows(self) -> Rows:
        """Row of every residual; the scale is the range in the test."""
        least = LEAST_RANGE * max([0.0, *(np.ptp(test.s_N) for test in self.tests if test.s_N is not None)])
        parts = []
        for number, test in enumerate(self.tests):
            columns = [("tau", test.tau, float(np.ptp(test.tau)))]
            if test.s_N is not None:
                columns.append(("dilation", test.s_N, max(float(np.ptp(test.s_N)), least)))
            for name, measured, of_column in columns:
                same = (np.full(measured.size, value) for value in (number, name, of_column))
                parts.append((*same, np.arange(measured.size), measured))
        tests, names, scales, rows, measured = map(np.concatenate, zip(*parts, strict=True))
        return Rows(tests, names, rows, measured, scales)

    @cached_property
    def measured(self) -> tuple[Floats, Floats, Floats]:
        """Measured value, scale and weight of every residual."""
        weights = np.where(self.is_dilation, self.weight, 1.0)
        return self.rows.measured, self.rows.scale, weights

    @cached_property
    def is_dilation(self) -> NDArray[np.bool_]:
        """Mask of the residuals of s_N."""
        mask: NDArray[np.bool_] = self.rows.name == "dilation"
        return mask

    def values(self, x: Floats) -> dict[str, float]:
        """Values of all constants by name, from the free ones on their scales."""
        values = {name: float(from_scale(name, value)) for name, value in zip(self.free, x, strict=True)}
        return dict(self.fixed) | values

    def x(self, values: Mapping[str, float]) -> Floats:
        """Free constants on their scales, from their values."""
        return np.array([float(to_scale(name, values[name])) for name in self.free])

    def interface(self, values: Mapping[str, float]) -> Interface:
        """The interface with these constants."""
        return Interface(material_of(values), Pattern.regular(self.sides, values["theta"], values["flat"]))

    def props(self, values: Mapping[str, float]) -> Floats:
        """PROPS of the interface with these constants."""
        return self.interface(values).props()

    def curves(self, values: Mapping[str, float]) -> list[Curve]:
        """Curve of each test."""
        return [self.curve(values, number) for number in range(len(self.tests))]

    def curve(self, values: Mapping[str, float], number: int) -> Curve:
        """tau, s_N and the number of rows with equilibrium of a test."""
        return self.known(number, tuple(values.items()))

    @cached_property
    def known(self) -> Callable[[int, Constants], Curve]:
        """Runs of the law, the last of which are kept: a search and what follows ask for some again."""
        return lru_cache(KEPT)(self.run)

    def run(self, number: int, constants: Constants) -> Curve:
        """Curve of a test by the law, from `slip_curve`."""
        props, test = self.props(dict(constants)), self.tests[number]
        return slip_curve(props, test, *self.paths[number], self.direction, PRELOAD)

    def residuals(self, x: Floats) -> Floats:
        """Model less measurement, divided by the range of tau or of s_N of each test, with their weights."""
        model, lost, curves = [], [], self.curves(self.values(x))
        for test, (_, rows), (tau, s_N, done) in zip(self.tests, self.paths, curves, strict=True):
            columns = [tau[rows]] if test.s_N is None else [tau[rows], s_N[rows]]
            model += columns
            lost += [rows >= done] * len(columns)
        measured, scales, weights = self.measured
        residual = (np.concatenate(model) - measured) / scales
        residual = np.where(np.isfinite(residual), residual, PENALTY) + PENALTY * np.concatenate(lost)
        return np.asarray(weights * residual)

    def coarse(self) -> Problem:
        """Problem with few rows and increments, on which the starts search."""
        tests = []
        for test in self.tests:
            rows = thinned(test.slip, MOST_SEARCHED) if test.slip.size > MOST_SEARCHED else slice(None)
            tests.append(rows_of(test, rows))
        return replace(self, tests=tests, increments=min(self.increments, MOST_SEARCHED))

    is_closed_form = False
    """Whether residuals cost next to nothing."""


class Series(Problem):
    """First strokes of a joint with a spring of the stiffness kT in series: measured slip u + tau(u)/kT.

    The law runs along the slip u of the joint itself; tau and s_N are interpolated at the measured slips.
    Specimen, box and matedness are such a spring; the shear stiffness of a joint lies in its inclined planes,
    so that it dilates before it slides.
    """

    @cached_property
    def paths(self) -> list[tuple[Floats, np.ndarray]]:
        """Measured slips (P,) of each test, from zero on, and which of them are rows of the test."""
        paths = []
        for test in self.tests:
            slips = np.append(0.0, np.maximum.accumulate(sign_of(test) * test.slip))
            paths.append((slips, np.arange(1, slips.size)))
        return paths

    def curve(self, values: Mapping[str, float], number: int) -> Curve:
        """tau, s_N and the number of rows with equilibrium of a test."""
        slips = self.paths[number][0]
        outside, tau, s_N, done = self.outside(values, number)
        lost = slips.size
        if done < outside.size:
            lost = int(np.searchsorted(slips, outside[max(done - 1, 0)]))
        return np.interp(slips, outside, tau), np.interp(slips, outside, s_N), lost

    @cached_property
    def signs(self) -> list[float]:
        """Sign of the slip of each test."""
        return [sign_of(test) for test in self.tests]

    def top(self, number: int) -> float:
        """Largest slip up to which the joint is followed in a test."""
        return float(self.paths[number][0][-1])

    def outside(self, values: Mapping[str, float], number: int) -> tuple[Floats, Floats, Floats, int]:
        """Measured slips, tau and s_N of a test, (P,) each, and the number of rows with equilibrium."""
        test, sign, stiffness = self.tests[number], self.signs[number], 1.0 / self.compliance(values)
        top = self.top(number)
        slips = top * places(self.increments)
        if test.path_N is None:
            tau, s_N, done = self.slid(values, number)
        else:
            at = np.maximum.accumulate(np.maximum(0.0, sign * (test.slip - test.tau / stiffness)))
            path = np.interp(slips[1:], at, test.path_N)
            alone = replace(test, slip=slips[1:], tau=slips[1:], s_N=None, lines=(), path_N=path)
            tau, s_N, done = self.slid_under(values, alone, sign * slips)
        # softening steeper than the spring is passed at one measured slip
        outside = np.maximum.accumulate(slips + sign * tau / stiffness) + 1e-12 * top * np.arange(slips.size)
        return outside, tau, s_N, done

    def compliance(self, values: Mapping[str, float]) -> float:
        """Slip over traction of what lies in series with `slid`, length/stress."""
        return 1.0 / values[KT]

    def slid(self, values: Mapping[str, float], number: int) -> Curve:
        """Curve of the joint alone under the pressure of a test, on which the spring has no effect."""
        return self.known(number, tuple(item for item in values.items() if item[0] != KT))

    def run(self, number: int, constants: Constants) -> Curve:
        """The same without those that are kept."""
        slips = self.signs[number] * (self.top(number) * places(self.increments))
        return self.slid_under(dict(constants), self.tests[number], slips)

    def slid_under(self, values: Mapping[str, float], test: ShearTest, slips: Floats) -> Curve:
        """Curve of the joint alone at these slips, as `slip_curve`."""
        rows = np.arange(1, slips.size)
        return slip_curve(self.props(values), test, slips, rows, self.direction, PRELOAD)


class CyclicSeries(Problem):
    """The same with reversals of the slip, where the driver has the spring: x is the way of its far end."""

    def run(self, number: int, constants: Constants) -> Curve:
        """Curve of a test by the law."""
        values, test = dict(constants), self.tests[number]
        path = self.paths[number]
        return slip_curve(self.props(values), test, *path, self.direction, PRELOAD, values[KT])


class Cyclic(Problem):
    """Cycles, in which the elastic slip is that of the joint."""

    @cached_property
    def ends(self) -> Floats:
        """Bounds of the free constants on their scales, (2, p)."""
        ranges = PLAUSIBLE | {KS: (PLAUSIBLE[KS][0], SOFT_CYCLES)}
        return np.transpose([to_scale(name, plausible(name, *self.size, ranges)) for name in self.free])

    def curve(self, values: Mapping[str, float], number: int) -> Curve:
        """Curve as of any problem.

        Raises ValueError for a bond that counts as rigid, which takes too many increments in each cycle.
        """
        if "sigma0" in values:
            stress, length = self.size
            stiffness = values["sigma0"] ** 2 / (2.0 * values["Gc"] * (1.0 - values["eta"]))
            if stiffness > STIFF * stress / length:
                raise ValueError(f"sigma0 = {values['sigma0']:g}: a bond of the stiffness {stiffness:g}")
        return super().curve(values, number)


@dataclass(frozen=True, eq=False)
class Rigid(Series):
    """Tests one after the other in the closed form of two rigid sides, from which a search begins.

    shape: name of that of slope and softening, which the law has or has not.
    """

    shape: str = LAW
    is_closed_form = True

    def compliance(self, values: Mapping[str, float]) -> float:
        """Slip over traction of the spring and of the joint before it slides, length/stress."""
        if SHAPES[self.shape].rises:
            return 1e-9 / values[KT]
        if KS in values:
            return 1.0 / values[KT] + 1.0 / values[KS]
        return 1.0 / values[KT] + 2.0 * (1.0 - values["eta"]) * values["Gc"] / values["sigma0"] ** 2

    def slid(self, values: Mapping[str, float], number: int) -> Curve:
        """As of any series; a bond that rises has the elastic slip itself."""
        if SHAPES[self.shape].rises:
            return self.known(number, tuple(values.items()))
        return super().slid(values, number)

    def slid_under(self, values: Mapping[str, float], test: ShearTest, slips: Floats) -> Curve:
        """tau and s_N of the closed form."""
        tau, s_N = rigid_curve(test, np.abs(slips), values, SHAPES[self.shape])
        return sign_of(test) * tau, s_N, slips.size


@dataclass(frozen=True, eq=False)
class Started(Rigid):
    """Rigid sides behind a spring, where slip and dilation of each test start at the values that fit best.

    Both are found for each test anew, whatever the constants are, so that they are no further constants.
    """

    @cached_property
    def scales(self) -> list[tuple[float, float]]:
        """Range of tau and of s_N of each test, as of the residuals."""
        rows = self.rows

        def scale(number: int, name: str) -> float:
            of_column = rows.scale[(rows.test == number) & (rows.name == name)]
            return float(of_column[0]) if of_column.size else 1.0

        return [(scale(i, "tau"), scale(i, "dilation")) for i in range(len(self.tests))]

    def farthest(self, number: int) -> float:
        """Largest start of the slip of a test."""
        return FARTHEST * float(np.ptp(self.paths[number][0]))

    def top(self, number: int) -> float:
        """Largest slip up to which the joint is followed in a test."""
        return super().top(number) + self.farthest(number)

    def curve(self, values: Mapping[str, float], number: int) -> Curve:
        """tau, s_N and the number of rows of a test, from its best starts on."""
        test = self.tests[number]
        slips, (of_tau, of_s_N) = self.paths[number][0], self.scales[number]
        farthest = self.farthest(number)
        outside, tau, s_N, _ = self.outside(values, number)

        def at(starts: Floats) -> tuple[Floats, Floats, Floats]:
            """Sum of squares, strength and opening, a row for each start of the slip."""
            slips_of_test = slips - starts[:, None]
            strength, opening = np.interp(slips_of_test, outside, tau), np.interp(slips_of_test, outside, s_N)
            squares = np.sum(((strength[:, 1:] - test.tau) / of_tau) ** 2, axis=1)
            if test.s_N is not None:
                opening = opening + np.mean(test.s_N - opening[:, 1:], axis=1)[:, None]
                squares += np.sum(((opening[:, 1:] - test.s_N) * self.weight / of_s_N) ** 2, axis=1)
            return squares, strength, opening

        middle, reach = 0.0, farthest
        for _ in range(ROUNDS):
            starts = np.clip(middle + reach * np.linspace(-1.0, 1.0, CANDIDATES), -farthest, farthest)
            squares = at(starts)[0]
            best = int(np.clip(np.argmin(squares), 1, CANDIDATES - 2))
            middle, reach = float(starts[best]), float(starts[best + 1] - starts[best])
        # the least value of the parabola through the last three
        below, here, above = squares[best - 1 : best + 2]
        bend = below - 2.0 * here + above
        part = float(np.clip(0.5 * (below - above) / bend, -1.0, 1.0)) if bend > 0.0 else 0.0
        _, strength, opening = at(np.array([middle + part * reach]))
        return strength[0], opening[0], slips.size


@cache
def places(increments: int) -> Floats:
    """Slips over the largest one at which a joint is followed, closer to each other at the start."""
    early = np.geomspace(1e-4, 0.1, 25)
    return np.unique(np.concatenate([[0.0], early, np.linspace(0.0, 1.0, increments + 1)]))


def sign_of(test: ShearTest) -> float:
    """Sign of the slip of a test."""
    return float(np.sign(test.slip[np.argmax(np.abs(test.slip))]))


@dataclass(frozen=True)
class Model:
    """Free constants, planes of the pattern, and constants that are not those of the usual model.

    shape: name of that of slope and softening; but for that of the law in closed form, without cycles.
    exact: whether the closed form of the law is not near enough to it.
    """

    free: tuple[str, ...]
    sides: int = 2
    fixed: Mapping[str, float] = field(default_factory=dict)
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
