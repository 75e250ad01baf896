"""Constants of the joints of a deck: what was read, what follows from them, and values that are doubtful.

A value is doubtful if it is probably that of another constant or in another unit, mostly beside other values
of the same deck, so that this holds in any consistent units.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .. import contract
from ..contract import Floats
from ..material import Material
from ..model_checks import model_warnings
from ..pattern import Pattern
from ..plausible import FLATTEST, OPENEST, doubts
from .deck import Block
from .deck_model import Model

WEAKEST, STRONGEST = 3.0e-7, 0.01
"""Smallest and largest strength of a bond over Young's modulus of the solid beside it: a mortar of 0.06 MPa
on steel, and a glue of 30 MPa between boards of 3 GPa.
"""

DUCTILE = 0.85
"""Smallest usual eta; a smaller one below mu is probably mu."""

STIFFEST = 1.0e4
"""Largest usual kc, which is a ratio."""

USUAL, SHALLOW = (1, 2, 3, 4, 5, 6, 8), 8
"""Usual numbers of planes; another one beside a whole inclination up to SHALLOW degrees is probably that."""

ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5, 8.0, 10.0)
"""First digits of ratios that users choose."""

SAME = 1.0e-4
"""Relative difference of two numbers that are the same but for their digits."""

REQUESTS = "ELEMENT OUTPUT", "EL PRINT", "EL FILE"


@dataclass(frozen=True)
class Solid:
    """Solids beside a joint: Young's modulus, stress, and their size, length."""

    modulus: float
    size: float


@dataclass(frozen=True)
class Report:
    """Lines for a joint: what was read, warnings, and what is doubtful."""

    lines: list[str]
    warned: list[str]
    doubtful: list[str]


def report(model: Model, head: str, props: Floats, sections: Sequence[Block]) -> Report:
    """What the constants (P,) of a joint with these sections are, with the solids beside it."""
    values = {row.name: float(value) for row, value in zip(contract.props_table(), props, strict=False)}
    solids = list(_beside(model, sections))
    lines = [f"{head}: {len(props)} constants"]
    lines += [f"  {text}" for text in _named(values)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            material, pattern = _objects(values, props)
            texts = model_warnings(material, pattern)
    except ValueError as error:  # what the library refuses stands among what is wrong
        return Report([*lines, f"  {error}"], [], [])
    lines += [f"  {text}" for text in _derived(material, solids)]
    doubtful = [f"{head}: {text}" for text in _doubts(material, pattern, solids)]
    return Report(lines, [f"{head}: {text}" for text in texts], doubtful)


def keyword_problems(deck: Sequence[Block], materials: set[str], sections: Sequence[Block]) -> Iterator[str]:
    """Keywords beside joints that change them, or leave them out of the results.

    materials: upper-case names of those of joints; sections: of joints.
    """
    explicit = any(block.keyword.startswith("DYNAMIC") and "EXPLICIT" in block.parameters for block in deck)
    inside = {name: set[str]() for name in materials}
    first: dict[str, Block] = {}
    name = ""
    for block in deck:
        if block.keyword == "MATERIAL":
            name = block.name("NAME").upper()
            first.setdefault(name, block)
        elif name in inside:
            inside[name].add(block.keyword)
            if block.keyword == "ELASTIC":
                yield f"{block.head()}: beside *User Material: expected one of both in a material"
    for name in sorted(materials if explicit else ()):
        if name in first and "DENSITY" not in inside[name]:
            yield f"{first[name].head()}: no *Density: expected one for Abaqus/Explicit, mass over area and h"
    controls = {(block.parameters.get("CONTROLS") or "").upper() for block in sections} - {""}
    for block in deck:
        deletes = (block.parameters.get("ELEMENT DELETION") or "").upper() == "YES"
        if block.keyword == "SECTION CONTROLS" and deletes and block.name("NAME").upper() in controls:
            yield f"{block.head()}: element deletion=YES: contact survives rupture: expected NO"
    yield from _output_problems(deck)


def _output_problems(deck: Sequence[Block]) -> Iterator[str]:
    """Output of elements without the state variables, which have the damage."""
    asked = [block for block in deck if block.keyword in REQUESTS]
    usual = [
        block
        for block in deck
        if block.keyword == "OUTPUT"
        and {"FIELD"} & {*block.parameters}
        and (block.parameters.get("VARIABLE") or "").upper() == "PRESELECT"
    ]
    words = [word.upper() for block in asked for _, row in block.rows() for word in row]
    everything = any(
        (block.parameters.get("VARIABLE") or "").upper() == "ALL"
        for block in deck
        if block.keyword in (*REQUESTS, "OUTPUT")
    )
    if (asked or usual) and not everything and not any(word.startswith("SDV") for word in words):
        block = (asked or usual)[0]
        yield f"{block.head()}: no output of elements has SDV, which are damage and slips: expected SDV"


def _named(values: Mapping[str, float]) -> Iterator[str]:
    """A line for each constant that is not 0, with its unit."""
    for row in contract.props_table():
        value = values.get(row.name, 0.0)
        if value or row.default is None:
            unit = "" if row.unit == "-" else f" {row.unit}"
            yield f"{row.name:<8} {value:<12.6g}{unit:<24} {row.meaning}"


def _objects(values: Mapping[str, float], props: Floats) -> tuple[Material, Pattern]:
    """Material and pattern of PROPS, in which a 0 stands for a default."""
    rows = {row.name: row for row in contract.owned("law")}
    material = Material(
        **{name: values[name] for name, row in rows.items() if values.get(name) or row.default is None}
    )
    m = int(values.get("m", 0.0))
    if m < 0:
        planes = props[contract.N_USED_PROPS :][: -4 * m].reshape(-1, 4)
        return material, Pattern.planes(planes[:, :3], planes[:, 3])
    if m == 0:
        return material, Pattern.regular(0, 0.0)
    return material, Pattern.regular(m, values["theta"], values.get("flat", 0.0), values.get("turn", 0.0))


def _derived(material: Material, solids: Sequence[Solid]) -> Iterator[str]:
    """What follows from the constants, beside the solids."""
    yield f"s0       {material.s_0:<12.6g} length: opening at which the bond begins to break"
    yield f"s_f      {material.s_f:<12.6g} length: opening at which it is broken"
    contact = f"; closed {material.K * material.kc:.4g}"
    yield f"K        {material.K:<12.6g} stress/length: sigma0/s0{contact}"
    for solid in solids:
        stiff = solid.modulus / solid.size
        text = (
            f"E/size   {stiff:<12.6g} stress/length: E = {solid.modulus:g} over elements of {solid.size:.4g}"
        )
        yield f"{text} beside; K over it {material.K / stiff:.4g}"
    if not solids:
        yield "E/size   -            no solid beside the joint has *Elastic"


def _doubts(material: Material, pattern: Pattern, solids: Sequence[Solid]) -> Iterator[str]:
    """A sentence for each value that is probably another one."""
    yield from doubts(mu=material.mu)
    if pattern.m > 0 and 0.0 < pattern.theta < FLATTEST:
        angle = np.degrees(pattern.theta)
        yield f"theta = {pattern.theta:g}: expected degrees; that many radians are {angle:.3g} degrees"
    if pattern.m > 0 and pattern.m not in USUAL and pattern.theta in range(2, SHALLOW + 1):
        text = (
            f"theta = {pattern.theta:g}, m = {pattern.m}: expected the inclination, then the number of planes"
        )
        yield f"{text}; are they exchanged?"
    kc, K = material.kc, material.K
    if kc > STIFFEST or (kc > 1.0 and _is_round(kc / K) and not _is_round(kc)):
        text = f"kc = {kc:g}: expected the ratio of the stiffness of the closed joint to K = {K:.4g}"
        yield f"{text}, which it is {kc / K:.4g} times"
    if material.damage0 >= 1.0:
        return
    eta, mu, sigma0 = material.eta, material.mu, material.sigma0
    if eta < min(DUCTILE, mu):
        yield f"eta = {eta:g}, mu = {mu:g}: expected eta = 1 - s0/s_f near 1; are they exchanged?"
    size = min((solid.size for solid in solids), default=OPENEST)
    if material.s_f > min(size, OPENEST):
        beside = f"elements of {size:.4g}" if solids and size < OPENEST else f"{OPENEST:g}"
        text = (
            f"sigma0 = {sigma0:g}, Gc = {material.Gc:g}: the bond breaks at an opening of {material.s_f:.3g}"
        )
        yield f"{text}, beyond {beside}: expected less; are they exchanged, or in other units?"
    for solid in solids:
        ratio = sigma0 / solid.modulus
        if not WEAKEST <= ratio <= STRONGEST:
            text = (
                f"sigma0 = {sigma0:g} is {ratio:.2g} of Young's modulus {solid.modulus:g} of the solid beside"
            )
            yield f"{text}: expected {WEAKEST:g} to {STRONGEST:g}; are both in one unit?"


def _is_round(value: float) -> bool:
    """Whether a number has one of the usual first digits and no others."""
    mantissa = float(f"{value:e}".partition("e")[0])
    return any(abs(mantissa - digits) <= SAME * digits for digits in ROUND)


def _beside(model: Model, sections: Sequence[Block]) -> Iterator[Solid]:
    """Solids with nodes of the elements of sections; without common nodes, all solids of the deck."""
    moduli = _moduli(model.deck)
    elements_of = [
        section.elements for section in model.sections if any(section.block is block for block in sections)
    ]
    elements = np.unique(np.concatenate([np.zeros(0, np.int64), *elements_of]))
    joint = np.zeros(len(model.points), bool)
    for entry in model.cohesive:
        joint[entry.nodes[np.isin(entry.places, elements)]] = True
    for (_, cells), at in zip(model.cells, model.by_array(elements), strict=True):
        joint[cells[at]] = True
    touching: dict[float, list[Floats]] = {}
    others: dict[float, list[Floats]] = {}
    for section in model.sections:
        modulus = moduli.get((section.block.parameters.get("MATERIAL") or "").upper())
        if modulus is None or section.block.keyword != "SOLID SECTION":
            continue
        for (_, cells), at in zip(model.cells, model.by_array(section.elements), strict=True):
            if not len(at):
                continue
            sizes = _sizes(model.points[cells[at]])
            near = joint[cells[at]].any(1)
            others.setdefault(modulus, []).append(sizes)
            if near.any():
                touching.setdefault(modulus, []).append(sizes[near])
    for modulus, sizes_of in (touching or others).items():
        yield Solid(modulus, float(np.median(np.concatenate(sizes_of))))


def _sizes(x: Floats) -> Floats:
    """Geometric mean of the extents of cells (m, k, 3) along the axes in which they have one."""
    extents = np.ptp(x, axis=1)
    flat = extents <= SAME * extents.max(axis=1, keepdims=True)
    logs = np.where(flat, 0.0, np.log(np.where(flat, 1.0, extents)))
    sizes: Floats = np.exp(logs.sum(axis=1) / np.maximum((~flat).sum(axis=1), 1))
    return sizes


def _moduli(deck: Sequence[Block]) -> dict[str, float]:
    """Young's modulus of each isotropic material by its upper-case name."""
    moduli, name = dict[str, float](), ""
    for block in deck:
        if block.keyword == "MATERIAL":
            name = block.name("NAME").upper()
        elif block.keyword == "ELASTIC" and name and name not in moduli:
            kind = (block.parameters.get("TYPE") or "ISOTROPIC").upper()
            rows = list(block.rows())
            if kind.startswith("ISO") and rows:
                value = block.numbers(rows[0][1][:1], rows[0][0])[0]
                if value > 0.0:
                    moduli[name] = value
    return moduli
