"""Walls and arches on FEniCSx: run by `make hosts`, which makes build/fenicsx first."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import exported
import meshio
import numpy as np
import pytest
from on_ranks import RANKS, SEVERAL_RANKS, WITH_FENICSX, done_by

from harness.studies.validation.wall_runs import EXAMPLES, PROGRAM, PYTHON, start

pytestmark = WITH_FENICSX

SMALL = "--elements 2 2 --step 0.1 --most 0.1 --tolerance 1e-10"
"""Fixed steps, as long as none is cut."""

FAILING = """
import sys
from asperity.fenicsx import newton
from asperity.fenicsx.response import LawError

respond, calls = newton.respond, [0]

def failing(*words, **names):
    calls[0] += 1
    if calls[0] in range({first}, {last}):
        raise LawError("point 3: planted")
    return respond(*words, **names)

newton.respond = failing
from harness.hosts.fenicsx import walls
sys.exit(walls.main())
"""
"""The program with a law that returns errors in some of its calls."""

MORTAR = """
&material sigma0 = 0.25, Gc = 0.018, eta = 0.97882791327913, mu = 0.75,
  sigma02 = 0.35, Gc2 = 0.125, tau_v = 0.002 /
&pattern sides = 4, theta = 10.0 /
&step slip = 1.0 /
"""
"""The law of window.py as a case."""


def run(words: str, ranks: int = 1, code: str = "", name: str = "walls", status: int = 0) -> tuple[str, str]:
    """Output and messages of a program, or of a code with its options, that ends with a status.

    Four ranks are of one run alone.
    """
    done = (done_by if ranks <= 2 else start)(words, name, ranks, code)
    assert done.returncode == status, done.stderr
    return done.stdout, done.stderr


def rows_of(out: Path, words: str, ranks: int = 1) -> np.ndarray:
    """Rows of a run of the walls that ends well."""
    run(f"{words} --out {out}", ranks)
    return rows(out)


def rows(file: Path) -> np.ndarray:
    """Rows of a run."""
    return np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)


def test_exported_element(tmp_path: Path) -> None:
    """The script of `asperity export fenicsx` shows the rows of the README."""
    exported.assert_script("fenicsx", tmp_path, PYTHON)


def test_script_of_the_page(tmp_path: Path) -> None:
    """The script of docs/how-to/your-mesh.md prints what the page shows, and writes its file."""
    page = (PROGRAM.parents[3] / "docs/how-to/your-mesh.md").read_text(encoding="utf-8")
    section = page[page.index("## FEniCSx") :]
    code, shown = (re.search(rf"^```{kind}\n(.*?)^```$", section, re.M | re.S)[1] for kind in ("py", "text"))
    done = subprocess.run([PYTHON, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == shown and (tmp_path / "block.pvd").exists()


@SEVERAL_RANKS
@pytest.mark.parametrize(
    ("words", "ranks"), [("--tau 0.05 --to 1", (2, 4)), ("--wall SW100 --drag 1e-6 --to 1", (2,))]
)
def test_ranks(tmp_path: Path, words: str, ranks: tuple[int, ...]) -> None:
    """Any number of ranks gives the forces of one."""
    alone, *by_ranks = (rows_of(tmp_path / f"{n}.csv", f"{SMALL} {words}", n)[:, :3] for n in (1, *ranks))
    for forces in by_ranks:
        assert forces == pytest.approx(alone, abs=1e-8)


@SEVERAL_RANKS
@pytest.mark.parametrize("steps", ["", "--always"])
def test_multigrid(tmp_path: Path, steps: str) -> None:
    """Iterations by Newton's method or passes, on two ranks, give the forces of MUMPS."""
    words = f"{SMALL} --tolerance 1e-6 --tau 0.05 --to 0.1 {steps}"
    mumps = rows_of(tmp_path / "mumps.csv", words)
    iterative = rows_of(tmp_path / "iterative.csv", f"{words} --petsc='-pc_type gamg'", 2)
    assert iterative[:, :3] == pytest.approx(mumps[:, :3], abs=1e-4)


def test_rocking_wall(tmp_path: Path) -> None:
    """A dry wall under a force N rocks: it carries N and at most N L/(2 H0), and most of that."""
    out = tmp_path / "rocking.csv"
    output, _ = run(
        f"--wall WS40 --elements 2 2 --to 5 --step 0.1 --most 0.5 --drag 1e-6 --tolerance 1e-5 --out {out}"
    )
    most = 44.8 * 500.0 / 1325.0
    assert rows(out)[:, 2] == pytest.approx(44.8, rel=1e-3)
    assert 0.75 * most < json.loads(output.splitlines()[-1])["peak"] < 1.01 * most


def test_window(tmp_path: Path) -> None:
    """The joints of a wall with a window open as its nodes move."""
    mesh = tmp_path / "window.msh"
    subprocess.run([PYTHON, EXAMPLES / "window_mesh.py", mesh], check=True, capture_output=True)
    out = tmp_path / "rows.csv"
    law = tmp_path / "mortar.nml"
    law.write_text(MORTAR)
    words = f"{mesh} --law {law} --to 0.6 --out {out} --pvd {tmp_path / 'window.pvd'}"
    run(words, name="window")
    joints = meshio.read(next((tmp_path / "window").glob("joints_*.vtu")))
    moved = joints.point_data["displacement"][joints.cells[0].data]
    apart = (moved[:, [3, 2]] - moved[:, :2]).mean(1)
    separation = np.linalg.norm(joints.cell_data["separation"][0], axis=1)
    assert np.linalg.norm(apart, axis=1) == pytest.approx(separation, abs=1e-12)
    assert joints.cell_data["damage"][0].max() > 0.5


def test_implex_in_kratos(tmp_path: Path) -> None:
    """A dry wall that stops plain Newton passes in Kratos with IMPL-EX, with the implicit forces of passes.

    The errors of the tractions are within half of the tolerance but for steps of the least size.
    """
    pytest.importorskip("KratosMultiphysics.GeoMechanicsApplication", reason="Kratos is not installed")
    wall = "--wall SW30 --size 5 6 --elements 2 2 --to 3"
    fine = f"{wall} --bare --tolerance 1e-5 --step 0.01 --most 0.1"
    implicit = np.vstack([np.zeros(8), rows_of(tmp_path / "implicit.csv", fine)])
    steps = f"{wall} --step 0.1 --most 0.5"
    command = [sys.executable, PROGRAM.parents[1] / "kratos" / "masonry_wall.py", *steps.split()]
    out = tmp_path / "implex.csv"
    words = ["--implex", "0.1", "--out", out]
    done = subprocess.run([*command, *words], check=True, capture_output=True, text=True)
    computed, summary = rows(out), json.loads(done.stdout.splitlines()[-1])
    force = np.interp(computed[:, 0], implicit[:, 0], implicit[:, 1])
    assert np.abs(computed[:, 1] - force).mean() <= 0.01 * force.max()
    assert computed[-1, 1:3] == pytest.approx(implicit[-1, 1:3], rel=0.01)
    work = np.trapezoid(implicit[:, 1], implicit[:, 0])
    assert summary["work"] == pytest.approx(work, rel=0.01)
    moved = np.diff(computed[:, 0], prepend=0.0)
    assert (computed[moved > 1.001e-4, 4] <= 0.05).all() and summary["cuts"] == 0
    plain = subprocess.run(command, check=False, capture_output=True, text=True)
    stopped = json.loads(plain.stdout.splitlines()[-1])
    assert plain.returncode == 3 and stopped["end"] < 3.0
    assert summary["iterations"] < 0.5 * stopped["iterations"]


@pytest.mark.parametrize("words", ["0.12 0.15", "0.2 --mu 0.35 --tan-psi 0.1", "0.15 --dim 3 --size 90"])
def test_arch(tmp_path: Path, words: str) -> None:
    """An arch falls at the acceleration of limit analysis, within 1 %: a part of the joints' compliance."""
    output, _ = run(f"{words} --folder {tmp_path}", name="arch")
    for acceleration, limit in re.findall(r"([\d.]+) g, limit analysis ([\d.]+) g", output):
        assert float(acceleration) == pytest.approx(float(limit), rel=0.01)


@pytest.mark.parametrize("ranks", RANKS)
def test_benchmarks(ranks: int) -> None:
    """Two arms that separate, a joint across a period, a block on a slope, loads that slide a block or dam.

    A sliding load is found within the last step of its path, 2e-5 of the weight.
    """
    output, _ = run("", ranks, name="benchmarks")
    errors = {"peel": 0.01, "period": 1e-5, "slope": 0.0, "block": 4e-5, "dam": 4e-5, "uplift": 4e-5}
    for name, computed, expected in (line.split() for line in output.splitlines()):
        assert float(computed) == pytest.approx(float(expected), rel=errors.pop(name)), name
    assert not errors


def test_crack_converges_to_the_closed_form() -> None:
    """Errors are those of the page; with a finite height the tractions balance opening and slip."""
    output, _ = run("--elements 16 32 64", name="crack")
    by_kind: dict[str, list[list[float]]] = {}
    for kind, *numbers in (line.split() for line in output.splitlines()[1:]):
        by_kind.setdefault(kind, []).append([float(x) for x in numbers])
    page = (PROGRAM.parents[3] / "docs/validation/benchmarks.md").read_text(encoding="utf-8")
    normal = {"friction": -11.698, "pressure": -10.0, "dilation": -15.127, "height": -13.7}
    for kind, rows in by_kind.items():
        _, error, order, _, _, traction = rows[-1]
        assert error < 0.005 and order > 1.6 and rows[-2][2] > 1.6, kind
        assert traction == pytest.approx(normal[kind], rel=0.005, abs=1e-9)
        cells = " | ".join(f"{100 * row[1]:.2f}" for row in rows)
        assert f"| {kind} | {cells} |" in page
    slip, opening = ([by_kind[kind][-1][k] for kind in ("dilation", "height", "friction")] for k in (3, 4))
    assert slip == sorted(slip) and slip[2] == pytest.approx(3.80785, rel=0.005)  # Phan 2003
    assert opening == sorted(opening, reverse=True)


@SEVERAL_RANKS
def test_crack_on_two_ranks() -> None:
    """They have the results of one, which a tip that both have does not change."""
    alone, together = (run("--elements 16", ranks, name="crack")[0].split() for ranks in (1, 2))
    assert [*map(is_number, alone)] == [*map(is_number, together)]
    pairs = [pair for pair in zip(alone, together, strict=True) if is_number(pair[0])]
    assert len(pairs) > 15
    for serial, parallel in pairs:
        assert float(parallel) == pytest.approx(float(serial), rel=1e-4, abs=1e-9, nan_ok=True)


def is_number(word: str) -> bool:
    """Whether a word is a number."""
    try:
        return bool(float(word)) or True
    except ValueError:
        return False


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--elements 4", "--elements [4]: expected 2 or 3 numbers"),
        ("--step 0.1 --most 0.05", "--step 0.1: expected between 1e-05 and --most"),
        ("--to nan", "--to [nan]: expected finite"),
        ("--theta 95", "theta"),
        ("--joint mu=0.5", "mu: expected kn, ks"),
        ("--wall WS40 --tau 0.1", "tau = 0.1: expected 0 for dry joints"),
        ("--wall WS40 --elements 3 3", "expected nodes of the beam at the level 1325 mm"),
        (f"--out {__file__}", "expected a new file, or --resume"),
    ],
)
def test_bad_options(words: str, expected: str) -> None:
    """A value out of range is named with what was expected, and nothing is computed."""
    output, messages = run(words, status=2)
    assert output == "" and expected in messages


@pytest.mark.parametrize(("last", "status"), [(21, 0), (10**9, 3)])
def test_law_that_fails(tmp_path: Path, last: int, status: int) -> None:
    """Once: the step is cut.  Always: the run ends with the message of the law and the rows before."""
    code = FAILING.format(first=20, last=last)
    words = f"--elements 2 2 --to 0.2 --out {tmp_path / 'rows.csv'}"
    output, messages = run(words, code=code, status=status)
    end = rows(tmp_path / "rows.csv")[-1, 0]
    assert end == pytest.approx(json.loads(output.splitlines()[-1])["end"], rel=1e-11)  # 12 digits
    assert end == 0.2 if status == 0 else 0.0 < end < 0.2 and "the law: point 3: planted" in messages


@SEVERAL_RANKS
def test_a_run_goes_on(tmp_path: Path) -> None:
    """From the files of a run that ended earlier, on two ranks."""
    whole, part = tmp_path / "whole.csv", tmp_path / "part.csv"
    words = f"{SMALL} --tau 0.05"
    rows_of(part, f"{words} --to 0.5", 2)
    resumed = rows_of(part, f"{words} --to 0.5 1 --resume", 2)
    assert resumed == pytest.approx(rows_of(whole, f"{words} --to 0.5 1", 2), abs=1e-8)
    _, messages = run(f"{words} --out {part} --elements 2 1 --resume", 2, status=2)
    assert "expected the files of a run" in messages


@SEVERAL_RANKS
def test_a_file_of_another_version(tmp_path: Path) -> None:
    """A file of one rank that is cut off, or lacks a number that a run needs, is refused by both ranks."""
    out = tmp_path / "rows.csv"
    words = f"{SMALL} --to 0.1"
    before = rows_of(out, words, 2)
    file = out.with_suffix(".1.npz")
    whole = file.read_bytes()
    with np.load(file) as data:
        saved = dict(data)
    broken = [b"", whole[:40], whole[: len(whole) // 2]]
    for name in ("ranks", "state.u", "before.joints0", "step", "rules"):
        np.savez(tmp_path / "less.npz", **{key: array for key, array in saved.items() if key != name})
        broken.append((tmp_path / "less.npz").read_bytes())
    np.savez(tmp_path / "less.npz", **saved | {"rules": saved["rules"][:-1]})
    for content in [*broken, (tmp_path / "less.npz").read_bytes()]:
        file.write_bytes(content)
        _, messages = run(f"{words} --out {out} --resume", 2, status=2)
        assert "expected the files of a run with the same mesh, laws and ranks" in messages
    assert rows(out) == pytest.approx(before)  # nothing is lost
