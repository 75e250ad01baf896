"""Walls on PETSc with the law in their joints: run by `make hosts`, which makes build/petsc first."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from harness.studies.validation.wall_runs import PROGRAM, PYTHON, environment

pytestmark = pytest.mark.skipif(
    not PYTHON.exists(), reason="build/petsc is not there: harness/hosts/petsc/install.sh"
)

SMALL = "--elements 2 2 --step 0.1 --most 0.1 --tolerance 1e-10"
"""Fixed steps, as long as none is cut."""

VISCOUS = "--tau 0.05"
"""Damage is so viscous that no step is cut where bricks snap."""

FAILING = """
import sys
from asperity.interface import Interface

update, calls = Interface.update, [0]

def failing(*words):
    calls[0] += 1
    if calls[0] in range({first}, {last}):
        raise ValueError("point 3: planted")
    return update(*words)

Interface.update = failing
sys.path.insert(0, {folder!r})
import shear_wall
sys.exit(shear_wall.main())
"""
"""The program with a law that returns errors in some of its calls."""


def start(words: str, ranks: int = 1, code: str = "") -> subprocess.Popen[str]:
    """Start the program, or a code with its options."""
    mpirun = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)]
    command = [
        *(mpirun if ranks > 1 else []),
        PYTHON,
        *(["-c", code] if code else [PROGRAM]),
        *shlex.split(words),
    ]
    env = environment() | {"OMPI_MCA_mpi_yield_when_idle": "1"}
    return subprocess.Popen(command, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def run(words: str, ranks: int = 1, code: str = "") -> tuple[int, str, str]:
    """Exit status, output and messages."""
    process = start(words, ranks, code)
    output, messages = process.communicate()
    return process.returncode, output, messages


def rows(file: Path) -> np.ndarray:
    """Rows of a run."""
    return np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)


@pytest.mark.parametrize(
    ("words", "solver"),
    [
        (f"{VISCOUS} --to 3", ""),
        (f"{VISCOUS} --to 1", "--solver bricks --petsc='-ksp_rtol 1e-10'"),
        ("--wall SW100 --drag 1e-6 --to 1", ""),
        ("--explicit 2e-3 --to 0.3", ""),
    ],
)
def test_ranks(tmp_path: Path, words: str, solver: str) -> None:
    """Two ranks give the forces of one with the direct solver, cut along the length or the height."""
    found = []
    for grid, more in (("1 1", ""), ("2 1", solver), ("1 2", solver)):
        ranks, out = (1 if grid == "1 1" else 2), tmp_path / f"{grid.replace(' ', '')}.csv"
        code, output, messages = run(f"{SMALL} {words} --ranks {grid} --out {out} {more}", ranks)
        assert code == 0, messages
        assert json.loads(output.splitlines()[-1])["cuts"] == 0
        found.append(rows(out))
    for one in found[1:]:
        assert len(one) == len(found[0])
        assert np.abs(one[:, :3] - found[0][:, :3]).max() <= 1e-8


def test_wall_in_kratos(tmp_path: Path) -> None:
    """Kratos gives the forces of the same mesh up to the first snap and back."""
    pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="no asperity[kratos]")
    steps, found = (
        "--elements 2 1 --tau 0.002 --most 0.1 --to 2 1.5",
        [tmp_path / "1.csv", tmp_path / "2.csv"],
    )
    command = [sys.executable, PROGRAM.parents[1] / "kratos" / "brick_wall.py", *steps.split()]
    subprocess.run([*command, "--out", found[0]], check=True)
    code, _, messages = run(f"{steps} --step 0.1 --tolerance 1e-8 --out {found[1]}")
    assert code == 0, messages
    kratos, petsc = map(rows, found)
    assert petsc[-1, 1] < 0.7 * petsc[:, 1].max()
    assert np.abs(kratos - petsc[:, :3]).max() <= 1e-3 * petsc[:, 1].max()


def test_explicit_dynamics(tmp_path: Path) -> None:
    """Explicit dynamics passes the snap of a wall; the force before is that of Newton's method.

    Inertia carries a part of the force; 5 % of the peak are left for it.
    """
    found = [tmp_path / "1.csv", tmp_path / "2.csv"]
    words = "--elements 2 1 --tau 0.002 --most 0.1"
    code, output, messages = run(f"{words} --explicit 7.5e-4 --to 2.7 --out {found[0]}")
    assert code == 0, messages
    assert 0.0 < json.loads(output.splitlines()[-1])["kinetic"] < 0.1
    assert run(f"{words} --step 0.1 --to 1.5 --out {found[1]}")[0] == 0
    explicit, newton = map(rows, found)
    middle = np.convolve(np.r_[0.0, explicit[:, 0]], [0.5, 0.5], "valid")  # rows are means
    early = (middle > newton[0, 0]) & (middle < 1.5)
    expected = np.interp(middle[early], newton[:, 0], newton[:, 1])
    assert np.abs(explicit[early, 1] - expected).max() <= 0.05 * explicit[:, 1].max()
    assert explicit[-1, 1] < 0.7 * explicit[:, 1].max()


def test_rocking_wall(tmp_path: Path) -> None:
    """A dry wall under a force N rocks: it carries N and at most N L/(2 H0), and most of that."""
    out = tmp_path / "rocking.csv"
    words = "--wall WS40 --elements 2 2 --to 5 --step 0.1 --most 0.5 --drag 1e-6 --tolerance 1e-5"
    code, output, messages = run(f"{words} --out {out} --pvd {tmp_path / 'rocking.pvd'}")
    assert code == 0, messages
    most = 44.8 * 500.0 / 1325.0
    assert rows(out)[:, 2] == pytest.approx(44.8, rel=1e-3)
    assert 0.75 * most < json.loads(output.splitlines()[-1])["peak"] < 1.01 * most
    assert (tmp_path / "rocking.pvd").exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--wall J9D", "--wall J9D: expected one of J4D"),
        ("--elements 4", "--elements [4]: expected 2 or 3 numbers"),
        ("--step 0.1 --most 0.05", "--most 0.05: expected at least --step"),
        ("--to nan", "--to [nan]: expected finite"),
        ("--theta 95", "theta"),
        ("--joint tan_phi=-1", "tan_phi = -1.0: expected"),
        ("--joint mu=0.5", "mu: expected kn, ks"),
        ("--wall WS40 --theta 10 --tau 0.1", "expected 0 and 1 for dry joints"),
        ("--wall WS40 --elements 3 3", "expected nodes of the beam at the level 1325 mm"),
        ("--ranks 2 1", "--ranks [2, 1]: expected a product of 1"),
        ("--out nowhere/rows.csv", "expected a folder that exists"),
        ("--arc 0.01 --tau 0.1", "--arc 0.01: expected without --tau"),
        ("--explicit 0.1", "--explicit 0.1: expected between 0 and --most"),
        ("--explicit 1e-3 --drag 1", "--explicit 0.001: expected without --arc and --drag"),
        ("--arc 0.01 --to -1", "--arc 0.01: expected --to above 0"),
        (f"--out {__file__}", "expected a new file, or --resume"),
        ("--thet 3", "unrecognized arguments"),
    ],
)
def test_bad_options(words: str, expected: str) -> None:
    """A value out of range is named with what was expected, and nothing is computed."""
    code, output, messages = run(words)
    assert (code, output) == (2, "")
    assert expected in messages


def test_more_ranks_than_half_bricks() -> None:
    """Each rank needs a column of half-bricks."""
    code, _, messages = run("", ranks=10)
    assert code != 0
    assert "--ranks [10, 1]: expected at most 9 along the length" in messages


def test_law_that_fails_once(tmp_path: Path) -> None:
    """The step is cut, and the run goes on to its end."""
    code = FAILING.format(first=60, last=61, folder=str(PROGRAM.parent))
    status, output, messages = run(f"--elements 2 2 --to 0.2 --out {tmp_path / 'rows.csv'}", code=code)
    assert status == 0, messages
    summary = json.loads(output.splitlines()[-1])
    assert summary["cuts"] == 1 and rows(tmp_path / "rows.csv")[-1, 0] == 0.2


def test_law_that_fails_always(tmp_path: Path) -> None:
    """The run ends with the message of the law, the exit status 3 and the rows before."""
    code = FAILING.format(first=60, last=10**9, folder=str(PROGRAM.parent))
    status, output, messages = run(f"--elements 2 2 --to 0.2 --out {tmp_path / 'rows.csv'}", code=code)
    assert status == 3
    assert "the law: point 3: planted" in messages
    assert 0.0 < rows(tmp_path / "rows.csv")[-1, 0] == json.loads(output.splitlines()[-1])["end"] < 0.2


def test_interrupted_run_goes_on(tmp_path: Path) -> None:
    """A run that was killed keeps its rows; with --resume it ends as one that was not."""
    words, out = f"{SMALL} {VISCOUS} --to 3 --out ", tmp_path / "whole.csv"
    assert run(words + str(out))[0] == 0
    part = tmp_path / "part.csv"
    process = start(words + str(part))
    while process.poll() is None and (not part.exists() or len(part.read_text().splitlines()) < 14):
        time.sleep(0.01)
    process.kill()
    process.communicate()
    assert 12 <= len(rows(part)) < 30
    status, _, messages = run(f"{words}{part} --resume")
    assert status == 0, messages
    assert rows(part) == pytest.approx(rows(out), abs=1e-8)
    assert "--resume" in run(f"{words}{tmp_path / 'none.csv'} --resume")[2]
    assert (
        "expected the files of a run with the same ranks and options"
        in run(f"{words}{part} --resume --theta 10")[2]
    )
