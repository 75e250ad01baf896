"""Recipes and metadata for package managers and archives agree with the package and with CMake."""

from __future__ import annotations

import json
import re
import runpy
import sys
import types
from importlib import metadata
from pathlib import Path
from typing import Any

import asperity
import pytest

ROOT = Path(__file__).parents[2]
RECIPE = ROOT / "tools" / "packaging" / "conda" / "recipe.yaml"
SPACK = ROOT / "tools" / "packaging" / "spack" / "packages" / "asperity" / "package.py"


def text_of(name: str) -> str:
    """Text of a file of the repository."""
    return (ROOT / name).read_text(encoding="utf-8")


COPIES = {
    "CITATION.cff": r"^version: (\S+)$",
    ".zenodo.json": r'"version": "([^"]*)"',
    "codemeta.json": r'"version": "([^"]*)"',
    "fpm.toml": r'^version = "([^"]*)"$',
    "tools/packaging/conda/recipe.yaml": r"^  version: (\d\S*)$",
    "tools/packaging/spack/packages/asperity/package.py": r'^    version\("([^"]*)"\)$',
}
"""Files that are read without a build and so have a copy of the version."""


@pytest.mark.parametrize("name", COPIES)
def test_copies_of_the_version(name: str) -> None:
    """Each copy is the version of the library, which CMake and pyproject.toml read from its source."""
    assert re.findall(COPIES[name], text_of(name), re.MULTILINE) == [asperity.__version__]


def test_dates_of_the_release_are_the_same() -> None:
    """Changelog, citation and archives have one date."""
    heading = rf"^## {re.escape(asperity.__version__)} \((\d{{4}}-\d\d-\d\d)\)$"
    dates = re.findall(heading, text_of("CHANGELOG.md"), re.MULTILINE)
    dates += re.findall(r"^date-released: (\S+)$", text_of("CITATION.cff"), re.MULTILINE)
    dates.append(json.loads(text_of(".zenodo.json"))["publication_date"])
    dates.append(json.loads(text_of("codemeta.json"))["datePublished"])
    assert len(dates) == 4 and len(set(dates)) == 1


def test_the_paper_is_the_same_everywhere() -> None:
    """Citation, archives and the pages name the paper by the same title, year and authors."""
    citation = " ".join(text_of("CITATION.cff").split())
    article = json.loads(text_of("codemeta.json"))["referencePublication"]
    (reference,) = json.loads(text_of(".zenodo.json"))["references"]
    assert article["name"] in citation and article["name"] in reference
    assert article["name"] in " ".join(text_of("README.md").split())
    assert f"year: {article['datePublished']}" in citation and article["datePublished"] in reference
    names = [author["familyName"] for author in article["author"]]
    assert re.findall(r"family-names: (\w+)", citation) == names
    assert re.findall(r"(\w+)[,:]", reference.partition(": A 3D")[0] + ":") == names


def requirements(lines: list[str]) -> dict[str, str]:
    """Names with their lower bounds."""
    found = (re.match(r"([\w-]+) ?>=([\d.]+)$", line) for line in lines)
    return {m[1].replace("-base", ""): m[2] for m in found if m}


def test_recipe_has_the_requirements_of_the_package() -> None:
    """The conda recipe asks for the versions that pyproject.toml asks for."""
    wanted = [line for line in metadata.requires("asperity") or [] if "extra" not in line]
    recipe = text_of("tools/packaging/conda/recipe.yaml")
    run = re.findall(r"^    - (.+)$", recipe.partition("  run:\n")[2].partition("\n\n")[0], re.MULTILINE)
    python = metadata.metadata("asperity")["Requires-Python"].removeprefix(">=")
    assert requirements(run) == requirements(wanted) | {"python": python}
    build = json.loads(re.findall(r"^requires = (\[.*\])$", text_of("pyproject.toml"), re.MULTILINE)[0])
    host = re.findall(r"^    - (.+)$", recipe.partition("  host:\n")[2].partition("  run:")[0], re.MULTILINE)
    assert requirements(build).items() <= requirements(host).items()
    assert (RECIPE.parent / "../../..").resolve() == ROOT


class Recorded:
    """What a Spack package declares."""

    def __init__(self) -> None:
        """Nothing yet."""
        self.calls: list[tuple[str, tuple[Any, ...]]] = []

    def directive(self, name: str) -> Any:
        """Return a function that records its arguments."""
        return lambda *arguments, **_: self.calls.append((name, arguments))


class CMakePackage:
    """The part of Spack's class that the package uses."""

    def define(self, name: str, value: object) -> str:
        """Option with a value."""
        return f"-D{name}={value}"

    def define_from_variant(self, name: str, variant: str) -> str:
        """Option with the value of a variant."""
        return f"-D{name}={variant}"


def test_spack_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """With stand-ins for Spack's modules the package loads; options and compilers are those of CMake."""
    recorded = Recorded()
    package = types.ModuleType("spack.package")
    for name in ("depends_on", "license", "variant", "version"):
        setattr(package, name, recorded.directive(name))
    build = types.ModuleType("spack_repo.builtin.build_systems.cmake")
    build.CMakePackage = CMakePackage  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, package.__name__, package)
    monkeypatch.setitem(sys.modules, build.__name__, build)
    asperity_package = runpy.run_path(str(SPACK))["Asperity"]()
    cmake = text_of("CMakeLists.txt")
    options = [re.match(r"-D(\w+)=", argument) for argument in asperity_package.cmake_args()]
    assert options and all(m and f"option({m[1]} " in cmake for m in options)
    needed = {arguments[0] for name, arguments in recorded.calls if name == "depends_on"}
    lowest = re.findall(r"cmake_minimum_required\(VERSION ([\d.]+)\)", cmake)[0]
    assert needed == {"c", "cxx", "fortran", f"cmake@{lowest}:"}
    assert asperity_package.url_for_version("1.2.3") == "file:asperity-1.2.3.tar.gz"


def test_fpm_has_the_sources_of_the_law() -> None:
    """Modules of src/law use modules of src/law only, so that fpm, which takes this folder, can build it."""
    assert 'source-dir = "src/law"' in text_of("fpm.toml")
    files = sorted((ROOT / "src" / "law").rglob("*.f90"))
    names = {file.stem for file in files}
    text = "\n".join(file.read_text(encoding="utf-8") for file in files)
    used = set(re.findall(r"^ *use (asperity_\w+)", text, re.MULTILINE))
    assert len(names) == len(files) > 5 and used <= names
