"""Nodes, elements, sets and surfaces of the instances of an Abaqus deck, by their places in the mesh."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from ..material import ModelWarning
from .deck import Block
from .deck_scopes import Numbers, Scope, moved, whole
from .deck_types import is_shell, type_of
from .labels import Labels
from .raw import Cells, RawMesh
from .shapes import FACES, Integers, dimension

FACETS = {
    (2, 2): "line",
    (2, 3): "line3",
    (3, 3): "triangle",
    (3, 4): "quad",
    (3, 6): "triangle6",
    (3, 8): "quad8",
}
"""Cells that are faces, by the dimension of the solids and the number of nodes."""


class Unread(Exception):
    """A surface that is not read, and why."""


class Model:
    """Nodes, elements and sets of all instances, by their places in the mesh.

    Elements of one kind of cells have one array, those that are left out come after all others.  first: place
    of the first one of each array, and of those that are left out.
    """

    def __init__(self, path: Path, model: Scope, instances: list[Scope]) -> None:
        """Number nodes and elements; raises ValueError for a deck without elements, or with some not read."""
        self.path, self.model, self.scopes = path, model, [*instances, model]
        self.by_name = {scope.name.upper(): scope for scope in instances}
        self.points: list[Floats] = []
        self.nodes: dict[int, Numbers] = {}
        self.elements: dict[int, Numbers] = {}
        self.by_block: dict[int, dict[int, Integers]] = {}
        self.left_out: dict[str, str] = {}
        for block, text in (refused for scope in self.scopes for refused in scope.refused):
            raise block.fail(text)
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
            self.points.append(moved(x, scope.move))
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
        if not self.first[-1]:
            text = "no elements" if not self.model.nodes else "nodes without elements"
            raise ValueError(f"{path}: {text}: expected *Element, in the model or in a part with an instance")
        self.cells = [(kind, np.concatenate(rows)) for kind, rows in data.items()]
        points = np.concatenate(self.points)
        self.cells = [
            (kind, _middle_last(rows, points) if kind == "line3" else rows) for kind, rows in self.cells
        ]
        self.types = [np.concatenate(rows) for rows in types.values()]
        self.dimension = max(dimension(kind) for kind in counts)

    def mesh(self) -> RawMesh:
        """The mesh, without sections and loads."""
        seen = Counter(key for scope in self.scopes for key in scope.sets)
        point_sets: dict[str, Integers] = {}
        sets: dict[str, list[Integers]] = {}
        facets: dict[str, list[tuple[str, Integers, Integers]]] = {}
        sources: dict[tuple[str, str], str] = {}
        blocks_of: dict[str, list[Block]] = {}
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
                    blocks_of.setdefault(name, []).extend(scope.sets[kind, key])
                    sets.setdefault(name, []).append(self._members(scope, kind, key))
                else:
                    try:
                        for cell, nodes, owner in self._faces(scope, key):
                            facets.setdefault(cell, []).append((name, nodes, owner))
                    except Unread as why:
                        self.left_out[name] = str(why)
        cells = list(self.cells)
        none = [np.zeros(0, np.int64)] * (len(cells) + len(facets))
        cell_sets = {
            name: [*self._by_array(np.concatenate(parts)), *none[len(cells) :]]
            for name, parts in sets.items()
        }
        owners = [np.full(len(data), -1) for _, data in cells]
        for kind, entries in facets.items():
            first = 0
            for name, faces, _ in entries:
                members = cell_sets.setdefault(name, list(none))
                members[len(cells)] = np.append(members[len(cells)], first + np.arange(len(faces)))
                first += len(faces)
            cells.append((kind, np.concatenate([faces for _, faces, _ in entries])))
            owners.append(np.concatenate([owner for *_, owner in entries]))
        self._set_apart(cells, cell_sets, point_sets)
        self._warn()
        types = [*self.types, *(np.full(len(data), "") for _, data in cells[len(self.cells) :])]
        parts = {
            scope.name: (*self._by_array(self.elements[id(scope)].places), *none[len(self.cells) :])
            for scope in self.scopes
            if scope.name and scope.elements
        }
        return RawMesh(
            np.concatenate(self.points),
            tuple(
                Cells(kind, nodes, owner, names)
                for (kind, nodes), owner, names in zip(cells, owners, types, strict=True)
            ),
            self._labels(),
            {name: tuple(cell_sets[name]) for name in sorted(cell_sets)},
            point_sets,
            parts=parts,
            given=frozenset(name for name, blocks in blocks_of.items() if _are(blocks, "INTERNAL")),
            defined=frozenset(name for name, blocks in blocks_of.items() if _are(blocks, "TYPE")),
            left_out=self.left_out,
        )

    def _labels(self) -> Labels:
        """Numbers of the nodes and elements in their scopes."""
        nodes, elements = (
            [numbers[id(scope)] for scope in self.scopes] for numbers in (self.nodes, self.elements)
        )
        home_of_node = np.repeat(np.arange(len(nodes)), [len(numbers.flat) for numbers in nodes])
        homes = np.repeat(np.arange(len(elements)), [len(numbers.flat) for numbers in elements])
        order = np.argsort(np.concatenate([numbers.places for numbers in elements]))
        return Labels(
            np.concatenate([numbers.flat for numbers in nodes]),
            home_of_node,
            np.concatenate([numbers.flat for numbers in elements])[order],
            homes[order],
            tuple(scope.name for scope in self.scopes),
        )

    def _set_apart(
        self,
        cells: list[tuple[str, Integers]],
        cell_sets: dict[str, list[Integers]],
        point_sets: dict[str, Integers],
    ) -> None:
        """Give faces another name where a set of other nodes has theirs: both are groups of the mesh."""
        d = self.dimension
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
        """Name the elements that are not solids, and the surfaces that are not read."""
        lost: Counter[str] = Counter()
        for (kind, _), types in zip(self.cells, self.types, strict=True):
            if dimension(kind) < self.dimension:
                lost.update(types.tolist())
        texts = [
            f"{count} elements of type {name} name faces or nodes only: they are not written"
            for name, count in lost.items()
        ]
        others: Counter[str] = Counter()
        for scope in self.scopes:
            for block, numbers, _ in scope.others:
                others[block.name("TYPE").upper()] += len(numbers)
        texts += [
            f"{count} elements of type {name}, {type_of(name).left_out}, are left out: what they carry is "
            "yours to add"
            for name, count in others.items()
        ]
        texts += [f"surface {name} is left out: {why}" for name, why in self.left_out.items()]
        for text in texts:
            warnings.warn(f"{self.path}: {text}", ModelWarning, stacklevel=5)

    def _by_array(self, places: Integers) -> list[Integers]:
        """Rows in each array of cells; elements that are left out have none."""
        at = np.unique(places)
        cuts = np.searchsorted(at, self.first)
        return [at[a:b] - first for a, b, first in zip(cuts, cuts[1:], self.first, strict=False)]

    def _members(self, scope: Scope, kind: str, key: str, above: tuple[str, ...] = ()) -> Integers:
        """Places of the nodes or elements of a set."""
        members = [np.zeros(0, np.int64)]
        for block in scope.sets[kind, key]:
            home = self._instance(block, scope)
            places = (self.nodes if kind == "NSET" else self.elements)[id(home)]
            if block.keyword in ("NODE", "ELEMENT"):
                members.append(places(block, self._numbers(scope)[id(block)]))
                continue
            if block.keyword == "NSET" and (elset := block.parameters.get("ELSET")):
                members.append(self._nodes_of(self._named(block, home, "ELSET", elset, above)))
                continue
            given_numbers: list[int] = []
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
                    if word.isdigit():
                        given_numbers.append(int(word))
                    else:
                        members.append(self._of(block, home, kind, word, above, k))
            members.append(places(block, np.array(given_numbers, np.int64)))
        return np.unique(np.concatenate(members))

    def _numbers(self, scope: Scope) -> dict[int, Integers]:
        """Numbers of the nodes or elements of each block."""
        if id(scope) not in self.by_block:
            rows = [*((row[0], row[1]) for row in scope.nodes), *((row[0], row[2]) for row in scope.elements)]
            rows += [(row[0], row[1]) for row in scope.others]
            self.by_block[id(scope)] = {id(block): numbers for block, numbers in rows}
        return self.by_block[id(scope)]

    def _instance(self, block: Block, scope: Scope) -> Scope:
        name = block.parameters.get("INSTANCE")
        return scope if name is None else self._scope(block, name)

    def _scope(self, block: Block, name: str) -> Scope:
        if name.upper() not in self.by_name:
            known = ", ".join(scope.name for scope in self.by_name.values()) or "none"
            raise block.fail(f"instance {name}: no such instance: {known}")
        return self.by_name[name.upper()]

    def _of(
        self, block: Block, home: Scope, kind: str, word: str, above: tuple[str, ...], k: int | None
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
        """Nodes of elements, also of those that are left out as far as the deck has them."""
        nodes = [np.zeros(0, np.int64)]
        nodes += [
            data[rows].ravel() for (_, data), rows in zip(self.cells, self._by_array(elements), strict=True)
        ]
        left_out = set(elements[elements >= self.first[-1]].tolist())
        for scope in self.scopes if left_out else ():
            for block, numbers, words in scope.others:
                for place, row in zip(self.elements[id(scope)](block, numbers).tolist(), words, strict=True):
                    if place in left_out:
                        nodes += [self._of(block, scope, "NSET", word, (), None) for word in row if word]
        return np.unique(np.concatenate(nodes))

    def _faces(self, scope: Scope, key: str) -> Iterable[tuple[str, Integers, Integers]]:
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
                at = self._of(block, self._instance(block, scope), "ELSET", words[0], (), k)
                label = words[1].upper() if len(words) > 1 else ""
                for i, rows in enumerate(self._by_array(at)):
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


def _are(blocks: list[Block], parameter: str) -> bool:
    """Whether all blocks of a set have a parameter."""
    return all(parameter in block.parameters for block in blocks)


def _middle_last(edges: Integers, points: Floats) -> Integers:
    """Nodes of edges with the middle last; in trusses and beams of three nodes it is the second."""
    x = points[edges]
    away = [np.linalg.norm(2.0 * x[:, k] - x.sum(1) + x[:, k], axis=1) for k in (1, 2)]
    return np.where((away[0] < away[1])[:, None], edges[:, [0, 2, 1]], edges)
