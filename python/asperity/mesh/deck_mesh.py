"""The mesh of an Abaqus deck: its solids, named faces, sets and cohesive elements."""

from __future__ import annotations

import warnings
from collections import Counter

import numpy as np

from ..material import ModelWarning
from .deck import Block
from .deck_connections import ties_of
from .deck_model import Model, Unread, sides_of
from .deck_types import type_of
from .labels import Labels
from .raw import Cells, Pairs, RawMesh
from .shapes import Integers, dimension

SAME_PLACE = 1e-6
"""Distance of two tied nodes over the size of the model at which they are one."""


def mesh_of(model: Model) -> RawMesh:
    """The mesh of a deck, whose cohesive elements are joints; ValueError for solids that are not read."""
    for scope in model.scopes:
        for block, _, _ in scope.others:
            name = block.name("TYPE").upper()
            if refused := type_of(name).refused:
                raise block.fail(f"type={name}: not read: {refused}")
    if not model.first[-1]:
        text = "no elements" if not model.model.nodes else "nodes without elements"
        wanted = "expected *Element, in the model or in a part with an instance"
        raise ValueError(f"{model.path}: {text}: {wanted}")
    left_out: dict[str, str] = {}
    seen = Counter(key for scope in model.scopes for key in scope.sets)
    point_sets: dict[str, Integers] = {}
    sets: dict[str, list[Integers]] = {}
    facets: dict[str, list[tuple[str, Integers, Integers]]] = {}
    sources: dict[tuple[str, str], str] = {}
    blocks_of: dict[str, list[Block]] = {}
    for scope in model.scopes:
        for (kind, key), title in scope.titles.items():
            name = f"{scope.name}_{title}" if seen[kind, key] > 1 and scope.name else title
            source = f"{scope.name}.{title}" if scope.name else title
            if (earlier := sources.setdefault((kind, name.upper()), source)) != source:
                text = f"sets {earlier} and {source} both become {name}: expected other names"
                raise ValueError(f"{model.path}: {text}")
            if kind == "NSET":
                known = point_sets.get(name, np.zeros(0, np.int64))
                point_sets[name] = np.union1d(known, model.members(scope, kind, key))
            elif kind == "ELSET":
                blocks_of.setdefault(name, []).extend(scope.sets[kind, key])
                sets.setdefault(name, []).append(model.members(scope, kind, key))
            else:
                try:
                    for cell, nodes, owner in model.faces(scope, key):
                        facets.setdefault(cell, []).append((name, nodes, owner))
                except Unread as why:
                    left_out[name] = str(why)
    cells = list(model.cells)
    none = [np.zeros(0, np.int64)] * (len(cells) + len(facets))
    cell_sets = {
        name: [*model.by_array(np.concatenate(parts)), *none[len(cells) :]] for name, parts in sets.items()
    }
    owners = [np.full(len(data), -1) for _, data in cells]
    for kind, entries in facets.items():
        first = 0
        for name, faces, _ in entries:
            members = cell_sets.setdefault(name, list(none))
            members[len(cells)] = np.append(members[len(cells)], first + np.arange(len(faces)))
            first += len(faces)
        cells.append((kind, np.concatenate([faces for _, faces, _ in entries])))
        owners.append(np.concatenate([owner for *_, owner in entries]))
    _set_apart(model, cells, cell_sets, point_sets)
    _warn(model, left_out)
    types = [*model.types, *(np.full(len(data), "") for _, data in cells[len(model.cells) :])]
    sectioned = {
        name
        for name, blocks in blocks_of.items()
        if any(name.upper() == section.block.name("ELSET").upper() for section in model.sections)
    }
    parts = {
        scope.name: (*model.by_array(model.elements[id(scope)].places), *none[len(model.cells) :])
        for scope in model.scopes
        if scope.name and scope.elements
    }
    return RawMesh(
        model.points,
        tuple(
            Cells(kind, nodes, owner, names)
            for (kind, nodes), owner, names in zip(cells, owners, types, strict=True)
        ),
        _labels(model),
        {name: tuple(cell_sets[name]) for name in sorted(cell_sets)},
        point_sets,
        parts=parts,
        of_programs=frozenset(name for name, blocks in blocks_of.items() if _are(blocks, "INTERNAL")),
        defined=frozenset(name for name, blocks in blocks_of.items() if _are(blocks, "TYPE")) | sectioned,
        joints=_joints(model),
        left_out=left_out,
    )


def _labels(model: Model) -> Labels:
    """Numbers of the nodes and elements in their scopes."""
    nodes, elements = (
        [numbers[id(scope)] for scope in model.scopes] for numbers in (model.nodes, model.elements)
    )
    home_of_node = np.repeat(np.arange(len(nodes)), [len(numbers.flat) for numbers in nodes])
    homes = np.repeat(np.arange(len(elements)), [len(numbers.flat) for numbers in elements])
    order = np.argsort(np.concatenate([numbers.places for numbers in elements]))
    return Labels(
        np.concatenate([numbers.flat for numbers in nodes]),
        home_of_node,
        np.concatenate([numbers.flat for numbers in elements])[order],
        homes[order],
        tuple(scope.name for scope in model.scopes),
    )


def _set_apart(
    model: Model,
    cells: list[tuple[str, Integers]],
    cell_sets: dict[str, list[Integers]],
    point_sets: dict[str, Integers],
) -> None:
    """Give faces another name where a set of other nodes has theirs: both are groups of the mesh."""
    d = model.dimension
    titles = {name.upper(): name for name in point_sets}
    for name in list(cell_sets):
        at = [k for k, (kind, _) in enumerate(cells) if dimension(kind) == d - 1 and len(cell_sets[name][k])]
        title = titles.get(name.upper())
        if not at or title is None:
            continue
        nodes = np.unique(np.concatenate([cells[k][1][cell_sets[name][k]].ravel() for k in at]))
        if not np.array_equal(nodes, point_sets[title]):
            title = f"{name}_faces"
            if title.upper() in {known.upper() for known in (*cell_sets, *point_sets)}:
                raise ValueError(f"{model.path}: {name} and {title}: expected other names of sets")
            text = f"{name} is a set of nodes and one of faces that has other nodes: the faces are {title}"
            warnings.warn(f"{model.path}: {text}", ModelWarning, stacklevel=5)
        if title != name:
            moved = cell_sets.setdefault(title, [np.zeros(0, np.int64)] * len(cells))
            for k in at:
                moved[k], cell_sets[name][k] = cell_sets[name][k], np.zeros(0, np.int64)


def _warn(model: Model, left_out: dict[str, str]) -> None:
    """Name the elements that are not solids, and the surfaces that are not read."""
    lost: Counter[str] = Counter()
    for (kind, _), types in zip(model.cells, model.types, strict=True):
        if dimension(kind) < model.dimension:
            lost.update(types.tolist())
    texts = [
        f"{count} elements of type {name} name faces or nodes only: they are not written"
        for name, count in lost.items()
    ]
    others: Counter[str] = Counter()
    for scope in model.scopes:
        for block, numbers, _ in scope.others:
            if not type_of(block.name("TYPE").upper()).sides:
                others[block.name("TYPE").upper()] += len(numbers)
    texts += [
        f"{count} elements of type {name}, {type_of(name).left_out}, are left out: what they carry is "
        "yours to add"
        for name, count in others.items()
    ]
    texts += [f"surface {name} is left out: {why}" for name, why in left_out.items()]
    for text in texts:
        warnings.warn(f"{model.path}: {text}", ModelWarning, stacklevel=5)


def _joints(model: Model) -> dict[str, tuple[Pairs, ...]]:
    """Sides of the cohesive elements, by the set of their section, or of their keyword without one."""
    node = _tied(model)
    titles: dict[int, tuple[str, str]] = {}  # scope and set of an element
    ways: dict[int, str | None] = {}
    for section in model.sections:
        title = section.scope.titles.get(("ELSET", section.block.name("ELSET").upper()), "")
        for place in section.elements[section.elements >= model.first[-1]].tolist():
            titles[place] = section.scope.name, title
            ways[place] = section.block.parameters.get("STACK DIRECTION")
    seen = Counter(title for _, title in set(titles.values()))
    joints: dict[str, list[Pairs]] = {}
    for entry in model.cohesive:
        elset = entry.block.parameters.get("ELSET") or "joint"
        names, groups = [], dict[tuple[str, str | None], list[int]]()
        for k, place in enumerate(entry.places.tolist()):
            home, title = titles.get(place, (entry.scope.name, elset))
            names.append(f"{home}_{title}" if seen[title] > 1 and home else title)
            groups.setdefault((names[-1], ways.get(place)), []).append(k)
        for (name, way), rows in groups.items():
            lower, upper = sides_of(entry.nodes[rows], way, entry.block)
            joints.setdefault(name, []).append(Pairs(node[lower], node[upper], entry.block.head()))
    return {name: tuple(joints[name]) for name in sorted(joints)}


def _tied(model: Model) -> Integers:
    """Node that each node of a cohesive element becomes where a tie connects it with one at its place."""
    from scipy.spatial import KDTree

    points, node = model.points, np.arange(len(model.points))
    cohesive_only = np.zeros(len(points), bool)
    for entry in model.cohesive:
        cohesive_only[entry.nodes] = True
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    for _, cells in model.cells:
        cohesive_only[cells] = False
    for tie in ties_of(model) if cohesive_only.any() else ():
        for mine, other in ((0, 1), (1, 0)):
            from_nodes = tie.nodes[mine][cohesive_only[tie.nodes[mine]]]
            to_nodes = tie.nodes[other][~cohesive_only[tie.nodes[other]]]
            if len(from_nodes) and len(to_nodes):
                away, nearest = KDTree(points[to_nodes]).query(points[from_nodes])
                same = away <= SAME_PLACE * size
                node[from_nodes[same]] = to_nodes[nearest[same]]
    return node


def _are(blocks: list[Block], parameter: str) -> bool:
    """Whether all blocks of a set have a parameter."""
    return all(parameter in block.parameters for block in blocks)
