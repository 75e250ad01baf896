"""Tests of the stand-in for pFUnit: its verdicts, the files that it refuses, and the count of tests.

If PFUNIT_DIR is set in the environment, the verdicts are compared with those of pFUnit.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
STAND_IN = ROOT / "tests" / "pfunit_stand_in"
# bodies of tests; x(1) is 1.0d0, v is [1.0d0, 2.0d0], nan and inf what they say
HOLDS = """@assertEqual(1.0d0, x(1.25d0), tolerance=0.25d0)
@assertEqual(2, nint(x(2)))
@assertEqual('a', 'a ')
@assertEqual(v, [1.0d0, x(2)])
@assertLessThan(x(1), x(2))
@assertLessThanOrEqual(x(1), v)
@assertGreaterThan(x(2), x(1))
@assertGreaterThanOrEqual(v, v)
@assertTrue(x(1) > 0)
@assertFalse(x(1) < 0)
@ASSERTISFINITE(x(1))
continue""".splitlines()
FAILS = """@assertEqual(1.0d0, nearest(x(1), 2.0d0))
@assertEqual(1.0d0, x(1.5d0), tolerance=0.25d0)
@assertEqual(v, [1.0d0, nan], tolerance=1.0d0)
@assertEqual('a', 'b')
@assertEqual(v, [1.0d0])
@assertLessThan(x(1), x(1))
@assertLessThan(x(1), nan)
@assertLessThanOrEqual(nearest(1.0d0, 2.0d0), x(1))
@assertGreaterThanOrEqual(v, [1.0d0, x(3)])
@assertTrue(x(1) < 0, message='why')
@assertTrue([.true., x(1) < 0])
@assertFalse(x(1) > 0)
@assertIsFinite(inf)
@assertIsFinite(nan)
call helper()""".splitlines()
# pFUnit does not compile them
MISFITS = """@assertEqual(1.0d0, 1)
@assertEqual(v, 1.0d0)
@assertEqual(1, 1, tolerance=1.0d0)
@assertEqual(1.0d0, 1.0d0, tolerance=nan)
@assertIsFinite(v)""".splitlines()
HEAD = "module sample\nuse funit\nimplicit none\ncontains\n"
HELPERS = """subroutine helper()\n@assertTrue(.false.)\nend subroutine helper
double precision function x(a)\nclass(*), intent(in) :: a\nselect type (a)\ntype is (integer)\nx = a
type is (double precision)\nx = a\nend select\nend function x\n"""
VALUES = f"""double precision :: v(2), nan, inf\nv = [1, 2]
nan = transfer({0x7FF8000000000000}_8, nan)\ninf = transfer({0x7FF0000000000000}_8, inf)\n"""


def run(*command: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command and capture its output."""
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


def suite(*bodies: str) -> str:
    """Return a .pf file with a test of each body: n0, n1, ..."""
    tests = [f"@test\nsubroutine n{i}()\n{VALUES}{b}\nend subroutine n{i}\n" for i, b in enumerate(bodies)]
    return HEAD + "".join(tests) + HELPERS + "end module sample\n"


def translate(folder: Path, text: str) -> subprocess.CompletedProcess[str]:
    """Translate a .pf text into main.F90."""
    (folder / "sample.pf").write_text(text)
    return run(sys.executable, STAND_IN / "pf2f90.py", folder / "sample.pf", "-o", folder / "main.F90")


def build(folder: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    """Compile the stand-in and main.F90."""
    sources = [STAND_IN / "funit.f90", "main.F90"]
    return run("gfortran", *flags, *sources, "-o", "main", cwd=folder)


def test_verdicts(tmp_path: Path) -> None:
    """Each assertion passes or fails, with floating-point traps; the report has its file, line and values."""
    done = translate(tmp_path, text := suite(*HOLDS, *FAILS, *MISFITS))
    assert done.returncode == 0, done.stderr
    done = build(tmp_path, "-fcheck=all", "-ffpe-trap=invalid,zero,overflow")
    assert done.returncode == 0, done.stderr
    done = run(tmp_path / "main")
    verdicts = re.findall(r"^sample n\d+ \.\.\. (\w+)$", done.stdout, re.MULTILINE)
    assert verdicts == ["ok"] * len(HOLDS) + ["FAILED"] * len(FAILS + MISFITS)
    assert done.stdout.splitlines()[-1] == f"{len(HOLDS)} passed, {len(FAILS + MISFITS)} failed"
    assert done.returncode == 1
    line = text[: text.index("'why'")].count("\n") + 1
    assert (
        f"   sample.pf:{line}: @assertTrue\n      actual   0." in done.stdout
        and "message  why\n" in done.stdout
    )


def test_line_of_a_compilers_error(tmp_path: Path) -> None:
    """An unknown name in an operand of an assertion is reported at the line of the assertion."""
    text = suite("@assertEqual(1, unknown, message='why')")
    assert translate(tmp_path, text).returncode == 0
    line = text[: text.index("unknown")].count("\n") + 1
    assert re.search(rf"sample\.pf:{line}:\d+:\n[^:]*unknown", build(tmp_path).stderr)


PROJECT = f"""cmake_minimum_required(VERSION 3.24)\nproject(suites LANGUAGES Fortran)\nenable_testing()
include({ROOT}/cmake/AsperityTesting.cmake)\nasperity_add_suite(sample TEST_SOURCES sample.pf)\n"""


@pytest.mark.skipif("PFUNIT_DIR" not in os.environ, reason="PFUNIT_DIR is not set")
def test_pfunit_gives_the_same_verdicts(tmp_path: Path) -> None:
    """What the stand-in calls failed fails in pFUnit, and the rest passes."""
    (tmp_path / "sample.pf").write_text(suite(*HOLDS, *FAILS))
    (tmp_path / "CMakeLists.txt").write_text(PROJECT)
    run("cmake", "-S", tmp_path, "-B", tmp_path, f"-DPFUNIT_DIR={os.environ['PFUNIT_DIR']}")
    run("cmake", "--build", tmp_path)
    output = run(tmp_path / "sample", "--verbose").stdout
    failed = re.findall(r"Failure in <sample_suite\.n(\d+)>", output)
    assert failed == [str(len(HOLDS) + i) for i in range(len(FAILS))]


REFUSED = """@disable
@ assertTrue(.true.)
@assertEqual(1, &
@assertTrue(.true.) ! sure
if (.true.) @assertTrue(.true.)
@assertEqual(1)
@assertEqual(1.0, 1.0, 0.1)
@assertTrue((.true.)
@assertRelativelyEqual(1.0, 1.0, tolerance=0.1)
@assertLessThan(1.0, 2.0, tolerance=1.0)
#define A 1
! see tests/*.pf
public :: a, T""".splitlines()
CHANGES = {"sample\nuse": "other\nuse", "@test": "@test !",
           "subroutine n0": "recursive subroutine n0", "n0": "suite", "continue": 121 * " "}  # fmt: skip


@pytest.mark.parametrize(
    "text", [suite(a) for a in REFUSED] + [suite("continue").replace(*c) for c in CHANGES.items()]
)
def test_malformed_file_is_refused(tmp_path: Path, text: str) -> None:
    """For a malformed file the translator reports file and line, and writes no output."""
    done = translate(tmp_path, text)
    assert done.returncode == 1 and not (tmp_path / "main.F90").exists()
    assert re.match(rf"{tmp_path}/sample\.pf:\d+: .+: ", done.stderr)


LOG = """1/1 Testing: law\n1/1 Test: law\nOutput:\n-----\n{0}\n<end of output>
Test {1}.\n"law" end time: Jan 01\n"""


@pytest.mark.parametrize(
    ("output", "verdict", "numbers"),
    [
        ("law a ... ok\n11 passed, 0 failed", "Passed", (11, 0)),
        ("0 passed, 0 failed\nSTOP 1", "Failed", (0, 1)),
        ("60 passed, 47 deselected in 90.01s (0:01:30)", "Passed", (60, 0)),
        ("60 passed, 47 skipped in 90.01s (0:01:30)", "Passed", (0, 1)),
        (" OK\n (11 tests)", "Passed", (11, 0)),
        (" OK\n (0 test)", "Passed", (0, 1)),
        (" FAILURES!!!\nTests run: 19, Failures: 12, Errors: 1\n", "Failed", (6, 13)),
        ("Program received signal SIGSEGV", "Failed", (0, 1)),
        (" OK\n (3 tests)\nLeakSanitizer: detected memory leaks", "Failed", (3, 1)),
    ],
)
def test_count_of_tests(tmp_path: Path, output: str, verdict: str, numbers: tuple[int, int]) -> None:
    """A suite without a test, and one that CTest reports as failed, counts as a failure."""
    (tmp_path / "LastTest.log").write_text(LOG.format(output, verdict))
    done = run(sys.executable, STAND_IN / "count_tests.py", tmp_path / "LastTest.log")
    assert done.stdout.splitlines()[-1] == f"{numbers[0]} passed, {numbers[1]} failed"
    assert done.returncode == (numbers[1] > 0)
