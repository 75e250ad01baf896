"""Tests of the metadata: the version is the same everywhere, and no file refers to one machine."""

from __future__ import annotations

import ctypes
import re
import subprocess
from importlib import metadata
from pathlib import Path

import asperity
import pytest

ROOT = Path(__file__).parents[2]
# This file defines the version.
OWNER = ROOT / "src" / "law" / "asperity_contract.f90"
LARGEST_FILE = 2_000_000
"""Limit in bytes: larger than any picture, smaller than a build product or a data set."""
PICTURES = {".png", ".svg"}

# Each entry is (what, pattern). The patterns are assembled here so that this file does not match them.
FOLDERS = "(?:" + "|".join(["home", "root", "tmp", "work", "Users", "mnt"]) + ")"
REGISTRIES = "(?:" + "|".join(["py" + "pi", "pythonhosted", "con" + "da"]) + ")"
FORBIDDEN = [
    ("absolute path of one machine", re.compile(r"(?<![\w.$})*~-])/" + FOLDERS + r"/\w")),
    ("host of a package registry", re.compile(r"\b" + REGISTRIES + r"\.(?:org|io|com)\b")),
    ("unresolved merge", re.compile(r"^(?:<{7}|>{7}) ", re.MULTILINE)),
]


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


@pytest.fixture(scope="module")
def version() -> str:
    """Return the version in the file that defines it."""
    found = re.findall(r'public :: version = "(\d+\.\d+\.\d+)"', OWNER.read_text(encoding="utf-8"))
    assert len(found) == 1
    return found[0]


def test_changelog_starts_with_the_version(version: str) -> None:
    """The newest entry of the changelog is the version of the source."""
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (\S+)", changelog, re.MULTILINE)[0] == version


def test_package_has_the_version(version: str) -> None:
    """pyproject.toml reads the version from the source, the package from the library it was built with."""
    assert metadata.version("asperity") == version
    assert asperity.__version__ == version


def test_library_has_the_version(version: str) -> None:
    """asperity_version of asperity.h returns the version; tests/c compares the one of CMake with it."""
    library = ctypes.CDLL(str(asperity.library()))
    text = ctypes.create_string_buffer(32)
    assert library.asperity_version(text, len(text)) == len(version)
    assert text.value.decode() == version


def test_licence_is_the_same_everywhere() -> None:
    """LICENSE, pyproject.toml and CITATION.cff name the same licence and the same owner."""
    licence, citation = ((ROOT / name).read_text(encoding="utf-8") for name in ("LICENSE", "CITATION.cff"))
    assert licence.startswith("BSD 3-Clause License") and "asperity developers" in licence
    assert "license: BSD-3-Clause" in citation and "asperity developers" in citation
    assert metadata.metadata("asperity")["License-Expression"] == "BSD-3-Clause"


def test_tree_is_small() -> None:
    """Git tracks no build product and no data set."""
    files = tracked_files()
    assert len(files) > 20
    assert [str(file) for file in files if file.stat().st_size > LARGEST_FILE] == []


@pytest.mark.parametrize(("what", "pattern"), FORBIDDEN, ids=[what for what, _ in FORBIDDEN])
def test_tree_names_no_machine(what: str, pattern: re.Pattern[str]) -> None:
    """Every file except pictures is text and contains nothing that works on one machine only."""
    hits = []
    for file in tracked_files():
        if file.suffix not in PICTURES:
            text = file.read_text(encoding="utf-8")
            hits += [f"{file.relative_to(ROOT)}: {m.group()}" for m in pattern.finditer(text)]
    assert hits == [], what
