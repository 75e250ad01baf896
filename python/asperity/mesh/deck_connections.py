"""What an Abaqus deck connects beside common nodes: surfaces, ties, links, and nodes that keywords hold."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .deck import Block
from .deck_model import Model
from .deck_types import type_of
from .shapes import FACES, Integers

TYING = {"TIE", "PIN", "BEAM", "LINK", "SLIDER", "LINEAR", "QUADRATIC", "BILINEAR", "C BIQUAD"}
"""Types of *MPC that hold displacements of their first node to those of the others."""

ROUNDING = 1.0e-9
"""Sum of the coefficients of an equation, over the largest, up to which equal displacements fulfil it."""


@dataclass(frozen=True)
class Link:
    """Line of *MPC or *Equation that equal displacements of all its nodes fulfil.

    pairs: each node of the first is held by one of the second, otherwise by all of them together.
    """

    block: Block
    row: int
    first: Integers
    second: Integers
    pairs: bool


@dataclass(frozen=True)
class Tie:
    """Two surfaces, tied or in contact: their nodes, the elements of which they are faces, and the line."""

    block: Block
    nodes: tuple[Integers, Integers]
    elements: tuple[Integers, Integers]


def surface(model: Model, block: Block, word: str, k: int | None = None) -> tuple[Integers, Integers]:
    """Nodes of a surface that a keyword names, and the elements of its faces.

    A surface without names of faces has all nodes of its elements.

    Raises ValueError for a name that is not there.
    """
    before, point, local = word.strip("\"'").rpartition(".")
    home = model.scope(block, before) if point and before.upper() in model.by_name else model.model
    key = (local if home is not model.model else word.strip("\"'")).upper()
    if ("NSET", key) in home.sets and ("SURFACE", key) not in home.sets:
        return model.members(home, "NSET", key), np.zeros(0, np.int64)
    if ("SURFACE", key) not in home.sets:
        raise block.fail(f"{word}: no such surface", k)
    nodes, elements = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for part in home.sets["SURFACE", key]:
        if (part.parameters.get("TYPE") or "ELEMENT").upper() != "ELEMENT":
            continue  # of no elements, as one that is rigid
        if "COMBINE" in part.parameters:
            for row, words in part.rows():
                for entry in (surface(model, part, name, row) for name in words if name):
                    nodes.append(entry[0])
                    elements.append(entry[1])
            continue
        for row, words in part.rows():
            at = model.of(part, model.instance(part, home), "ELSET", words[0], (), row)
            label = words[1].upper() if len(words) > 1 else ""
            elements.append(at)
            sides = _nodes_of_faces(model, at, label) if re.fullmatch("S[1-6]", label) else None
            nodes.append(model.nodes_of(at) if sides is None else sides)
    return np.unique(np.concatenate(nodes)), np.unique(np.concatenate(elements))


def _nodes_of_faces(model: Model, elements: Integers, label: str) -> Integers | None:
    """Nodes of a face of elements, also of cohesive ones; None where an element has no such face."""
    nodes, side, count = [np.zeros(0, np.int64)], int(label[1]) - 1, 0
    for (kind, data), rows in zip(model.cells, model.by_array(elements), strict=True):
        if len(rows) and side < len(FACES.get(kind, ())):
            nodes.append(data[rows][:, FACES[kind][side]].ravel())
            count += len(rows)
    for entry in model.cohesive:
        faces = FACES[{4: "quad", 6: "wedge", 8: "hexahedron"}[entry.nodes.shape[1]]]
        at = np.isin(entry.places, elements)
        if at.any() and side < len(faces):
            nodes.append(entry.nodes[at][:, faces[side]].ravel())
            count += int(at.sum())
    return np.concatenate(nodes) if count == len(elements) else None


def ties_of(model: Model, keyword: str = "TIE") -> list[Tie]:
    """Pairs of surfaces of a keyword, which are tied or in contact, with nodes and elements of both."""
    ties = []
    for block in model.deck:
        if block.keyword != keyword:
            continue
        for k, words in block.rows():
            if len(words) >= 2:
                sides = [surface(model, block, word, k) for word in words[:2]]
                nodes, elements = zip(*sides, strict=True)
                ties.append(Tie(block, (nodes[0], nodes[1]), (elements[0], elements[1])))
    return ties


def links_of(model: Model) -> Iterator[Link]:
    """Links by *MPC and *Equation; lines of other types, or of names that are not there, are passed over."""
    for block in model.deck:
        if block.keyword == "MPC":
            for k, words in block.rows():
                nodes = [nodes_of_name(model, block, word) for word in words[1:] if word]
                if words[0].upper() in TYING and len(nodes) > 1:
                    yield Link(block, k, nodes[0], np.unique(np.concatenate(nodes[1:])), len(nodes) == 2)
        elif block.keyword == "EQUATION":
            yield from _equations(model, block)


def _equations(model: Model, block: Block) -> Iterator[Link]:
    """Links by equations of one displacement: number of terms, then node, direction and factor of each."""
    rows = block.rows()
    for k, head in rows:
        count = int(head[0]) if head[0].isdigit() else 0
        words: list[str] = []
        while len(words) < 3 * count and (row := next(rows, None)) is not None:
            words += row[1]
        terms = [words[i : i + 3] for i in range(0, 3 * count, 3)]
        if count < 2 or len(words) != 3 * count or {term[1] for term in terms} - {"1", "2", "3"}:
            continue
        factors = np.array(block.numbers([term[2] for term in terms], k))
        if len({term[1] for term in terms}) > 1 or abs(factors.sum()) > ROUNDING * np.abs(factors).max():
            continue
        nodes = [nodes_of_name(model, block, term[0]) for term in terms]
        sides = [
            np.concatenate(
                [np.zeros(0, np.int64), *(at for at, f in zip(nodes, factors, strict=True) if s * f > 0)]
            )
            for s in (1, -1)
        ]
        yield Link(block, k, sides[0], sides[1], count == 2)


def nodes_of_name(model: Model, block: Block, word: str) -> Integers:
    """Nodes that a word names, by number, set or surface: of the model, or of a part where it has none."""
    before, point, local = word.strip("\"'").rpartition(".")
    home = model.by_name.get(before.upper(), model.model) if point else model.model
    name = local if point and home is not model.model else word.strip("\"'")
    scopes = [home] if home is not model.model else [model.model, *model.scopes]
    for scope in scopes:
        numbers = model.nodes[id(scope)]
        if name.isdigit() and np.isin(int(name), numbers.flat):
            return numbers(block, np.array([int(name)]))
        if ("NSET", name.upper()) in scope.sets:
            return model.members(scope, "NSET", name.upper())
        if ("SURFACE", name.upper()) in scope.sets:
            return surface(model, block, word)[0] if scope is home else np.zeros(0, np.int64)
        if ("ELSET", name.upper()) in scope.sets:
            return model.nodes_of(model.members(scope, "ELSET", name.upper()))
    return np.zeros(0, np.int64)


def nodes_named(model: Model, keywords: Sequence[str]) -> Integers:
    """Nodes that keywords name, by number, set or surface; what is none of these is passed over."""
    nodes = [np.zeros(0, np.int64)]
    for block in model.deck:
        if block.keyword not in keywords:
            continue
        words = [value for value in block.parameters.values() if value]
        for _, row in block.rows():
            is_mpc = block.keyword == "MPC"
            words += (
                row[1:]
                if is_mpc
                else row[: 1 if block.keyword == "BOUNDARY" else None : 3 if len(row) > 2 else 1]
            )
        nodes += [nodes_of_name(model, block, word) for word in words]
    return np.unique(np.concatenate(nodes))


def nodes_unread(model: Model) -> Integers:
    """Nodes of elements that may be solids and that are not read."""
    nodes = [np.zeros(0, np.int64)]
    for scope in model.scopes:
        for block, _, words in scope.others:
            if type_of(block.name("TYPE").upper()).refused:
                digits = {int(word) for row in words for word in row if word.isdigit()}
                known = model.nodes[id(scope)]
                nodes.append(known.places[np.isin(known.flat, list(digits))])
    return np.unique(np.concatenate(nodes))
