"""Named groups of the cells of a mesh, and which of them are the blocks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .raw import RawMesh, Rows
from .shapes import Integers, dimension, place

PHYSICAL = "gmsh:physical"
"""Cell data of meshio that has the physical group of a cell, or 0."""

ENTITIES = "gmsh:geometrical"
"""Cell data with the entity of gmsh of a cell, which is its block where there are no groups."""

NO_BLOCK = (
    r"ranks?|mpi|proc.*|ghosts?|partition.*|owners?|valid.*|active|flags?|mask|stat(?:us|e)|visib.*|damage.*"
    r"|crack.*|broken|iter.*|steps?|times?|levels?|stage"
)
"""Words in names of cell data of ranks and results."""

OF_BLOCKS = (
    r"mat|mat(?:erials?|id|ids|no|num)|materialids?|blocks?|blockids?|regions?|regionids?|parts?|partids?|zones?"
    r"|layers?|domains?|subdomains?|groups?|attributes?|attribs?|phys.*|medi(?:um|a)|entit(?:y|ies)|tags?"
    r"|markers?|labels?|prop(?:erty|erties|s|id)?|lith.*|rocks?|soils?|geo.*|facies|units?|sections?"
    r"|components?|bod(?:y|ies)|(?:el)?sets?|strat.*|formations?|objects?|bricks?|stones?|grains?"
)
"""Words in names of cell data whose numbers are those of blocks."""

WORDS = r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+"
"""Words of a name: parts between capitals, digits and other signs."""

MOST_NUMBERED = 2  # cells each of which may be a block of its own


def groups_of(mesh: RawMesh, data: str | None = None) -> Mapping[str, Rows]:
    """All groups of cells, each whole, or those of equal numbers in cell data.

    data: name of the cell data to take; by default the groups of the file, or gmsh's entities, or the only
    cell data of whole numbers with a name that blocks have.  Raises ValueError where there is none.
    """
    dimensions = [dimension(entry.kind) for entry in mesh.cells]
    if data is not None:
        if not _is_whole(mesh.numbers[data]):
            raise ValueError(f"blocks = {data}: expected one whole number for each cell")
        return numbered_groups(mesh.numbers[data], dimensions, {})
    if mesh.groups:
        return mesh.groups
    integral = {name: parts for name, parts in mesh.numbers.items() if _is_whole(parts)}
    if ENTITIES in integral:
        return numbered_groups(integral[ENTITIES], dimensions, {})
    named = [name for name, parts in integral.items() if _may_be_blocks(name, parts)]
    if len(named) != 1:
        text = f"several arrays with numbers of blocks, {', '.join(named)}" if named else "no groups"
        known = ", ".join(integral)
        wanted = f"--blocks NAME with the numbers of the blocks, of {known}" if known else "cell sets"
        raise ValueError(f"the mesh has {text}: expected groups of gmsh, sets of elements, or {wanted}")
    return numbered_groups(integral[named[0]], dimensions, {})


def _is_whole(parts: Sequence[NDArray[Any]]) -> bool:
    """Whether there is one whole number for each cell."""
    return all(
        part.size == len(part)
        and (part.dtype.kind in "iu" or (part.dtype.kind == "f" and bool((part == np.round(part)).all())))
        for part in parts
    )


def _may_be_blocks(name: str, parts: Sequence[NDArray[Any]]) -> bool:
    """Whether cell data are taken for numbers of blocks, as their name says, and not for those of cells."""
    numbers = np.concatenate([part.ravel() for part in parts])
    cells_of_own = len(numbers) > MOST_NUMBERED and len(np.unique(numbers)) == len(numbers)
    words = [word.lower() for word in re.findall(WORDS, name)]
    if cells_of_own or any(re.fullmatch(NO_BLOCK, word) for word in words):
        return False
    return any(re.fullmatch(OF_BLOCKS, word) for word in words)


def numbered_groups(
    numbers: Sequence[NDArray[Any]], dimensions: Sequence[int], called: Mapping[tuple[int, int], str]
) -> dict[str, Rows]:
    """Groups of equal numbers, in their order; called: names by dimension and number, others are block_N."""
    groups: dict[str, list[Integers]] = {}
    order: dict[str, int] = {}
    for k, (d, values) in enumerate(zip(dimensions, numbers, strict=True)):
        tags = np.asarray(values).ravel().astype(np.int64)
        for tag in np.unique(tags).tolist():
            name = called.get((d, tag), f"block_{tag}")
            rows = groups.setdefault(name, [np.zeros(0, np.int64)] * len(dimensions))
            rows[k] = np.union1d(rows[k], np.flatnonzero(tags == tag))
            order[name] = tag  # the solids come last
    return {name: tuple(groups[name]) for name in sorted(groups, key=order.__getitem__)}


OF_PROGRAMS = r"_.*|(?:Point|Line|Curve|Surface|Volume)\d+|Internal_Selection.*|Eall"
"""Names that CAE, gmsh, PrePoMax and cgx give to groups that the user has not named."""


def blocks_of(
    cells: dict[str, Integers],
    parts: dict[str, Integers],
    choice: list[str] | None,
    centres: Floats,
    mesh: RawMesh,
) -> tuple[list[str], Integers]:
    """Names of the blocks and the number of the block of each cell.

    cells, parts: groups and instances, with the numbers of their cells.  choice: names of the blocks, or
    patterns.  By default they are the groups, without those of all cells or of whole instances and those that
    programs name (OF_PROGRAMS) if the others have all once.
    Raises ValueError with the number, the place and the groups of a cell that is in two blocks or in none.
    """
    total = len(centres)
    filled = {name: rows for name, rows in cells.items() if len(rows)}
    programs = {
        name for name in filled if name in mesh.of_programs or re.fullmatch(OF_PROGRAMS, name, re.IGNORECASE)
    }
    if choice is not None:
        known = {**parts, **filled}
        chosen: dict[str, Integers] = {}
        for word in choice:
            here = [name for name in known if fnmatchcase(name, word)]
            if not here:
                raise ValueError(
                    f"blocks = {word}: expected groups of the mesh: {', '.join(known) or 'none'}"
                )
            chosen |= {name: known[name] for name in here}
        return _numbered(chosen, total, centres, "")
    inner = {name: rows for name, rows in filled.items() if name not in programs}
    partial = {name: rows for name, rows in inner.items() if len(rows) < total}
    unions = _unions(partial, parts, total)
    finer = {name: rows for name, rows in partial.items() if name not in unions}
    for groups in (partial, finer):
        if groups and _once(groups, total):
            return _numbered(groups, total, centres, "")
    if parts and _once(parts, total) and (len(parts) > 1 or not inner) and not partial:
        return _numbered(parts, total, centres, "")
    every = {
        name: rows
        for name, rows in filled.items()
        if len(rows) < total and not name.startswith("_") and name not in mesh.of_programs
    }
    if every and _once(every, total):
        return _numbered(every, total, centres, "")
    if inner and not partial:  # each of them has all cells
        name = next((name for name in inner if name in mesh.defined), next(iter(inner)))
        return _numbered({name: inner[name]}, total, centres, "")
    advice = _advice({**filled, **parts}, total, programs | unions, mesh.defined)
    return _numbered(inner or filled or parts, total, centres, advice)


def _unions(groups: dict[str, Integers], parts: dict[str, Integers], total: int) -> set[str]:
    """Groups of all cells of one instance or more."""
    part = np.full(total, len(parts))
    for k, rows in enumerate(parts.values()):
        part[rows] = k
    size = np.bincount(part, minlength=len(parts) + 1)
    counts = {name: np.bincount(part[rows], minlength=len(parts) + 1) for name, rows in groups.items()}
    return {
        name
        for name, count in counts.items()
        if parts and (count[:-1] * (count - size)[:-1] == 0).all() and not count[-1]
    }


def _once(groups: dict[str, Integers], total: int) -> bool:
    return bool((np.bincount(np.concatenate(list(groups.values())), minlength=total) == 1).all())


def _numbered(
    groups: dict[str, Integers], total: int, centres: Floats, advice: str
) -> tuple[list[str], Integers]:
    names = list(groups)
    block = np.full(total, -1, np.int64)
    for k, name in enumerate(names):
        if (twice := groups[name][block[groups[name]] >= 0]).size:
            cell = int(twice[0])
            inside = [group for group in names if cell in groups[group]]
            text = f"{len(twice)} of {total} cells are in two groups, as a cell at {place(centres[cell])}"
            text = f"{text} in {' and '.join(inside)}"
            raise ValueError(
                f"{text}: expected one block for each: {advice or 'name the blocks, --blocks A,B,...'}"
            )
        block[groups[name]] = k
    if (lost := np.flatnonzero(block < 0)).size:
        text = f"{len(lost)} of {total} cells are in no block, as a cell at {place(centres[lost[0]])}"
        raise ValueError(f"{text}: expected a group for each{advice and f'; {advice}'}")
    return names, block


def _advice(known: dict[str, Integers], total: int, programs: set[str], defined: frozenset[str]) -> str:
    """What to do: groups that have every cell once.

    Those that the elements were defined with come first, then others of the user, the largest first.
    """
    for first, last in ((defined, programs), (frozenset[str](), programs), (frozenset[str](), set[str]())):
        chosen: list[str] = []
        seen = np.zeros(total, bool)
        for name in sorted(known, key=lambda name: (name not in first, name in last, -len(known[name]))):
            if len(known[name]) < total and not seen[known[name]].any():
                chosen.append(name)
                seen[known[name]] = True
        if chosen and seen.all():
            return f"name the blocks, as --blocks {','.join(chosen)}"
    return ""
