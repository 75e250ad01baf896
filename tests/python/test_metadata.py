"""The repository: one version, licence and recipe, no name of a machine, layers of the sources, targets."""

from __future__ import annotations

import csv
import ctypes
import json
import re
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import asperity
import pytest
from asperity.cli import COMMANDS

ROOT = Path(__file__).parents[2]
CONTRACT, LICENCE, CHANGES = "src/law/asperity_contract.f90", "LICENSE", "CHANGELOG.md"
CITATION, ARCHIVE, CODE, FPM = "CITATION.cff", ".zenodo.json", "codemeta.json", "fpm.toml"
RECIPE = "tools/packaging/conda/recipe.yaml"
SPACK = "tools/packaging/spack_repo/asperity/packages/asperity/package.py"
LARGEST_FILE = 2_000_000
"""Limit in bytes: larger than any picture, smaller than a build product or a data set."""
PICTURES = {".png", ".svg"}

# Each entry is (what, pattern). The patterns are assembled here so that this file does not match them.
FOLDERS = "(?:" + "|".join(["home", "root", "tmp", "work", "Users", "mnt"]) + ")"
REGISTRIES = "(?:" + "|".join(["py" + "pi", "pythonhosted", "con" + "da"]) + ")"
FORBIDDEN = {
    "absolute path of one machine": re.compile(r"(?<![\w.$})*~-])/" + FOLDERS + r"/\w"),
    "host of a package registry": re.compile(r"\b" + REGISTRIES + r"\.(?:org|io|com)\b"),
    "unresolved merge": re.compile(r"^(?:<{7}|>{7}) ", re.MULTILINE),
}


def text_of(name: str) -> str:
    """Text of a file of the repository."""
    return (ROOT / name).read_text(encoding="utf-8")


def found_in(name: str, pattern: str) -> list[str]:
    """What the group of a pattern matches in a file, line by line."""
    return re.findall(pattern, text_of(name), re.MULTILINE)


# --- the tree -----------------------------------------------------------------------------------------------


def tracked_files() -> list[Path]:
    """Return the files that git tracks or would track; outside a clone all files but generated ones."""
    command = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        names = subprocess.run(command, capture_output=True, check=True, text=True).stdout.split("\0")
        files = [ROOT / name for name in names if name]
    except (FileNotFoundError, subprocess.CalledProcessError):
        made_by_tools = {"build", ".venv", "__pycache__", ".hypothesis", ".pytest_cache", ".ruff_cache"}
        files = [f for f in ROOT.rglob("*") if not made_by_tools.intersection(f.relative_to(ROOT).parts)]
    return [file for file in files if file.is_file()]


def test_tree_is_small_and_names_no_machine() -> None:
    """No build product, no data set; every file except pictures is text that works on any machine."""
    files = tracked_files()
    assert len(files) > 20
    assert [str(file) for file in files if file.stat().st_size > LARGEST_FILE] == []
    texts = {file: file.read_text(encoding="utf-8") for file in files if file.suffix not in PICTURES}
    for what, pattern in FORBIDDEN.items():
        names = {str(file.relative_to(ROOT)): pattern.findall(text) for file, text in texts.items()}
        assert {name: hits for name, hits in names.items() if hits} == {}, what


# --- version, date, licence, paper --------------------------------------------------------------------------

COPIES = {
    CONTRACT: r'public :: version = "(\d+\.\d+\.\d+)"',
    CITATION: r"^version: (\S+)$",
    ARCHIVE: r'"version": "([^"]*)"',
    CODE: r'"version": "([^"]*)"',
    FPM: r'^version = "([^"]*)"$',
    RECIPE: r"^  version: (\d\S*)$",
    SPACK: r'^    version\("([^"]*)", url=f"file://\{os\.getcwd\(\)\}/asperity-\1\.tar\.gz"\)$',
}
"""The file that defines the version, and those that are read without a build and so have a copy of it."""


@pytest.mark.parametrize("name", COPIES)
def test_copies_of_the_version(name: str) -> None:
    """Each copy is the version of the package."""
    assert found_in(name, COPIES[name]) == [asperity.__version__]


def test_version_of_package_and_library() -> None:
    """Package, its metadata, library and changelog have one version; tests/c compares that of CMake."""
    version = asperity.__version__
    assert metadata.version("asperity") == version == found_in(CHANGES, r"^## (\S+)")[0]
    library, text = ctypes.CDLL(str(asperity.library())), ctypes.create_string_buffer(32)
    assert library.asperity_version(text, len(text)) == len(version) and text.value.decode() == version


def test_dates_of_the_release_are_the_same() -> None:
    """Changelog, citation and archives have one date."""
    dates = found_in(CHANGES, rf"^## {re.escape(asperity.__version__)} \((\d{{4}}-\d\d-\d\d)\)$")
    dates += found_in(CITATION, r"^date-released: (\S+)$")
    dates += [json.loads(text_of(ARCHIVE))["publication_date"], json.loads(text_of(CODE))["datePublished"]]
    assert len(dates) == 4 and len(set(dates)) == 1


def test_licence_is_the_same_everywhere() -> None:
    """LICENSE, pyproject.toml and CITATION.cff name the same licence and the same owner."""
    assert text_of(LICENCE).startswith("BSD 3-Clause License")
    assert "license: BSD-3-Clause" in text_of(CITATION)
    assert all("asperity developers" in text_of(name) for name in (LICENCE, CITATION))
    assert metadata.metadata("asperity")["License-Expression"] == "BSD-3-Clause"


# --- recipes ------------------------------------------------------------------------------------------------


def requirements(lines: list[str]) -> dict[str, str]:
    """Names with their lower bounds."""
    matches = (re.match(r"([\w-]+) ?>=([\d.]+)$", line) for line in lines)
    return {m[1].replace("-base", ""): m[2] for m in matches if m}


def listed(section: str) -> list[str]:
    """Entries of a section of the conda recipe."""
    part = text_of(RECIPE).partition(f"  {section}:\n")[2]
    end = re.search(r"^$|^  \w", part, re.MULTILINE)
    return re.findall(r"^    - (.+)$", part[: end.start()] if end else part, re.MULTILINE)


def test_recipe_has_the_requirements_of_the_package() -> None:
    """The conda recipe asks for the versions that pyproject.toml asks for, those of the toolbox included."""
    lines = metadata.requires("asperity") or []
    wanted = [line.split(";")[0] for line in lines if re.search(r"extra == .tools.$|^[^;]*$", line)]
    python = metadata.metadata("asperity")["Requires-Python"].removeprefix(">=")
    assert requirements(listed("run")) == requirements(wanted) | {"python": python}
    build = json.loads(found_in("pyproject.toml", r"^requires = (\[.*\])$")[0])
    assert requirements(build) and requirements(build).items() <= requirements(listed("host")).items()


def test_spack_package() -> None:
    """Options and compilers of the recipe are those of CMake; its folders are what Spack 1 expects."""
    cmake = text_of("CMakeLists.txt")
    options = re.findall(r'self\.define(?:_from_variant)?\("(\w+)"', text_of(SPACK))
    assert options and all(f"option({name} " in cmake for name in options)
    lowest = re.findall(r"cmake_minimum_required\(VERSION ([\d.]+)\)", cmake)[0]
    top = Path(SPACK).parents[2]
    assert found_in(str(top / "repo.yaml"), r"^  namespace: (\w+)$") == [top.name]
    assert top.parent.name == "spack_repo"
    needed = set(found_in(SPACK, r'^    depends_on\("([^"]+)"'))
    assert needed == {"c", "cxx", "fortran", f"cmake@{lowest}:", "lapack"}


def test_fpm_has_the_sources_of_the_law() -> None:
    """Modules of src/law use modules of src/law only, so that fpm, which takes this folder, can build it."""
    assert 'source-dir = "src/law"' in text_of(FPM)
    assert not [*(ROOT / "src" / "law").glob("*.inc")]
    uses = modules_of("law")
    assert len(uses) > 5 and set().union(*uses.values()) <= set(uses)


def test_equivalent_mutants_are_of_this_source() -> None:
    """Every line of the list of mutants that no test can notice stands in its file."""
    rows = [*csv.DictReader(text_of("tests/equivalent_mutants.csv").splitlines())]
    assert rows and not [row for row in rows if row["before"] not in text_of(row["file"])]


# --- walls between the folders of the Fortran sources -----------------------------------------------------

FOLDERS = {
    "law": set(),
    "point": {"asperity_kinds", "asperity_checks", "asperity_text"},
    "joint": {"law", "point"},
    "adapters": {"law", "point", "joint"},
    "run": {"law", "point", "joint"},
    "umat_host": {"law", "point", "joint", "run"},
}
"""What the modules of a folder of src may use beside each other: folders, or modules by name."""
KNOW_NO_PLANE = [ROOT / "src" / "joint" / "asperity_initial.f90"] + [
    file for file in sorted((ROOT / "src" / "run").glob("*.f90")) if not file.stem.startswith("asperity_case")
]
"""Initial states and runs; readers of case files have constants and planes."""
NAMES_OF_CONSTANTS = {"asperity_initial.f90": {"pattern%n", "material%guard"}}
"""Names of constants in messages, and numbers of planes in the array of a state."""


def modules_of(folder: str) -> dict[str, set[str]]:
    """Module files of a folder of src and what each uses, directly or through files that it includes."""
    uses = {}
    for file in sorted((ROOT / "src" / folder).rglob("*.f90")):
        text = file.read_text(encoding="utf-8")
        for name in re.findall(r'^ *include "(.+)"', text, re.MULTILINE):
            text += "".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob(name))
        uses[file.stem] = set(re.findall(r"^ *use *(asperity_\w+)", re.sub(r"!.*", "", text), re.MULTILINE))
    return uses


@pytest.mark.parametrize("folder", FOLDERS)
def test_walls_between_folders_of_src(folder: str) -> None:
    """A module uses modules of its own folder and of those that stand before it; src/point knows no joint."""
    uses = modules_of(folder)
    assert uses and set().union(*uses.values())
    allowed = set(uses)
    for name in FOLDERS[folder]:
        allowed |= {name} if name.startswith("asperity_") else set(modules_of(name))
    # the build makes these of the law
    allowed |= {f"{name}_single" for name in allowed & set(modules_of("law"))}
    assert set().union(*uses.values()) <= allowed | {"asperity_instruction_set"}


@pytest.mark.parametrize("file", KNOW_NO_PLANE, ids=lambda file: file.stem)
def test_runs_know_no_plane(file: Path) -> None:
    """A module names no other constant of the law than the listed ones, and takes no formula of a plane."""
    text = re.sub(r"!.*", "", file.read_text(encoding="utf-8"))
    assert set(re.findall(r"\b(?:pattern|material)%\w+", text)) <= NAMES_OF_CONSTANTS.get(file.name, set())
    borrowed = re.findall(r"use asperity_(?:pattern|material|point), only: (.*)", text)
    assert set(borrowed) <= {"direction_vector"}


# --- public names -------------------------------------------------------------------------------------------


def statuses(page: str) -> list[str]:
    """Names in the tables of a page that have a status."""
    rows = found_in(page, r"^\| (`.*`(?:\(.*?\))?) \| (?:stable|experimental) \|")
    return [re.sub(r"\(.*", "", name) for row in rows for name in re.findall(r"`([^`]+)`", row)]


def test_each_public_name_has_one_status() -> None:
    """Names of Python, commands and functions of the headers; no other name has one."""
    functions = [
        name
        for header in ("src/asperity.h", "src/asperity_run.h")
        for name in found_in(header, r"^(?:int|void|double|asperity_\w+ \*)\s?\**(\w+)\(")
    ]
    assert len(functions) > 20 and sorted(statuses("docs/reference/c.md")) == sorted(functions)
    names = statuses("docs/reference/status.md")
    commands = [name for name in names if name in COMMANDS]
    assert sorted(commands) == sorted(COMMANDS)
    rest = [name for name in names if name not in COMMANDS]
    assert sorted(rest) == sorted(asperity.__all__)


# --- targets that CONTRIBUTING.md names ---------------------------------------------------------------------

in_a_clone = pytest.mark.skipif(
    not (ROOT / ".git").exists() or not shutil.which("make"), reason="sdist, or no make"
)


def run(*command: str | Path) -> str:
    """Output of a command in the top folder, which must not fail."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@in_a_clone
@pytest.mark.long
def test_mutants() -> None:
    """A changed line of the law is compiled, and a suite notices it."""
    arguments = ["--samples", "1", "--jobs", "1", "--suite", "test_rie_law", "src/law/asperity_law.f90"]
    table = run(sys.executable, "tools/mutants.py", *arguments).splitlines()
    assert re.fullmatch(r"\| `src/law` \| \d+ \| 1 \| 0 \| 1 \| 0 \|", table[-1])


@in_a_clone
@pytest.mark.slow
def test_release() -> None:
    """The sdist is made from a clone; it has what builds the package, its tests and the files for Abaqus."""
    listed = Path(run("tools/release.sh", "--dry").splitlines()[-1]).read_text(encoding="utf-8").splitlines()
    files = {name.partition("/")[2] for name in listed}
    needed = "CMakeLists.txt pyproject.toml LICENSE src harness python tests docs/how-to".split()
    committed = run("git", "ls-tree", "-r", "--name-only", "HEAD", *needed).splitlines()
    assert len(committed) > 100 and set(committed) <= files
