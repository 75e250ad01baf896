"""Physical checks of shear-box tests: signs, order and sizes of their numbers, and units that are mixed."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ...contract import Floats
from ...material import ModelWarning
from ..tables import size

if TYPE_CHECKING:
    from .shear_test import ShearTest

Kind = TypeVar("Kind")

HELD = 0.05
"""Largest relative variation of a constant normal traction."""

LEAST_CORRELATION, TIMES = 0.95, 1.5
"""Correlation of pressure and dilation in a box with a normal stiffness; and ratio of the given stiffness to
that of the rows above which they contradict each other.
"""

LARGEST_RATIO, LARGEST_FRICTION = 1.0e3, 100.0
"""Ratios of two lengths or stresses above which units are mixed (kPa to MPa is near 1000), and of tau to
|sigma_N| without units (a friction of 0.8 on planes of 45 degrees gives 9).
"""

STEEPEST, OFFSET = 20.0, 0.5
"""Ratio of dilation to slip of planes of 87 degrees; largest first dilation or slip over its range."""

CLOSING = 0.05
"""Closure over the slip at the end of a test beyond which its sign may be the other one."""

SIGNAL, DEVIATIONS = 0.25, 3.0
"""Largest correlation of neighbouring rows, and this in standard deviations of that of independent ones, of a
dilation that is noise.
"""

SAME_ROWS, SAME_DIGITS = 0.9, 6
"""Fraction of the rows of a test in another one that makes it a copy, and digits in which they agree."""

USUAL = {"length": (1e-6, 1.0), "stress": (1e3, 2e8)}
"""Usual sizes of the largest slip, in metres, and of the largest stress, in pascals."""


_SEEN = "the pressure grows with the dilation by a stiffness of"


def warn_if(odd: object, text: str) -> None:
    """Give a ModelWarning where something is odd."""
    if odd:
        warnings.warn(text, ModelWarning, stacklevel=2)


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


def check_known(known: Mapping[str, float]) -> None:
    """Check values of constants that are known from elsewhere, by name.  Raises ValueError."""
    for name, value in known.items():
        if not 0.0 <= value < np.inf:
            raise ValueError(f"{name} = {value:g}: expected a finite value >= 0")
    theta, eta = known.get("theta", 0.0), known.get("eta", 0.9)
    if 0.0 < theta < 0.1:
        raise ValueError(f"theta = {theta:g}: expected degrees, 0 or at least 0.1 (a radian is 57.3)")
    if theta >= 90.0:
        raise ValueError(f"theta = {theta:g}: expected 0 <= theta < 90")
    if eta >= 1.0:
        raise ValueError(f"eta = {eta:g}: expected below 1")


def of_kind(tests: Sequence[object], kind: type[Kind]) -> list[Kind]:
    """Tests, all of one kind.  Raises ValueError for one of another kind."""
    of_this_kind = [test for test in tests if isinstance(test, kind)]
    if len(of_this_kind) < len(tests):
        stranger = next(test for test in tests if not isinstance(test, kind))
        raise ValueError(
            f"tests: {type(stranger).__name__} beside {kind.__name__}: expected tests of one kind"
        )
    return of_this_kind


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
    return bool(total > 0.0 and 1.0 - noise / total > min(SIGNAL, DEVIATIONS / np.sqrt(rows)))


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
