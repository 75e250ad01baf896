"""Results of the driver: files of a run and their rows."""

from __future__ import annotations

import glob
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .installed import driver

if TYPE_CHECKING:
    from .contract import Floats

NO_EQUILIBRIUM = 2
"""Exit code of the driver after a lost equilibrium."""

ENERGIES = ("stored", "rupture", "friction", "work")
"""Energies per unit area, in the order of the columns."""

COLUMNS = ("s_N", "s_Tx", "s_Ty", "t_N", "t_Tx", "t_Ty", "damage", *ENERGIES, "event")
"""Columns that this module reads."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a result: separation and traction (T, 3), damage (T,), event of each row, ENERGIES (T, 4)."""

    separation: Floats
    traction: Floats
    damage: Floats
    events: list[str]
    energies: Floats

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.damage)


def read_rows(path: Path) -> Rows:
    """Read the CSV of a driver run; raises ValueError if a column of COLUMNS or all rows are missing."""
    import numpy as np

    header, *lines = path.read_text(encoding="utf-8").splitlines() or [""]
    names = header.split(",")
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise ValueError(f"{path}: expected columns {', '.join(missing)}")
    if not lines:
        raise ValueError(f"{path}: expected rows after the header")
    cells = [line.split(",") for line in lines]
    column = {name: [row[names.index(name)] for row in cells] for name in COLUMNS}
    numbers = np.array([column[name] for name in COLUMNS[:-1]], dtype=float).T
    return Rows(numbers[:, 0:3], numbers[:, 3:6], numbers[:, 6], column["event"], numbers[:, 7:])


def drive(case: Path) -> dict[float | None, Rows]:
    """Rows by the value of the sweep, None without one; raises ValueError with the message of the driver."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder, "out.csv")
        command = [driver(), case, "-o", output, "--quiet"]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            raise ValueError(run.stderr.strip())
        return {value: read_rows(path) for value, path in results_of(output).items()}


def results_of(output: Path) -> dict[float | None, Path]:
    """Result files of a run by the value of the sweep, in ascending order; None without a sweep."""
    found: dict[float | None, Path] = {None: output} if output.is_file() else {}
    values = {}
    # as in the driver, only the ending .csv is removed before the value is appended
    stem = output.name.removesuffix(".csv")
    for path in output.parent.glob(f"{glob.escape(stem)}_*.csv"):
        try:
            values[float(path.stem.removeprefix(stem + "_"))] = path
        except ValueError:
            continue
    return found | dict(sorted(values.items()))
