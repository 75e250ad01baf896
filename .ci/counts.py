"""Counts of every suite, of CTest and of pytest; the last line is 'N passed, N failed'.

The argument is the exit status of make check. A suite that several builds ran counts once, with the result
of the worst build. The exit status is 1 if a test failed, a suite ran no test, or make check failed otherwise
(that counts as one failure).
"""

from __future__ import annotations

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

SUITE = re.compile(r"^(?P<name>\S+): (?P<passed>\d+) passed, (?P<failed>\d+) failed", re.MULTILINE)


class Result(NamedTuple):
    """What one build (or pytest) counted for a suite."""

    failed: int
    passed: int
    build: str


def build_results(log: Path) -> dict[str, Result]:
    """Return the result of every suite in the CTest log of a build."""
    command = [sys.executable, "tests/support/count_tests.py", str(log)]
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False).stdout
    build = log.parts[1]
    return {m["name"]: Result(int(m["failed"]), int(m["passed"]), build) for m in SUITE.finditer(output)}


def pytest_results(report: Path) -> dict[str, Result]:
    """Return the result of every file in pytest's JUnit report; a file without a test that ran has failed."""
    cases: dict[str, list[bool]] = {}
    for case in ElementTree.parse(report).iter("testcase"):
        ran = cases.setdefault(case.get("classname", ""), [])
        if case.find("skipped") is None:
            ran.append(case.find("failure") is None and case.find("error") is None)
    return {name: Result(len(ran) - sum(ran) + (not ran), sum(ran), "pytest") for name, ran in cases.items()}


def main() -> int:
    """Run the command."""
    status = int(sys.argv[1])
    suites: dict[str, list[Result]] = {}
    for log in Path("build").glob("*/Testing/Temporary/LastTest.log"):
        for name, result in build_results(log).items():
            suites.setdefault(name, []).append(result)
    report = Path("build/pytest/junit.xml")
    if report.is_file():
        for name, result in pytest_results(report).items():
            suites.setdefault(name, []).append(result)

    passed = failed = 0
    for name, results in sorted(suites.items()):
        worst = max(results, key=lambda r: (r.failed, -r.passed))
        passed += worst.passed
        failed += worst.failed
        builds = ", ".join(sorted(r.build for r in results))
        print(f"{name}: {worst.passed} passed, {worst.failed} failed ({builds})")
    if not failed and (status or not passed):
        print(f"make check ended with status {status}")
        failed = 1
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
