"""Checks of `asperity check-umat` and `rie_driver --check`: planted faults, no law, the own UMAT."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from support_driver import call
from support_umat import MIXED, outcomes, planted

pytestmark = [
    pytest.mark.slow,
    pytest.mark.waits,
    pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran"),
]

HIDDEN = {"repeated", "cut", "alternating", "threads", "restart"}
"""Checks that hidden state fails."""


NO_LAW = """
void umat_({type} *stress, {type} *statev, {type} *ddsdde, double *a, double *b, double *c, double *d,
           double *e, double *f, double *g, {type} *stran, {type} *dstran) {{ {body} }}
"""
"""UMAT without a law; the type is that of its real numbers."""

ELASTIC = "for (int i = 0; i < 9; i++) ddsdde[i] = i % 4 ? 0 : {0}; for (int i = 0; i < 3; i++) "
ELASTIC += "stress[i] = {1} * (stran[i] + dstran[i]);"
DIAGONAL = ELASTIC.replace("i++", "i += 4", 1)


@pytest.mark.parametrize(
    ("real", "body", "code", "said", "failed"),
    [
        ("double", "", 1, "at the start of the path it does not write DDSDDE", {"path", "stiffness"}),
        ("float", ELASTIC.format(100, 100), 1, "in double precision", {"path", "stiffness"}),
        ("double", ELASTIC.format(-100, -100), 1, "= -100 of its DDSDDE: expected", {"path", "stiffness"}),
        ("double", ELASTIC.format(5, 5), 0, "", {"stiffness"}),
        ("double", ELASTIC.format(100, 0), 0, "", {"stiffness", "tangent"}),
        ("double", ELASTIC.format(100, -100), 0, "", {"stiffness", "tangent"}),
        ("double", DIAGONAL.format(100, 100), 0, "", {"written"}),
        ("double", "double old = ddsdde[0]; " + ELASTIC.format("100 + old", 100), 0, "", {"written"}),
        ("double", ELASTIC.format(100, 100).replace("stran[i] + ", ""), 0, "", {"unmoved"}),
        ("double", ELASTIC.format(100, "1 + 100"), 0, "", {"stiffness"}),
        ("double", ELASTIC.format(100, "i < 2 ? 0 : 100"), 0, "", {"stiffness", "tangent"}),
        ("double", ELASTIC.format(100, 100), 0, "", set()),
    ],
    ids="empty single negative soft zero signs diagonal reads increments prestress one elastic".split(),
)
def test_no_law(run, driver, tmp_path: Path, real: str, body: str, code: int, said: str, failed) -> None:
    """A routine that is no law, or not the declared one, ends without rows or fails its check."""
    source, path = tmp_path / "no_law.c", tmp_path / "no_law.so"
    source.write_text(NO_LAW.format(type=real, body=body), encoding="utf-8")
    subprocess.run(["gcc", "-shared", "-fPIC", source, "-o", path], check=True)
    case = "&umat library = 'no_law.so', length = 0.01, stiffness = 100, ntens = 3, energies = .false. /\n"
    rows = run(case + "&step s_N = 0.01, 0, increments = 4 /\n&step slip = 0.02, -0.02 /\n", code=code)
    assert said in rows.messages and bool(rows.rows) == (code == 0)
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    assert {name for name, outcome in outcomes(done.stdout).items() if outcome == "FAILED"} == failed
    assert done.returncode == bool(failed)


@pytest.mark.parametrize(
    "case",
    ["figure05b", "figure12", "bed_joint", "rough_joint", "stability/snap", "stability/snap_branch"],
)
def test_own_umat_passes(driver: Path, case: str) -> None:
    """The UMAT of this project passes every check, along cases of the paper and from an initial state."""
    path = Path(__file__).parents[2] / "harness/cases" / f"{case}.nml"
    done = call(driver, path, "--check", "--only", "1", folder=path.parent)
    table = outcomes(done.stdout)
    assert done.returncode == 0 and len(table) == 16
    assert {name for name, outcome in table.items() if outcome != "passed"} == {"symmetry"}


@pytest.mark.parametrize(
    ("fault", "failed"),
    [
        (0, set()),
        (1, {"tangent"}),
        (2, {"cut", "alternating", "threads"}),
        (3, {"dissipation"}),
        (4, {"path", "stiffness"}),
        (5, {"path"}),
        (7, set()),
        (10, {"arguments", "absent"}),
        (11, {"absent"}),
        (13, {"components"}),
    ],
    ids=["none", "symmetrised", "saved", "heals", "overruns", "XIT", "cuts", "writes", "reads", "NTENS"],
)
def test_planted_faults(driver: Path, library: Path, tmp_path: Path, fault: int, failed: set[str]) -> None:
    """A fault fails in its row; hidden state leaves the later rows not judged."""
    (tmp_path / "case.nml").write_text(planted(library, fault, 2) + MIXED, encoding="utf-8")
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    table = outcomes(done.stdout)
    assert {name for name, outcome in table.items() if outcome == "FAILED"} == failed
    assert done.returncode == (1 if failed else 0)
    if failed & HIDDEN:
        assert table["tangent"] == table["energies"] == "not judged"
    if fault == 1:
        assert "DDSDDE is symmetric" in done.stdout
    if fault == 11:
        assert "it uses COORDS" in done.stdout


@pytest.mark.parametrize(("fault", "failed"), [(14, {"path"}), (19, {"restart"}), (20, {"restart"})])
def test_requests_and_initial_states(driver, library: Path, tmp_path: Path, fault: int, failed: set) -> None:
    """Endless requests end a path; a state that is set to 0 in a new process, or in each step, is lost."""
    (tmp_path / "case.nml").write_text(planted(library, fault) + MIXED, encoding="utf-8")
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    assert {name for name, outcome in outcomes(done.stdout).items() if outcome == "FAILED"} == failed
    assert done.returncode == 1


def test_what_a_umat_does_not_declare(driver: Path, attacker, tmp_path: Path) -> None:
    """Components and energies that a UMAT does not have are no failures; without a word they are."""
    case = attacker("")
    for more, expected in (("", "FAILED"), (", ntens = 3, energies = .false.", "not declared")):
        (tmp_path / "case.nml").write_text(case.replace(" /", more + " /", 1), encoding="utf-8")
        done = call(driver, "case.nml", "--check", folder=tmp_path)
        table = outcomes(done.stdout)
        assert table["components"] == table["energies"] == expected
        assert done.returncode == (expected == "FAILED")


@pytest.mark.parametrize(
    ("attack", "said"),
    [("abort();", "Aborted"), ("for (;;);", "limit of 0.5 s"), ("exit(0);", "exit code 0")],
)
def test_the_table_is_whole(driver: Path, attacker, tmp_path: Path, attack: str, said: str) -> None:
    """A UMAT that fails in a check leaves the table whole."""
    case = attacker(f"if (statev[0]++ > 0) {{ {attack} }}")
    (tmp_path / "case.nml").write_text(case, encoding="utf-8")
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    assert done.returncode == 1 and len(outcomes(done.stdout)) == 16
    assert outcomes(done.stdout)["path"] == "FAILED" and said in done.stdout
