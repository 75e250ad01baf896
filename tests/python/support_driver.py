"""Constants, results and closed forms that the tests of the driver share; conftest.py has their fixtures."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "harness" / "cases"
COLUMNS = (
    "step increment time s_N s_Tx s_Ty t_N t_Tx t_Ty p aperture "
    "damage stored rupture friction work iterations event"
).split()

# The parameters of Table 2 of the paper, and the quantities that follow from them by (12).
SIGMA0, GC, ETA, MU = 3.0, 0.3, 0.9, 0.5
S_F = 2 * GC / SIGMA0
S_0 = (1 - ETA) * S_F
K = SIGMA0 / S_0

MATERIAL = f"&material sigma0 = {SIGMA0}, Gc = {GC}, eta = {ETA}, mu = {MU} /\n"
FLAT = "&pattern sides = 0 /\n"
RP_4 = "&pattern sides = 4, theta = 30.0 /\n"

# The solver accepts a residual of 1e-13 (K |s| + |sigma|), here at most 1e-13 (150*0.6 + 20) MPa.
# The tolerance is ten times that.
TRACTION_TOLERANCE = 1.1e-10

# Sub-increments of the load path to an initial traction, as in docs/solver.md.
PARTS = 32


class Result:
    """Results of a run of the driver: exit code, messages and rows."""

    def __init__(self, process: subprocess.CompletedProcess[str], output: Path):
        """Read the CSV if the run has written one."""
        self.code, self.messages, self.stdout = process.returncode, process.stderr, process.stdout
        self.header, self.rows = read_csv(output.read_text()) if output.exists() else ([], [])

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a column as numbers."""
        return np.array([float(row[self.header.index(name)]) for row in self.rows])

    @property
    def events(self) -> list[set[str]]:
        """The events of each row."""
        column = self.header.index("event")
        return [set(row[column].split("+")) - {""} for row in self.rows]

    def vector(self, prefix: str) -> np.ndarray:
        """Return the components N, Tx, Ty of the separation (prefix `s`) or traction (`t`), shape (T, 3)."""
        return np.stack([self[f"{prefix}_{c}"] for c in ("N", "Tx", "Ty")], axis=1)


def read_csv(text: str) -> tuple[list[str], list[list[str]]]:
    """Return header and rows of a CSV; every row must be complete."""
    assert text.endswith("\n")
    lines = [line.split(",") for line in text.splitlines()]
    assert {len(line) for line in lines} == {len(lines[0])}
    return lines[0], lines[1:]


def call(driver: Path, *arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the driver in a folder."""
    return subprocess.run([driver, *arguments], cwd=folder, capture_output=True, text=True, timeout=120)


def assert_traction(actual: np.ndarray, expected: np.ndarray | float) -> None:
    """Assert that tractions are equal within the residual that the solver accepts."""
    np.testing.assert_allclose(actual, expected, rtol=0, atol=TRACTION_TOLERANCE)
