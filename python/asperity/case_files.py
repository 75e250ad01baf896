"""Cases as the library reads them, and the slip tests in these cases."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import calls, contract
from .contract import Floats
from .history import History
from .interface import Interface
from .load_path import rows_of
from .material import Material
from .pattern import Pattern
from .steps import TARGETS, Point, Step, numbers_of, prescribed, step_of


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a case.

    value: value of the sweep, None without a sweep. start: "virgin", or the group with the state at the
    start, "initial" or "state". steps: the load path, with cycles, increments and times of every target; a
    replay has none. state: start of the path, None for a virgin point. tolerance: of the path, or None.
    loses: whether a loss of equilibrium is the expected end.  a_0, a_min: as in `History.with_aperture`.
    """

    value: float | None
    props: tuple[float, ...]
    material: Material
    pattern: Pattern
    start: str
    steps: tuple[Step, ...]
    state: Point | None
    tolerance: float | None
    loses: bool = False
    a_0: float = 0.0
    a_min: float = 0.0

    @property
    def interface(self) -> Interface:
        """Interface with the material and the pattern of the run."""
        return Interface(self.material, self.pattern)

    def history(self) -> History:
        """Rows of the run, by `Interface.run`; raises ValueError for a replay, which has no steps."""
        rows = self.interface.run(self.steps, self.state, self.tolerance)
        return rows.with_aperture(self.a_0, self.a_min)

    def of_host(self) -> dict[str, Any]:
        """Entries of PROPS that belong to the host and to the numerics, by name."""
        return _values(self.props, "host", "numerics")


@dataclass(frozen=True, eq=False)
class Case:
    """Content of a case file.

    sweep: name of the swept value, empty without a sweep. before, after: text of the file before and after
    the group &pattern. umat: whether the law is that of &umat, and `runs` is empty; count: number of runs.
    """

    path: Path
    title: str
    sweep: str
    runs: tuple[Run, ...]
    before: bytes
    after: bytes
    umat: bool = False
    count: int = 1


@dataclass(frozen=True, eq=False)
class SlipTest:
    """Slip test: slips (T,) along direction (degrees) under a constant sigma_N.

    sigma_N is applied first, in `preload` increments. A case that opens the interface in mode I has no slips.
    value: value of the sweep, None without a sweep.
    """

    value: float | None
    material: Material
    pattern: Pattern
    preload: int
    sigma_N: float
    direction: float
    slips: Floats


def read_case(path: str | Path, any_law: bool = False) -> Case:
    """Read a case file of the driver, defaults included; it has a `Run` for every value of its sweep, or one.

    A run has the joint (`interface`), `steps`, `state` and `tolerance` of `Interface.run`; `history()` runs
    it.  any_law: whether the case may have `&umat` instead of material and pattern.  Raises ValueError with
    the messages of the driver: all errors, each with file, line, value and what is expected.

    Examples
    --------
    >>> import asperity
    >>> from asperity.installed import named_case
    >>> case = asperity.read_case(named_case("figure04b"))
    >>> case.runs[0].steps[1].slip
    (0.6,)
    >>> round(float(case.runs[0].history().traction[-1, 0]), 9)
    -10.0
    """
    path = Path(path)
    content = calls.content(b"", path=os.fsencode(path))
    runs = [_run(run) for run in content["runs"]]
    umat = runs[0] is None
    if umat and not any_law:
        raise ValueError(f"{path}: &umat: expected &material and &pattern")
    source, (first, last) = path.read_bytes(), content["pattern"]
    of_joints = tuple(run for run in runs if run is not None)
    return Case(
        path,
        content["title"] or path.stem,
        content["sweep"],
        of_joints,
        source[: first - 1],
        source[last:],
        umat,
        len(runs),
    )


def check_text(text: str) -> None:
    """Raise ValueError with all errors of a text in the form of a case file, without file and line."""
    calls.content(text.encode())


def read_run(path: Path, value: str | None = None, with_path: bool = False) -> Run:
    """Return the run of a case for a value of its sweep, if PROPS change with it.

    with_path: a value is also needed where the sweep changes the load path alone.
    Raises ValueError with the messages of the driver, and for a value that is missing or not in the sweep.
    """
    case = read_case(path)
    run = case.runs[0]
    if all(candidate.props == run.props for candidate in case.runs) and not (with_path and case.sweep):
        if value is None:
            return run
        what = "with a &sweep" if with_path else "where a constant is the name of a sweep"
        raise ValueError(f"{path}: --value {value}: expected {what} only")
    expected = f"{case.sweep}, as {', '.join(f'{candidate.value:g}' for candidate in case.runs)}"
    if value is None:
        raise ValueError(f"{path}: --value is missing: expected one for {expected}")
    for candidate in case.runs:
        if contract.number("--value", value) == candidate.value:
            return candidate
    raise ValueError(f"{path}: --value {value}: expected one of {expected}")


def drive(case: Path) -> dict[float | None, History]:
    """Rows of a case by the value of the sweep, None without one, as those of the driver.

    Where equilibrium is lost, the last row is the one beyond which there is none. Raises ValueError for a
    loss that `&expect` does not state, and if there is none that it states.
    """
    histories = {}
    for run in read_case(case).runs:
        history, lost = rows_of(run.interface.props(), run.steps, run.state, run.tolerance, keep_lost=True)
        if bool(lost) != run.loses:
            raise ValueError(f"{case}: {lost or 'the run ended where a loss of equilibrium was expected'}")
        histories[run.value] = history
    return histories


def _values(props: Sequence[float], *owners: str) -> dict[str, Any]:
    """Entries of PROPS of these owners by name; those that must be whole numbers are integers."""
    rows = ((row, props[row.index - 1]) for row in contract.owned(*owners))
    return {row.name: int(value) if row.integral else value for row, value in rows}


def _run(content: dict[str, Any]) -> Run | None:
    """A run of a case by names; None if its law is a UMAT."""
    props = tuple(map(float, content["props"]))
    if not props:
        return None
    material = Material(**_values(props, "law"))
    listed = np.reshape(props[contract.N_FIXED_PROPS :], (-1, contract.N_LISTED_VALUES)).tolist()
    pattern = Pattern(**_values(props, "pattern"), listed=tuple(map(tuple, listed)))
    start, point = content["start"], None
    if start != "virgin":
        N, Tx, Ty = map(float, content["s"])
        traction = tuple(content["traction"]) if "traction" in content else None
        point = Point(np.array(content["statev"]), (N, Tx, Ty), content.get("work"), content["p"], traction)
    steps = tuple(map(step_of, content["steps"]))
    value, tolerance = content.get("value"), content.get("tolerance")
    aperture = content["a_0"], content["a_min"]
    return Run(value, props, material, pattern, start, steps, point, tolerance, content["lost"], *aperture)


def slip_tests(case: Case) -> Iterator[SlipTest]:
    """Slip tests of a case, one for each value of its sweep.

    A spring in series along the slip, as that of a shear box, is left out: the joint slips as far as both.
    Raises ValueError unless the case starts from a virgin point and is a slip under a constant normal
    traction or an opening in mode I.
    """
    return (slip_test(case.path, run) for run in case.runs)


def _without_spring(step: Step) -> Step:
    """Slip in place of the tractions t_Tx, t_Ty = k times the slip of a box beside k_Tx = k_Ty = k."""
    if not (step.k_Tx and step.k_Tx == step.k_Ty and step.t_Tx is not None and step.t_Ty is not None):
        return step
    x, y = np.broadcast_arrays(np.atleast_1d(step.t_Tx), np.atleast_1d(step.t_Ty))
    far = int(np.hypot(x, y).argmax())
    e = np.array([x[far], y[far]]) / np.hypot(x[far], y[far])
    slip, direction = (x * e[0] + y * e[1]) / step.k_Tx, float(np.degrees(np.arctan2(e[1], e[0])))
    return replace(step, slip=slip, direction=direction, t_Tx=None, t_Ty=None, k_Tx=None, k_Ty=None)


def slip_test(path: Path, run: Run) -> SlipTest:
    """Slip test of one run; raises ValueError as `slip_tests`."""
    if run.start != "virgin":
        raise ValueError(f"{path}: &{run.start}: expected a case that starts virgin and free of traction")
    preload, sigma_N, direction = 0, 0.0, 0.0
    opened = False
    slips = [np.zeros(1)]
    steps = [_without_spring(step) for step in run.steps]
    for step, traction in zip(steps, prescribed(steps), strict=True):
        numbers = numbers_of(step)
        targets = {name for name in TARGETS if name in numbers}
        loaded = bool(preload) or len(slips) > 1
        if water := max(numbers.get("p", [0.0])):
            wanted = "expected no p, and its value added to t_N, which is what the joint then carries"
            raise ValueError(f"{path}: &step: p = {water:g}, a water pressure: {wanted}")
        targets -= {"p"}
        if step.k_N:
            wanted = "expected a constant normal traction, as in the same case without k_N"
            raise ValueError(f"{path}: &step: k_N = {step.k_N:g}, a constant normal stiffness: {wanted}")
        if any((step.k_Tx, step.k_Ty)) or any(traction[1:]) or step.follow == "branch":
            targets, parts = {"what is neither slip nor opening"}, []
        else:
            parts = [int(n) for n in numbers["increments"]]
        if targets == {"t_N"} and len(parts) == 1 and not (loaded or opened):
            preload, (sigma_N,) = parts[0], numbers["t_N"]
        elif (
            targets in ({"slip"}, {"slip", "t_N"})
            and traction[0]
            and set(numbers.get("t_N", [sigma_N])) == {sigma_N}
            and not opened
            and (len(slips) == 1 or step.direction == direction)
        ):
            (direction,) = numbers["direction"]
            for target, n in zip(numbers["slip"], parts, strict=True):
                slips.append(np.linspace(slips[-1][-1], target, n + 1)[1:])
        elif targets <= {"s_N"} and not loaded:
            opened = True
        else:
            raise ValueError(
                f"{path}: expected &step with t_N, then slip under it in one direction, or with s_N alone"
            )
    return SlipTest(
        run.value, run.material, run.pattern, preload, sigma_N, direction, np.concatenate(slips)[1:]
    )
