"""A UMAT of others along a load path: the driver calls it, so that nothing it does can end this process."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike

from . import contract
from .case_writer import Group, case_text
from .driver_process import run_driver
from .history import ENERGIES, EquilibriumLost, History, csv_columns, finite_column
from .load_path import history_of
from .steps import Point, Step


@dataclass(frozen=True)
class ForeignUmat:
    """UMAT in a shared library, called as Abaqus/Standard calls it (docs/how-to/any-umat.md).

    The fields are the entries of `&umat` (docs/reference/driver.md).  length, stiffness: separation at which
    the strength is reached, length, and elastic stiffness of the bond, stress/length: scales for the solver.
    symbol: name of the routine.  order: components in the order of the UMAT, "-" for another one; 2, 3 or 6
    in all.  thickness: length by which separations are divided.  state: STATEV (nstatv,) at the start; None
    is zero.  damage: number, from 1, of the state variable that is the damage.  limit: longest time for an
    increment, s.  Raises FileNotFoundError if there is no such library.
    """

    library: str | Path
    length: float
    stiffness: float
    props: Sequence[float] = ()
    nstatv: int = 0
    symbol: str = "umat_"
    order: str = "N,Tx,Ty"
    thickness: float = 1.0
    state: Sequence[float] | None = None
    damage: int | None = None
    limit: float = 60.0

    def __post_init__(self) -> None:
        """Check that the library is there."""
        if not Path(self.library).is_file():
            raise FileNotFoundError(f"library = {self.library}: expected the path of a shared library")

    def run(
        self,
        steps: Sequence[Step] | Step,
        state: ArrayLike | Point | None = None,
        tolerance: float | None = None,
    ) -> History:
        """Take one point along a load path, as `Interface.run`; `state` is a `Point`, or None: virgin.

        A state of the rows has the energies, the work, the time, STRESS and STATEV. Damage is zero without
        `damage`. Raises ValueError for wrong input, a tolerance not reached or a fork not taken, and
        EquilibriumLost where no equilibrium is found or the UMAT fails, with the rows before and the reason.
        """
        path = [steps] if isinstance(steps, Step) else steps
        start = state if state is None or isinstance(state, Point) else Point(contract.array("state", state))
        groups: list[Group] = [("case", {"tolerance": tolerance})]
        groups.append(("umat", self._given()))
        if start is not None:
            entries = {
                "separation": start.separation,
                "statev": start.state,
                "work": start.work,
                "p": start.p,
            }
            groups += [("state", entries)]
        groups += [("step", step.given()) for step in path]
        with TemporaryDirectory() as folder:
            case, output, report = (Path(folder, name) for name in ("case.nml", "out.csv", "out.json"))
            case.write_text(case_text(*groups), encoding="utf-8")
            # what the UMAT prints last is in the message
            silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            run_driver(case, "-o", output, "--planes", "--quiet", "--report", report, **silent)
            result = json.loads(report.read_text(encoding="utf-8"))
            message, lost = result["message"], result["lost"]
            if not output.is_file() or (result["code"] == 2 and not lost):
                raise ValueError(message)
            history = _rows(output, lost, message)
        if result["code"] != 0:
            raise EquilibriumLost(message, history)
        return history

    def _given(self) -> dict[str, object]:
        """Entries of &umat."""
        arguments = {part.name: getattr(self, part.name) for part in fields(self)}
        for name in ("props", "state"):
            if arguments[name] is not None:
                contract.array(name, arguments[name], ("n",))
        return arguments | {"library": str(Path(self.library).resolve())}


def _rows(output: Path, lost: bool, message: str) -> History:
    """Rows of the driver with all columns; the message is an event, instead of a lost row."""
    table = csv_columns(output)
    names = [*table]
    n = names.index("event")
    rows = len(table["event"]) - lost
    values = {name: finite_column(output, table, name)[:rows] for name in names if name != "event"}
    numbers = np.column_stack([values[name] for name in names[:n]])
    states = np.column_stack([values[name] for name in ("damage", *ENERGIES[:3], *names[n + 1 :])])
    return history_of(numbers, states, np.array(table["event"][:rows], dtype="S64"), 0, message)
