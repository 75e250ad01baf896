"""What an Abaqus deck connects beside common nodes: surfaces, ties, and nodes that keywords hold."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .deck import Block
from .deck_model import Model
from .deck_types import type_of
from .shapes import FACES, Integers


@dataclass(frozen=True)
class Tie:
    """Two surfaces that are tied: their nodes, the elements of which they are faces, and the line."""

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


def ties_of(model: Model) -> list[Tie]:
    """Ties, with the nodes and elements of both surfaces."""
    ties = []
    for block in model.deck:
        if block.keyword != "TIE":
            continue
        for k, words in block.rows():
            if len(words) >= 2:
                sides = [surface(model, block, word, k) for word in words[:2]]
                nodes, elements = zip(*sides, strict=True)
                ties.append(Tie(block, (nodes[0], nodes[1]), (elements[0], elements[1])))
    return ties


def nodes_named(model: Model, keywords: Sequence[str]) -> Integers:
    """Nodes that keywords name, by number, set or surface; what is none of these is passed over."""
    nodes = [np.zeros(0, np.int64)]
    for block in model.deck:
        if block.keyword not in keywords:
            continue
        words = [value for value in block.parameters.values() if value]
        for _, row in block.rows():
            words += row[:1] if block.keyword == "BOUNDARY" else row[:: 3 if len(row) > 2 else 1]
        for word in words:
            before, point, local = word.strip("\"'").rpartition(".")
            home = model.by_name.get(before.upper(), model.model) if point else model.model
            name = local if point and home is not model.model else word.strip("\"'")
            numbers = model.nodes[id(home)]
            if name.isdigit() and np.isin(int(name), numbers.flat):
                nodes.append(numbers(block, np.array([int(name)])))
            elif ("NSET", name.upper()) in home.sets:
                nodes.append(model.members(home, "NSET", name.upper()))
            elif ("SURFACE", name.upper()) in home.sets:
                nodes.append(surface(model, block, word)[0])
            elif ("ELSET", name.upper()) in home.sets:
                nodes.append(model.nodes_of(model.members(home, "ELSET", name.upper())))
    return np.unique(np.concatenate(nodes))


def nodes_unread(model: Model) -> Integers:
    """Nodes of elements that may be solids and that are not read."""
    nodes = [np.zeros(0, np.int64)]
    for scope in model.scopes:
        for block, _, words in scope.others:
            if type_of(block.name("TYPE").upper()).refused:
                given = {int(word) for row in words for word in row if word.isdigit()}
                known = model.nodes[id(scope)]
                nodes.append(known.places[np.isin(known.flat, list(given))])
    return np.unique(np.concatenate(nodes))
