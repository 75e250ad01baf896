"""A mesh as a file has it, between the readers and `split`: nodes, cells, and groups by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .labels import Labels
from .shapes import Integers

Rows = tuple[Integers, ...]
"""For each array of cells numbers of its cells."""


def _fixed(value: Any) -> Any:
    """A value whose arrays are read-only and whose dictionaries cannot be changed."""
    if isinstance(value, np.ndarray):
        view = value.view()
        view.flags.writeable = False
        return view
    if isinstance(value, tuple):
        return tuple(_fixed(entry) for entry in value)
    if isinstance(value, Mapping):
        return MappingProxyType({name: _fixed(entry) for name, entry in value.items()})
    return value


@dataclass(frozen=True)
class Cells:
    """Cells of one kind, named as in meshio, and their nodes (m, k).

    owner (m,): of faces the number, through all arrays, of the cell that they are faces of, or -1.  types
    (m,): of the elements in their file, or an empty text.
    """

    kind: str
    nodes: Integers
    owner: Integers
    types: NDArray[np.str_]

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        _fix(self)

    @classmethod
    def plain(cls, kind: str, nodes: Integers) -> Cells:
        """Cells of which nothing more is known."""
        return cls(kind, nodes, np.full(len(nodes), -1), np.full(len(nodes), ""))


@dataclass(frozen=True)
class Pairs:
    """Faces of a joint that the file has: nodes (f, k) of both sides, node on node, and where it stands."""

    lower: Integers
    upper: Integers
    where: str

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        _fix(self)


@dataclass(frozen=True)
class RawMesh:
    """A mesh of a file; its arrays are read-only.

    points (n, 3) or (n, 2).  groups: of cells by name, in the order of the blocks.  spots: named nodes.
    numbers: of cells by name, whole or as floats, which may be those of blocks.  parts: instances of parts.
    of_programs: groups that a program has named.  defined: those that elements or sections were defined
    with.  joints: of cohesive elements, by name.  left_out: groups of faces that are not read, and why.
    """

    points: Floats
    cells: tuple[Cells, ...]
    labels: Labels
    groups: Mapping[str, Rows] = field(default_factory=dict)
    spots: Mapping[str, Integers] = field(default_factory=dict)
    numbers: Mapping[str, tuple[NDArray[Any], ...]] = field(default_factory=dict)
    parts: Mapping[str, Rows] = field(default_factory=dict)
    of_programs: frozenset[str] = frozenset()
    defined: frozenset[str] = frozenset()
    joints: Mapping[str, tuple[Pairs, ...]] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        _fix(self)


def _fix(record: Any) -> None:
    for entry in fields(record):
        object.__setattr__(record, entry.name, _fixed(getattr(record, entry.name)))
