"""Counts of every suite, of CTest and of pytest; the last line is 'N passed, N failed'.

The arguments are the exit statuses of make check, make hosts and make site-test ('not run': no time, or check
failed). A suite that several builds ran counts once, with the result of the worst build. A host that is not
to be had on this machine is skipped, with the reason, as is the site. The exit status is 1 if a test failed,
a suite or a host ran no test, or one of the three failed otherwise (that counts as one failure).
"""

from __future__ import annotations

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

SUITE = re.compile(r"^(?P<name>\S+): (?P<passed>\d+) passed, (?P<failed>\d+) failed", re.MULTILINE)

HOSTS = sorted({path.parent.name for path in Path("harness/hosts").glob("*/test_*.py")})
"""Hosts, whose tests have a report of their own."""

TIMED_OUT = (124, 137)
"""Exit statuses of timeout."""


class Result(NamedTuple):
    """What one build (or pytest) counted for a suite."""

    failed: int
    passed: int
    build: str
    skipped: int = 0


def build_results(log: Path) -> dict[str, Result]:
    """Return the result of every suite in the CTest log of a build."""
    command = [sys.executable, "tests/pfunit_stand_in/count_tests.py", str(log)]
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False).stdout
    build = log.parts[1]
    return {m["name"]: Result(int(m["failed"]), int(m["passed"]), build) for m in SUITE.finditer(output)}


def pytest_results(report: Path, may_skip: bool = False) -> dict[str, Result]:
    """Return the result of every file in pytest's JUnit report.

    A file without a test that ran has failed, unless it may be left out.
    """
    cases: dict[str, list[bool]] = {}
    skipped: dict[str, int] = {}
    for case in ElementTree.parse(report).iter("testcase"):
        # a file that is left out as a whole has a name only
        name = case.get("classname") or case.get("name", "")
        ran = cases.setdefault(name, [])
        if case.find("skipped") is None:
            ran.append(case.find("failure") is None and case.find("error") is None)
        else:
            skipped[name] = skipped.get(name, 0) + 1
    results = {}
    for name, ran in cases.items():
        failed = len(ran) - sum(ran) + (not ran and not may_skip)
        results[name] = Result(failed, sum(ran), "pytest", skipped.get(name, 0))
    return results


def site_results(status: str) -> dict[str, Result]:
    """Return the results of the tests of the site; without a report they are skipped."""
    report = Path("build/site-tools/junit.xml")
    if report.is_file():
        return pytest_results(report)
    print(f"site: no report, make site-test ended with status {status}")
    return {"site": Result(0, 0, "site", 1)}


def reasons(report: Path) -> str:
    """Return why tests of a report were left out."""
    texts = set()
    for node in ElementTree.parse(report).iter("skipped"):
        message = node.get("message", "")
        # of a file that is left out as a whole: ('file', line, 'Skipped: reason')
        m = re.search(r"Skipped: (.*?)['\"]?\)?$", node.text or "", re.DOTALL)
        texts.add(m[1] if message == "collection skipped" and m else message)
    return "; ".join(sorted(texts))


def reports_of(host: str) -> list[Path]:
    """Return the reports of the tests of a host, that of several ranks last."""
    tests = Path("harness/hosts", host).glob("test_*.py")
    several = any("SEVERAL_RANKS" in test.read_text(encoding="utf-8") for test in tests)
    return [Path("build/hosts", f"{host}{kind}.xml") for kind in (["", "-ranks"] if several else [""])]


def host_results(status: str) -> dict[str, Result]:
    """Return the result of every host, and print what did not run, and why.

    A host whose tests are all left out is not to be had here, and is skipped. One without a test has failed,
    as has one without a report, unless make check has failed.
    """
    results = {}
    for host in HOSTS:
        name, passed, failed, skipped = f"hosts.{host}", 0, 0, 0
        for report in reports_of(host):
            outcomes = list(pytest_results(report, may_skip=True).values()) if report.is_file() else []
            passed += sum(r.passed for r in outcomes)
            failed += sum(r.failed for r in outcomes)
            left_out = sum(r.skipped for r in outcomes)
            skipped += left_out
            if left_out:
                print(f"{name}: {left_out} left out: {reasons(report)}")
            if not outcomes and status == "not run":
                print(f"{name}: not run: make check failed ({report.name})")
                skipped += 1
            elif not outcomes:
                ended = "out of time" if int(status) in TIMED_OUT else "no test"
                print(f"{name}: not run: {ended} ({report.name})")
                failed += 1
        results[name] = Result(failed, passed, "hosts", skipped)
    return results


def main() -> int:
    """Run the command."""
    status, hosts, site = int(sys.argv[1]), sys.argv[2], sys.argv[3]
    suites: dict[str, list[Result]] = {}
    for log in Path("build").glob("*/Testing/Temporary/LastTest.log"):
        for name, result in build_results(log).items():
            suites.setdefault(name, []).append(result)
    report = Path("build/pytest/junit.xml")
    if report.is_file():
        for name, result in pytest_results(report).items():
            suites.setdefault(name, []).append(result)
    for name, result in (host_results(hosts) | site_results(site)).items():
        suites.setdefault(name, []).append(result)

    passed = failed = skipped = 0
    for name, results in sorted(suites.items()):
        worst = max(results, key=lambda r: (r.failed, -r.passed))
        passed += worst.passed
        failed += worst.failed
        skipped += worst.skipped
        builds = ", ".join(sorted(r.build for r in results))
        left_out = f", {worst.skipped} skipped" if worst.skipped else ""
        print(f"{name}: {worst.passed} passed, {worst.failed} failed{left_out} ({builds})")
    broken = any(other != "not run" and int(other) not in (0, *TIMED_OUT) for other in (hosts, site))
    if not failed and (status or broken or not passed):
        print(f"make check ended with status {status}, make hosts: {hosts}, make site-test: {site}")
        failed = 1
    if skipped:
        print(f"{skipped} skipped")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
