"""Modules of library and package have a test file of their name, or stand in a table with what tests them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


USE = re.compile(r"^\s*use asperity_(\w+)", re.MULTILINE)

WITHOUT_SUITE = {
    "tests/law/test_kinds.pf: interfaces, points and blocks of every kind, with all parts of the kernels": (
        "axes block_double block_kernel block_setup block_single chunk contact energy interface kernels "
        "phases plane_setup plane_sums point point_kernel tangent types wear width"
    ),
    "tests/law/test_contract.pf: constants, their checks and messages": "checks material",
    "tests/law/test_options.pf: arrays of points, what calls refuse": "arrays call_checks",
    "tests/python/test_compressive_strength.py: closed forms, through Python": "cap crushing yielding_rows",
    "tests/python/test_aim.py: what updates with an aim call": "rows_kernel",
    "tests/c/test_c_api.c: functions with names of C": "c c_text instruction_set",
    "tests/c/test_run_api.c: functions with names of C": "run_c json",
    "tests/python/test_case_files.py: parts of the reader, which errors of files name": (
        "case_entries case_groups case_material case_text rows separators"
    ),
    "tests/point/test_acceptance.pf: laws of given numbers, their equations": "equations point_law",
    "tests/point/test_increment.pf: parts of asperity_increment": "equilibrium_path newton tolerances",
    "tests/point/test_branch.pf: parts of asperity_branch": "branch_step null_space",
    "tests/run/test_stability.pf: LAPACK as its judge": "elimination",
    "tests/adapters/test_umat.pf: what UMATs and VUMATs share": "host report",
    "tests/python/test_umat_checks.py: the child of a UMAT, through the driver": (
        "case_umat foreign_umat umat_run umat_stiffness umat_utilities umat_walk umat_worker"
    ),
    "tests/c/test_generic.c: the program that writes its symbols": "write_symbols",
}
"""Modules without a test file of their name, by the test that reaches them and what it is about."""


MIRRORED = (
    "mesh", "export", "tools/barton", "tools/explore", "tools/fit", "tools/selection", "tools/surface",
    "tools/uncertainty",
)  # fmt: skip
"""Rooms of the package whose tests have their folder and the names of their modules."""

LISTED = "", "cards", "tools"
"""Rooms whose tests have other names, too."""

ALIKE = "command", "picture", "cells", "joint", "model"
"""Names of modules of several rooms, which stand in the table with their room."""

WITHOUT_FILE = {
    "test_law.py: interfaces, as callers see them": "interface material pattern point_arrays",
    "test_messages.py: what calls refuse, and how": "calls contract errors",
    "test_history.py: load paths and their steps": "load_path steps",
    "test_case_writers.py: cases that Python writes": "case_writer",
    "test_signals.py: the process of the driver, its end": "driver_process",
    "test_any_umat.py: UMATs of others": "foreign",
    "test_cli.py: commands, what is installed, cases to start from": "installed starters",
    "test_cards.py: material blocks of all hosts": "card_command model_checks blocks generic",
    "mesh/test_deck_constants.py: values that are doubtful": "plausible",
    "test_parallel.py: runs side by side": "sweeps slip_curves",
    "test_constants.py: constants of joints with a bond": "tools.joint",
    "tools/test_tables.py: columns, units and workbooks": "tools.cells units workbooks",
    "tools/test_style.py: pictures of rows and patterns": "plots pattern_pictures",
    "mesh/test_split.py: what a split mesh has": "mesh.cells faces jointed shapes",
    "mesh/test_abaqus.py: decks as a whole, which errors name with their lines": (
        "deck_model deck_scopes deck_take deck_types"
    ),
    "mesh/test_deck_elements.py: ties, links, drawn decks": "deck_connections deck_held own_joints",
    "mesh/test_deck_joints.py: decks by doctor, their water": "deck_water doctor",
    "mesh/test_touching.py: numbers of a file in messages": "labels",
    "mesh/test_files.py: files that meshio reads": "others",
    "mesh/test_inp.py: lines and layers of files": "writing",
    "export/test_kits.py: files that the command writes": "export.command element",
    "tools/barton/test_envelope.py: laws of Barton, the command": "tools.barton.command tools.barton.joint",
    "tools/explore/test_page.py: what the page shows, and its server": (
        "tools.explore.command tools.explore.model"
    ),
    "tools/fit/test_fitting.py: the fit of curves as a whole, from the ladder of models to the verdict": (
        "thresholds verdict"
    ),
    "tools/fit/test_closures.py: closure tests and what is said of them": "closure_report closure_test",
    "tools/fit/test_kinds.py: what a fit writes, and its predictions": (
        "tools.fit.command html tools.fit.picture predict prediction report written"
    ),
    "tools/fit/test_strengths.py: tables of strengths": "strength strength_report",
    "tools/selection/test_search.py: selected patterns, the command": "tools.selection.command",
    "tools/uncertainty/test_spread.py: drawn constants, the command, its pictures": (
        "tools.uncertainty.command distribution tools.uncertainty.picture"
    ),
    "tools/surface/test_scan_files.py: scans with holes, grids": "grids holes scan",
    "tools/surface/test_slopes.py: the command, its pictures": "tools.surface.command tools.surface.picture",
}
"""Modules of the mirrored rooms without a test file of their name, by the file that tests them, and what."""


def modules() -> dict[str, str]:
    """Source of each module and procedure of the library by the name of its file, without asperity_.

    Files of one name, such as those of src/dispatch and of src/law, count as one.
    """
    sources: dict[str, str] = {}
    for file in sorted((ROOT / "src").rglob("*.f90")):
        name = file.stem.removeprefix("asperity_")
        sources[name] = sources.get(name, "") + file.read_text(encoding="utf-8")
    return sources


def test_modules_have_suites() -> None:
    """asperity_y has a test_y, a suite of its room, in C or Python, or stands in the table; none in vain."""
    files = [path for path in (ROOT / "tests").rglob("test_*") if path.suffix in {".pf", ".c", ".py"}]
    listed = " ".join(WITHOUT_SUITE.values()).split()
    # tools have modules of these names, too, which are none of the library
    names = {path.stem.removeprefix("test_") for path in files if "tools" not in path.parts}
    missing = modules().keys() - names
    assert sorted(missing - {*listed}) == [], "expected a test file, or a place in WITHOUT_SUITE"
    assert sorted({*listed} - missing) == []
    assert len(listed) == len({*listed})


@pytest.mark.parametrize("reason", WITHOUT_SUITE)
def test_reasons(reason: str) -> None:
    """The test of a reason is there; a suite reaches the modules through those that it uses."""
    path = ROOT / reason.partition(":")[0]
    assert path.is_file()
    if path.parent.name not in ("law", "point"):
        return  # procedures outside modules, and programs
    sources, reached = modules(), set[str]()
    new = set(USE.findall(path.read_text(encoding="utf-8")))
    while new:
        reached |= new
        new = {name for text in new for name in USE.findall(sources.get(text, ""))} - reached
    assert {*WITHOUT_SUITE[reason].split()} - reached == set()


def test_mirrored_rooms() -> None:
    """A module x.py has a test_x.py or stands in the table; in MIRRORED each test_x.py has a module x.py."""
    listed = " ".join(WITHOUT_FILE.values()).split()
    missing = []
    for room in (*MIRRORED, *LISTED):
        tests = {path.stem.removeprefix("test_") for path in (ROOT / "tests/python" / room).glob("test_*.py")}
        names = {path.stem for path in (ROOT / "python/asperity" / room).glob("[!_]*.py")}
        assert room in LISTED or sorted(tests - names) == []
        prefix = room.replace("/", ".")
        missing += [f"{prefix}.{name}" if name in ALIKE else name for name in names - tests]
    assert sorted({*missing} - {*listed}) == [], "expected a test file, or a place in WITHOUT_FILE"
    assert sorted({*listed} - {*missing}) == []
    for reason in WITHOUT_FILE:
        assert (ROOT / "tests/python" / reason.partition(":")[0]).is_file()


def imported() -> Iterator[str]:
    """Names that test files import from the package, with their modules."""
    for folder in ("tests/python", "harness"):
        for path in (ROOT / folder).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            for module, names in re.findall(
                r"^\s*from (asperity[\w.]*) import (\([^)]*\)|.*)$", text, re.MULTILINE
            ):
                yield from (f"{module}.{name}" for name in re.findall(r"\w+", names))
            yield from re.findall(r"^\s*import (asperity[\w.]*)", text, re.MULTILINE)


def test_rooms_have_tests() -> None:
    """Each folder of the package, as asperity.mesh, has a test file that imports something of it."""
    folders = [path.parent for path in (ROOT / "python" / "asperity").rglob("__init__.py")]
    rooms = {".".join(folder.relative_to(ROOT / "python").parts) for folder in folders}
    names = {f"{name}." for name in imported()}
    assert len(rooms) > 10
    assert sorted(room for room in rooms if not any(name.startswith(f"{room}.") for name in names)) == []
