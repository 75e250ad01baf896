"""Types of the elements of sections in a deck of Abaqus."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from .deck import Block
from .deck_scopes import whole

Name = tuple[str, str]
"""Part, "" outside of parts, and number of an element or name of a set in it."""


def types_of_sections(deck: list[Block], keywords: Sequence[str]) -> dict[int, set[str]]:
    """Types of the elements of each section with one of these keywords, by the id of its block.

    A set may name others, which come before or after it; those that name each other alone have no types.
    """
    sets: dict[Name, set[str]] = {}
    of_number: dict[str, dict[str, set[str]]] = {}
    part, parts, scopes = "", {}, {}
    for block in deck:
        if block.keyword == "PART":
            part = block.name("NAME").upper()
        elif block.keyword == "END PART":
            part = ""
        elif block.keyword == "INSTANCE":
            parts[block.name("NAME").upper()] = block.name("PART").upper()
        scopes[id(block)] = part
        if block.keyword != "ELEMENT":
            continue
        kind = block.name("TYPE").upper()
        for _, words in block.rows():
            of_number.setdefault(part, {}).setdefault(words[0], set()).add(kind)
        if elset := block.parameters.get("ELSET"):
            sets.setdefault((part, elset.upper()), set()).add(kind)
    named: list[tuple[Name, Name]] = []
    for block in deck:
        if block.keyword == "ELSET":
            scope = scopes[id(block)]
            name = scope, block.name("ELSET").upper()
            own = sets.setdefault(name, set())
            home = parts.get((block.parameters.get("INSTANCE") or "").upper(), scope)
            for member in _members(block, of_number.get(home, {})):
                instance, _, local = member.upper().rpartition(".")
                at = parts.get(instance, home)
                own |= of_number.get(at, {}).get(local, set())
                named.append((name, (at, local)))
    while any(not sets.get(one, set()) <= sets[name] for name, one in named):
        for name, one in named:
            sets[name] |= sets.get(one, set())
    return {
        id(block): sets.get((scopes[id(block)], block.name("ELSET").upper()), set())
        for block in deck
        if block.keyword in keywords
    }


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
            yield from filter(None, words)
