"""Layers of solids of a deck that are joints in CalculiX: their normal, their thickness and the steps."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

import numpy as np

from ..contract import Floats
from .deck import Block, table
from .deck_model import Cohesive, Model, Section, sides_of
from .shapes import FACES, Integers, area, place

ALONG = np.cos(np.radians(10.0))
"""Least cosine between the normal of a face and the axis N of its layer, which may be curved."""

THICKNESS = 0.02
"""Relative difference of a thickness that may be one of curved sides."""

LAYERS = "wedge", "hexahedron"
"""Kinds of the solids of layers."""

WAYS = {"wedge": ((6, "3"),), "hexahedron": ((8, "3"), (8, "1"), (8, "2"))}
"""Numbers of nodes and stack directions of the elements of layers."""

SOLIDS = *LAYERS, "hexahedron20", "tetra", "tetra10"
"""Kinds of the solids beside them."""


def layer_problems(model: Model, thickness: Mapping[int, float]) -> list[str]:
    """What is wrong with the layers of a deck, with file and line and what was expected.

    thickness: of the constants of each layer (PROPS 9), by the id of its section.
    """
    layers = [section for section in model.sections if id(section.block) in thickness]
    if not layers:
        return []
    wrong = list(_steps(model.deck))
    solids = list(_solids(model))
    inside = np.concatenate([section.elements for section in layers])
    beside = _faces_beside(solids, inside)
    for section in layers:
        wrong += _of_section(model, section, thickness[id(section.block)], beside)
    return list(dict.fromkeys(wrong))


def layers_of(model: Model, sections: Container[int]) -> Iterator[Cohesive]:
    """Elements of layers as cohesive ones: the nodes of the lower and of the upper side along their axis N.

    sections: of layers, by id.  Elements with another normal are left out.
    """
    solids = list(_solids(model))
    for section in model.sections:
        axis, _ = _axis(model.deck, section.block)
        if id(section.block) not in sections or axis is None:
            continue
        for block, kind, places, nodes in solids:
            for count, way in WAYS[kind] if kind in WAYS else ():
                lower, upper = sides_of(nodes[:, :count], way, block)
                normal, _ = area(model.points[lower])
                along = (np.abs(normal @ axis) >= ALONG) & np.isin(places, section.elements)
                above = (model.points[upper] - model.points[lower]).mean(1) @ axis > 0.0
                for at, sides in ((along & above, (lower, upper)), (along & ~above, (upper, lower))):
                    order = slice(None) if sides[0] is lower else slice(None, None, -1)
                    rows = np.concatenate([side[at][:, order] for side in sides], 1)
                    if len(rows):
                        yield Cohesive(block, section.scope, places[at], rows)


def _steps(deck: Sequence[Block]) -> Iterator[str]:
    """Steps of large displacements."""
    for block in deck:
        if block.keyword == "STEP" and (block.parameters.get("NLGEOM", "NO") or "YES").upper() != "NO":
            yield f"{block.head()}: NLGEOM: expected none, as the strain of a layer is its separation over h"


def _solids(model: Model) -> Iterator[tuple[Block, str, Integers, Integers]]:
    """Keywords, kinds, places (n,) and nodes (n, k) of the solids."""
    for scope in model.scopes:
        for block, kind, numbers, rows in scope.elements:
            if len(numbers) and kind in SOLIDS:
                places = model.elements[id(scope)](block, numbers)
                yield block, kind, places, model.nodes[id(scope)](block, rows)


def _faces_beside(
    solids: Sequence[tuple[Block, str, Integers, Integers]], inside: Integers
) -> dict[int, list[tuple[int, ...]]]:
    """Corners of the faces that elements of layers share with other solids, by the place of the element."""
    of_layers: dict[tuple[int, ...], tuple[int, tuple[int, ...]]] = {}
    for _, kind, places, nodes in solids:
        for k in np.flatnonzero(np.isin(places, inside)).tolist() if kind in LAYERS else ():
            for face in FACES[kind]:
                corners = tuple(nodes[k, list(face)].tolist())
                of_layers[tuple(sorted(corners))] = int(places[k]), corners
    ends = np.unique([node for corners in of_layers for node in corners])
    found: dict[int, list[tuple[int, ...]]] = {}
    for _, kind, places, nodes in solids:
        others = nodes[~np.isin(places, inside)]
        for face in FACES[kind]:
            rows = np.sort(others[:, list(face[: 3 if kind.startswith("tetra") else 4])], axis=1)
            for row in rows[np.isin(rows, ends).all(1)].tolist():
                if tuple(row) in of_layers:
                    element, around = of_layers[tuple(row)]
                    found.setdefault(element, []).append(around)
    return found


def _of_section(
    model: Model, section: Section, h: float, beside: Mapping[int, list[tuple[int, ...]]]
) -> Iterator[str]:
    """Elements without a face beside other solids along the axis N, and those of another thickness."""
    axis, name = _axis(model.deck, section.block)
    head = section.block.head()
    if axis is None:
        if not any(_is_orientation(block, name) for block in model.deck):
            yield f"{head}: orientation={name}: no *Orientation has this name: expected one"
        return
    turned, others = list[Floats](), list[tuple[Floats, float]]()
    for element in section.elements.tolist():
        faces = beside.get(element, ())
        x = [model.points[list(corners)] for corners in faces]
        sides = [k for k, face in enumerate(x) if abs(area(face[None])[0][0] @ axis) >= ALONG]
        if faces and not sides:
            turned.append(x[0].mean(0))
        # a layer ends at a tip, where its sides have nodes in common
        elif len(sides) == 2 and not {*faces[sides[0]]} & {*faces[sides[1]]}:
            t = abs((x[sides[1]].mean(0) - x[sides[0]].mean(0)) @ axis)
            if abs(t - h) > THICKNESS * h:
                others.append((x[sides[0]].mean(0), float(t)))
    total = len(section.elements)
    if turned:
        text = f"{len(turned)} of {total} elements, as at {place(turned[0])}, have another normal than {name}"
        yield f"{head}: {text}: expected an *Orientation whose third axis is the normal"
    if others:
        where, t = others[0]
        text = f"{len(others)} of {total} elements, as at {place(where)}, are {t:g} thick"
        yield f"{head}: {text}: expected {h:g} (PROPS 9)"


def _axis(deck: Sequence[Block], section: Block) -> tuple[Floats | None, str]:
    """Axis N of a section and its name; None for an *Orientation of another system or with a rotation."""
    name = (section.parameters.get("ORIENTATION") or "").upper()
    if not name:
        return np.array([0.0, 0.0, 1.0]), "z"
    for block in deck:
        if _is_orientation(block, name):
            system = (block.parameters.get("SYSTEM") or "RECTANGULAR").upper()
            rows = table(block, 6, 2)
            if system.startswith("R") and len(rows) == 1:
                axis = np.cross(rows[0, :3], rows[0, 3:])
                size = float(np.linalg.norm(axis))
                return (axis / size if size > 0.0 else None), f"the third axis of *Orientation {name}"
    return None, name


def _is_orientation(block: Block, name: str) -> bool:
    return block.keyword == "ORIENTATION" and (block.parameters.get("NAME") or "").upper() == name
