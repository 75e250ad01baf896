"""Load path of a case for many sets of constants: curves over the prescribed slip or opening."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from .. import _core, contract
from ..case_files import Case, Run, SlipTest, read_case, slip_test
from ..contract import Floats
from ..interface import work_along
from ..pattern import direction_vector
from ..results import NO_EQUILIBRIUM, driven, read_rows
from ..slip_curves import ROW

CURVES = ("traction", "dilation", "damage")
"""Curves of a sample: traction along the slip (without slip along N), s_N and damage."""

COMPONENTS, TRACTIONS, SPRINGS = (tuple(f"{x}_{axis}" for axis in ("N", "Tx", "Ty")) for x in "stk")
"""Names of case files."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Curves of one sample, (n, 3) in the order of CURVES, and work (n,); n is smaller where it was lost."""

    values: Floats
    work: Floats


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Load path of one run of a case, as PROPS -> curves over the abscissa x (n,), which is prescribed.

    value: of the sweep, None without one.  props: of the case.  slips: whether x is a slip (or an opening).
    """

    value: float | None
    props: Floats
    x: Floats
    slips: bool

    def curve(self, props: Floats) -> Curve:
        """Curves of a joint with these constants."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class SlipPath(LoadPath):
    """Slip under a constant normal traction."""

    test: SlipTest = field(kw_only=True)

    def curve(self, props: Floats) -> Curve:
        """Curves by the solver of slip tests."""
        test = self.test
        rows = np.empty((1, self.x.size, ROW))
        one = (np.array([value]) for value in (test.direction, test.sigma_N, 0.0))
        done, _ = _core.interface_slip_curves(props, *one, self.x, test.preload, rows.T)
        n = max(int(np.atleast_1d(done)[0]), 0)
        s_N, _, t_x, t_y, damage, work = rows[0, :n].T
        e_x, e_y = direction_vector(test.direction)
        return Curve(np.column_stack([t_x * e_x + t_y * e_y, s_N, damage]), work)


@dataclass(frozen=True, eq=False)
class PrescribedPath(LoadPath):
    """Prescribed separations (n, 3): the law alone; e (3,): direction of the traction that is shown."""

    separations: Floats = field(kw_only=True)
    e: Floats = field(kw_only=True)

    def curve(self, props: Floats) -> Curve:
        """Curves by the update of a point."""
        n = len(self.separations)
        wears = props[contract.index("W0")] > 0.0
        traction = np.empty((n, 3))
        state = np.empty((n, contract.n_statev(contract.check(props), wears)))
        _core.interface_replay(props, self.separations.T, np.zeros(n), traction.T, state.T)
        damage = state[:, contract.statev_index("damage")]
        values = np.column_stack([traction @ self.e, self.separations[:, 0], damage])
        return Curve(values, work_along(self.separations, traction))


@dataclass(frozen=True, eq=False)
class DrivenPath(LoadPath):
    """Any other case, by the driver.  steps: its &step groups; first: first row of the curves; e as above."""

    steps: str = field(kw_only=True)
    first: int = field(kw_only=True)
    e: Floats = field(kw_only=True)

    def curve(self, props: Floats) -> Curve:
        """Curves by a run of the driver."""
        with TemporaryDirectory() as folder:
            case = Path(folder, "case.nml")
            case.write_text(_constants(props) + self.steps, encoding="utf-8")
            with driven(case) as (run, output):
                if run.returncode not in (0, NO_EQUILIBRIUM):
                    raise ValueError(run.stderr.strip())
                rows = read_rows(output)
        part = slice(self.first, len(rows) - (run.returncode == NO_EQUILIBRIUM))
        values = [rows.traction @ self.e, rows.separation[:, 0], rows.damage]
        return Curve(np.column_stack(values)[part], rows.energies[part, 3])


def load_paths(case: Case) -> list[LoadPath]:
    """Load paths of the runs of a case; raises ValueError for a case without a prescribed slip or opening."""
    return [_load_path(case.path, run) for run in case.runs]


def _load_path(path: Path, run: Run) -> LoadPath:
    if run.start != "virgin" or not run.steps:
        what = f"&{run.start}" if run.steps else "&replay"
        raise ValueError(f"{path}: {what}: expected &step from a virgin state")
    if any(step["tolerance"] for step in run.steps):
        raise ValueError(f"{path}: tolerance: expected fixed increments, which all samples share")
    e = _abscissa(path, run)
    separations = _targets(run)
    common = run.value, np.array(run.props)
    slips = bool(e[0] == 0.0)
    if run.material.tau_v == 0.0:
        if not any(any(step["traction"]) for step in run.steps):
            separations = np.vstack([np.zeros(3), separations])
            return PrescribedPath(*common, separations @ e, slips, separations=separations, e=e)
        test = _slip_test(path, run)
        if test is not None:
            return SlipPath(*common, np.concatenate([[0.0], test.slips]), True, test=test)
    # the row before x moves is the start of the curve
    moving = np.diff(separations @ e, prepend=0.0) != 0.0
    first = max(int(np.argmax(moving)) - 1, 0)
    steps = _steps(run)
    _check_steps(run, steps)
    return DrivenPath(*common, separations[first:] @ e, slips, steps=steps, first=first, e=e)


def _slip_test(path: Path, run: Run) -> SlipTest | None:
    """Slip test that a run is, or None."""
    try:
        test = slip_test(path, run)
    except ValueError:
        return None
    return test if test.slips.size and test.preload else None


def _abscissa(path: Path, run: Run) -> Floats:
    """Unit vector (3,) of the prescribed separation over which curves are drawn: of a slip, or of s_N."""
    for names in (("slip", "s_Tx", "s_Ty"), ("s_N",)):
        moved = [(step, name) for step in run.steps for name in names if name in step]
        if not moved:
            continue
        step, name = moved[0]
        e = np.zeros(3)
        if name == "slip":
            e[1:] = direction_vector(step["direction"])
        else:
            e[COMPONENTS.index(name)] = 1.0
        if not any(step["traction"][i] for step in run.steps for i in np.flatnonzero(e)):
            return e
    raise ValueError(f"{path}: expected &step with a prescribed slip or opening, over which curves are drawn")


def _targets(run: Run) -> Floats:
    """Separations (n, 3) at the ends of all increments; 0 for components under a prescribed traction."""
    place, parts = np.zeros(3), []
    for step in run.steps:
        for i, count in enumerate(step["increments"]):
            end = place.copy()
            for k, name in enumerate(COMPONENTS):
                if name in step:
                    end[k] = step[name][i]
            if "slip" in step:
                end[1:] = step["slip"][i] * direction_vector(step["direction"])
            shares = np.arange(1, int(count) + 1)[:, None] / int(count)
            parts.append(place + shares * (end - place))
            parts[-1][-1] = end
            place = end
    return np.vstack(parts)


def _steps(run: Run) -> str:
    """Groups &step of a run."""
    lines, spring = [], [0.0, 0.0, 0.0]
    for step in run.steps:
        names = ("slip", *COMPONENTS, *TRACTIONS, "increments")
        entries = [f"{name} = {_list(step[name])}" for name in names if name in step]
        if "slip" in step:
            entries.append(f"direction = {step['direction']!r}")
        entries += [
            f"{name} = {new!r}"
            for name, old, new in zip(SPRINGS, spring, step["spring"], strict=True)
            if new != old
        ]
        entries.append(f"time = {step['time']!r}")
        spring = step["spring"]
        lines.append(f"&step {', '.join(entries)} /\n")
    return "".join(lines)


def _constants(props: Floats) -> str:
    """Groups &material and &pattern of PROPS; flags are whole numbers."""
    values = {row.name: float(props[row.index - 1]) for row in contract.owned("law")}
    material = ", ".join(
        f"{row.name} = {int(values[row.name]) if row.integral else values[row.name]!r}"
        for row in contract.owned("law")
    )
    listed = props[contract.N_FIXED_PROPS :].reshape(-1, contract.N_LISTED_VALUES)
    if len(listed):
        pattern = f"normals = {_list(listed[:, :3].ravel())}, weights = {_list(listed[:, 3])}"
    else:
        places = {name: float(props[contract.index(name)]) for name in ("m", "theta", "flat", "turn")}
        pattern = f"sides = {int(places.pop('m'))}"
        if places["theta"] or "sides = 0" not in pattern:
            pattern += "".join(f", {name} = {value!r}" for name, value in places.items())
    return f"&material {material} /\n&pattern {pattern} /\n"


def _list(values: Sequence[float] | Floats) -> str:
    return ", ".join(repr(float(value)) for value in values)


def _check_steps(run: Run, steps: str) -> None:
    """Raise ValueError unless the driver reads the same run from the text that samples are made of."""
    with TemporaryDirectory() as folder:
        case = Path(folder, "case.nml")
        case.write_text(_constants(np.array(run.props)) + steps, encoding="utf-8")
        again = read_case(case).runs[0]
    if again.steps != run.steps or again.props[: contract.index("h")] != run.props[: contract.index("h")]:
        raise ValueError("the load path cannot be written as &step groups: expected a simpler one")
