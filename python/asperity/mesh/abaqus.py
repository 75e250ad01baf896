"""Abaqus decks: parts, their instances moved and turned, sets and surfaces, as a RawMesh.

None of meshio, meshlane and meshio++ reads all of that; a comment in pyproject.toml says what each lacks.
"""

from __future__ import annotations

import warnings
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from ..material import ModelWarning
from .deck import Block, blocks, table
from .deck_model import Model
from .deck_scopes import Scope, whole
from .deck_types import type_of
from .raw import RawMesh

READ = (
    "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "PART", "END PART", "INSTANCE", "END INSTANCE", "ASSEMBLY",
    "END ASSEMBLY", "INCLUDE",
)  # fmt: skip

EMPTY = ("PART", "END PART", "END INSTANCE", "ASSEMBLY", "END ASSEMBLY")
"""Keywords that have no data lines."""

REFUSED = (
    "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "PARAMETER", "IMPORT", "SYMMETRIC MODEL GENERATION",
    "SYSTEM",
)  # fmt: skip
"""Keywords that make nodes and elements, and are not read."""

TIED = (
    "TIE", "MPC", "EQUATION", "COUPLING", "KINEMATIC COUPLING", "DISTRIBUTING COUPLING", "RIGID BODY",
    "EMBEDDED ELEMENT", "CONTACT PAIR", "CONTACT", "SHELL TO SOLID COUPLING",
)  # fmt: skip
"""Keywords that connect parts of the model, which are not carried over."""

LOADS = (
    "BOUNDARY", "CLOAD", "DLOAD", "DSLOAD", "INITIAL CONDITIONS", "TEMPERATURE", "FIELD",
    "PRE-TENSION SECTION",
)  # fmt: skip
"""Keywords of loads and supports, which are not carried over."""


def read_deck(path: Path) -> RawMesh:
    """Mesh of a deck, with its element sets and surfaces as groups of cells and its node sets as spots.

    The sets of parts keep their names, with that of the instance before where several instances have one.
    Raises ValueError with file, line and what is not read; ModelWarning names what is left out.
    """
    parts: dict[str, Scope] = {}
    model = Scope("")
    instances: dict[str, Scope] = {}
    here, used, tied, loads = model, set(), [], []
    opened: Block | None = None
    for block in blocks(path):
        word = block.keyword
        if word in EMPTY and (line := next(block.rows(), None)):
            raise block.fail(f"{', '.join(line[1])}: expected a keyword", line[0])
        if word in ("PART", "INSTANCE", "ASSEMBLY", "STEP") and opened is not None:
            raise block.fail(
                f"*{opened.keyword.title()} has no end before: expected *End {opened.keyword.title()}"
            )
        if word in REFUSED:
            raise block.fail("not read: expected nodes and elements in lists (a deck that Abaqus/CAE writes)")
        if word in TIED:
            tied.append(block)
        elif word in LOADS:
            loads.append(block)
        elif word == "PART":
            here, opened = _new(parts, block, Scope(block.name("NAME"))), block
        elif word == "INSTANCE":
            block.allow("NAME", "PART")
            part = parts.get(block.name("PART").upper())
            if part is None:
                known = ", ".join(scope.name for scope in parts.values()) or "none"
                raise block.fail(f"part={block.name('PART')}: no such part before this line: {known}")
            used.add(part.name.upper())
            here = _instance_of(part, block.name("NAME"))
            here.move = opened = block
            _new(instances, block, here)
        elif word in ("END PART", "END INSTANCE"):
            if opened is None or opened.keyword != word.removeprefix("END "):
                raise block.fail(f"expected after *{word.removeprefix('END ').title()}")
            here, opened = model, None
        elif word not in READ:
            if like := get_close_matches(word, READ, 1, 0.8):
                raise block.fail(f"unknown: expected *{like[0].title()}")
        else:
            _take(here, block)
    if opened is not None:
        raise opened.fail(f"expected *End {opened.keyword.title()} after it")
    for name, part in parts.items():
        if name not in used:
            count = sum(len(group[2]) for group in part.elements)
            warnings.warn(
                f"{path}: part {part.name} has no instance: {count} elements left out",
                ModelWarning,
                stacklevel=3,
            )
    if tied:
        words = ", ".join(f"*{word.title()}" for word in dict.fromkeys(entry.keyword for entry in tied))
        text = f"{path}: {words}: not carried over: connections of the model are those of shared nodes"
        warnings.warn(text, ModelWarning, stacklevel=3)
    if loads:
        words = ", ".join(f"*{word.title()}" for word in dict.fromkeys(block.keyword for block in loads))
        text = f"{path}: {words}: not carried over: loads and supports of the new mesh are yours"
        if any(block.keyword == "CLOAD" for block in loads):
            text += "; *Cload of a set loads each of its nodes, of a node that a joint doubles both"
        warnings.warn(text, ModelWarning, stacklevel=3)
    return Model(path, model, list(instances.values())).mesh()


def _instance_of(part: Scope, name: str) -> Scope:
    """Scope of an instance, which may add nodes, elements and sets to those of the part."""
    return Scope(
        name,
        list(part.nodes),
        list(part.elements),
        list(part.others),
        list(part.refused),
        {k: list(v) for k, v in part.sets.items()},
        dict(part.titles),
    )


def _new(scopes: dict[str, Scope], block: Block, scope: Scope) -> Scope:
    if scopes.setdefault(scope.name.upper(), scope) is not scope:
        raise block.fail(f"name={scope.name}: there before: expected another name")
    return scope


def _take(here: Scope, block: Block) -> None:
    """Nodes, elements, sets and surfaces of a block."""
    word = block.keyword
    if word == "NODE":
        block.allow("NSET", "INPUT")
        rows = table(block, 4, 2)
        here.nodes.append((block, whole(block, rows[:, :1])[:, 0], rows[:, 1:]))
        if name := block.parameters.get("NSET"):
            here.add("NSET", name, block)
    elif word == "ELEMENT":
        block.allow("TYPE", "ELSET", "INPUT")
        _elements(here, block)
        if name := block.parameters.get("ELSET"):
            here.add("ELSET", name, block)
    elif word == "NSET":
        block.allow("NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT")
        here.add("NSET", block.name("NSET"), block)
    elif word == "ELSET":
        block.allow("ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT")
        here.add("ELSET", block.name("ELSET"), block)
    elif word == "SURFACE":
        nodes = (block.parameters.get("TYPE") or "").upper() == "NODE"
        here.add("NSET" if nodes else "SURFACE", block.name("NAME"), block)


def _elements(here: Scope, block: Block) -> None:
    """Numbers and nodes of elements, whose lines may go on."""
    name = block.name("TYPE").upper()
    element = type_of(name)
    if element.refused:
        here.refused.append((block, f"type={name}: not read: {element.refused}"))
        return
    count = element.nodes + 1
    if element.left_out:
        parts: list[list[str]] = []
        first = []
        for k, words in block.rows():
            if parts and element.nodes > 2 and len(parts[-1]) < count:  # of two nodes one may be missing
                parts[-1] += words
            else:
                parts.append(list(words))
                first.append(block.numbers(words[:1], k))
        numbers = whole(block, np.array(first, float).reshape(-1, 1))[:, 0]
        here.others.append((block, numbers, [words[1:] for words in parts]))
        return
    rows, row = [], []
    for k, words in block.rows():
        row += block.numbers(words, k)
        if len(row) > count:
            raise block.fail(f"{len(row) - 1} nodes of an element of type {name}: expected {count - 1}", k)
        if len(row) == count:
            rows.append(row)
            row = []
    if row:
        raise block.fail(f"{len(row) - 1} nodes of the last element of type {name}: expected {count - 1}")
    data = whole(block, np.array(rows, float).reshape(-1, count))
    here.elements.append((block, element.kind, data[:, 0], data[:, 1:]))
