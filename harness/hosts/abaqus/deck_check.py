"""Check of a whole deck, `model(text)`: steps, and whether materials, sections and elements fit each other.

Constants and state variables of the joint are compared with the contract of asperity. What Abaqus itself
would say about the deck is not known.
"""

from __future__ import annotations

import numpy as np
from asperity import contract
from deck import DeckError, Keyword, read
from deck_model import (
    COHESIVE,
    READERS,
    SOLIDS,
    Model,
    Step,
    rows_of_boundary,
    rows_of_cload,
    rows_of_dload,
)

VARIABLES = {
    "node output": {"U", "RF"} | {f"{name}{i}" for name in ("U", "RF") for i in (1, 2, 3)},
    "element output": {"S", "E", "SDV"},
    "node print": {f"{name}{i}" for name in ("U", "RF") for i in (1, 2, 3)},
    "el print": {"SDV1"},
}


def model(text: str) -> Model:
    """Model of a deck; raises DeckError."""
    found = Model()
    keywords = read(text)
    for keyword in keywords:
        reader = READERS.get(keyword.name)
        if reader is not None:
            reader(found, keyword)
    _read_steps(found, keywords)
    if not found.steps:
        raise DeckError("no *Step")
    for check in CHECKS:
        check(found)
    return found


def _read_steps(found: Model, keywords: list[Keyword]) -> None:
    inside: list[Keyword] | None = None
    for keyword in keywords:
        if keyword.name == "step":
            inside = [keyword]
        elif keyword.name == "end step":
            found.steps.append(_step(found, inside or []))
            inside = None
        elif inside is not None:
            inside.append(keyword)
        elif keyword.name == "boundary":
            found.boundary.append(keyword)
            list(rows_of_boundary(found, keyword))


def _step(found: Model, keywords: list[Keyword]) -> Step:
    head = keywords[0]
    procedures = [keyword for keyword in keywords if keyword.name in ("static", "dynamic")]
    if len(procedures) != 1 or procedures[0] is not keywords[1]:
        raise head.error("expected one procedure, *Static or *Dynamic, right after it")
    explicit = procedures[0].name == "dynamic"
    values = procedures[0].data[0]
    if explicit and (len(values) != 2 or values[0] or procedures[0].number(values[1]) <= 0.0):
        raise procedures[0].error(f"{', '.join(values)}: expected an empty field and the duration")
    if not explicit:
        _check_static(head, procedures[0])
    for keyword in keywords[2:]:
        name = keyword.options.get("amplitude")
        if name is not None and name not in found.amplitudes:
            raise keyword.error(f"amplitude = {name}: does not exist")
        for rows, kind in (
            (rows_of_boundary, "boundary"),
            (rows_of_cload, "cload"),
            (rows_of_dload, "dload"),
        ):
            if keyword.name == kind:
                list(rows(found, keyword))
        _check_output(found, keyword)
    return Step(head.options["name"], explicit, keywords)


def _check_static(head: Keyword, procedure: Keyword) -> None:
    values = procedure.numbers()
    direct = "direct" in procedure.options
    if len(values) != (2 if direct else 4) or min(values) <= 0.0 or values[0] > values[1]:
        wanted = (
            "increment and duration"
            if direct
            else "first increment, duration, smallest and largest increment"
        )
        raise procedure.error(f"{values}: expected {wanted}, all > 0")
    if not direct and not values[2] <= values[0] <= values[3]:
        raise procedure.error(f"first increment {values[0]:g}: expected from {values[2]:g} to {values[3]:g}")
    needed = round(values[1] / (values[0] if direct else values[3]))
    if needed > int(head.options.get("inc", "100")):
        raise head.error(f"inc = {head.options.get('inc', '100')}: expected at least {needed} increments")
    if head.options.get("unsymm", "").upper() != "YES":
        raise head.error("unsymm=YES is missing, which friction needs")


def _check_output(found: Model, keyword: Keyword) -> None:
    """Sets and variables of output requests."""
    known = VARIABLES.get(keyword.name)
    if known is None:
        return
    for option, sets in (("nset", found.nsets), ("elset", found.elsets)):
        if option in keyword.options and keyword.options[option] not in sets:
            raise keyword.error(f"{option} = {keyword.options[option]}: does not exist")
    for name in keyword.data[0]:
        if name not in known:
            raise keyword.error(f"{name}: expected one of {', '.join(sorted(known))}")


def _check_sections(found: Model) -> None:
    for number, (kind, _) in found.elements.items():
        if number not in found.sections:
            raise DeckError(f"element {number} has no section")
        material = found.materials[found.sections[number][0]]
        if kind in COHESIVE and (material.props is None or not material.statev):
            raise DeckError(
                f"*Material, name={material.name}: expected *User Material and *Depvar for {kind}"
            )
        if kind in SOLIDS and material.elastic is None:
            raise DeckError(f"*Material, name={material.name}: expected *Elastic for {kind}")


def _check_user_materials(found: Model) -> None:
    """Constants, state variables, thickness and procedure fit each other."""
    explicit = any(step.explicit for step in found.steps)
    if explicit and not all(step.explicit for step in found.steps):
        raise DeckError("static and explicit steps in one deck")
    for material in found.materials.values():
        if explicit and material.density is None:
            raise DeckError(
                f"*Material, name={material.name}: *Density is missing, which *Dynamic, Explicit needs"
            )
        if material.props is None:
            continue
        planes = contract.check(np.array(material.props))
        names = contract.statev_names(planes, material.props[contract.index("W0")] > 0.0)
        expected = [name.replace("offset", "separation") if explicit else name for name in names]
        if material.statev != expected:
            raise DeckError(
                f"*Material, name={material.name}: *Depvar: expected {len(names)}: {', '.join(expected)}"
            )
        if not explicit and not material.unsymmetric:
            raise DeckError(f"*Material, name={material.name}: unsymm is missing, which friction needs")
        for name, thickness in found.sections.values():
            if name == material.name and thickness != material.props[contract.index("h")]:
                raise DeckError(f"*Cohesive Section: thickness {thickness:g}: expected PROPS 9 of {name}")
    for number, values in found.solution.items():
        needed = len(found.materials[found.sections[number][0]].statev)
        if len(values) != needed:
            raise DeckError(
                f"*Initial Conditions: element {number}: {len(values)} state variables: expected {needed}"
            )


def _check_geometry(found: Model) -> None:
    """Elements are not turned over; both faces of a joint coincide and belong to something."""
    held = {
        node
        for keyword in found.boundary
        for nodes, _, _ in rows_of_boundary(found, keyword)
        for node in nodes
    }
    solid = {node for kind, nodes in found.elements.values() if kind in SOLIDS for node in nodes}
    for number, (kind, nodes) in found.elements.items():
        points = np.array([found.nodes[node] for node in nodes])
        half = len(nodes) // 2
        lower, upper = points[:half], points[half:]
        if found.dimension == 2:
            upper = upper[::-1]
        if kind in SOLIDS and not _volume(lower, upper) > 0.0:
            raise DeckError(f"element {number}: its nodes are not in the order of {kind}")
        if kind in COHESIVE:
            if np.abs(upper - lower).max() > 1.0e-9:
                raise DeckError(f"element {number}: node {nodes[half]} does not lie on the lower face")
            loose = [node for node in nodes if node not in solid | held]
            if loose:
                raise DeckError(f"element {number}: node {loose[0]} belongs to no solid and has no *Boundary")
            up = np.eye(found.dimension)[-1]
            if not _volume(lower, upper + up) > 0.0:
                raise DeckError(
                    f"element {number}: its normal does not point from the lower to the upper face"
                )


def _volume(lower: np.ndarray, upper: np.ndarray) -> float:
    """Volume between two faces that are counter-clockwise seen from above (approximate if twisted)."""
    if lower.shape[1] == 2:
        x, y = np.concatenate([lower, upper[::-1]]).T
        return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    middle = 0.5 * (lower + upper)
    area = 0.5 * np.cross(middle[2] - middle[0], middle[3] - middle[1])
    return float(area @ (upper - lower).mean(axis=0))


CHECKS = (_check_sections, _check_user_materials, _check_geometry)
