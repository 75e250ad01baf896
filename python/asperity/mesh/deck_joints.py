"""Joints of a deck of Abaqus or CalculiX: their constants, state variables, sections and elements."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from .. import contract
from ..contract import Floats
from .abaqus import read_model
from .deck import Block
from .deck_constants import keyword_problems, report
from .deck_elements import element_problems
from .deck_held import held_problems
from .deck_layers import layer_problems
from .deck_water import water_problems

SECTIONS = "COHESIVE SECTION", "SOLID SECTION"
"""Keywords of the sections of joints: of Abaqus' cohesive elements, and of CalculiX' solids."""
ON_A_LINE = 8
"""Number of constants that Abaqus and CalculiX read from a line."""
CHARACTERS = 20
"""Characters of a number that CalculiX reads."""
ROOM = 21
"""Number of constants that CalculiX has room for, as it comes."""
LINEAR_STEPS = "FREQUENCY", "BUCKLE", "COMPLEX FREQUENCY", "SUBSTRUCTURE GENERATE", "STEADY STATE DYNAMICS"
"""Keywords of steps that are linear perturbations."""
ROUNDING = 1.0e-9
"""Relative difference of two numbers that are the same but for their digits."""


@dataclass
class UserMaterial:
    """A user material with its state variables and constants."""

    name: str
    block: Block
    depvar: Block | None = None
    props: Floats = field(default_factory=lambda: np.zeros(0))
    errors: list[str] = field(default_factory=list)

    def of(self, name: str) -> float:
        """A constant by its name; those that are not there have their default, as a 0 of the first ones."""
        i = contract.index(name)
        value = float(self.props[i]) if i < len(self.props) else 0.0
        return 1.0 if name == "h" and value == 0.0 else value


@dataclass
class Joint:
    """Section of a joint, its material and the types of its elements."""

    section: Block
    material: UserMaterial
    types: set[str]


@dataclass
class Judgement:
    """What is wrong with the joints of a deck, with file and line, what is doubtful, and what was read."""

    wrong: list[str]
    doubtful: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)


def judged(path: Path) -> Judgement:
    """Judgement of the joints of a deck.

    A joint is a cohesive section, or a section of CalculiX' solids, whose material has PROPS of the law.
    Raises ValueError for a deck that is not read, and for one without a joint.
    """
    model = read_model(path)
    deck = model.deck
    explicit = any(block.keyword.startswith("DYNAMIC") and "EXPLICIT" in block.parameters for block in deck)
    materials = _materials(deck)
    types: dict[int, set[str]] = {}
    for section in model.sections:
        types.setdefault(id(section.block), set()).update(model.types_of(section.elements))
    names = {block.name("NAME").upper() for block in deck if block.keyword == "MATERIAL"}
    joints, wrong, notes, used = [], [], [], set()
    for block in deck:
        name = (block.parameters.get("MATERIAL") or "").upper()
        named = block.keyword == SECTIONS[0] or (block.keyword.endswith("SECTION") and name)
        if named and name not in names:
            known = ", ".join(sorted(names))
            wrong.append(
                f"{block.head()}: material={name}: no *Material has this name: expected one of {known}"
            )
        if block.keyword not in SECTIONS:
            continue
        used.add(name)
        material = materials.get(name)
        # of a solid with other constants the UMAT is another one
        if material and (block.keyword == SECTIONS[0] or not material.errors):
            joints.append(Joint(block, material, types.get(id(block), set())))
    faults = [text for material in materials.values() for text in material.errors]
    if not any(not joint.material.errors for joint in joints):
        reasons = "".join(f"; {text}" for text in (*wrong, *faults))
        raise ValueError(
            f"{path}: expected a *Cohesive Section whose material has PROPS of asperity, or a *Solid Section "
            f"for CalculiX{reasons}"
        )
    by_material = {joint.material.name: joint for joint in joints}
    read, doubtful = list[str](), list[str]()
    for joint in by_material.values():
        wrong += joint.material.errors or _material_problems(joint, explicit)
        if not joint.material.errors:
            of_material = [other.section for other in joints if other.material is joint.material]
            of_joint = report(model, joint.material.block.head(), joint.material.props, of_material)
            read += of_joint.lines
            notes += of_joint.warned
            doubtful += of_joint.doubtful
    wrong += keyword_problems(deck, {*by_material}, [joint.section for joint in joints])
    for name, material in materials.items():
        if name not in used and not material.errors:
            wrong.append(f"{material.block.head()}: no section has material={name}: expected one of a joint")
    for joint in joints:
        if joint.section.keyword == SECTIONS[1]:
            texts = _calculix_problems(joint)
            wrong += texts[0]
            notes += texts[1]
        else:
            wrong += _section_problems(joint)
    frictional = [joint for joint in joints if _is_unsymmetric(joint.material)]
    for block in deck if frictional and not explicit else []:
        unsymm = (block.parameters.get("UNSYMM") or "").upper()
        if block.keyword == "STEP" and unsymm == "NO":
            wrong.append(f"{block.head()}: unsymm=NO: friction makes the tangent unsymmetric: expected YES")
    if not explicit and any(joint.section.keyword == SECTIONS[0] for joint in frictional):
        doubtful += _steps_without_unsymm(deck)
    wet = [
        (joint.section, joint.material.block, int(joint.material.of("water")), joint.types)
        for joint in joints
        if joint.section.keyword == SECTIONS[0] and not joint.material.errors
    ]
    cohesive, layers = (
        {id(joint.section): joint.material.of("h") for joint in joints if joint.section.keyword == keyword}
        for keyword in SECTIONS
    )
    wrong += (
        element_problems(model, {**cohesive, **layers})
        + layer_problems(model, layers)
        + water_problems(model, wet)
    )
    wrong += held_problems(model, {*cohesive, *layers})
    return Judgement(wrong, doubtful, notes, read)


def _materials(deck: list[Block]) -> dict[str, UserMaterial]:
    """User materials by name."""
    materials: dict[str, UserMaterial] = {}
    name, depvars = "", {}
    for block in deck:
        if block.keyword == "MATERIAL":
            name = block.name("NAME").upper()
        elif block.keyword == "DEPVAR":
            depvars[name] = block
        elif block.keyword == "USER MATERIAL":
            materials[name] = UserMaterial(name, block)
    for name, material in materials.items():
        material.depvar = depvars.get(name)
        try:
            material.props = _constants(material.block, name)
            contract.check(material.props)
        except ValueError as error:
            head = material.block.head()
            material.errors = [
                text if head in text else f"{head}: {text}" for text in str(error).splitlines()
            ]
    return materials


def _constants(block: Block, name: str) -> Floats:
    """Constants of a material as a host reads them; raises ValueError where it would read others."""
    values: list[float] = []
    rows = list(block.rows())
    for k, words in rows:
        values += block.numbers(words, k)
    text = block.parameters.get("CONSTANTS") or ""
    count = int(text) if text.isdecimal() else -1
    # CalculiX reads a temperature behind them
    if count not in (len(values), len(values) - name.startswith("ABAQUS")):
        raise block.fail(f"constants={text}: expected {len(values)}, the number of the values below")
    for k, words in rows[:-1]:
        if len(words) != ON_A_LINE:
            expected = f"expected {ON_A_LINE} on each line but the last, as others count as 0"
            raise block.fail(f"{len(words)} constants: {expected}", k)
    if rows and len(rows[-1][1]) > ON_A_LINE:
        raise block.fail(f"{len(rows[-1][1])} constants: expected {ON_A_LINE} on a line", rows[-1][0])
    return np.array(values[:count])


def _is_unsymmetric(material: UserMaterial) -> bool:
    """Whether the tangent is unsymmetric."""
    return not material.errors and material.of("mu") > 0.0 and material.of("implex") == 0.0


def _steps_without_unsymm(deck: list[Block]) -> Iterator[str]:
    """Steps of Abaqus/Standard without unsymm; linear perturbations, which are symmetric, are left out."""
    for block, following in pairwise([*deck, Block("END", {})]):
        symmetric = "PERTURBATION" in block.parameters or following.keyword in LINEAR_STEPS
        if block.keyword == "STEP" and "UNSYMM" not in block.parameters and not symmetric:
            yield f"{block.head()}: no unsymm: friction makes the tangent unsymmetric: expected unsymm=YES"


def _material_problems(joint: Joint, explicit: bool) -> Iterator[str]:
    """What is wrong with the material of a joint whose constants are good."""
    material = joint.material
    head, parameters = material.block.head(), material.block.parameters
    kind = (parameters.get("TYPE") or "MECHANICAL").upper()
    if kind != "MECHANICAL":
        yield f"{head}: type={kind}: expected MECHANICAL, for which UMAT and VUMAT are called"
    # CalculiX, whose joints are solids, has no such parameter
    symmetric = joint.section.keyword == SECTIONS[0] and not explicit and "UNSYMM" not in parameters
    if symmetric and _is_unsymmetric(material):
        yield f"{head}: unsymm is missing: friction makes the tangent unsymmetric"
    implex = material.of("implex")
    if explicit and implex > 0.0:
        yield f"{head}: implex = {implex:g} (PROPS 25): expected 0 for Abaqus/Explicit"
    n_planes, wears = contract.check(material.props)
    yields = contract.yields(material.props)
    needed = len(contract.umat_names(n_planes, wears, 0.0 if explicit else implex, yields))
    wanted = f"expected at least {needed} state variables for {n_planes} planes"
    if material.depvar is None:
        yield f"{head}: no *Depvar: {wanted}"
        return
    head = material.depvar.head()
    rows = list(material.depvar.rows())
    variables = int(material.depvar.numbers(rows[0][1][:1], rows[0][0])[0]) if rows else 0
    if variables < needed:
        yield f"{head}: {variables}: {wanted}"
    if "DELETE" in material.depvar.parameters:
        variable = material.depvar.parameters["DELETE"]
        yield f"{head}: delete={variable}: contact survives rupture: expected no deletion"


def _section_problems(joint: Joint) -> Iterator[str]:
    """What is wrong with a cohesive section and its elements."""
    head, parameters = joint.section.head(), joint.section.parameters
    yield from _element_problems(joint, "COH2D4, COHAX4, COH3D6 or COH3D8", "COH")
    response = (parameters.get("RESPONSE") or "none").upper()
    if response != "TRACTION SEPARATION":
        yield f"{head}: response={response}: expected TRACTION SEPARATION, for which the law is made"
    if joint.material.errors or (parameters.get("THICKNESS") or "SPECIFIED").upper() != "SPECIFIED":
        return
    rows = [joint.section.numbers(words[:1], k) for k, words in joint.section.rows()][:1]
    thickness = rows[0][0] if rows and rows[0] and rows[0][0] else 1.0
    h = joint.material.of("h")
    if not math.isclose(thickness, h, rel_tol=ROUNDING):
        yield f"{head}: thickness {thickness:g}: expected {h:g}, the h of PROPS 9, as strain = separation/h"


def _calculix_problems(joint: Joint) -> tuple[list[str], list[str]]:
    """What is wrong with a section of solids, and what cannot be known."""
    head, name = joint.material.block.head(), joint.material.name
    if not name.startswith("ABAQUS"):
        text = (
            f"{head}: {name} in a *Solid Section: CalculiX calls a UMAT for names that begin with ABAQUS only"
        )
        return [], [text]
    wrong, notes = [*_element_problems(joint, "C3D8 or C3D6", "C3D[68]$")], []
    if name.startswith("ABAQUSNL"):
        wrong.append(f"{head}: {name}: expected none that begins with ABAQUSNL, which selects log strains")
    for k, words in joint.material.block.rows():
        expected = f"expected at most {CHARACTERS} characters, as CalculiX drops the others"
        where = joint.material.block.where(k)
        wrong += [f"{where}: {word}: {expected}" for word in words if len(word) > CHARACTERS]
    values = sum(len(words) for _, words in joint.material.block.rows())
    if values == len(joint.material.props) and values % ON_A_LINE == 0:
        wrong.append(f"{head}: {values} constants: CalculiX expects a further line, with the temperature")
    if len(joint.material.props) > ROOM:
        text = f"CalculiX as it comes has room for {ROOM} constants: use the one of install.sh"
        notes.append(f"{head}: {len(joint.material.props)} constants: {text}")
    return wrong, notes


def _element_problems(joint: Joint, wanted: str, start: str) -> Iterator[str]:
    """What is wrong with the elements of a section; start: regular expression of good types."""
    head, elset = joint.section.head(), joint.section.name("ELSET")
    if not joint.types:
        yield f"{head}: elset={elset}: no element is in it: expected {wanted}"
    if bad := sorted(kind for kind in joint.types if not re.match(start, kind)):
        yield f"{head}: elset={elset}: {', '.join(bad)}: expected {wanted}"
