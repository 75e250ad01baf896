"""Nodes, elements, sets and surfaces of the instances of an Abaqus deck, by their places in the mesh."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from ..material import ModelWarning
from .deck import Block
from .groups import OWNER, TYPE, Members
from .shapes import FACES, Integers, dimension

if TYPE_CHECKING:
    import meshio

FACETS = {
    (2, 2): "line",
    (2, 3): "line3",
    (3, 3): "triangle",
    (3, 4): "quad",
    (3, 6): "triangle6",
    (3, 8): "quad8",
}
"""Cells that are faces, by the dimension of the solids and the number of nodes."""


@dataclass
class Scope:
    """What is numbered together: a part, an instance, or the model.

    Members of sets are blocks of the deck, whose numbers and names are looked up when all is read.
    """

    name: str
    nodes: list[tuple[Block, Integers, Floats]] = field(default_factory=list)
    elements: list[tuple[Block, str, Integers, Integers]] = field(default_factory=list)
    sets: dict[tuple[str, str], list[Block]] = field(default_factory=dict)
    titles: dict[tuple[str, str], str] = field(default_factory=dict)
    move: Block | None = None

    def add(self, kind: str, name: str, block: Block) -> None:
        """Add members to a set; kind: NSET, ELSET or SURFACE."""
        key = kind, name.upper()
        self.titles.setdefault(key, name)
        self.sets.setdefault(key, []).append(block)


def whole(block: Block, rows: Floats) -> Integers:
    """Numbers of nodes or elements, which are whole."""
    bad = (rows != np.round(rows)) | (rows < 1.0) | (rows > 2.0**53)
    if bad.any():
        raise block.fail(f"{rows[bad][0]:g}: expected a number of a node or element, 1, 2, ...")
    return rows.astype(np.int64)


class Numbers:
    """Places of numbers: nodes or elements of a scope."""

    def __init__(self, scope: Scope, kind: str, numbered: list[tuple[Block, Integers]], first: int) -> None:
        """Sort the numbers; raises ValueError for one that is there twice."""
        numbers = [np.zeros(0, np.int64), *(part for _, part in numbered)]
        flat = np.concatenate(numbers)
        self.order = np.argsort(flat, kind="stable")
        self.sorted, self.first = flat[self.order], first
        self.kind, self.scope = kind, f" of {scope.name}" if scope.name else ""
        again = np.flatnonzero(np.diff(self.sorted) == 0)
        if len(again):
            number = int(self.sorted[again[0]])
            block = [block for block, part in numbered if (part == number).any()][-1]
            raise block.fail(f"{kind} {number}{self.scope} is there before: expected each number once")

    def generated(self, block: Block, numbers: range) -> Integers:
        """Places of those of a range that are there; ModelWarning for others, ValueError if there is none."""
        at = np.searchsorted(self.sorted, [numbers[0], numbers[-1] + 1])
        inside = np.flatnonzero((self.sorted[at[0] : at[1]] - numbers[0]) % numbers.step == 0) + at[0]
        if not len(inside):
            raise block.fail(f"{self.kind} {numbers[0]}{self.scope}: no such {self.kind}")
        if missing := len(numbers) - len(inside):
            text = f"{missing} of {len(numbers)} numbers are no {self.kind}s{self.scope}: they are left out"
            warnings.warn(f"{block.head()}: {text}", ModelWarning, stacklevel=6)
        places: Integers = self.first + self.order[inside]
        return places

    def __call__(self, block: Block, numbers: Integers) -> Integers:
        """Places of numbers; those that are not there raise ValueError."""
        if not len(self.sorted):
            at, bad = np.zeros(numbers.shape, np.int64), np.ones(numbers.shape, bool)
        else:
            at = np.minimum(np.searchsorted(self.sorted, numbers), len(self.sorted) - 1)
            bad = self.sorted[at] != numbers
        if bad.any():
            raise block.fail(f"{self.kind} {numbers[bad][0]}{self.scope}: no such {self.kind}")
        return self.first + self.order[at]


class Model:
    """Nodes, elements and sets of all instances, by their places in the mesh."""

    def __init__(self, path: Path, model: Scope, instances: list[Scope]) -> None:
        """Number nodes and elements; raises ValueError for a deck without elements."""
        self.path, self.model, self.scopes = path, model, [*instances, model]
        self.by_name = {scope.name.upper(): scope for scope in instances}
        self.points: list[Floats] = []
        self.cells: list[tuple[str, Integers]] = []
        self.nodes: dict[int, Numbers] = {}
        self.elements: dict[int, Numbers] = {}
        node, cell = 0, 0
        for scope in self.scopes:
            x = np.concatenate([np.zeros((0, 3)), *(rows[2] for rows in scope.nodes)])
            self.points.append(_moved(x, scope.move))
            nodes = Numbers(scope, "node", [rows[:2] for rows in scope.nodes], node)
            numbered = [(block, numbers) for block, _, numbers, _ in scope.elements]
            self.nodes[id(scope)] = nodes
            self.elements[id(scope)] = Numbers(scope, "element", numbered, cell)
            for block, kind, numbers, data in scope.elements:
                self.cells.append((kind, nodes(block, data)))
                cell += len(numbers)
            node += len(x)
        if not cell:
            text = "no elements" if not self.model.nodes else "nodes without elements"
            raise ValueError(f"{path}: {text}: expected *Element, in the model or in a part with an instance")
        self.first = np.cumsum([0, *(len(data) for _, data in self.cells)])

    def mesh(self) -> meshio.Mesh:
        """The mesh of meshio."""
        import meshio

        seen = Counter(key for scope in self.scopes for key in scope.sets)
        point_sets: dict[str, Integers] = {}
        sets: dict[str, list[Integers]] = {}
        facets: list[tuple[str, str, Integers, Integers]] = []
        sources: dict[tuple[str, str], str] = {}
        for scope in self.scopes:
            for (kind, key), title in scope.titles.items():
                name = f"{scope.name}_{title}" if seen[kind, key] > 1 and scope.name else title
                source = f"{scope.name}.{title}" if scope.name else title
                if (earlier := sources.setdefault((kind, name.upper()), source)) != source:
                    text = f"sets {earlier} and {source} both become {name}: expected other names"
                    raise ValueError(f"{self.path}: {text}")
                if kind == "NSET":
                    known = point_sets.get(name, np.zeros(0, np.int64))
                    point_sets[name] = np.union1d(known, self._members(scope, kind, key))
                elif kind == "ELSET":
                    sets.setdefault(name, []).append(self._members(scope, kind, key))
                else:
                    facets += [(name, *faces) for faces in self._faces(scope, key)]
            here = self.elements[id(scope)]
            if scope.name and scope.elements:
                sets.setdefault(f"instance:{scope.name}", []).append(here.first + np.arange(len(here.order)))
        cells = list(self.cells)
        cell_sets = {
            name: [self._in_block(parts, k) for k in range(len(cells))] for name, parts in sets.items()
        }
        owners = [np.full(len(data), -1) for _, data in cells]
        for name, kind, data, owner in facets:
            cells.append((kind, data))
            owners.append(owner)
            for rows in cell_sets.values():
                rows.append(np.zeros(0, np.int64))
            empty = [np.zeros(0, np.int64)] * (len(cells) - 1)
            rows = cell_sets.setdefault(name, [*empty, np.zeros(0, np.int64)])
            rows[-1] = np.arange(len(data))
        self._set_apart(cells, cell_sets, point_sets)
        self._warn()
        points = np.concatenate(self.points)
        types = [block.name("TYPE").upper() for scope in self.scopes for block, *_ in scope.elements]
        types += [""] * (len(cells) - len(types))
        cell_data: dict[str, list[NDArray[Any]]] = {
            OWNER: owners,
            TYPE: [np.full(len(rows[1]), name) for name, rows in zip(types, cells, strict=True)],
        }
        return meshio.Mesh(points, cells, cell_sets=cell_sets, point_sets=point_sets, cell_data=cell_data)

    def _set_apart(
        self, cells: list[tuple[str, Integers]], cell_sets: Members, point_sets: dict[str, Integers]
    ) -> None:
        """Give faces another name where a set of other nodes has theirs: both are groups of the mesh."""
        d = max(dimension(kind) for kind, _ in self.cells)
        titles = {name.upper(): name for name in point_sets}
        for name in list(cell_sets):
            at = [
                k for k, (kind, _) in enumerate(cells) if dimension(kind) == d - 1 and len(cell_sets[name][k])
            ]
            title = titles.get(name.upper())
            if not at or title is None:
                continue
            nodes = np.unique(np.concatenate([cells[k][1][cell_sets[name][k]].ravel() for k in at]))
            if not np.array_equal(nodes, point_sets[title]):
                title = f"{name}_faces"
                if title.upper() in {known.upper() for known in (*cell_sets, *point_sets)}:
                    raise ValueError(f"{self.path}: {name} and {title}: expected other names of sets")
                text = (
                    f"{name} is a set of nodes and one of faces that has other nodes: the faces are {title}"
                )
                warnings.warn(f"{self.path}: {text}", ModelWarning, stacklevel=5)
            if title != name:
                moved = cell_sets.setdefault(title, [np.zeros(0, np.int64)] * len(cells))
                for k in at:
                    moved[k], cell_sets[name][k] = cell_sets[name][k], np.zeros(0, np.int64)

    def _warn(self) -> None:
        """Name the elements that are not solids."""
        d = max(dimension(kind) for kind, _ in self.cells)
        lost: Counter[str] = Counter()
        for scope in self.scopes:
            for block, kind, numbers, _ in scope.elements:
                if dimension(kind) < d:
                    lost[block.name("TYPE").upper()] += len(numbers)
        for name, count in lost.items():
            text = (
                f"{self.path}: {count} elements of type {name} name faces or nodes only: they are not written"
            )
            warnings.warn(text, ModelWarning, stacklevel=4)

    def _in_block(self, parts: list[Integers], k: int) -> Integers:
        at = np.unique(np.concatenate(parts))
        rows: Integers = at[(at >= self.first[k]) & (at < self.first[k + 1])] - self.first[k]
        return rows

    def _members(self, scope: Scope, kind: str, key: str, above: tuple[str, ...] = ()) -> Integers:
        """Places of the nodes or elements of a set."""
        members = [np.zeros(0, np.int64)]
        for block in scope.sets[kind, key]:
            home = self._instance(block, scope)
            places = (self.nodes if kind == "NSET" else self.elements)[id(home)]
            if block.keyword in ("NODE", "ELEMENT"):
                rows = scope.nodes if block.keyword == "NODE" else scope.elements
                members += [places(block, rows[-2]) for rows in rows if rows[0] is block]
                continue
            if block.keyword == "NSET" and (elset := block.parameters.get("ELSET")):
                of = self._named(block, home, "ELSET", elset, above)
                members += [np.unique(np.concatenate([self._nodes_of(of)]))]
                continue
            for k, words in block.rows():
                if "GENERATE" in block.parameters:
                    given = whole(block, np.array([block.numbers(words, k)]))[0].tolist()
                    if len(given) not in (2, 3) or given[1] < given[0]:
                        raise block.fail(f"{', '.join(words)}: expected first, last, step", k)
                    members.append(places.generated(block, range(given[0], given[1] + 1, *given[2:])))
                    continue
                if block.keyword == "SURFACE":  # of nodes: a set or a number, and an area
                    words = words[:1]
                for word in filter(None, words):
                    members.append(self._of(block, home, kind, word, above, k))
        return np.unique(np.concatenate(members))

    def _instance(self, block: Block, scope: Scope) -> Scope:
        name = block.parameters.get("INSTANCE")
        return scope if name is None else self._scope(block, name)

    def _scope(self, block: Block, name: str) -> Scope:
        if name.upper() not in self.by_name:
            known = ", ".join(scope.name for scope in self.by_name.values()) or "none"
            raise block.fail(f"instance {name}: no such instance: {known}")
        return self.by_name[name.upper()]

    def _of(
        self, block: Block, home: Scope, kind: str, word: str, above: tuple[str, ...], k: int
    ) -> Integers:
        """Places of a number or of a set, with or without its instance before a point."""
        word = word.strip("\"'")
        before, point, local = word.rpartition(".")
        if point and before.upper() in self.by_name:
            home, word = self._scope(block, before), local
        if word.isdigit():
            return (self.nodes if kind == "NSET" else self.elements)[id(home)](block, np.array([int(word)]))
        return self._named(block, home, kind, word, above, k)

    def _named(
        self, block: Block, home: Scope, kind: str, name: str, above: tuple[str, ...], k: int | None = None
    ) -> Integers:
        key = name.upper()
        if (kind, key) not in home.sets or f"{kind} {key}" in above:
            raise block.fail(f"{name}: expected a number or a set that is there", k)
        return self._members(home, kind, key, (*above, f"{kind} {key}"))

    def _nodes_of(self, elements: Integers) -> Integers:
        nodes = [np.zeros(0, np.int64)]
        for k, (_, data) in enumerate(self.cells):
            nodes.append(data[self._in_block([elements], k)].ravel())
        return np.unique(np.concatenate(nodes))

    def _faces(self, scope: Scope, key: str) -> Iterable[tuple[str, Integers, Integers]]:
        """Kinds and nodes of the faces of a surface, and the elements that they are faces of."""
        by_kind: dict[str, list[tuple[Integers, Integers]]] = {}
        for block in scope.sets["SURFACE", key]:
            for k, words in block.rows():
                at = self._of(block, self._instance(block, scope), "ELSET", words[0], (), k)
                label = words[1].upper() if len(words) > 1 else ""
                for i, (kind, data) in enumerate(self.cells):
                    rows = self._in_block([at], i)
                    if not len(rows):
                        continue
                    faces = FACES.get(kind, ())
                    if not re.fullmatch("S[1-9]", label) or int(label[1]) > len(faces):
                        text = f"face {label or 'of all free sides'} of elements of {len(data[0])} nodes"
                        raise block.fail(f"{text}: not read: expected S1 to S{len(faces)}", k)
                    face = data[rows][:, faces[int(label[1]) - 1]]
                    by_kind.setdefault(FACETS[dimension(kind), face.shape[1]], []).append(
                        (face, rows + self.first[i])
                    )
        return [
            (kind, np.concatenate([faces for faces, _ in parts]), np.concatenate([rows for _, rows in parts]))
            for kind, parts in by_kind.items()
        ]


def _moved(x: Floats, block: Block | None) -> Floats:
    """Nodes of an instance: moved first, then turned about an axis through two points."""
    if block is None:
        return x
    lines = [(k, line.strip()) for k, line in enumerate(block.lines) if not line.startswith("**")]
    while lines and not lines[-1][1]:
        lines.pop()
    if len(lines) > 2:
        raise block.fail(f"{len(lines)} lines: expected one to move the part and one to turn it")
    given = [block.numbers(text.removesuffix(",").split(","), k) if text else [] for k, text in lines]
    if (given and len(given[0]) > 3) or (len(given) == 2 and len(given[1]) != 7):
        raise block.fail(f"{given[-1]}: expected three components to move it, then two points and an angle")
    if given:
        x = x + np.pad(given[0], (0, 3 - len(given[0])))
    if len(given) == 2:
        a, b, angle = np.array(given[1][:3]), np.array(given[1][3:6]), np.radians(given[1][6])
        length = np.linalg.norm(b - a)
        if not length > 0.0:
            raise block.fail(f"{given[1]}: expected two points of an axis")
        axis, p = (b - a) / length, x - a
        x = (
            a
            + p * np.cos(angle)
            + np.cross(axis, p) * np.sin(angle)
            + np.outer(p @ axis, axis) * (1.0 - np.cos(angle))
        )
    return x
