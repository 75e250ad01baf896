"""Nodes, elements, sets and surfaces of one keyword of an Abaqus deck."""

from __future__ import annotations

import re

import numpy as np

from .deck import Block, table
from .deck_generate import GENERATORS, Members, placed
from .deck_scopes import Scope, entity_numbers
from .deck_types import Type, type_of
from .shapes import Integers


def take(here: Scope, block: Block, members: Members) -> None:
    """Nodes, elements, sets and surfaces of a block."""
    word = block.keyword
    if word == "NODE":
        block.allow("NSET", "INPUT", "SYSTEM")
        rows = table(block, 4, 2)
        here.nodes.append((block, entity_numbers(block, rows[:, :1])[:, 0], placed(rows[:, 1:], block)))
        if name := block.parameters.get("NSET"):
            here.add("NSET", name, block)
    elif word == "ELEMENT":
        block.allow("TYPE", "ELSET", "INPUT", "OFFSET")
        _elements(here, block)
        if name := block.parameters.get("ELSET"):
            here.add("ELSET", name, block)
    elif word == "NSET":
        block.allow("NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT")
        here.add("NSET", block.name("NSET"), block)
    elif word == "ELSET":
        block.allow("ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT")
        here.add("ELSET", block.name("ELSET"), block)
    elif word in GENERATORS:
        GENERATORS[word](here, block, members)
    elif word == "SURFACE":
        nodes = (block.parameters.get("TYPE") or "").upper() == "NODE"
        here.add("NSET" if nodes else "SURFACE", block.name("NAME"), block)


def _elements(here: Scope, block: Block) -> None:
    """Numbers and nodes of elements, whose lines may go on."""
    name = block.name("TYPE").upper()
    element = type_of(name)
    offset = block.parameters.get("OFFSET", "0")
    if "OFFSET" in block.parameters and not (element.sides and (offset or "").isdigit()):
        raise block.fail(f"offset={offset}: expected a number, of cohesive elements")
    if not element.kind:
        here.others.append((block, *_words(block, element)))
        return
    count = element.nodes + 1
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
    data = entity_numbers(block, np.array(rows, float).reshape(-1, count))
    here.elements.append((block, element.kind, data[:, 0], data[:, 1:]))


def _words(block: Block, element: Type) -> tuple[Integers, list[list[str]]]:
    """Numbers of elements that are no cells, and the words of their nodes, whose lines may go on."""
    size = re.search(r"(?:[23]D|AX|SC|CSS)(\d+)", block.name("TYPE").upper())
    count = element.nodes or element.sides or (int(size[1]) if size else 0)
    offset = block.parameters.get("OFFSET")
    count //= 1 if offset is None else 2
    parts: list[list[str]] = []
    first = []
    for k, words in block.rows():
        if parts and count > 2 and len(parts[-1]) < count + 1:  # of two nodes one may be missing
            parts[-1] += words
        elif parts and element.refused and not count and block.lines[k - 1].rstrip().endswith(","):
            parts[-1] += words
        else:
            parts.append(list(words))
            first.append(block.numbers(words[:1], k))
    if element.sides and parts and len(parts[-1]) <= count:
        nodes = len(parts[-1]) - 1
        raise block.fail(f"{nodes} nodes of the last element of type {block.name('TYPE')}: expected {count}")
    numbers = entity_numbers(block, np.array(first, float).reshape(-1, 1))[:, 0]
    rows = [words[1:] for words in parts]
    return numbers, rows if offset is None else [_with_other_side(row, int(offset), block) for row in rows]


def _with_other_side(nodes: list[str], offset: int, block: Block) -> list[str]:
    """Nodes of a cohesive element of which the lower side is given, and the offset of the upper one."""
    upper = [str(int(number) + offset) for number in block.numbers(nodes, 0)]
    return nodes + (upper[::-1] if len(upper) == 2 else upper)
