"""Tests of the configuration: modules that cmake/FortranUnit.cmake merges, and the folder of the build."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = {
    "kernels": "module asperity_kernels\n  use asperity_kinds, only: wp\n"
    "  use asperity_contract, only: version\n  implicit none\n  private\n  public :: one\n"
    "\ncontains\n\n  pure function one()\n    real(wp) :: one\n"
    "    one = 1.0_wp\n  end function one\n\nend module asperity_kernels\n",
    "point_kernel": "module asperity_point_kernel\n  use asperity_kernels, only: one\n"
    "  use asperity_kinds, only: wp\n  use asperity_width, only: vector_width\n  implicit none\n  private\n"
    "  public :: two\n\ncontains\n\n  pure function two()\n    real(wp) :: two\n"
    "    two = vector_width*one()\n  end function two\n\nend module asperity_point_kernel\n",
}
PROJECT = f"""cmake_minimum_required(VERSION 3.22)
project(unit LANGUAGES NONE)
{{before}}
include({ROOT / "cmake" / "FortranUnit.cmake"})
asperity_unit(made FROM ${{{{PROJECT_SOURCE_DIR}}}}/law PARTS kernels point_kernel {{options}})
"""


def configure(source: Path, build: Path) -> subprocess.CompletedProcess[str]:
    """Configure a project."""
    return subprocess.run(["cmake", "-S", source, "-B", build], capture_output=True, text=True, check=False)


def merged(folder: Path, options: str = "", before: str = "", changed: dict[str, str] | None = None) -> str:
    """Text of the merged module of PARTS, some of their lines changed; RuntimeError: messages of CMake."""
    (folder / "law").mkdir(parents=True)
    for part, text in PARTS.items():
        for line, replacement in (changed or {}).items():
            text = text.replace(line, replacement)
        (folder / "law" / f"asperity_{part}.f90").write_text(text)
    (folder / "CMakeLists.txt").write_text(PROJECT.format(options=options, before=before))
    done = configure(folder, folder / "build")
    if done.returncode:
        raise RuntimeError(" ".join(done.stderr.split()))
    (made,) = (folder / "build").rglob("asperity_*.f90")
    return made.read_text().replace(str(folder), "")


def test_variables_of_the_caller(tmp_path: Path) -> None:
    """A project may have variables with the names of those of asperity_unit."""
    names = (
        "uses",
        "declarations",
        "procedures",
        "text",
        "name",
        "line",
        "lines",
        "part",
        "merged",
        "statements",
    )
    before = "\n".join(f'set({name} "of the caller")' for name in names)
    assert merged(tmp_path / "a", before=before) == merged(tmp_path / "b")


def test_names_of_kinds_and_widths(tmp_path: Path) -> None:
    """A level and single precision take other names of the same modules, in each part."""
    text = merged(tmp_path, "LEVEL v3 SINGLE")
    assert text.startswith("module asperity_point_kernel_v3\n")
    head = text.partition("implicit none")[0]
    assert head.count("\n  use asperity_kinds, only: wp => sp\n") == len(PARTS)
    assert head.count("\n  use asperity_width, only: vector_width => vector_width_v3\n") == 1


@pytest.mark.parametrize(
    ("options", "line", "replacement"),
    [
        ("SINGLE", "use asperity_kinds, only: wp", "use asperity_kinds, only: sp, wp"),
        ("SINGLE", "use asperity_kinds, only: wp", "use asperity_kinds, only: wp, dp"),
        ("SINGLE", "use asperity_kinds, only: wp", "use asperity_kinds"),
        (
            "LEVEL v1",
            "use asperity_width, only: vector_width",
            "use asperity_width, only: vector_width, other",
        ),
    ],
)
def test_use_of_another_form(tmp_path: Path, options: str, line: str, replacement: str) -> None:
    """A line that cannot be renamed is refused, not merged with the kind or the width of another kernel."""
    with pytest.raises(RuntimeError) as refused:
        merged(tmp_path, options, changed={line: replacement})
    assert replacement in str(refused.value)
    assert f"expected `{line}`" in str(refused.value)


def test_build_in_the_folder_of_the_sources(tmp_path: Path) -> None:
    """It is refused before a source is written, by a link to the folder, too."""
    for folder in ("src", "cmake"):
        shutil.copytree(ROOT / folder, tmp_path / "asperity" / folder)
    shutil.copy(ROOT / "CMakeLists.txt", tmp_path / "asperity")
    (tmp_path / "link").symlink_to("asperity")
    before = {path: path.read_bytes() for path in (tmp_path / "asperity" / "src").rglob("*.*")}
    for build in ("asperity", "link"):
        done = configure(tmp_path / "asperity", tmp_path / build)
        assert done.returncode != 0
        assert "expected a folder of its own" in " ".join(done.stderr.split())
    assert {path: path.read_bytes() for path in (tmp_path / "asperity" / "src").rglob("*.*")} == before
