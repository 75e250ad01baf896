"""Water in the joints of an Abaqus deck: whether its field and its elements go with PROPS 23."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .deck import Block
from .deck_connections import nodes_of_name
from .deck_model import Model
from .shapes import Integers, place

PORE = "COH2D4P", "COH3D6P", "COH3D8P", "COHAX4P"
"""Beginnings of cohesive elements that carry a pore pressure themselves; a T may follow."""


def water_problems(model: Model, joints: Iterable[tuple[Block, Block, int, set[str]]]) -> list[str]:
    """What is wrong with the water, of joints by section, user material, PROPS 23 and types of elements."""
    fields = [(block.parameters.get("VARIABLE") or "1", block) for block in model.deck if _is_field(block)]
    empty, filled = ({n: block for n, block in fields if _gives(block) == full} for full in (False, True))
    texts = []
    for section, material, number, types in joints:
        if number == 0:
            continue
        if wet := sorted(element for element in types if element.startswith(PORE)):
            dry = ", ".join(element.rstrip("TP") for element in wet)
            texts.append(
                f"{section.head()}: {', '.join(wet)} carry the water themselves, and so does the law, by "
                f"field {number} (PROPS 23): expected water = 0, or {dry}"
            )
        if str(number) in filled:
            named = [_named(model, block) for variable, block in fields if variable == str(number)]
            rows = [np.zeros(0, np.int64), *(rows.ravel() for rows in model.of_sections({id(section)}))]
            nodes = np.unique(np.concatenate(rows))
            unset = np.setdiff1d(nodes, np.concatenate([nodes if at is None else at for at in named]))
            if len(unset):
                where = (
                    f"{len(unset)} of {len(nodes)} nodes of the joint, as at {place(model.points[unset[0]])}"
                )
                text = f"{material.head()}: water = {number}: the field has no value at {where}"
                texts.append(f"{text}: expected one for the nodes of both sides")
        else:
            bare = empty.get(str(number))
            texts.append(
                f"{material.head()}: water = {number}: expected *Field, variable={number} or initial "
                "conditions of this field, for the water pressure; the deck has "
                + (f"one without data ({bare.where()})" if bare else "none")
            )
    return texts


def _named(model: Model, block: Block) -> Integers | None:
    """Nodes to which a keyword gives values of its field; None for those of results of another analysis."""
    if "FILE" in block.parameters:
        return None
    return np.concatenate(
        [np.zeros(0, np.int64), *(nodes_of_name(model, block, row[0]) for _, row in block.rows())]
    )


def _is_field(block: Block) -> bool:
    """Whether a block gives values of a predefined field, in a step or at the start."""
    kind = (block.parameters.get("TYPE") or "").upper()
    return block.keyword == "FIELD" or (block.keyword == "INITIAL CONDITIONS" and kind == "FIELD")


def _gives(block: Block) -> bool:
    """Whether there are data: lines, or results of another analysis."""
    return "FILE" in block.parameters or any(True for _ in block.rows())
