"""A shear-box test: slip, traction and dilation, checks of its numbers, what its rows show without a law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ... import contract
from ...contract import Floats
from ...steps import turns_of
from ..tables import size, warn_if
from .thresholds import (
    AT_END,
    BACK,
    BEYOND_NOISE,
    CLOSING,
    FAR,
    HELD,
    LARGEST_FRICTION,
    LARGEST_RATIO,
    LEAST_CORRELATION,
    LEAST_DATA,
    LEAST_ROWS,
    LONELY,
    MOST_ALIKE,
    OF_SIGNAL,
    OFFSET,
    SAME_DIGITS,
    SAME_ROWS,
    SIGNAL,
    SMOOTHED,
    STEEPEST,
    TIMES,
    USUAL,
)

_SEEN = "the pressure grows with the dilation by a stiffness of"


@dataclass(frozen=True, eq=False)
class ShearTest:
    """One test: slip (T,) and s_N (T,), None where not measured, length; tau (T,), stress.

    s_N counts from the start of the slip, opening positive.  sigma_N: normal traction there, stress, <= 0;
    k_N: normal stiffness of the box, stress/length, 0 where sigma_N is constant.  name: file and test.
    units: of length and stress where the file has them.  lines (T,): of the file, empty where there is none.
    path_N (T,): measured normal traction of each row, None where sigma_N and k_N give it.
    Raises ValueError for inadmissible data.
    """

    name: str
    slip: Floats
    tau: Floats
    s_N: Floats | None
    sigma_N: float
    k_N: float = 0.0
    units: dict[str, str] = field(default_factory=dict)
    lines: tuple[int, ...] = ()
    path_N: Floats | None = None
    WHAT: ClassVar[str] = "curves of the slip"

    def __post_init__(self) -> None:
        """Check shapes and values."""
        for name in ("slip", "tau", "s_N", "path_N"):
            if getattr(self, name) is None:
                continue
            values = contract.array(name, getattr(self, name))
            object.__setattr__(self, name, values)
            wrong = values.shape != (self.slip.size,) or not (values.size and np.isfinite(values).all())
            if wrong:
                wanted = f"expected finite numbers of shape ({self.slip.size or 'T'},)"
                raise ValueError(f"{self.name}: {name} has shape {values.shape}: {wanted}")
            same = name in ("slip", "tau") and not np.ptp(values) > 0.0
            if same:
                raise ValueError(
                    f"{self.name}: column {name} is {values[0]:g} in all rows: expected values that change"
                )
        for name in ("sigma_N", "k_N"):
            object.__setattr__(self, name, contract.number(name, getattr(self, name)))
        worst = self.sigma_N if self.path_N is None else max(self.sigma_N, *self.path_N)
        if not -np.inf < worst <= 0.0:
            raise ValueError(f"{self.name}: sigma_N = {worst:g}: expected a finite compression, <= 0")
        if not 0.0 <= self.k_N < np.inf:
            raise ValueError(f"{self.name}: k_N = {self.k_N:g}: expected a finite stiffness >= 0")

    @property
    def pressed(self) -> float:
        """Normal traction of the largest size, stress."""
        return self.sigma_N if self.path_N is None else float(self.path_N.min())

    @property
    def level(self) -> float:
        """Largest pressure of those that are prescribed."""
        return 0.0 - self.pressed

    @property
    def covers(self) -> tuple[float, float, float]:
        """Prescribed pressure, largest one of the first stroke, and largest slip."""
        return self.level, float(np.max(pressures(self)[first_stroke(self)])), float(np.abs(self.slip).max())

    @property
    def turns(self) -> list[float]:
        """Slips at the reversals, and the last slip."""
        path = np.append(0.0, self.slip)
        return list(path[turns_of(path)[1:]].tolist())

    @property
    def ends_far(self) -> bool:
        """Whether the test ends at its largest slip, and not within a cycle."""
        return bool(abs(self.slip[-1]) >= FAR * np.abs(self.slip).max())

    def place(self, row: int) -> str:
        """Name of the test, with the line of a row where it comes from a file."""
        return f"{self.name}: line {self.lines[row]}" if self.lines else self.name


def smooth(values: Floats, rows: int) -> Floats:
    """Moving average over a number of rows."""
    rows = min(rows, values.size)
    return np.convolve(values, np.ones(rows) / rows, "valid")


def first_stroke(test: ShearTest) -> slice:
    """Rows of a test up to the first reversal."""
    slip = np.sign(test.slip[np.argmax(np.abs(test.slip))]) * test.slip
    # the rows beyond the highest slip so far by a reversal are not of the first stroke
    back = np.flatnonzero(np.maximum.accumulate(slip) - slip > BACK * np.ptp(slip))
    if not back.size:
        return slice(0, slip.size)
    return slice(0, int(np.argmax(slip[: back[0]])) + 1)


def cycles(tests: Sequence[ShearTest]) -> bool:
    """Whether the slip of a test is reversed."""
    return any(first_stroke(test).stop < test.slip.size for test in tests)


def under_pressure(tests: Sequence[ShearTest]) -> bool:
    """Whether a first stroke is under a pressure, without which no row shows the friction."""
    return max(test.covers[1] for test in tests) > 0.0


def noise(values: Floats) -> float:
    """Standard deviation of the noise of a curve, from its second differences."""
    second = np.diff(values, 2)
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0)) if second.size else 0.0


def independent_rows(residuals: Floats) -> float:
    """Number of independent rows of a curve: n (1 - rho)/(1 + rho).

    rho is the correlation of neighbouring residuals, as no law meets a joint within its noise.
    """
    size, square = residuals.size, max(float(residuals @ residuals), 1e-300)
    rho = float(residuals[:-1] @ residuals[1:]) / square if size > 2 else 0.0
    rho = min(max(rho, 0.0), MOST_ALIKE)
    return min(size, max(LEAST_DATA, size * (1.0 - rho) / (1.0 + rho)))


def pressures(test: ShearTest) -> Floats:
    """Pressure in each row of a test, (T,)."""
    if test.path_N is not None:
        return -test.path_N
    opening = np.zeros(test.slip.size) if test.s_N is None else test.s_N
    return np.asarray(test.k_N * opening - test.sigma_N)


def numbers(test: ShearTest, tau: Floats, s_N: Floats | None) -> dict[str, float]:
    """Peak, slip at the peak, residual and dilation at the end of rows, measured or of the law.

    The rows are averaged, as the largest of noisy rows is above the peak.  The residual is missing where the
    test ends within a cycle.
    """
    rows = first_stroke(test)
    size = np.abs(tau[rows])
    width = min(max(3, round(SMOOTHED * tau.size)), max(1, size.size // 2))
    averaged, slips = smooth(size, width), smooth(np.abs(test.slip[rows]), width)
    shown = {"peak": float(averaged.max()), "slip at peak": float(slips[int(averaged.argmax())])}
    end = slice(-max(min(width, tau.size), round(AT_END * tau.size)), None)
    if test.ends_far:
        shown["residual"] = float(np.mean(np.abs(tau[end])))
    if s_N is not None:
        shown["dilation"] = float(np.mean(s_N[end]))
    return shown


def noises(test: ShearTest) -> dict[str, float]:
    """Standard deviations, by noise, of the averages from which `numbers` reads a measured test."""
    size, strokes = test.tau.size, first_stroke(test)
    averaged = min(max(3, round(SMOOTHED * size)), max(1, test.tau[strokes].size // 2))
    at_end = max(min(averaged, size), round(AT_END * size))
    of_tau = noise(test.tau)
    deviations = {"peak": of_tau / averaged**0.5, "residual": of_tau / at_end**0.5}
    return deviations | ({} if test.s_N is None else {"dilation": noise(test.s_N) / at_end**0.5})


def first_slope(test: ShearTest) -> float:
    """Largest slope of the dilation over the slip in the first stroke; 0 where it was not measured."""
    slopes = _slopes(test)
    return max(slopes) if slopes else 0.0


def last_slope(test: ShearTest) -> float:
    """Slope of the dilation at the end of the first stroke; 0 where it was not measured."""
    slopes = _slopes(test)
    return max(0.0, slopes[-1]) if slopes else 0.0


def _slopes(test: ShearTest) -> list[float]:
    if test.s_N is None:
        return []
    rows = first_stroke(test)
    slip, dilation = np.abs(test.slip[rows]), test.s_N[rows]
    width = max(4, slip.size // 6)
    parts = [slice(i, i + width) for i in range(0, slip.size - width + 1, max(1, width // 2))]
    return [float(np.polyfit(slip[part], dilation[part], 1)[0]) for part in parts if np.ptp(slip[part]) > 0.0]


def check_rows(test: ShearTest, sigma_N: Floats) -> None:
    """Check the rows of a test against each other; sigma_N (T,): as measured.  Raises ValueError."""
    slip, held, path = test.slip, abs(test.sigma_N), test.path_N is not None
    slips, first = float(np.ptp(slip)), test.place(0)
    worst = int(np.argmax(np.abs(sigma_N - test.sigma_N)))
    varies = not (test.k_N or path) and abs(sigma_N[worst] - test.sigma_N) > HELD * held
    text = f"column sigma_N: {sigma_N[worst]:g} is more than {HELD:.0%} off the mean {test.sigma_N:g}"
    seen = 0.0 if test.s_N is None else _stiffness(test.s_N, sigma_N)
    if varies and seen:
        raise ValueError(f"{test.place(worst)}, {text}; {_SEEN} {seen:.3g}: expected --k-N {seen:.3g}")
    if varies:
        wanted = (
            "expected a constant normal traction, k_N, or a column test for several tests; --sigma-N-path"
        )
        raise ValueError(f"{test.place(worst)}, {text}: {wanted} prescribes it as it was measured")
    work = float(0.5 * (test.tau + np.append(0.0, test.tau[:-1])) @ np.diff(slip, prepend=0.0))
    if work < 0.0:
        text = f"columns slip, tau: the work of tau along the slip is {work:.3g} < 0: expected tau > 0"
        raise ValueError(f"{test.name}: {text} where the slip grows; change the sign of one of the columns")
    if abs(float(slip[0])) > OFFSET * slips:
        late = f"{slip[0]:g} in the first row: expected slips from 0 on, as those of the model"
        raise ValueError(f"{first}, column slip: {late}")
    if test.s_N is None:
        return
    s_N, dilated = test.s_N, float(np.ptp(test.s_N))
    apart = outliers(s_N[first_stroke(test)])
    if apart:
        more = f" (as in {len(apart)} rows)" if len(apart) > 1 else ""
        text = f"column dilation: {s_N[apart[0]]:g}{more} lies apart from all others"
        raise ValueError(f"{test.place(apart[0])}, {text}: expected no outlier, no mark of a missing value")
    offset = abs(float(s_N[0])) > STEEPEST * abs(float(slip[0])) + OFFSET * dilated
    if offset:
        text = f"column dilation: {s_N[0]:g} at slip {slip[0]:g}: expected the change since the start"
        raise ValueError(f"{first}, {text} of the slip")
    far = int(np.argmax(np.abs(s_N)))
    impossible = abs(float(s_N[far])) > STEEPEST * float(np.abs(slip).max())
    if impossible:
        text = f"column dilation: {s_N[far]:g} is more than {STEEPEST:g} times the largest slip"
        raise ValueError(f"{test.place(far)}, {text}: expected another unit, or no mark of a missing value")
    closes = s_N[-1] < -CLOSING * abs(float(slip[-1])) and s_N[-1] < -OFFSET * dilated
    text = f"{test.name}: column dilation: {s_N[-1]:.3g} at the end: a joint that slips usually opens"
    warn_if(closes, f"{text}, and opening is positive: check the sign")


def outliers(values: Floats) -> list[int]:
    """Rows between others whose values lie farther from the others than these from each other."""
    if values.size < LEAST_ROWS:
        return []
    ordered = np.sort(values)
    gap = int(np.argmax(np.diff(ordered)))
    middle = 0.5 * (ordered[gap] + ordered[gap + 1])
    above = values > middle
    others = np.flatnonzero(above == (2 * np.sum(above) > values.size))
    # others that are equal have no range to compare with
    if not 0.0 < LONELY * float(np.ptp(values[others])) < np.diff(ordered)[gap]:
        return []
    return sorted({*range(int(others[0]), int(others[-1]))} - {*others.tolist()})


def _stiffness(s_N: Floats, sigma_N: Floats) -> float:
    """Normal stiffness of the box by which the pressure grows with the dilation; 0 where it does not."""
    if not (np.ptp(s_N) > 0.0 and np.ptp(sigma_N) > HELD * abs(float(np.mean(sigma_N)))):
        return 0.0
    slope, correlation = -float(np.polyfit(s_N, sigma_N, 1)[0]), -float(np.corrcoef(s_N, sigma_N)[0, 1])
    return slope if correlation > LEAST_CORRELATION else 0.0


def check_stiffness(name: str, k_N: float, s_N: Floats, sigma_N: Floats) -> None:
    """Raise ValueError for a stiffness that the rows contradict."""
    seen = _stiffness(s_N, sigma_N)
    if seen and not 1.0 / TIMES <= k_N / seen <= TIMES:
        raise ValueError(f"{name}: k_N = {k_N:g}, but {_SEEN} {seen:.3g}: expected this one")


def check_copies(tests: Sequence[ShearTest]) -> None:
    """Raise ValueError for a test with the rows of another one, which would count twice."""
    columns = [[test.slip, test.tau] for test in tests]
    dilations = [test.s_N for test in tests if test.s_N is not None]
    if len(dilations) == len(tests):
        columns = [[*some, s_N] for some, s_N in zip(columns, dilations, strict=True)]
    refuse_copies([test.name for test in tests], columns)


def refuse_copies(names: Sequence[str], columns: Sequence[Sequence[Floats]]) -> None:
    """Raise ValueError for a test with the rows of another one; columns (T,) of each test."""
    every = zip(*columns, strict=True)
    sizes = [max(1e-300, *(float(np.abs(column).max()) for column in same)) for same in every]
    seen: list[tuple[str, set[tuple[float, ...]]]] = []
    for name, columns_of_test in zip(names, columns, strict=True):
        parts = (
            np.round(column / size, SAME_DIGITS).tolist()
            for column, size in zip(columns_of_test, sizes, strict=True)
        )
        rows = {*zip(*parts, strict=True)}
        for name_before, theirs in seen:
            small, large = sorted((rows, theirs), key=len)
            same = len(small & large) > SAME_ROWS * len(small)
            if same:
                raise ValueError(
                    f"{name}: the rows are those of {name_before}: expected different tests, each once"
                )
        seen.append((name, rows))


def shows_dilation(tests: Sequence[ShearTest]) -> bool:
    """Whether a dilation was measured that is no noise, by the correlation of its neighbouring rows."""
    columns = [test.s_N for test in tests if test.s_N is not None]
    rows, total = sum(map(len, columns)), sum(float(np.var(s_N)) * s_N.size for s_N in columns)
    noise = 0.5 * sum(float(np.sum(np.diff(s_N) ** 2)) for s_N in columns)
    return bool(total > 0.0 and 1.0 - noise / total > min(SIGNAL, OF_SIGNAL / np.sqrt(rows)))


def lift(test: ShearTest) -> float:
    """Dilation of asperities that would give a test all of its strength above that at the end.

    A slope t adds t (1 + ratio^2) to a ratio of strength to pressure.
    """
    rows, slip = first_stroke(test), np.abs(test.slip)
    pressure = pressures(test)[rows]
    if not (pressure > 0.0).all():
        return np.inf
    ratio = np.abs(test.tau[rows]) / pressure
    end = float(np.mean(ratio[-max(1, round(AT_END * ratio.size)) :]))
    slope = np.maximum(0.0, ratio - end) / (1.0 + end**2)
    return float(np.sum(slope[1:] * np.maximum(0.0, np.diff(slip[rows]))))


def excludes_lift(test: ShearTest) -> bool:
    """Whether a dilation that is noise would show the lift of asperities."""
    return test.s_N is not None and float(np.std(test.s_N)) < lift(test) / BEYOND_NOISE


def check_sizes(tests: Sequence[ShearTest]) -> None:
    """Check stresses and units of tests against each other.  Raises ValueError or gives a ModelWarning."""
    with_units, without = (
        [test.name for test in tests if bool(test.units) == which] for which in (True, False)
    )
    if with_units and without:
        text = f"expected units in every file, as in {''.join(with_units[:1])}, or in none"
        raise ValueError(f"{''.join(without[:1])}: no units in the header: {text}")
    for test in tests:
        last = 0.0 if test.s_N is None else test.k_N * float(test.s_N[-1])
        held = abs(test.sigma_N - last if test.path_N is None else float(test.path_N[-1]))
        most = LARGEST_RATIO if test.units else LARGEST_FRICTION
        tau = float(np.mean(np.abs(test.tau[-max(1, test.slip.size // 10) :])))
        text = f"{test.name}: column tau: {tau:.3g} at the end where |sigma_N| is {held:.3g}: expected the"
        text += f" same unit (a ratio of {1.0 / most:g} to {most:g}), or units in the header, as tau [kPa]"
        # a bond may have no traction at its end, so that the smallest ratio is that of the largest one
        if held > 0.0 and not (tau <= most * held and held <= most * float(np.abs(test.tau).max())):
            raise ValueError(text)
    largest = {"length": max(float(np.abs(test.slip).max()) for test in tests)}
    largest["stress"] = max(max(abs(test.pressed), float(np.abs(test.tau).max())) for test in tests)
    for kind, (low, high) in USUAL.items() if with_units else ():
        unit = tests[0].units[kind]
        text = f"the largest {kind} is {largest[kind]:.3g} {unit}, which is unusual for a shear box"
        warn_if(not low <= largest[kind] * size(kind, unit) <= high, f"{text}: check the units of the header")
