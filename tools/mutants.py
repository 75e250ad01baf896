#!/usr/bin/env python3
"""Mutation test: change one operator, constant or name of the library at a time; a test must notice.

Each mutant is compiled without optimisation in a copy of the project, and the tests of CTest run until one
fails. A mutant that no test notices is a survivor. tests/equivalent_mutants.csv lists mutants that compute
the same as the unchanged line, each with its reason: they are left out. The result is a table in Markdown.
The status is 1 if a mutant survives, and 2 if the list of equivalent mutants has a line that is not in the
source. Run from the top folder.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import queue
import random
import re
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

FOLDERS = ["src/law", "src/equilibrium"]
EQUIVALENT = Path("tests/equivalent_mutants.csv")
WORK = Path("build/mutants")
COPIED = ["CMakeLists.txt", "cmake", "src", "harness", "tests"]
# They repeat the same calls on many threads or for a long time, or compile another project.
LEFT_OUT = {"test_package", "test_adaptive_soak", "test_solver_soak", "test_threads", "threads", "memory"}
# A test that takes so many times its usual time, and at least so many seconds, has noticed the mutant.
PATIENCE, LEAST_PATIENCE = 10.0, 20.0
# What the program of a test takes to be linked, in seconds; it counts in the order of the tests.
LINK_TIME = 1.0

# Pattern of what is changed, and the text that replaces it. Comparisons are turned round: to include the
# limit or not is the same for almost all real numbers. Constants are doubled.
SWAP_ARGUMENTS, ADD_ONE = "swap arguments", "add one"
CHANGES: list[tuple[str, str]] = [
    (r"(?<=[\w)] )\+(?= )", "-"),
    (r"(?<=[\w)] )-(?= )", "+"),
    (r"(?<=[=(,] )-(?=[\w(])|(?<=[=(])-(?=[\w(])", ""),
    (r"(?<=[\w)])\*(?=[\w(])", "/"),
    (r"(?<=[\w)])/(?=[\w(])", "*"),
    (r"\*\*2\b", "**3"),
    (r" <= ", " > "),
    (r" < ", " >= "),
    (r" >= ", " < "),
    (r" > ", " <= "),
    (r" == ", " /= "),
    (r" /= ", " == "),
    (r"\.and\.", ".or."),
    (r"\.or\.", ".and."),
    (r"\.not\. ", ""),
    (r"\.true\.", ".false."),
    (r"\.false\.", ".true."),
    (r"\bmax\(", "min("),
    (r"\bmin\(", "max("),
    (r"\babs\(", "("),
    (r"\ball\(", "any("),
    (r"\bany\(", "all("),
    (r"\bmerge\(", SWAP_ARGUMENTS),
    (r"(?<![\w.%])0\.0_(wp|real64)", r"1.0_\1"),
    (r"(?<![\w.%])([1-9]\d*\.\d+(e[+-]?\d+)?)_(wp|real64)", r"(2.0_\3*\1_\3)"),
    (r"(?<![\w.%])(0\.\d*[1-9]\d*(e[+-]?\d+)?)_(wp|real64)", r"(2.0_\3*\1_\3)"),
    (r"(?<![\w.%*])([0-9])(?![\w.])(?=[^'\"]*$)", ADD_ONE),
    (r"%t\b", "%h"),
    (r"%h\b", "%t"),
    (r"%x\b", "%y"),
    (r"%y\b", "%x"),
    (r"_s01\b", "_s02"),
    (r"_s02\b", "_s01"),
    (r"_old\b", ""),
]
# lines without anything to change: declarations, headings, what is written for people
PASSED_OVER = re.compile(
    r"^\s*(!|use\b|implicit\b|private\b|public\b|import\b|include\b|end\b|contains\b|module\b|submodule\b|"
    r"(pure |elemental |impure |recursive )*(function|subroutine)\b|interface\b|type\b|integer\b|real\b|"
    r"logical\b|character\b|procedure\b|class\b|case \(|select\b|associate\b|error stop|bind\b|result\b|&?$)",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Mutant:
    """A changed line of a file."""

    path: str
    line: int
    before: str
    after: str

    def __str__(self) -> str:
        """Tell the file, the line and the change."""
        return f"{self.path}:{self.line}: {self.before.strip()}  ->  {self.after.strip()}"


def code_length(line: str) -> int:
    """Return where the comment of a line begins."""
    quote = ""
    for i, c in enumerate(line):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c == "!":
            return i
    return len(line)


def in_text(line: str, at: int) -> bool:
    """Return whether a place lies within a character constant."""
    return any(line[:at].count(q) % 2 for q in "'\"")


def swapped(line: str, at: int) -> str | None:
    """Exchange the first two arguments of the call that begins at `at`; None if it ends in another line."""
    depth, commas = 0, []
    start = line.index("(", at)
    for i in range(start, len(line)):
        depth += (line[i] in "([") - (line[i] in ")]")
        if depth == 1 and line[i] == ",":
            commas.append(i)
        if depth == 0 and len(commas) == 2:
            a, b = line[start + 1 : commas[0]], line[commas[0] + 1 : commas[1]]
            return f"{line[: start + 1]}{b.strip()}, {a}{line[commas[1] :]}"
    return None


def mutants_of(path: Path) -> list[Mutant]:
    """List every mutant of a file."""
    found: list[Mutant] = []
    continued = declared = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        code = line[: code_length(line)].rstrip()
        passed_over = bool(PASSED_OVER.match(code)) or (continued and declared)
        declared = passed_over
        continued = code.endswith("&")
        if passed_over or not code:
            continue
        for pattern, text in CHANGES:
            for match in re.finditer(pattern, code):
                if in_text(code, match.start()):
                    continue
                if text == SWAP_ARGUMENTS:
                    after = swapped(code, match.start())
                elif text == ADD_ONE:
                    after = f"{code[: match.start()]}{int(match[1]) + 1}{code[match.end() :]}"
                else:
                    after = code[: match.start()] + match.expand(text) + code[match.end() :]
                if after and after != code:
                    found.append(Mutant(str(path), number, code, after))
    return found


class Bench:
    """A copy of the project in which one mutant at a time is compiled and tested."""

    def __init__(self, folder: Path) -> None:
        """Copy, configure and build the project, and measure the tests' times."""
        self.folder = folder.resolve()
        self.build = self.folder / "build"
        self.folder.mkdir(parents=True, exist_ok=True)
        for name in COPIED:
            target = self.folder / name
            if target.is_dir():
                shutil.rmtree(target)
            (shutil.copytree if Path(name).is_dir() else shutil.copy2)(name, target)
        options = [
            "-DCMAKE_BUILD_TYPE=None",
            "-DCMAKE_Fortran_FLAGS=-O0 -fcheck=bounds -ffree-line-length-none",
            "-DCMAKE_DISABLE_FIND_PACKAGE_PFUNIT=ON",
        ]
        self.run(
            [
                "cmake",
                "-S",
                str(self.folder),
                "-B",
                str(self.build),
                "-G",
                "Ninja",
                f"-DPython3_EXECUTABLE={sys.executable}",
                *options,
            ]
        )
        if self.compile():
            sys.exit(f"{self.folder}: the unchanged project does not compile")
        listed = subprocess.run(
            ["ctest", "--test-dir", str(self.build), "--show-only=json-v1"],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        self.tests = {}
        for test in json.loads(listed)["tests"]:
            properties = {p["name"]: p["value"] for p in test["properties"]}
            if test["name"] not in LEFT_OUT:
                environment = dict(os.environ)
                environment.update(e.split("=", 1) for e in properties.get("ENVIRONMENT", []))
                self.tests[test["name"]] = (
                    test["command"],
                    properties.get("WORKING_DIRECTORY", self.build),
                    environment,
                )
        self.times = dict.fromkeys(self.tests, 300.0)
        for name in self.tests:
            start = time.monotonic()
            if not self.passes(name):
                sys.exit(f"{name} fails without any change")
            self.times[name] = LINK_TIME + time.monotonic() - start
        self.kills: Counter[tuple[str, str]] = Counter()

    def run(self, command: list[str]) -> None:
        """Run a command that must not fail."""
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def compile(self, target: str = "all") -> int:
        """Compile what has changed for a target; 0 if this was possible."""
        return subprocess.run(
            ["cmake", "--build", str(self.build), "--parallel", "1", "--target", target],
            check=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        ).returncode

    def target(self, name: str) -> str:
        """Return what must be compiled for a test: its program, or all if it runs something else."""
        program = Path(self.tests[name][0][0])
        return program.name if self.build in program.parents else "all"

    def passes(self, name: str) -> bool:
        """Run a test; a test that takes far too long does not pass."""
        command, folder, environment = self.tests[name]
        limit = max(LEAST_PATIENCE, PATIENCE * self.times[name])
        try:
            return (
                subprocess.run(
                    command,
                    cwd=folder,
                    env=environment,
                    check=False,
                    timeout=limit,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                ).returncode
                == 0
            )
        except subprocess.TimeoutExpired:
            return False

    def judge(self, mutant: Mutant) -> str:
        """Return the test that notices a mutant, 'does not compile', or 'survived'."""
        path = self.folder / mutant.path
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines(keepends=True)
        lines[mutant.line - 1] = mutant.after + "\n"
        path.write_text("".join(lines), encoding="utf-8")
        try:
            # first what has noticed many mutants of this file in little time
            for name in sorted(self.tests, key=lambda n: self.times[n] / (1 + self.kills[mutant.path, n])):
                if self.compile(self.target(name)):
                    return "does not compile"
                if not self.passes(name):
                    self.kills[mutant.path, name] += 1
                    return name
            return "survived"
        finally:
            path.write_text(text, encoding="utf-8")


def equivalents() -> dict[tuple[str, str, str], str]:
    """Read the list of mutants that no test can notice: (file, line, changed line) -> reason."""
    if not EQUIVALENT.exists():
        return {}
    with EQUIVALENT.open(newline="", encoding="utf-8") as file:
        return {(r["file"], r["before"], r["after"]): r["reason"] for r in csv.DictReader(file)}


def chosen(mutants: list[Mutant], samples: int, seed: int) -> list[Mutant]:
    """Draw some of the mutants, or all with samples = 0, in the order of the files."""
    if 0 < samples < len(mutants):
        mutants = random.Random(seed).sample(mutants, samples)
    return sorted(mutants, key=lambda m: (m.path, m.line, m.after))


def judge_all(mutants: list[Mutant], jobs: int, show: bool) -> dict[Mutant, str]:
    """Judge the mutants in `jobs` copies of the project; the results are also in a file as they come."""
    waiting: queue.SimpleQueue[Mutant] = queue.SimpleQueue()
    for mutant in mutants:
        waiting.put(mutant)
    results: dict[Mutant, str] = {}
    lock = threading.Lock()
    start = time.monotonic()
    WORK.mkdir(parents=True, exist_ok=True)
    with (WORK / "results.csv").open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["file", "line", "before", "after", "result"])

        def work(bench: Bench) -> None:
            while True:
                try:
                    mutant = waiting.get_nowait()
                except queue.Empty:
                    return
                result = bench.judge(mutant)
                with lock:
                    results[mutant] = result
                    rows.writerow(
                        [mutant.path, mutant.line, mutant.before.strip(), mutant.after.strip(), result]
                    )
                    file.flush()
                    if show:
                        rest = (time.monotonic() - start) / len(results) * (len(mutants) - len(results))
                        print(
                            f"\r{len(results)} of {len(mutants)}, {rest / 60:.0f} minutes left ",
                            end="",
                            file=sys.stderr,
                        )

        benches = [Bench(WORK / str(i)) for i in range(jobs)]
        start = time.monotonic()
        threads = [threading.Thread(target=work, args=(bench,)) for bench in benches]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    if show:
        print(file=sys.stderr)
    return results


def table(results: dict[Mutant, str], possible: Counter[str], known: Counter[str]) -> str:
    """Write the counts of each file as a Markdown table."""
    lines = [
        "| File | Mutants | Judged | Noticed | Survived | Listed as equivalent | Score |",
        "|---|---|---|---|---|---|---|",
    ]
    total = Counter[str]()
    for path in sorted({m.path for m in results}):
        judged = Counter(
            "survived" if r == "survived" else "noticed"
            for m, r in results.items()
            if m.path == path and r != "does not compile"
        )
        counts = Counter(
            possible=possible[path],
            judged=judged.total(),
            noticed=judged["noticed"],
            survived=judged["survived"],
            known=known[path],
        )
        total.update(counts)
        lines.append(row(Path(path).name, counts))
    return "\n".join([*lines, row("all", total)])


def row(name: str, counts: Counter[str]) -> str:
    """Write a row of the table."""
    score = f"{100 * counts['noticed'] / counts['judged']:.0f} %" if counts["judged"] else "-"
    numbers = [counts[k] for k in ("possible", "judged", "noticed", "survived", "known")]
    return f"| {name} | " + " | ".join(map(str, numbers)) + f" | {score} |"


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "files", nargs="*", type=Path, help="files to change (default: all of src/law and src/equilibrium)"
    )
    parser.add_argument(
        "--samples", type=int, default=0, metavar="N", help="draw N of the mutants (default: all)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default: %(default)s)")
    parser.add_argument("--survivors", action="store_true", help="only those that survived in the run before")
    parser.add_argument(
        "--jobs", type=int, default=int(os.environ.get("JOBS", "2")), help="copies (default: %(default)s)"
    )
    parser.add_argument("--list", action="store_true", help="list the mutants and end")
    options = parser.parse_args()

    files = options.files or [
        p for f in FOLDERS for p in sorted(Path(f).iterdir()) if p.suffix in {".f90", ".inc"}
    ]
    mutants = [m for path in files for m in mutants_of(path)]
    known = equivalents()
    stale = [
        k
        for k in known
        if Path(k[0]) in files and k not in {(m.path, m.before.strip(), m.after.strip()) for m in mutants}
    ]
    for path, before, after in stale:
        print(f"{EQUIVALENT}: {path} has no line '{before}' that becomes '{after}'", file=sys.stderr)
    if stale:
        return 2
    possible = Counter(m.path for m in mutants)
    listed = [m for m in mutants if (m.path, m.before.strip(), m.after.strip()) in known]
    mutants = [m for m in mutants if m not in set(listed)]
    if options.survivors:
        with (WORK / "results.csv").open(newline="", encoding="utf-8") as file:
            again = {
                (r["file"], r["before"], r["after"])
                for r in csv.DictReader(file)
                if r["result"] == "survived"
            }
        mutants = [m for m in mutants if (m.path, m.before.strip(), m.after.strip()) in again]
    mutants = chosen(mutants, options.samples, options.seed)
    if options.list:
        print("\n".join(map(str, mutants)))
        return 0
    results = judge_all(mutants, options.jobs, show=sys.stderr.isatty())
    print(table(results, possible, Counter(m.path for m in listed)))
    survivors = [m for m, r in results.items() if r == "survived"]
    if survivors:
        print("\nSurvivors:\n")
        print("\n".join(map(str, sorted(survivors, key=lambda m: (m.path, m.line)))))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
