"""Water in the joints of an Abaqus deck: whether its field and its elements go with PROPS 23."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from .. import contract
from .deck import Block, blocks
from .deck_model import whole

PORE = "COH2D4P", "COH3D6P", "COH3D8P", "COHAX4P"
"""Beginnings of cohesive elements that carry a pore pressure themselves; a T may follow."""


def problems(path: Path) -> list[str]:
    """What is wrong with the water of the joints in a deck, with file and line.

    A joint is a cohesive section whose material has PROPS of the law. Raises ValueError for a deck that is
    not read, and for one without a joint.
    """
    deck = blocks(path)
    types = _types(deck)
    materials, joints, texts, other_materials, name = {}, 0, [], "", ""
    for block in deck:
        if block.keyword == "MATERIAL":
            name = block.name("NAME").upper()
        elif block.keyword == "USER MATERIAL":
            materials[name] = block, np.concatenate([block.numbers(words, k) for k, words in block.rows()])
    fields = [(block.parameters.get("VARIABLE") or "1", block) for block in deck if _is_field(block)]
    empty, given = ({n: block for n, block in fields if _gives(block) == full} for full in (False, True))
    for block in deck:
        if block.keyword != "COHESIVE SECTION" or block.name("MATERIAL").upper() not in materials:
            continue
        material, props = materials[block.name("MATERIAL").upper()]
        try:
            contract.check(props)
        except ValueError as error:
            other_materials += f"; {material.head()}: {error}"
            continue
        joints += 1
        number = int(props[contract.index("water")])
        if number == 0:
            continue
        elset = block.name("ELSET").upper()
        if not types.get(elset):
            texts.append(f"{block.head()}: elset={elset}: no element is in it")
        wet = sorted(element for element in types.get(elset, ()) if element.startswith(PORE))
        if wet:
            dry = ", ".join(element.rstrip("TP") for element in wet)
            texts.append(
                f"{block.head()}: {', '.join(wet)} carry the water themselves, and so does the law, by field "
                f"{number} (PROPS 23): expected water = 0, or {dry}"
            )
        if str(number) not in given:
            place = empty.get(str(number))
            texts.append(
                f"{material.head()}: water = {number}: expected *Field, variable={number} or initial "
                "conditions of this field, for the water pressure; the deck has "
                + (f"one without data ({place.where()})" if place else "none")
            )
    if not joints:
        raise ValueError(
            f"{path}: expected a *Cohesive Section whose material has PROPS of asperity{other_materials}"
        )
    return texts


def _is_field(block: Block) -> bool:
    """Whether a block gives values of a predefined field, in a step or at the start."""
    kind = (block.parameters.get("TYPE") or "").upper()
    return block.keyword == "FIELD" or (block.keyword == "INITIAL CONDITIONS" and kind == "FIELD")


def _gives(block: Block) -> bool:
    """Whether there are data: lines, or results of another analysis."""
    return "FILE" in block.parameters or any(True for _ in block.rows())


def _types(deck: list[Block]) -> dict[str, set[str]]:
    """Types of the elements of each set; a number in several parts stands for all of them.

    A set may name others, which come before or after it; those that name each other alone have no types.
    """
    sets: dict[str, set[str]] = {}
    of_number: dict[str, set[str]] = {}
    for block in deck:
        if block.keyword != "ELEMENT":
            continue
        kind = block.name("TYPE").upper()
        for _, words in block.rows():
            of_number.setdefault(words[0], set()).add(kind)
        if elset := block.parameters.get("ELSET"):
            sets.setdefault(elset.upper(), set()).add(kind)
    named: list[tuple[str, str]] = []
    for block in deck:
        if block.keyword == "ELSET":
            name = block.name("ELSET").upper()
            own = sets.setdefault(name, set())
            for member in _members(block, of_number):
                own |= of_number.get(member, set())
                named.append((name, member.upper().rpartition(".")[2]))
    while any(not sets.get(part, set()) <= sets[name] for name, part in named):
        for name, part in named:
            sets[name] |= sets.get(part, set())
    return sets


def _members(block: Block, numbers: Iterable[str]) -> Iterator[str]:
    """Numbers and sets of a set; those that it generates are of the given ones."""
    for k, words in block.rows():
        if "GENERATE" in block.parameters:
            given = whole(block, np.array([block.numbers([*filter(None, words)], k)]))[0].tolist()
            if len(given) not in (2, 3) or given[1] < given[0]:
                raise block.fail(f"{', '.join(words)}: expected first, last, step", k)
            generated = range(given[0], given[1] + 1, *given[2:])
            yield from (number for number in numbers if number.isdigit() and int(number) in generated)
        else:
            yield from words
