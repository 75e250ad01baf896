"""Abaqus decks: parts, their instances moved and turned, sets and surfaces, as a RawMesh.

None of meshio, meshlane and meshio++ reads all of that; a comment in pyproject.toml says what each lacks.
"""

from __future__ import annotations

import warnings
from difflib import get_close_matches
from pathlib import Path

from ..material import ModelWarning
from .deck import Block, blocks
from .deck_mesh import mesh_of
from .deck_model import Model
from .deck_scopes import Scope
from .deck_take import take
from .raw import RawMesh
from .shapes import Integers

READ = (
    "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "PART", "END PART", "INSTANCE", "END INSTANCE", "ASSEMBLY",
    "END ASSEMBLY", "INCLUDE", "NGEN", "NCOPY", "ELGEN", "ELCOPY",
)  # fmt: skip

EMPTY = ("PART", "END PART", "END INSTANCE", "ASSEMBLY", "END ASSEMBLY")
"""Keywords that have no data lines."""

REFUSED = (
    "NFILL", "NMAP", "PARAMETER", "IMPORT", "SYMMETRIC MODEL GENERATION", "SYSTEM",
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
    model = read_model(path)
    for scope in model.unused:
        count = sum(len(group[2]) for group in scope.elements)
        text = f"{path}: part {scope.name} has no instance: {count} elements left out"
        warnings.warn(text, ModelWarning, stacklevel=3)
    for keywords, why in (
        (TIED, "connections are those of common nodes, and of cohesive elements tied node to node"),
        (LOADS, "loads and supports of the new mesh are yours"),
    ):
        here = dict.fromkeys(block.keyword for block in model.deck if block.keyword in keywords)
        if here:
            text = f"{path}: {', '.join(f'*{word.title()}' for word in here)}: not carried over: {why}"
            if "CLOAD" in here:
                text += "; *Cload of a set loads each of its nodes, of a node that a joint doubles both"
            warnings.warn(text, ModelWarning, stacklevel=3)
    return mesh_of(model)


def read_model(path: Path) -> Model:
    """What a deck numbers and names, in parts, instances and the model; ValueError with file and line."""
    parts: dict[str, Scope] = {}
    model = Scope("")
    instances: dict[str, Scope] = {}
    here, used = model, set()
    opened: Block | None = None
    deck = blocks(path)

    def members(scope: Scope, block: Block, kind: str, name: str) -> Integers:
        return Model(path, [], scope, [], []).numbers_of(scope, block, kind, name)

    for block in deck:
        word = block.keyword
        if word in EMPTY and (line := next(block.rows(), None)):
            raise block.fail(f"{', '.join(line[1])}: expected a keyword", line[0])
        if word in ("PART", "INSTANCE", "ASSEMBLY", "STEP") and opened is not None:
            raise block.fail(
                f"*{opened.keyword.title()} has no end before: expected *End {opened.keyword.title()}"
            )
        if word in REFUSED:
            raise block.fail("not read: expected nodes and elements in lists (a deck that Abaqus/CAE writes)")
        if word == "PART":
            here, opened = _new(parts, block, Scope(block.name("NAME"))), block
        elif word == "INSTANCE":
            block.allow("NAME", "PART", "NSET", "ELSET")
            part = parts.get(block.name("PART").upper())
            if part is None:
                known = ", ".join(scope.name for scope in parts.values()) or "none"
                raise block.fail(f"part={block.name('PART')}: no such part before this line: {known}")
            used.add(part.name.upper())
            here = _instance_of(part, block.name("NAME"))
            here.move = opened = block
            _new(instances, block, here)
            for kind in ("NSET", "ELSET"):  # of all nodes or elements of the instance
                if name := block.parameters.get(kind):
                    model.add(kind, name, block)
        elif word in ("END PART", "END INSTANCE"):
            if opened is None or opened.keyword != word.removeprefix("END "):
                raise block.fail(f"expected after *{word.removeprefix('END ').title()}")
            here, opened = model, None
        elif word.endswith("SECTION") and "ELSET" in block.parameters:
            here.sections.append(block)
        elif word not in READ and word not in TIED and word not in LOADS:
            if like := get_close_matches(word, READ, 1, 0.8):
                raise block.fail(f"unknown: expected *{like[0].title()}")
        else:
            take(here, block, members)
    if opened is not None:
        raise opened.fail(f"expected *End {opened.keyword.title()} after it")
    no_assembly = not any(block.keyword == "ASSEMBLY" for block in deck) and not model.nodes
    if len(parts) == 1 and no_assembly and not instances:
        [part] = parts.values()
        model, used = _with(_instance_of(part, ""), model), {*parts}
        text = f"{path}: no *Assembly: part {part.name} is the model, where its nodes are"
        warnings.warn(text, ModelWarning, stacklevel=3)
    unused = [part for name, part in parts.items() if name not in used]
    return Model(path, deck, model, list(instances.values()), unused)


def _instance_of(part: Scope, name: str) -> Scope:
    """Scope of an instance, which may add nodes, elements and sets to those of the part."""
    return Scope(
        name,
        list(part.nodes),
        list(part.elements),
        list(part.others),
        list(part.sections),
        {k: list(v) for k, v in part.sets.items()},
        dict(part.titles),
        dict(part.generated_numbers),
    )


def _with(scope: Scope, other: Scope) -> Scope:
    """A scope that has elements, sections and sets of another one, too."""
    scope.elements += other.elements
    scope.others += other.others
    scope.sections += other.sections
    for key, blocks_of in other.sets.items():
        scope.sets.setdefault(key, []).extend(blocks_of)
    scope.titles = other.titles | scope.titles
    scope.generated_numbers |= other.generated_numbers
    return scope


def _new(scopes: dict[str, Scope], block: Block, scope: Scope) -> Scope:
    if scopes.setdefault(scope.name.upper(), scope) is not scope:
        raise block.fail(f"name={scope.name}: there before: expected another name")
    return scope
