#!/usr/bin/env python3
"""Count the tests of all suites in a CTest log: a line per suite, then 'N passed, N failed'.

The suites were run by pFUnit, its stand-in or pytest. The exit status is 1 if a test failed, if a suite ran
no test or did not end, or if CTest itself calls it failed.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

# One entry of Testing/Temporary/LastTest.log has the name, the output, and the result that CTest reports.
ENTRY = re.compile(
    r"^\d+/\d+ Testing: (?P<name>.+?)\n.*?"
    r"^Output:\n-+\n(?P<output>.*?)^<end of output>\n(?P<end>.*?)"
    r"^\"(?P=name)\" end time",
    re.MULTILINE | re.DOTALL,
)
STAND_IN = re.compile(r"^(\d+) passed, (\d+) failed$", re.MULTILINE)
PFUNIT_OK = re.compile(r"^ OK\n \((\d+) tests?(?:, \d+ disabled)?\)$", re.MULTILINE)
# what the command leaves out by name is no test; one that leaves itself out is
PYTEST_OK = re.compile(r"^(\d+) passed(?:, \d+ deselected)?(?:, \d+ warnings?)? in ", re.MULTILINE)
PFUNIT_FAILURES = re.compile(r"^Tests run: (\d+), Failures: (\d+), Errors: (\d+)", re.MULTILINE)


def count(output: str) -> tuple[int, int]:
    """Return the numbers of passed and failed tests by the last closing line; (0, 0) without one."""
    closing_lines = [(m.start(), int(m[1]), int(m[2])) for m in STAND_IN.finditer(output)]
    closing_lines += [(m.start(), int(m[1]), 0) for m in PFUNIT_OK.finditer(output)]
    closing_lines += [(m.start(), int(m[1]), 0) for m in PYTEST_OK.finditer(output)]
    for m in PFUNIT_FAILURES.finditer(output):
        failed = int(m[2]) + int(m[3])
        closing_lines.append((m.start(), int(m[1]) - failed, failed))
    return max(closing_lines)[1:] if closing_lines else (0, 0)


def main() -> int:
    """Run the command: the argument is Testing/Temporary/LastTest.log in the build folder."""
    log = Path(sys.argv[1]).read_text(encoding="utf-8", errors="replace")
    total_passed = total_failed = 0
    for entry in ENTRY.finditer(log):
        passed, failed = count(entry["output"])
        note = ""
        if passed + failed == 0:
            note = ", no test ran"
        elif failed == 0 and "Test Passed." not in entry["end"]:
            note = ", CTest calls it failed"
        failed += bool(note)
        print(f"{entry['name']}: {passed} passed, {failed} failed{note}")
        total_passed += passed
        total_failed += failed
    print(f"{total_passed} passed, {total_failed} failed")
    return 0 if total_passed and not total_failed else 1


if __name__ == "__main__":
    sys.exit(main())
