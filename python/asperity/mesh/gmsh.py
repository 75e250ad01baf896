"""Files of gmsh, formats 2.2 and 4.1, with all physical groups of each cell.

meshio refuses a file of format 4.1 with entities that are in no physical group, keeps one group of a cell in
format 2.2, and takes a node that is not in the file for another one.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ..contract import Floats
from ..material import ModelWarning
from .gmsh_binary import ORDERS, read_sections
from .groups import ENTITIES
from .labels import Labels
from .raw import Cells, RawMesh
from .shapes import Integers, dimension

KINDS = {
    1: ("line", 2), 2: ("triangle", 3), 3: ("quad", 4), 4: ("tetra", 4), 5: ("hexahedron", 8),
    6: ("wedge", 6), 7: ("pyramid", 5), 8: ("line3", 3), 9: ("triangle6", 6), 10: ("quad9", 9),
    11: ("tetra10", 10), 12: ("hexahedron27", 27), 13: ("wedge18", 18), 14: ("pyramid14", 14),
    15: ("vertex", 1), 16: ("quad8", 8), 17: ("hexahedron20", 20), 18: ("wedge15", 15), 19: ("pyramid13", 13),
}  # fmt: skip
"""Cells of meshio and their number of nodes by gmsh's number of the type."""

ORDER = {
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
}
"""Places in gmsh's cells of the nodes in meshio's order, where they differ."""


HEAD = r"\$MeshFormat\s+([0-9.]+)\s+([01])\s+([0-9]+)\s"  # format, binary, size of numbers


def refuse_format_1(path: Path) -> NoReturn:
    """Raise ValueError for a file of gmsh from before it had a line of its format."""
    raise ValueError(f"{path}: format 1 of gmsh: expected format 2.2 or 4.1 (Mesh.MshFileVersion)")


@dataclass
class _Numbers:
    """Numbers of a section, taken one after the other."""

    path: Path
    section: str
    values: Floats
    at: int = 0

    def take(self, count: float) -> Floats:
        """The next numbers."""
        if not 0 <= count <= len(self.values) - self.at:
            raise self.fail(f"expected {count:g} more numbers, found {len(self.values) - self.at}")
        self.at += int(count)
        return self.values[self.at - int(count) : self.at]

    def take_integers(self, count: float) -> list[int]:
        """The next numbers, which are integers."""
        return [int(value) for value in self.integers(self.take(count))]

    def integers(self, values: Floats) -> Integers:
        """Numbers as integers."""
        if (bad := (values != np.round(values)) | (np.abs(values) > 2.0**53)).any():
            raise self.fail(f"{values[bad][0]:g}: expected an integer")
        return values.astype(np.int64)

    def fail(self, text: str) -> ValueError:
        """Error that names the file and the section."""
        return ValueError(f"{self.path}, ${self.section}: {text}")

    def end(self) -> None:
        """Raise ValueError for numbers that are left."""
        if rest := len(self.values) - self.at:
            raise self.fail(f"{rest} numbers more than its counts say: expected none")


def read_msh(path: Path) -> RawMesh:
    """Mesh with the physical groups, or without any the entities.

    Raises ValueError with the section, and for a node that is not there, a cell twice, a wrong count.
    """
    with path.open("rb") as file:
        head = re.search(HEAD, file.read(4096).decode("latin-1"))
    if not head or not re.fullmatch(r"2|2\.[0-9]|4\.1", head[1]) or (head[2] == "1" and head[3] != "8"):
        shown = head[1] if head else "none"
        raise ValueError(f"{path}: format {shown}: expected 2.2 or 4.1 (Mesh.MshFileVersion)")
    parts = (
        read_sections(path, {kind: size for kind, (_, size) in KINDS.items()})
        if head[2] == "1"
        else _texts(path)
    )
    for name in ("MeshFormat", "Nodes", "Elements"):
        if name not in parts:
            raise ValueError(f"{path}: no section ${name}: expected a mesh of gmsh")
    if "PartitionedEntities" in parts:
        raise ValueError(f"{path}: a mesh in partitions: expected one without (Mesh.PartitionCreate... = 0)")
    names = _names(path, str(parts.get("PhysicalNames", "")))
    read = _cells4 if head[1].startswith("4") else _cells2
    return _mesh(path, names, *read(path, parts))


def _texts(path: Path) -> dict[str, str | Floats]:
    """Sections of a text file by name."""
    text = path.read_text(encoding="utf-8", errors="replace")
    parts: dict[str, str | Floats] = {}
    at = 0
    while start := re.compile(r"^\$(\w+)[^\S\n]*\n", re.MULTILINE).search(text, at):
        name = start[1]
        end = re.compile(rf"^\$End{name}\b", re.MULTILINE).search(text, start.end())
        if not end:
            raise ValueError(f"{path}: ${name} has no $End{name}: expected a whole file")
        if name in parts and name in ("PhysicalNames", "Entities", "Nodes", "Elements"):
            raise ValueError(f"{path}: ${name} twice: expected it once")
        parts[name], at = text[start.end() : end.start()], end.end()
    return parts


def _section(path: Path, parts: dict[str, str | Floats], name: str) -> _Numbers:
    body = parts[name]
    words = body.split() if isinstance(body, str) else []
    try:
        values = np.array(words, float) if isinstance(body, str) else body
    except ValueError:
        bad = next(word for word in words if not re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", word))
        raise ValueError(f"{path}, ${name}: {bad}: expected a number") from None
    if not np.isfinite(values).all():
        raise ValueError(f"{path}, ${name}: {values[~np.isfinite(values)][0]}: expected finite numbers")
    return _Numbers(path, name, values)


def _names(path: Path, text: str) -> dict[tuple[int, int], str]:
    """Names of physical groups by dimension and tag."""
    lines = [line for line in text.splitlines() if line.strip()]
    names: dict[tuple[int, int], str] = {}
    for line in lines[1:]:
        row = re.fullmatch(r'\s*(\d)\s+(\d+)\s+"(.*)"\s*', line)
        if not row or (key := (int(row[1]), int(row[2]))) in names:
            raise ValueError(
                f'{path}, $PhysicalNames: {line.strip()}: expected dimension, number, "name", once'
            )
        names[key] = row[3]
    if lines and lines[0].strip() != str(len(names)):
        raise ValueError(
            f"{path}, $PhysicalNames: {lines[0].strip()}: expected {len(names)}, the number of names"
        )
    return names


def _cells4(path: Path, parts: dict[str, str | Floats]) -> tuple[Integers, Floats, list[Any]]:
    """Numbers and places of nodes; cells of format 4.1: type, numbers, nodes, entity, physical tags."""
    tags: dict[tuple[int, int], list[int]] = {}
    if "Entities" in parts:
        entities = _section(path, parts, "Entities")
        for d, count in enumerate(entities.take_integers(4)):
            for _ in range(count):
                [tag] = entities.take_integers(1)
                entities.take(6 if d else 3)
                tags[d, tag] = [
                    abs(tag_of) for tag_of in entities.take_integers(entities.take_integers(1)[0])
                ]
                if d:
                    entities.take(entities.take_integers(1)[0])
        entities.end()
    nodes = _section(path, parts, "Nodes")
    blocks, total, *_ = nodes.take_integers(4)
    numbers, points = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for _ in range(blocks):
        d, _, parametric, count = nodes.take_integers(4)
        numbers.append(nodes.integers(nodes.take(count)))
        width = 3 + (d if parametric else 0)
        points.append(nodes.take(count * width).reshape(count, width)[:, :3])
    nodes.end()
    if sum(map(len, numbers)) != total:
        raise nodes.fail(f"{sum(map(len, numbers))} nodes: expected {total}, as its first line says")
    elements = _section(path, parts, "Elements")
    blocks, total, *_ = elements.take_integers(4)
    cells, counted = [], 0
    for _ in range(blocks):
        d, entity, kind, count = elements.take_integers(4)
        size = _size(elements, kind)
        rows = elements.integers(elements.take(count * (1 + size))).reshape(count, 1 + size)
        if tags and (d, entity) not in tags:
            raise elements.fail(f"entity {entity} of dimension {d}: expected one of $Entities")
        here = [np.full(count, tag) for tag in tags.get((d, entity), [])]
        cells.append((kind, rows[:, 0], rows[:, 1:], np.full(count, entity), here))
        counted += count
    elements.end()
    if counted != total:
        raise elements.fail(f"{counted} elements: expected {total}, as its first line says")
    return np.concatenate(numbers), np.concatenate(points), cells


def _size(elements: _Numbers, kind: int) -> int:
    if kind not in KINDS:
        raise elements.fail(f"elements of type {kind}: {ORDERS}")
    return KINDS[kind][1]


def _cells2(path: Path, parts: dict[str, str | Floats]) -> tuple[Integers, Floats, list[Any]]:
    """As _cells4, of format 2.2, in which an element has a line for each of its physical groups."""
    nodes = _section(path, parts, "Nodes")
    rows = nodes.take(4 * nodes.take_integers(1)[0]).reshape(-1, 4)
    nodes.end()
    elements = _section(path, parts, "Elements")
    flat = elements.integers(elements.values).tolist()
    [count] = elements.take_integers(1)
    by_kind: dict[int, dict[tuple[int, ...], list[int]]] = {}
    at = 1
    for _ in range(count):
        elements.at = at
        elements.take(3)
        number, kind, n_tags = flat[at : at + 3]
        size = _size(elements, kind)
        elements.take(n_tags + size)
        tag, entity = map(abs, [*flat[at + 3 : at + 3 + n_tags], 0, 0][:2])
        nodes_of = tuple(flat[at + 3 + n_tags : at + 3 + n_tags + size])
        row = by_kind.setdefault(kind, {}).setdefault(nodes_of, [number, entity])
        if tag in row[2:]:
            raise elements.fail(f"element {number} is element {row[0]} again: expected it once in each group")
        row.append(tag)
        at += 3 + n_tags + size
    elements.at = at
    elements.end()
    cells = []
    for kind, rows_of in by_kind.items():
        lines_of = list(rows_of.values())
        tags = [
            [row[k] if k < len(row) else 0 for row in lines_of] for k in range(2, max(map(len, lines_of)))
        ]
        number, entity = np.array([row[:2] for row in lines_of], np.int64).T
        cells.append((kind, number, np.array(list(rows_of), np.int64), entity, list(map(np.array, tags))))
    return nodes.integers(rows[:, 0]), rows[:, 1:], cells


def _mesh(
    path: Path, names: dict[tuple[int, int], str], numbers: Integers, points: Floats, cells: list[Any]
) -> RawMesh:
    order = np.argsort(numbers, kind="stable")
    known = numbers[order]
    if (np.diff(known) == 0).any():
        raise ValueError(f"{path}, $Nodes: node {known[1:][np.diff(known) == 0][0]} twice: expected it once")
    if not len(cells) or not len(known):
        raise ValueError(
            f"{path}: {len(known)} nodes, {sum(len(c[1]) for c in cells)} elements: expected a mesh"
        )
    data, entities = [], []
    groups: dict[str, dict[int, list[Integers]]] = {}
    tagged: dict[str, tuple[int, int]] = {}
    for kind, elements, nodes, entity, tags in cells:
        at = np.minimum(np.searchsorted(known, nodes), len(known) - 1)
        if (bad := known[at] != nodes).any():
            row = np.flatnonzero(bad.any(1))[0]
            raise ValueError(f"{path}: element {elements[row]}: node {nodes[row][bad[row]][0]}: no such node")
        name, _ = KINDS[kind]
        data.append(Cells.plain(name, order[at][:, ORDER.get(name, slice(None))]))
        entities.append(entity)
        here = dimension(name)
        for tags_of in tags:
            for tag in np.unique(tags_of[tags_of > 0]).tolist():
                title = names.get((here, tag), f"block_{tag}")
                tagged[title] = max(tagged.get(title, (0, 0)), (here, tag))
                groups.setdefault(title, {}).setdefault(len(data) - 1, []).append(
                    np.flatnonzero(tags_of == tag)
                )
    sets = {
        title: tuple(
            np.unique(np.concatenate(at[k])) if k in at else np.zeros(0, np.int64) for k in range(len(data))
        )
        for title, at in sorted(groups.items(), key=lambda item: (tagged[item[0]][1], item[0]))
    }
    if empty := [name for name in names.values() if name not in groups]:
        text = f"physical groups {', '.join(empty)} have no cells"
        warnings.warn(f"{path}: {text} (Mesh.SaveAll = 1 of format 2.2?)", ModelWarning, stacklevel=4)
    numbered = np.concatenate([rows[1] for rows in cells])
    if (again := np.flatnonzero(np.bincount(np.unique(numbered, return_inverse=True)[1].ravel()) > 1)).size:
        raise ValueError(
            f"{path}, $Elements: element {np.unique(numbered)[again[0]]} twice: expected it once"
        )
    zero = np.zeros(max(len(points), len(numbered)), np.int64)
    labels = Labels(numbers, zero, numbered, zero, ("",))
    return RawMesh(points, tuple(data), labels, sets, numbers={ENTITIES: tuple(entities)})
