"""Named groups of the cells of a mesh, and which of them are the blocks."""

from __future__ import annotations

import re
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contract import Floats
from .shapes import Integers, dimension, place

if TYPE_CHECKING:
    import meshio

OWNER = "asperity:owner"
"""Cell data: the number, through all arrays, of the cell that a cell is a face of, or -1."""

TYPE = "asperity:type"
"""Cell data: the type of the element in the deck of Abaqus, or an empty text."""

Members = dict[str, list[Integers]]
"""Names of groups, and for each array of cells the numbers of its cells in the group."""


def groups_of(mesh: meshio.Mesh, data: str | None = None) -> Members:
    """All groups of cells, each whole: cell sets, physical groups of gmsh, or integer cell data.

    data: name of the cell data to take; by default the cell sets and physical groups, or gmsh's entities, or
    the only integer cell data.  Raises ValueError where there is none.
    """
    arrays: dict[str, list[Any]] = mesh.cell_data
    whole = [
        name
        for name, parts in arrays.items()
        if name != OWNER and all(np.asarray(part).dtype.kind in "iu" for part in parts)
    ]
    if data is not None:
        return _of_data(mesh, data)
    groups: Members = {}
    tags = {name: int(tag) for name, (tag, _) in mesh.field_data.items()}
    for name, rows in sorted(mesh.cell_sets.items(), key=lambda item: (tags.get(item[0], 0), item[0])):
        if not name.startswith("gmsh:"):
            groups[name] = [np.asarray([] if part is None else part, np.int64) for part in rows]
    if "gmsh:physical" in whole:
        groups = {**_of_data(mesh, "gmsh:physical"), **groups}
    if groups:
        return groups
    if "gmsh:geometrical" in whole:
        return _of_data(mesh, "gmsh:geometrical")
    if len(whole) != 1:
        known = ", ".join(whole) or "none"
        raise ValueError(
            f"the mesh has no groups: expected groups of gmsh, cell sets or one array of {known}"
        )
    return _of_data(mesh, whole[0])


def _of_data(mesh: meshio.Mesh, data: str) -> Members:
    """Groups of equal numbers in cell data; 0 of gmsh is no physical group."""
    called = {(dim, tag): name for name, (tag, dim) in mesh.field_data.items() if "phys" in data}
    groups: Members = {}
    order: dict[str, int] = {}
    for k, (block, values) in enumerate(zip(mesh.cells, mesh.cell_data[data], strict=True)):
        numbers = np.asarray(values, np.int64)
        for tag in np.unique(numbers).tolist():
            name = called.get((dimension(block.type), tag), f"block_{tag}")
            rows = groups.setdefault(name, [np.zeros(0, np.int64)] * len(mesh.cells))
            groups[name][k] = np.union1d(rows[k], np.flatnonzero(numbers == tag))
            order[name] = tag  # the solids come last
    return {name: groups[name] for name in sorted(groups, key=order.__getitem__)}


GIVEN = r"_.*|(?:Point|Line|Curve|Surface|Volume)\d+|Internal_Selection.*|Eall"
"""Names that CAE, gmsh, PrePoMax and cgx give to groups that the user has not named."""


def blocks_of(
    cells: dict[str, Integers], choice: list[str] | None, centres: Floats
) -> tuple[list[str], Integers]:
    """Names of the blocks and the number of the block of each cell.

    cells: groups, with the numbers of their cells.  choice: names of the blocks, or patterns.  By default
    they are the groups, without one of all cells and those that programs name (GIVEN) if the others have all
    once.
    Raises ValueError with the number, the place and the groups of a cell that is in two blocks or in none.
    """
    total = len(centres)
    own = {name: rows for name, rows in cells.items() if len(rows) and not name.startswith("instance:")}
    parts = {name.partition(":")[2]: rows for name, rows in cells.items() if name.startswith("instance:")}
    if choice is not None:
        known = {**parts, **own}
        chosen: dict[str, Integers] = {}
        for word in choice:
            here = [name for name in known if fnmatchcase(name, word)]
            if not here:
                raise ValueError(
                    f"blocks = {word}: expected groups of the mesh: {', '.join(known) or 'none'}"
                )
            chosen |= {name: known[name] for name in here}
        return _numbered(chosen, total, centres, {})
    inner = {name: rows for name, rows in own.items() if not re.fullmatch(GIVEN, name, re.IGNORECASE)}
    partial = {name: rows for name, rows in inner.items() if len(rows) < total}
    if partial and _once(partial, total):
        return _numbered(partial, total, centres, {})
    if parts and _once(parts, total) and (len(parts) > 1 or not inner) and not partial:
        return _numbered(parts, total, centres, {})
    every = {name: rows for name, rows in own.items() if len(rows) < total and not name.startswith("_")}
    if every and _once(every, total):
        return _numbered(every, total, centres, {})
    return _numbered(inner or own or parts, total, centres, {**own, **parts})


def _once(groups: Members | dict[str, Integers], total: int) -> bool:
    return bool((np.bincount(np.concatenate(list(groups.values())), minlength=total) == 1).all())


def _numbered(
    groups: dict[str, Integers], total: int, centres: Floats, known: dict[str, Integers]
) -> tuple[list[str], Integers]:
    names = list(groups)
    block = np.full(total, -1, np.int64)
    for k, name in enumerate(names):
        if (twice := groups[name][block[groups[name]] >= 0]).size:
            cell = int(twice[0])
            inside = [group for group in names if cell in groups[group]]
            text = f"{len(twice)} of {total} cells are in two groups, as a cell at {place(centres[cell])}"
            text = f"{text} in {' and '.join(inside)}"
            raise ValueError(f"{text}: expected one block for each: {_advice(known, total)}")
        block[groups[name]] = k
    if (lost := np.flatnonzero(block < 0)).size:
        text = f"{len(lost)} of {total} cells are in no block, as a cell at {place(centres[lost[0]])}"
        raise ValueError(f"{text}: expected a group for each{_advice(known, total, '; ')}")
    return names, block


def _advice(known: dict[str, Integers], total: int, before: str = "") -> str:
    """What to do: groups that have every cell once, those of the user and the largest first."""
    given = {name for name in known if re.fullmatch(GIVEN, name, re.IGNORECASE)}
    for last in (given, set[str]()):
        chosen: list[str] = []
        seen = np.zeros(total, bool)
        for name in sorted(known, key=lambda name: (name in last, -len(known[name]))):
            if len(known[name]) < total and not seen[known[name]].any():
                chosen.append(name)
                seen[known[name]] = True
        if chosen and seen.all():
            return f"{before}name the blocks, as --blocks {','.join(chosen)}"
    return "" if before else "name the blocks, --blocks A,B,..."
