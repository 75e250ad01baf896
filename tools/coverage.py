#!/usr/bin/env python3
"""Report the line coverage of src/, and fail where a file has less than it should.

Run from the top folder, after the suites of an instrumented build.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

# Share of the lines of a file that the suites must run.
REQUIRED = 0.95

# Files whose tests are in Python, which run the driver and the libraries of the release: reader of cases,
# errors and rows, UMATs of others, doors of hosts, and what a law has that says nothing of itself. They are
# counted apart.
BY_PYTHON = re.compile(
    r"/umat_host/|/doors/(diana|lsdyna|radioss)|/run/asperity_(case|errors|json|rows|steps|text_file)|asperity_point_law"
)


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="build folder with ASPERITY_COVERAGE=ON")
    build = parser.parse_args().build
    summary = build / "coverage.json"
    # The names of Fortran procedures begin with two underscores, which gcovr takes for internal functions.
    # The compiler writes a procedure of its own for each type, which it places in the module's last line.
    command = [sys.executable, "-m", "gcovr", "--include-internal-functions", "--root", ".", "--txt", "-"]
    # a line of the law is compiled for each kernel and kind, and measured once
    command += ["--merge-lines", "--filter", "src/", "--exclude-lines-by-pattern", r"^\s*end module\b.*"]
    subprocess.run([*command, "--json-summary", str(summary), str(build / "src")], check=True)

    files = {f["filename"]: f for f in json.loads(summary.read_text(encoding="utf-8"))["files"]}
    bad = 0
    lines = covered = 0
    others = [entry for name, entry in files.items() if BY_PYTHON.search(name)]
    for name, entry in files.items():
        if BY_PYTHON.search(name):
            continue
        lines += entry["line_total"]
        covered += entry["line_covered"]
        if entry["line_covered"] < REQUIRED * entry["line_total"]:
            share = f"{entry['line_covered']} of {entry['line_total']} lines"
            print(f"{name}: {share}, required {REQUIRED:.0%}")
            bad += 1
    if not lines:
        print("no line of src/ was measured")
        return 1
    apart = [sum(entry[f"line_{kind}"] for entry in others) for kind in ("covered", "total")]
    print(f"{apart[0]} of {apart[1]} lines that Python tests")
    print(f"{covered} of {lines} lines of src/ run, {bad} files below the required share")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
