"""Nodes, elements, sets and surfaces of the instances of an Abaqus deck, by their places in the mesh."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Container, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .deck import Block
from .deck_scopes import Numbers, Scope, entity_numbers, moved
from .deck_types import is_shell, type_of
from .shapes import FACES, FACETS, Integers, dimension


class Unread(Exception):
    """A surface that is not read, and why."""


@dataclass(frozen=True)
class Section:
    """Keyword of a section, the part, instance or model in which it stands, and places of its elements."""

    block: Block
    scope: Scope
    elements: Integers


@dataclass(frozen=True)
class Cohesive:
    """Cohesive elements of a keyword: their places, and the nodes (m, 2 k) of both sides."""

    block: Block
    scope: Scope
    places: Integers
    nodes: Integers


class Model:
    """Nodes, elements and sets of all instances, by their places in the mesh.

    Elements of one kind of cells have one array, those that are left out come after all others.  first: place
    of the first one of each array, and of those that are left out.
    """

    def __init__(
        self, path: Path, deck: list[Block], model: Scope, instances: list[Scope], unused: list[Scope]
    ) -> None:
        """Number nodes and elements; raises ValueError for numbers that are not there.

        deck: all blocks.  unused: parts without an instance.
        """
        self.path, self.deck, self.unused = path, deck, unused
        self.model, self.scopes = model, [*instances, model]
        self.by_name = {scope.name.upper(): scope for scope in instances}
        places_of_nodes: list[Floats] = []
        self.nodes: dict[int, Numbers] = {}
        self.elements: dict[int, Numbers] = {}
        self.by_block: dict[int, dict[int, Integers]] = {}
        counts: Counter[str] = Counter()
        for scope in self.scopes:
            for _, kind, numbers, _ in scope.elements:
                counts.update({kind: len(numbers)} if len(numbers) else {})
        self.first = np.cumsum([0, *counts.values()])
        place = dict(zip(counts, self.first.tolist(), strict=False))
        data: dict[str, list[Integers]] = {kind: [] for kind in counts}
        types: dict[str, list[NDArray[np.str_]]] = {kind: [] for kind in counts}
        node, other = 0, int(self.first[-1])
        for scope in self.scopes:
            x = np.concatenate([np.zeros((0, 3)), *(rows[2] for rows in scope.nodes)])
            places_of_nodes.append(moved(x, scope.move))
            nodes = Numbers(scope, "node", [rows[:2] for rows in scope.nodes], node + np.arange(len(x)))
            self.nodes[id(scope)] = nodes
            node += len(x)
            numbered, places = list[tuple[Block, Integers]](), [np.zeros(0, np.int64)]
            for block, kind, numbers, rows in scope.elements:
                if not len(numbers):
                    continue
                data[kind].append(nodes(block, rows))
                types[kind].append(np.full(len(numbers), block.name("TYPE").upper()))
                numbered.append((block, numbers))
                places.append(place[kind] + np.arange(len(numbers)))
                place[kind] += len(numbers)
            for block, numbers, _ in scope.others:
                numbered.append((block, numbers))
                places.append(other + np.arange(len(numbers)))
                other += len(numbers)
            self.elements[id(scope)] = Numbers(scope, "element", numbered, np.concatenate(places))
        self.cells = [(kind, np.concatenate(rows)) for kind, rows in data.items()]
        self.points = np.concatenate(places_of_nodes)
        self.cells = [
            (kind, _middle_last(rows, self.points) if kind == "line3" else rows) for kind, rows in self.cells
        ]
        self.types = [np.concatenate(rows) for rows in types.values()]
        self.dimension = max((dimension(kind) for kind in counts), default=0)

    @cached_property
    def sections(self) -> list[Section]:
        """Sections of all instances, with their elements; a set that is not there has none."""
        sections = []
        for scope in self.scopes:
            for block in scope.sections:
                key = "ELSET", block.name("ELSET").upper()
                elements = self.members(scope, *key) if key in scope.sets else np.zeros(0, np.int64)
                sections.append(Section(block, scope, elements))
        return sections

    @cached_property
    def cohesive(self) -> list[Cohesive]:
        """Cohesive elements, by their keywords."""
        entries = []
        for scope in self.scopes:
            for block, numbers, words in scope.others:
                if not len(numbers) or not (count := type_of(block.name("TYPE").upper()).sides):
                    continue
                flat = [word for row in words for word in row[:count]]
                if all(word.isdigit() for word in flat):
                    nodes = self.nodes[id(scope)](block, np.array(flat, np.int64))
                else:
                    nodes = np.concatenate([self.of(block, scope, "NSET", word, (), None) for word in flat])
                if len(nodes) != count * len(words):
                    raise block.fail(f"{len(nodes)} nodes of {len(words)} elements: expected {count} of each")
                places = self.elements[id(scope)](block, numbers)
                entries.append(Cohesive(block, scope, places, nodes.reshape(-1, count)))
        return entries

    def of_sections(self, sections: Container[int]) -> Iterator[Integers]:
        """Nodes (m, k) of the elements, cohesive ones and cells, of sections by their id."""
        for section in self.sections:
            if id(section.block) in sections:
                yield from (entry.nodes[np.isin(entry.places, section.elements)] for entry in self.cohesive)
                rows = self.by_array(section.elements)
                yield from (cells[at] for (_, cells), at in zip(self.cells, rows, strict=True))

    def types_of(self, elements: Integers) -> set[str]:
        """Types of elements."""
        rows = self.by_array(elements)
        types = {name for names, at in zip(self.types, rows, strict=True) for name in np.unique(names[at])}
        not_cells = elements[elements >= self.first[-1]]
        for scope in self.scopes if len(not_cells) else ():
            for block, numbers, _ in scope.others:
                if len(numbers) and np.isin(self.elements[id(scope)](block, numbers), not_cells).any():
                    types.add(block.name("TYPE").upper())
        return types

    def by_array(self, places: Integers) -> list[Integers]:
        """Rows in each array of cells; elements that are left out have none."""
        at = np.unique(places)
        cuts = np.searchsorted(at, self.first)
        return [at[a:b] - first for a, b, first in zip(cuts, cuts[1:], self.first, strict=False)]

    def numbers_of(self, scope: Scope, block: Block, kind: str, name: str) -> Integers:
        """Numbers, in their scope, of the members of a set that a keyword names."""
        places = self._named(block, scope, kind, name, ())
        known = (self.nodes if kind == "NSET" else self.elements)[id(scope)]
        return np.asarray(known.flat[np.isin(known.places, places)])

    def members(self, scope: Scope, kind: str, key: str, above: tuple[str, ...] = ()) -> Integers:
        """Places of the nodes or elements of a set."""
        members = [np.zeros(0, np.int64)]
        for block in scope.sets[kind, key]:
            home = self.instance(block, scope)
            places = (self.nodes if kind == "NSET" else self.elements)[id(home)]
            if block.keyword == "INSTANCE":  # of all its nodes or elements
                home = self.scope(block, block.name("NAME"))
                members.append((self.nodes if kind == "NSET" else self.elements)[id(home)].place)
                continue
            if id(block) in scope.generated_numbers or block.keyword in ("NODE", "ELEMENT"):
                numbers = scope.generated_numbers.get(id(block))
                members.append(places(block, self._numbers(scope)[id(block)] if numbers is None else numbers))
                continue
            if block.keyword == "NSET" and (elset := block.parameters.get("ELSET")):
                members.append(self.nodes_of(self._named(block, home, "ELSET", elset, above)))
                continue
            given_numbers: list[int] = []
            for k, words in block.rows():
                if "GENERATE" in block.parameters:
                    ends = entity_numbers(block, np.array([block.numbers(words, k)]))[0].tolist()
                    if len(ends) not in (2, 3) or ends[1] < ends[0]:
                        raise block.fail(f"{', '.join(words)}: expected first, last, step", k)
                    members.append(places.generated(block, range(ends[0], ends[1] + 1, *ends[2:])))
                    continue
                if block.keyword == "SURFACE":  # of nodes: a set or a number, and an area
                    words = words[:1]
                for word in filter(None, words):
                    if word.isdigit():
                        given_numbers.append(int(word))
                    else:
                        members.append(self.of(block, home, kind, word, above, k))
            members.append(places(block, np.array(given_numbers, np.int64)))
        return np.unique(np.concatenate(members))

    def _numbers(self, scope: Scope) -> dict[int, Integers]:
        """Numbers of the nodes or elements of each block."""
        if id(scope) not in self.by_block:
            rows = [*((row[0], row[1]) for row in scope.nodes), *((row[0], row[2]) for row in scope.elements)]
            rows += [(row[0], row[1]) for row in scope.others]
            self.by_block[id(scope)] = {id(block): numbers for block, numbers in rows}
        return self.by_block[id(scope)]

    def instance(self, block: Block, scope: Scope) -> Scope:
        """Scope of the instance that a block names, or that in which it stands."""
        name = block.parameters.get("INSTANCE")
        return scope if name is None else self.scope(block, name)

    def scope(self, block: Block, name: str) -> Scope:
        """Scope of an instance."""
        if name.upper() not in self.by_name:
            known = ", ".join(scope.name for scope in self.by_name.values()) or "none"
            raise block.fail(f"instance {name}: no such instance: {known}")
        return self.by_name[name.upper()]

    def of(
        self, block: Block, home: Scope, kind: str, word: str, above: tuple[str, ...], k: int | None
    ) -> Integers:
        """Places of a number or of a set, with or without its instance before a point."""
        word = word.strip("\"'")
        before, point, local = word.rpartition(".")
        if point and before.upper() in self.by_name:
            home, word = self.scope(block, before), local
        if word.isdigit():
            return (self.nodes if kind == "NSET" else self.elements)[id(home)](block, np.array([int(word)]))
        return self._named(block, home, kind, word, above, k)

    def _named(
        self, block: Block, home: Scope, kind: str, name: str, above: tuple[str, ...], k: int | None = None
    ) -> Integers:
        key = name.upper()
        if (kind, key) not in home.sets or f"{kind} {key}" in above:
            raise block.fail(f"{name}: expected a number or a set that is there", k)
        return self.members(home, kind, key, (*above, f"{kind} {key}"))

    def nodes_of(self, elements: Integers) -> Integers:
        """Nodes of elements, also of those that are left out as far as the deck has them."""
        nodes = [np.zeros(0, np.int64)]
        nodes += [
            data[rows].ravel() for (_, data), rows in zip(self.cells, self.by_array(elements), strict=True)
        ]
        left_out = set(elements[elements >= self.first[-1]].tolist())
        for scope in self.scopes if left_out else ():
            for block, numbers, words in scope.others:
                for place, row in zip(self.elements[id(scope)](block, numbers).tolist(), words, strict=True):
                    if place in left_out:
                        nodes += [self.of(block, scope, "NSET", word, (), None) for word in row if word]
        return np.unique(np.concatenate(nodes))

    def faces(self, scope: Scope, key: str) -> Iterable[tuple[str, Integers, Integers]]:
        """Kinds and nodes of the faces of a surface, and the elements that they are faces of.

        Raises Unread for a surface that has other faces than S1, S2, ... of solids.
        """
        by_kind: dict[str, list[tuple[Integers, Integers]]] = {}
        for block in scope.sets["SURFACE", key]:
            kind = (block.parameters.get("TYPE") or "ELEMENT").upper()
            for word in ("COMBINE", "CROP"):
                if word in block.parameters:
                    raise Unread(f"{block.head()}: {word.lower()}: expected lines of sets and faces")
            if kind != "ELEMENT":
                raise Unread(f"{block.head()}: type={kind}: expected faces of elements")
            for k, words in block.rows():
                at = self.of(block, self.instance(block, scope), "ELSET", words[0], (), k)
                label = words[1].upper() if len(words) > 1 else ""
                for i, rows in enumerate(self.by_array(at)):
                    if len(rows):
                        face = self._face(i, rows, label, block, k)
                        by_kind.setdefault(FACETS[self.dimension, face.shape[1]], []).append(
                            (face, rows + self.first[i])
                        )
                if (at >= self.first[-1]).any():
                    raise Unread(f"{block.where(k)}: {words[0]}: has elements that are left out")
        return [
            (kind, np.concatenate([faces for faces, _ in parts]), np.concatenate([rows for _, rows in parts]))
            for kind, parts in by_kind.items()
        ]

    def _face(self, i: int, rows: Integers, label: str, block: Block, k: int) -> Integers:
        """Nodes of a face of elements of an array."""
        kind, data = self.cells[i]
        faces = FACES.get(kind, ())
        shells = sorted({name for name in self.types[i][rows].tolist() if is_shell(name)})
        where = f"{block.where(k)}: {label or 'all free faces'}"
        if shells and (dimension(kind) < self.dimension or not re.fullmatch("E[1-9]", label)):
            wanted = "their element sets are groups of faces"
            if dimension(kind) == self.dimension:
                wanted = "expected E1, E2, ..., their edges"
            raise Unread(f"{where} of elements of type {', '.join(shells)}: {wanted}")
        if not shells and not re.fullmatch("S[1-9]", label):
            raise Unread(f"{where} of elements of {data.shape[1]} nodes: expected S1 to S{len(faces)}")
        if int(label[1]) > len(faces):
            text = f"face {label} of elements of {data.shape[1]} nodes"
            raise block.fail(f"{text}: not read: expected {label[0]}1 to {label[0]}{len(faces)}", k)
        return data[rows][:, faces[int(label[1]) - 1]]


SIDES: dict[tuple[int, str], tuple[list[int], list[int]]] = {
    (4, "2"): ([0, 1], [3, 2]), (4, "1"): ([3, 0], [2, 1]), (6, "3"): ([0, 1, 2], [3, 4, 5]),
    (8, "3"): ([0, 1, 2, 3], [4, 5, 6, 7]), (8, "1"): ([0, 3, 7, 4], [1, 2, 6, 5]),
    (8, "2"): ([0, 4, 5, 1], [3, 7, 6, 2]),
}  # fmt: skip
"""Nodes of the lower and the upper side of a cohesive element, by their number and the stack direction."""


def sides_of(nodes: Integers, way: str | None, block: Block) -> tuple[Integers, Integers]:
    """Nodes of the lower and the upper side, node on node; way: stack direction of the section."""
    count = nodes.shape[1]
    stack = (way or "").strip()
    direction = stack if stack in "123" and stack else "2" if count == 4 else "3"
    if (count, direction) not in SIDES:
        raise block.fail(f"stack direction={way}: expected one that elements of {count} nodes have")
    lower, upper = SIDES[count, direction]
    return nodes[:, lower], nodes[:, upper]


def _middle_last(edges: Integers, points: Floats) -> Integers:
    """Nodes of edges with the middle last; in trusses and beams of three nodes it is the second."""
    x = points[edges]
    away = [np.linalg.norm(2.0 * x[:, k] - x.sum(1) + x[:, k], axis=1) for k in (1, 2)]
    return np.where((away[0] < away[1])[:, None], edges[:, [0, 2, 1]], edges)
