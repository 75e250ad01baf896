"""Host programs: each is a folder with host.toml, and what it has of card.py, mesh.py, export.py and a kit.

The folders lie in harness/hosts and are installed beside this file.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import import_module
from math import inf
from pathlib import Path
from types import ModuleType
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Card", "Host", "Kit", "Mesh", "folder", "hosts", "of", "part"]


@dataclass(frozen=True)
class Card:
    """Table `card`: what the material block of a host, which card.py writes, can take."""

    listed: bool = False
    """Whether the host takes listed planes, m < 0."""
    explicit: bool = False
    """Whether the block may be for explicit dynamics, with a density."""
    contact: bool = False
    """Whether the block may be for surfaces in contact, instead of elements."""
    path: bool = False
    """Whether the load path of the case follows the block."""
    only: Mapping[str, float | list[float]] = field(default_factory=dict)
    """Constants, and the dimension, of which the host takes one value only, or one of a list."""
    water: str = ""
    """How a host whose law gets no water pressure carries it."""


@dataclass(frozen=True)
class Kit:
    """Table `kit`: the model of one joint element that `asperity export` writes."""

    options: Mapping[str, Any] = field(default_factory=dict)
    """Arguments of the material block."""
    card: str = ""
    """File that is the material block alone."""
    template: str = ""
    """File with places for the path, and for the block where it has no file of its own."""
    files: tuple[str, ...] = ()
    """Further files, as they are."""


@dataclass(frozen=True)
class Mesh:
    """Table `mesh`: how mesh.py, or the module of the ending, writes a mesh with joints."""

    ending: str
    default: bool = False
    """Whether the ending alone stands for this host."""
    layer: bool = False
    """Whether joints are solids of a thickness."""
    labels: bool = True
    """Whether names must begin with a letter and have letters, digits, underscores and hyphens only."""
    materials: str = ""
    """Ending of the file of the materials, where they have one of their own."""
    start: str = ""
    """Regular expression for the start of that file."""
    linear: bool = True
    """Whether the host has joints between linear faces at one place only."""
    axisymmetric: bool = False
    """Whether it has joints that are surfaces of revolution."""


@dataclass(frozen=True)
class Host:
    """A host.toml: title, Python packages to install, the module or programs that show the host is there."""

    title: str
    packages: tuple[str, ...] = ()
    module: str = ""
    programs: tuple[str, ...] = ()
    card: Card | None = None
    kit: Kit | None = None
    mesh: Mesh | None = None


def folder(name: str) -> Path:
    """Folder of a host."""
    places = [Path(place) / name for place in __path__]
    return next((place for place in places if place.is_dir()), places[0])


@cache
def hosts(having: str = "") -> dict[str, Host]:
    """Hosts by the name of the folder, in the order of the alphabet; having: with this table only."""
    if having:
        return {name: host for name, host in hosts().items() if getattr(host, having)}
    files = [path for place in __path__ for path in Path(place).glob("*/host.toml")]
    return {path.parent.name: read(path) for path in sorted(files, key=lambda path: path.parent.name)}


def of(name: str, having: str) -> Any:
    """Table of a host; raises ValueError for an unknown host, or one without this table."""
    known = hosts(having)
    if name not in known:
        raise ValueError(f"host = {name!r}: expected one of {', '.join(known)}")
    return getattr(known[name], having)


def read(path: Path) -> Host:
    """Read a host.toml; raises ValueError that names the file for what no table has."""
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
        for name, kind in (("card", Card), ("kit", Kit), ("mesh", Mesh)):
            if name in tables:
                tables[name] = kind(**_checked(name, tables[name], kind))
        return Host(**_checked("", tables, Host))
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(f"{path}: {error}") from None


def part(name: str, what: str) -> ModuleType | None:
    """Module of a host: "card", "mesh" or "export"; None where the host has none."""
    if not (folder(name) / f"{what}.py").is_file():
        return None
    return import_module(f"{__package__}.{name}.{what}")


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < inf


def _numbers(value: object) -> bool:
    return isinstance(value, list) and all(map(_number, value))


_KINDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "bool": ("true or false", lambda value: isinstance(value, bool)),
    "str": ("a text", lambda value: isinstance(value, str)),
    "tuple[str, ...]": (
        "a list of texts",
        lambda value: isinstance(value, list) and all(isinstance(word, str) for word in value),
    ),
    "Mapping[str, float | list[float]]": (
        "a table of finite numbers, or lists of them",
        lambda value: isinstance(value, dict) and all(_number(n) or _numbers(n) for n in value.values()),
    ),
    "Mapping[str, Any]": ("a table", lambda value: isinstance(value, dict)),
}
"""What a value of each annotation has to be."""


def _checked(table: str, values: Any, kind: type) -> dict[str, Any]:
    """Values of a table, lists as tuples; raises ValueError that names one of a wrong type."""
    if not isinstance(values, dict):
        raise ValueError(f"{table} = {values!r}: expected a table")
    for part in fields(kind):
        if part.name in values and str(part.type) in _KINDS:
            expected, holds = _KINDS[str(part.type)]
            if not holds(values[part.name]):
                raise ValueError(f"{part.name} = {values[part.name]!r}: expected {expected}")
    return {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
