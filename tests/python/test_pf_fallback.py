"""Tests of the replacement of pFUnit: its verdicts, the files it rejects, and the count of tests.

If PFUNIT_DIR is set in the environment, the verdicts are compared with those of pFUnit.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SUPPORT = ROOT / "tests" / "pfunit_stand_in"
VERDICTS = SUPPORT / "pf_verdicts.pf"
STRICT = ["-std=f2008", "-Wall", "-Wextra", "-Wimplicit-interface", "-Wconversion", "-Werror"]
TRAPS = ["-O0", "-g", "-fcheck=all", "-finit-real=snan", "-ffpe-trap=invalid,zero,overflow"]

needs_gfortran = pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran")


def run(*command: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command and capture its output."""
    words = [str(word) for word in command]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True, errors="replace", check=False)


def translate(source: Path, output: Path) -> subprocess.CompletedProcess[str]:
    """Translate one .pf file."""
    return run(sys.executable, SUPPORT / "pf2f90.py", source, "-o", output)


def build(main: Path, flags: list[str]) -> Path:
    """Compile the replacement of pFUnit and a program; return the executable."""
    executable = main.with_suffix(".exe")
    sources = [SUPPORT / "pf_operands.f90", SUPPORT / "funit.f90", main]
    done = run("gfortran", *STRICT, *flags, *sources, "-o", executable, cwd=main.parent)
    assert done.returncode == 0, done.stderr
    return executable


def suite(body: str, name: str = "sample") -> str:
    """Return the text of a .pf file whose module has the body after its `contains`."""
    return f"module {name}\n   use funit\n   implicit none\n   public\ncontains\n{body}end module {name}\n"


def one_test(*lines: str, name: str = "only") -> str:
    """Return a @test subroutine with these lines."""
    return "\n".join(["@test", f"subroutine {name}()", *lines, f"end subroutine {name}", ""])


def run_suite(tmp_path: Path, text: str, name: str = "sample") -> subprocess.CompletedProcess[str]:
    """Translate, build and run a .pf text."""
    source, main = tmp_path / f"{name}.pf", tmp_path / "main.F90"
    source.write_text(text)
    done = translate(source, main)
    assert done.returncode == 0, done.stderr
    return run(build(main, TRAPS))


def names_in(text: str) -> list[str]:
    """Return the names of the tests of a .pf text."""
    return re.findall(r"@test\n\s*subroutine (\w+)", text)


@pytest.mark.slow
@needs_gfortran
@pytest.mark.parametrize("flags", [TRAPS, ["-O3"]], ids=["traps", "O3"])
def test_verdicts(tmp_path: Path, flags: list[str]) -> None:
    """Every test of pf_verdicts.pf passes or fails according to its name.

    The program is compiled with floating-point traps and with optimisation.
    """
    assert translate(VERDICTS, tmp_path / "main.F90").returncode == 0
    done = run(build(tmp_path / "main.F90", flags))
    names = names_in(VERDICTS.read_text())
    expected = {name: "ok" if name.startswith("holds_") else "FAILED" for name in names}
    assert len(expected) == len(names) > 100
    assert dict(re.findall(r"^pf_verdicts (\w+) \.\.\. (\w+)$", done.stdout, re.MULTILINE)) == expected
    good = sum(verdict == "ok" for verdict in expected.values())
    assert done.stdout.splitlines()[-1] == f"{good} passed, {len(names) - good} failed"
    assert done.returncode == 1


@needs_gfortran
def test_report(tmp_path: Path) -> None:
    """The report of a failure has file, line, expected and actual value, tolerance, element and message."""
    failing = "@assertEqual([1.0d0, 2.0d0], [1.0d0, 4.0d0], tolerance=0.5d0, message='why')"
    text = suite(one_test("@assertTrue(.true.)", failing))
    done = run_suite(tmp_path, text)
    line = text.splitlines().index(failing) + 1
    assert re.sub(r"(\.\d+?)0+\b", r"\1", done.stdout).splitlines() == [
        "sample only ... FAILED",
        f"   sample.pf:{line}: @assertEqual",
        "      expected 2.0",
        "      actual   4.0",
        "      within   0.5",
        "      element  2 of shape 2",
        "      message  why",
        "0 passed, 1 failed",
    ]


MISFITS = [
    "@assertEqual([1, 2], 1)",
    "@assertEqual([1, 2], reshape([1, 2], [1, 2]))",
    "@assertEqual(1, .true.)",
    "@assertEqual(1.0d0, 1)",
    "@assertEqual(1.0d0, 1.0)",
    "@assertEqual('1', 1)",
    "@assertEqual(1, 1, tolerance=1)",
    "@assertEqual(1, 1, tolerance=1.0d0)",
    "@assertEqual([1.0d0], [1.0d0], tolerance=[1.0d0])",
    "@assertNotEqual('a', 'b')",
    "@assertLessThan([1, 2], 3)",
    "@assertLessThan(.false., .true.)",
    "@assertGreaterThan('b', 'a')",
    "@assertRelativelyEqual(1, 1, tolerance=0.5)",
    "@assertTrue(1)",
    "@assertFalse(reshape([.false.], [1, 1]))",
    "@assertIsNaN(1)",
    "@assertIsFinite([1.0d0])",
]


@needs_gfortran
def test_operands_that_do_not_fit_fail(tmp_path: Path) -> None:
    """An assertion fails if its kinds, ranks or tolerance do not match; pFUnit does not compile it."""
    done = run_suite(tmp_path, suite("".join(one_test(line, name=f"n{i}") for i, line in enumerate(MISFITS))))
    failed = re.findall(r"^sample n(\d+) \.\.\. FAILED$", done.stdout, re.MULTILINE)
    assert failed == [str(i) for i in range(len(MISFITS))]
    assert done.stdout.splitlines()[-1] == f"0 passed, {len(MISFITS)} failed"


@needs_gfortran
def test_before_and_after(tmp_path: Path) -> None:
    """After a failure in @before neither the test nor @after runs; a failure in @after fails the test."""
    fixture = "@{0}\nsubroutine around()\nprint *, '{0} ran'\n@assertTrue({1})\nend subroutine around\n"
    body = one_test("print *, 'test ran'")
    (tmp_path / "a").mkdir()
    done = run_suite(tmp_path / "a", suite(fixture.format("before", ".false.") + body))
    assert "before ran" in done.stdout and "test ran" not in done.stdout and done.returncode == 1
    (tmp_path / "b").mkdir()
    done = run_suite(tmp_path / "b", suite(fixture.format("after", ".false.") + body))
    assert "test ran" in done.stdout and "after ran" in done.stdout and done.returncode == 1
    (tmp_path / "c").mkdir()
    done = run_suite(tmp_path / "c", suite(fixture.format("after", ".true.") + body))
    assert done.stdout.splitlines()[-1] == "1 passed, 0 failed" and done.returncode == 0


@needs_gfortran
def test_no_test_is_a_failure(tmp_path: Path) -> None:
    """An executable that ran no test exits with an error."""
    main = tmp_path / "main.F90"
    main.write_text("program no\nuse funit, only: pf_finish\nimplicit none\ncall pf_finish()\nend program\n")
    done = run(build(main, []))
    assert (done.returncode, done.stdout) == (1, "0 passed, 0 failed\n")


def test_flang_compiles_the_stand_in(tmp_path: Path) -> None:
    """Flang, a second compiler, accepts the replacement of pFUnit and the output of the translator."""
    flang = next(filter(None, map(shutil.which, ("flang-new", "flang-new-16", "flang"))), None)
    if not flang:
        pytest.skip("no flang")
    translate(VERDICTS, tmp_path / "main.F90")
    for source in (SUPPORT / "pf_operands.f90", SUPPORT / "funit.f90", tmp_path / "main.F90"):
        done = run(flang, "-c", source, cwd=tmp_path)
        assert done.returncode == 0, done.stderr


GOOD = one_test("@assertTrue(.true.)")
RECURSIVE = GOOD.replace("subroutine only()", "recursive subroutine only()", 1)
BEFORE = "@before\nsubroutine {0}()\nend subroutine {0}\n"
# Each entry has a malformed file and the number of the line with the error. The body starts at line 6.
REFUSED = {
    "unknown directive": (suite("@tset\n" + GOOD), 6),
    "directive of pFUnit outside the subset": (suite("@disable\n" + GOOD), 6),
    "unknown assertion": (suite(one_test("@assertSame(1, 1)")), 8),
    "misspelt assertion": (suite(one_test("@asserTrue(.true.)")), 8),
    "empty directive": (suite(one_test("@ assertTrue(.true.)")), 8),
    "continued assertion": (suite(one_test("@assertEqual(1, &", "   1)")), 8),
    "continued after its end": (suite(one_test("@assertTrue(.true.) &", "")), 8),
    "assertion as a continuation": (suite(one_test("if (.true.) &", "@assertTrue(.true.)")), 9),
    "comment after an assertion": (suite(one_test("@assertTrue(.true.) ! sure")), 8),
    "comment in parentheses after it": (suite(one_test("@assertTrue(.true.) ! (sure)")), 8),
    "comment after @test": (suite(GOOD.replace("@test", "@test ! first")), 6),
    "options of @test": (suite(GOOD.replace("@test", "@test(npes=[1])")), 6),
    "@test without a subroutine": (suite("@test\ninteger function f()\nend function f\n" + GOOD), 7),
    "@test before a recursive subroutine": (suite(RECURSIVE), 7),
    "@test before a subroutine with arguments": (suite(GOOD.replace("only()", "only(this)", 1)), 7),
    "@test before a subroutine without parentheses": (suite(GOOD.replace("only()", "only", 1)), 7),
    "@test before an empty line": (suite(GOOD.replace("@test", "@test\n")), 7),
    "@test at the end": (suite(GOOD) + "@test\n", 11),
    "two @before": (suite(BEFORE.format("a") + BEFORE.format("b") + GOOD), 10),
    "same test twice": (suite(GOOD + GOOD.replace("only", "ONLY")), 11),
    "same name for test and set-up": (suite(BEFORE.format("only") + GOOD), 10),
    "test named like a variable of pFUnit": (suite(one_test("@assertTrue(.true.)", name="suite")), 7),
    "public entity named like a variable of pFUnit": (suite("public :: a, T\n" + GOOD), 6),
    "121 columns": (suite(one_test("@assertTrue(.true.)".ljust(121))), 8),
    "121 columns of code": (suite("!".ljust(121, "-") + "\n" + GOOD), 6),
    "conditional assertion": (suite(one_test("if (.true.) @assertTrue(.true.)")), 8),
    "two statements": (suite(one_test("@assertTrue(.true.); continue")), 8),
    "too few operands": (suite(one_test("@assertEqual(1)")), 8),
    "third operand by position": (suite(one_test("@assertEqual(1.0, 1.0, 0.1)")), 8),
    "no operand": (suite(one_test("@assertTrue()")), 8),
    "empty operand": (suite(one_test("@assertEqual(1, )")), 8),
    "no parentheses": (suite(one_test("@assertTrue .true.")), 8),
    "no closing parenthesis": (suite(one_test("@assertTrue((.true.)")), 8),
    "parenthesis only in a text": (suite(one_test("@assertEqual('a', 'b)'")), 8),
    "operand by name": (suite(one_test("@assertEqual(expected=1, actual=1)")), 8),
    "unknown option": (suite(one_test("@assertEqual('a', 'b', whitespace=IGNORE_ALL)")), 8),
    "option twice": (suite(one_test("@assertTrue(.true., message='a', message='b')")), 8),
    "empty option": (suite(one_test("@assertTrue(.true., message=)")), 8),
    "tolerance where there is none": (suite(one_test("@assertTrue(.true., tolerance=1.0)")), 8),
    "relative without tolerance": (suite(one_test("@assertRelativelyEqual(1.0, 1.0)")), 8),
    "operand after an option": (suite(one_test("@assertEqual(1.0, tolerance=0.1, 1.0)")), 8),
    "no test": (suite(""), 6),
    "other module name": (suite(GOOD, name="other"), 1),
    "second module": (suite(GOOD) + "module more\nend module more\n", 11),
    "comment after the module name": (suite(GOOD).replace("module sample\n", "module sample ! all\n", 1), 10),
    "no use funit": (suite(GOOD).replace("use funit", "use, intrinsic :: iso_c_binding"), 10),
    "use funit with only": (suite(GOOD).replace("use funit", "use funit, only: throw"), 10),
    "preprocessor directive": (suite("#define A 1\n" + GOOD), 6),
    "start of a C comment": (suite("! see tests/*.pf\n" + GOOD), 6),
    "backslash at the end": (suite("! one \\\n" + GOOD), 6),
    "empty file": ("", 0),
}


@pytest.mark.parametrize("case", REFUSED)
def test_malformed_file_is_refused(tmp_path: Path, case: str) -> None:
    """For a malformed file the translator reports file, line and text, and writes no output."""
    text, number = REFUSED[case]
    source, output = tmp_path / "sample.pf", tmp_path / "main.F90"
    source.write_text(text)
    done = translate(source, output)
    assert done.returncode == 1 and not output.exists()
    lines = text.splitlines()
    shown = lines[number - 1].strip() if number else ""
    errors = done.stderr.splitlines()
    assert any(e.startswith(f"{source}:{number}: ") and e.endswith(f": {shown}") for e in errors)
    assert "Traceback" not in done.stderr


def test_well_formed_file_is_translated(tmp_path: Path) -> None:
    """The translator accepts the file from which the malformed files are derived."""
    source, output = tmp_path / "sample.pf", tmp_path / "main.F90"
    source.write_text(suite(GOOD))
    assert translate(source, output).returncode == 0 and output.exists()


LOG = """1/1 Testing: law
1/1 Test: law
Command: "law"
"law" start time: Jan 01 00:00 UTC
Output:
----------------------------------------------------------
{output}
<end of output>
Test time =   0.01 sec
----------------------------------------------------------
Test {verdict}.
"law" end time: Jan 01 00:00 UTC
----------------------------------------------------------
"""


@pytest.mark.parametrize(
    ("output", "verdict", "numbers", "status"),
    [
        ("law a ... ok\n11 passed, 0 failed", "Passed", (11, 0), 0),
        ("law a ... FAILED\n3 passed, 2 failed\nSTOP 1", "Failed", (3, 2), 1),
        ("0 passed, 0 failed\nSTOP 1", "Failed", (0, 1), 1),
        (".....\nTime:         0.000 seconds\n  \n OK\n (11 tests)", "Passed", (11, 0), 0),
        (" OK\n (1 test)", "Passed", (1, 0), 0),
        (" OK\n (5 tests, 1 disabled)", "Passed", (5, 0), 0),
        (" OK\n (0 test)", "Passed", (0, 1), 1),
        (" FAILURES!!!\nTests run: 19, Failures: 12, Errors: 1\n, Disabled: 0", "Failed", (6, 13), 1),
        ("Program received signal SIGSEGV", "Failed", (0, 1), 1),
        (" OK\n (3 tests)\nLeakSanitizer: detected memory leaks", "Failed", (3, 1), 1),
    ],
)
def test_count_of_tests(
    tmp_path: Path, output: str, verdict: str, numbers: tuple[int, int], status: int
) -> None:
    """The count is correct for the last lines of pFUnit and of its replacement.

    A suite without a test, and one that CTest reports as failed, counts as a failure.
    """
    log = tmp_path / "LastTest.log"
    log.write_text(LOG.format(output=output, verdict=verdict))
    done = run(sys.executable, SUPPORT / "count_tests.py", log)
    assert done.stdout.splitlines()[-1] == f"{numbers[0]} passed, {numbers[1]} failed"
    assert done.returncode == status


def test_count_of_tests_misses_a_suite(tmp_path: Path) -> None:
    """A requested suite that is not in the log counts as failed; an empty log is a failure."""
    log = tmp_path / "LastTest.log"
    log.write_text(LOG.format(output="1 passed, 0 failed", verdict="Passed"))
    done = run(sys.executable, SUPPORT / "count_tests.py", log, "law", "kernel")
    assert done.stdout.splitlines()[-1] == "1 passed, 1 failed" and done.returncode == 1
    log.write_text("")
    done = run(sys.executable, SUPPORT / "count_tests.py", log)
    assert done.stdout == "0 passed, 0 failed\n" and done.returncode == 1


PROJECT = """cmake_minimum_required(VERSION 3.24)
project(suites LANGUAGES Fortran)
enable_testing()
include({root}/cmake/AsperityTesting.cmake)
asperity_add_suite(verdicts TEST_SOURCES pf_verdicts.pf)
asperity_add_suite(empty TEST_SOURCES empty.pf)
"""


@needs_gfortran
@pytest.mark.skipif("PFUNIT_DIR" not in os.environ, reason="PFUNIT_DIR is not set")
@pytest.mark.skipif(not shutil.which("cmake"), reason="no cmake")
def test_pfunit_gives_the_same_verdicts(tmp_path: Path) -> None:
    """The tests fails_* fail in pFUnit and all others pass.

    pFUnit reports OK for a suite without tests; CTest reports this suite as failed.
    """
    shutil.copy(VERDICTS, tmp_path)
    (tmp_path / "empty.pf").write_text(suite("", name="empty"))
    (tmp_path / "CMakeLists.txt").write_text(PROJECT.format(root=ROOT))
    folder = tmp_path / "build"
    pfunit = f"-DPFUNIT_DIR={os.environ['PFUNIT_DIR']}"
    done = run("cmake", "-S", tmp_path, "-B", folder, pfunit, "-DCMAKE_Fortran_COMPILER=gfortran")
    assert done.returncode == 0, done.stderr
    assert run("cmake", "--build", folder, "--target", "verdicts").returncode == 0
    output = run(folder / "verdicts", "--verbose").stdout
    names = names_in(VERDICTS.read_text())
    assert re.findall(r"Start: <pf_verdicts_suite\.(\w+)>", output) == names
    failed = re.findall(r"Failure in <pf_verdicts_suite\.(\w+)>", output)
    assert failed == [name for name in names if name.startswith("fails_")]
    # The check before the build rejects the empty suite. Without this check CTest must reject 'OK (0 test)'.
    assert run("cmake", "--build", folder, "--target", "empty").returncode != 0
    checked = folder / "empty.checked"
    checked.touch()
    os.utime(checked, (time.time() + 1e4,) * 2)
    assert run("cmake", "--build", folder, "--target", "empty").returncode == 0
    assert run(folder / "empty").returncode == 0
    done = run("ctest", "-R", "empty", cwd=folder)
    assert "100% tests passed" not in done.stdout and done.returncode != 0
