#!/usr/bin/env python3
"""Mutation test: change one operator, constant or name of src/law or src/adapters; a test must notice.

Each mutant is compiled without optimisation in a copy of the project, and the tests of CTest run until one
fails. A mutant that no test notices is a survivor and is printed at once. tests/equivalent_mutants.csv lists
mutants that compute the same as the unchanged line, each with its reason: they are left out. The status is 1
if a mutant survives, and 2 if that list has a line that is not in the source. With --suite only that suite is
built and run, which tries the program itself in a short time. Run from the top folder.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

FOLDERS = [Path("src/law"), Path("src/adapters")]
OUTCOMES = ("does not compile", "survived")
EQUIVALENT = Path("tests/equivalent_mutants.csv")
WORK = Path("build/mutants")
COPIED = ["CMakeLists.txt", "pyproject.toml", "cmake", "src", "harness", "tests"]
# They repeat the same calls on many threads, compile another project, or judge the solver for long.
LEFT_OUT = {"test_package", "threads", "test_solver_soak", "test_slips_across", "test_branch_soak"}
# of the random calls of each routine, which notice few mutants that nothing else notices
CALLS = "400"
# A test that takes so many times its usual time, and at least so many seconds, has noticed the mutant.
PATIENCE, LEAST_PATIENCE = 10.0, 5.0
# of CMake
OPTIONS = [
    f"-DPython3_EXECUTABLE={sys.executable}",
    "-DCMAKE_BUILD_TYPE=None",
    "-DCMAKE_Fortran_FLAGS=-O1 -fcheck=bounds -ffree-line-length-none",
    "-DCMAKE_DISABLE_FIND_PACKAGE_PFUNIT=ON",
    "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON",
    "-DASPERITY_DISPATCH=OFF",
]

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
# what follows is asked for its kind only, so that another value is the same
KIND_ONLY = re.compile(r"\b(huge|tiny|digits|epsilon|kind)\($")
# lines without anything to change: declarations (not real constants), headings, what is written for people
PASSED_OVER = re.compile(
    r"^\s*(!|use\b|implicit\b|private\b|public\b|import\b|include\b|end\b|contains\b|module\b|submodule\b|"
    r"(pure |elemental |impure |recursive )*(function|subroutine)\b|interface\b|type\b|integer\b|"
    r"real\b(?!.*\bparameter\b)|"
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

    @property
    def key(self) -> tuple[str, str, str]:
        """The file and the change, as in the list of equivalent mutants."""
        return self.path, self.before.strip(), self.after.strip()

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
    mutants: list[Mutant] = []
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
                if in_text(code, match.start()) or KIND_ONLY.search(code[: match.start()]):
                    continue
                if text == SWAP_ARGUMENTS:
                    after = swapped(code, match.start())
                elif text == ADD_ONE:
                    after = f"{code[: match.start()]}{int(match[1]) + 1}{code[match.end() :]}"
                else:
                    after = code[: match.start()] + match.expand(text) + code[match.end() :]
                if after and after != code:
                    mutants.append(Mutant(str(path), number, code, after))
    return mutants


class Bench:
    """A copy of the project in which one mutant at a time is compiled and tested.

    The programs of the tests are linked with one shared library, made of the objects of all libraries. For a
    mutant its file is compiled and this library is linked, not the programs.
    """

    def __init__(self, folder: Path, suite: str | None) -> None:
        """Copy, configure and build the project, link the programs again and measure the tests' times.

        suite: the only one, None: all.
        """
        self.folder = folder.resolve()
        self.build = self.folder / "build"
        self.library = self.build / "libmutant.so"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for name in COPIED:
            (shutil.copytree if Path(name).is_dir() else shutil.copy2)(name, self.folder / name)
        self.run("cmake", "-S", self.folder, "-B", self.build, "-G", "Ninja", *OPTIONS)
        targets = ["--target", suite] if suite else []
        self.run("cmake", "--build", self.build, "--parallel", "1", *targets)
        listed = json.loads(self.run("ctest", "--test-dir", self.build, "--show-only=json-v1"))
        tests = {t["name"]: t for t in listed["tests"]}
        self.tests = {suite: tests[suite]} if suite else {n: t for n, t in tests.items() if n not in LEFT_OUT}
        self.modules = {name: self.linked_modules(name) for name in self.tests}
        self.commands = {
            Path(entry["file"]): (entry["command"], self.build / entry["command"].split(" -o ")[1].split()[0])
            for entry in json.loads((self.build / "compile_commands.json").read_text(encoding="utf-8"))
            if re.search(r"/asperity_(static|solver)\.dir/", entry["command"])
            and (self.build / entry["command"].split(" -o ")[1].split()[0]).exists()
        }
        self.link()
        self.relink_programs(*[suite] if suite else [])
        self.times = dict.fromkeys(self.tests, 300.0)
        for name in self.tests:
            start = time.monotonic()
            if not self.passes(name):
                sys.exit(f"{name} fails without any change")
            self.times[name] = time.monotonic() - start
        self.kills: Counter[tuple[str, str]] = Counter()
        print(f"{len(self.tests)} tests take {sum(self.times.values()):.0f} s", file=sys.stderr, flush=True)

    def run(self, *command: str | Path) -> str:
        """Run a command that must not fail, and return its output."""
        ran = subprocess.run(command, check=False, capture_output=True, text=True)
        if ran.returncode:
            sys.exit(f"{' '.join(map(str, command[:3]))} ...: {ran.stdout}{ran.stderr}")
        return ran.stdout

    def linked_modules(self, name: str) -> set[str] | None:
        """Return the modules that are part of the program of a test; None if it runs something else."""
        program = Path(self.tests[name]["command"][0])
        if self.build not in program.parents or "libasperity.so" in self.run("ldd", program):
            return None
        return set(re.findall(r"__(asperity_\w+?)_MOD_", self.run("nm", program)))

    def link(self) -> None:
        """Link the shared library of all objects."""
        name = f"-Wl,-soname,{self.library}"
        objects = [o for _, o in self.commands.values()]
        self.run("gfortran", "-shared", "-fopenmp", name, "-o", self.library, *objects)

    def relink_programs(self, *targets: str) -> None:
        """Link programs (default: all) with the shared library of all objects, not the project's ones."""
        libraries = re.compile(r"\S*/libasperity(_static|_solver)?\.(a|so[\d.]*)(?=\s)")
        for command in self.run("ninja", "-C", self.build, "-t", "commands", *targets).splitlines():
            changed = libraries.sub(str(self.library), command)
            if changed != command and " -shared " not in command and " -o " in command:
                subprocess.run(changed, shell=True, check=True, cwd=self.build)

    def passes(self, name: str) -> bool:
        """Run a test; a test that takes far too long does not pass."""
        properties = {p["name"]: p["value"] for p in self.tests[name]["properties"]}
        environment = dict(e.split("=", 1) for e in properties.get("ENVIRONMENT", []))
        own = {"ASPERITY_LIBRARY": str(self.library), "ASPERITY_CALLS": CALLS}
        command = self.tests[name]["command"]
        try:
            ran = subprocess.run(
                command + (["-x"] if "pytest" in command else []),
                cwd=properties.get("WORKING_DIRECTORY", self.build),
                env={**os.environ, **environment, **own},
                check=False,
                timeout=max(LEAST_PATIENCE, PATIENCE * self.times[name]),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired:
            return False
        return ran.returncode == 0

    def sources_of(self, path: Path) -> list[Path]:
        """Return the compiled files of which a file is a part, by a mark, and the file itself."""
        part = re.compile(rf'^# \d+ "{re.escape(str(path))}"', re.MULTILINE)
        return [f for f in self.commands if f == path or part.search(f.read_text(encoding="utf-8"))]

    def changed_text(self, file: Path, path: Path, mutant: Mutant) -> str:
        """Return the text of a file with the changed line of a path; lines of merged files have marks."""
        here, number, lines = file == path, 0, []
        for line in file.read_text(encoding="utf-8").splitlines(keepends=True):
            number += 1
            if mark := re.match(r'# (\d+) "(.+)"', line):
                here, number = mark[2] == str(path), int(mark[1]) - 1
            lines.append(mutant.after + "\n" if here and number == mutant.line and not mark else line)
        return "".join(lines)

    def users_of(self, path: Path) -> list[Path]:
        """Return the compiled files that use a file's module: its constants are part of their code."""
        using = re.compile(rf"^ *use {path.stem}\b", re.MULTILINE)
        return [f for f in self.commands if f != path and using.search(f.read_text(encoding="utf-8"))]

    def interfaces_of(self, modules: set[str]) -> list[Path]:
        """Return the files that the compiler writes for other files to use these modules."""
        return [f for m in modules for f in self.build.rglob(f"{m}.mod")]

    def judge(self, mutant: Mutant) -> str:
        """Return the test that notices a mutant, 'does not compile', or 'survived'."""
        path = self.folder / mutant.path
        text = path.read_text(encoding="utf-8")
        sources = self.sources_of(path)
        texts = {file: file.read_bytes() for file in {path, *sources}}
        declared = text[: text.index("\ncontains")] if "\ncontains" in text else text
        if "parameter" in mutant.before and mutant.before in declared:
            sources += [user for source in sources for user in self.users_of(source)]
        changed = {s.stem for s in sources}
        kept = {
            f: f.read_bytes() for f in [self.commands[s][1] for s in sources] + self.interfaces_of(changed)
        }
        for file in texts:
            file.write_text(self.changed_text(file, path, mutant), encoding="utf-8")
        try:
            for source in sources:
                command = shlex.split(self.commands[source][0])
                if subprocess.run(command, check=False, cwd=self.build, capture_output=True).returncode:
                    return "does not compile"
            self.link()
            # a host's user routine is in no module
            external = not any(modules and modules & changed for modules in self.modules.values())
            # first what has noticed many mutants of this file in little time
            for name in sorted(self.tests, key=lambda n: self.times[n] / (1 + self.kills[mutant.path, n])):
                modules = self.modules[name]
                if (modules is None or modules & changed or external) and not self.passes(name):
                    self.kills[mutant.path, name] += 1
                    return name
            return "survived"
        finally:
            for file, content in (texts | kept).items():
                file.write_bytes(content)


def is_in(mutant: Mutant, folder: str) -> bool:
    """Return whether a mutant's file is in a folder."""
    return str(Path(mutant.path).parent) == folder


def equivalents() -> set[tuple[str, str, str]]:
    """Read the list of mutants that no test can notice: file, line, changed line."""
    with EQUIVALENT.open(newline="", encoding="utf-8") as file:
        return {(r["file"], r["before"], r["after"]) for r in csv.DictReader(file)}


def judge_all(mutants: list[Mutant], jobs: int, suite: str | None) -> dict[Mutant, str]:
    """Judge the mutants in `jobs` copies of the project, and print the survivors as they come."""
    waiting = iter(mutants)
    results: dict[Mutant, str] = {}
    lock = threading.Lock()

    def work(bench: Bench) -> None:
        while True:
            with lock:
                mutant = next(waiting, None)
            if mutant is None:
                return
            results[mutant] = bench.judge(mutant)
            if results[mutant] == "survived":
                print(mutant, flush=True)
            print(f"{len(results)} of {len(mutants)} judged: {results[mutant]}", file=sys.stderr, flush=True)

    benches = [Bench(WORK / str(i), suite) for i in range(jobs)]
    threads = [threading.Thread(target=work, args=(bench,)) for bench in benches]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="files to change (default: all)")
    parser.add_argument("--samples", type=int, default=0, metavar="N", help="draw N mutants (default: all)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default: %(default)s)")
    parser.add_argument(
        "--jobs", type=int, default=int(os.environ.get("JOBS", "2")), help="copies of the project"
    )
    parser.add_argument("--suite", help="the only suite that is built and run (default: all tests)")
    options = parser.parse_args()

    files = options.files or [p for f in FOLDERS for p in sorted(f.iterdir()) if p.suffix == ".f90"]
    mutants = [m for path in files for m in mutants_of(path)]
    known = {k for k in equivalents() if Path(k[0]) in files}
    stale = known - {m.key for m in mutants}
    for path, before, after in stale:
        print(f"{EQUIVALENT}: {path} has no line '{before}' that becomes '{after}'", file=sys.stderr)
    if stale:
        return 2
    judged = [m for m in mutants if m.key not in known]
    judged = random.Random(options.seed).sample(judged, min(options.samples or len(judged), len(judged)))
    results = judge_all(judged, options.jobs, options.suite)
    print("| folder | mutants | judged | not compiled | noticed | survived |\n|---|--:|--:|--:|--:|--:|")
    for folder in sorted({str(Path(m.path).parent) for m in mutants}):
        counts = Counter(r if r in OUTCOMES else "noticed" for m, r in results.items() if is_in(m, folder))
        numbers = [sum(is_in(m, folder) for m in mutants), counts.total()]
        numbers += [counts[outcome] for outcome in (OUTCOMES[0], "noticed", OUTCOMES[1])]
        print(f"| `{folder}` | " + " | ".join(map(str, numbers)) + " |")
    return 1 if "survived" in results.values() else 0


if __name__ == "__main__":
    sys.exit(main())
