"""Parts of the decks that several of them have, as lines of an input file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from asperity import Interface, Material, contract

from .mesh import Mesh

JOINT_DENSITY, SOLID_DENSITY = 1.0e-8, 2.0e-9
"""Mass per area of a joint and per volume of a solid, t/mm^2 and t/mm^3, for Abaqus/Explicit."""


def single() -> Mesh:
    """One element of 1 mm^2."""
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
    mesh = Mesh(3, nodes=corners * 2, node_sets={"BOTTOM": [1, 2, 3, 4], "TOP": [5, 6, 7, 8]})
    mesh.add("JOINT", "COH3D8", np.arange(1, 9)[None])
    return mesh


def deck(
    heading: str, comments: Sequence[str], name: str, mesh: Mesh, card: Sequence[str], *lines: str
) -> str:
    """Text of an input file."""
    explicit = any(line.startswith("*Dynamic, Explicit") for line in lines)
    run = f"abaqus job={name} user=asperity_abaqus.f90{' double=both' if explicit else ''}"
    head = ["*Heading", heading, f"** {run}"]
    if explicit:
        head.append(f"** in single precision: abaqus job={name} user=asperity_abaqus_single.f90")
    head.append("** Abaqus was not available when this deck was written.")
    return "\n".join([*head, *(f"** {line}" for line in comments), *mesh.lines(), *card, *lines]) + "\n"


def card(joint: Interface, explicit: bool = False, **options: Any) -> list[str]:
    """Material and section of a joint, with what the two constants of finite asperities would do.

    options: those of `Interface.card`.
    """
    density = JOINT_DENSITY if explicit else None
    text = joint.card("abaqus", name="JOINT", explicit=explicit, density=density, **options)
    height, wear = (contract.index(prop) + 1 for prop in ("height", "W0"))
    worn = contract.n_statev(joint.n_planes, True)
    return [
        f"** Finite asperities: PROPS {height} (height, mm) is the rise at which the dilation ends, and",
        f"** PROPS {wear} (W0, N/mm) the work of friction per area that wears 63 % of them off. Both are 0",
        "** here: no end and no wear. With W0 > 0",
        f"** *Depvar needs {worn} variables instead of {contract.n_statev(joint.n_planes)}.",
        *text.splitlines(),
    ]


def solids(
    mesh: Mesh,
    material: str,
    modulus: float,
    nu: float,
    density: float | None = None,
    sets: Sequence[str] = ("LOWER", "UPPER"),
) -> list[str]:
    """Elastic material and the sections of the blocks."""
    text = [
        "** Elastic solids beside the joint.",
        f"*Material, name={material}",
        "*Elastic",
        f"{modulus}, {nu}",
    ]
    if density is not None:
        text += ["*Density", f"{density},"]
    for name in sets:
        text.append(f"*Solid Section, elset={name}, material={material}")
        text += ["1.0,"] if mesh.dimension == 2 else []
    return text


def solution(name: str, values: Sequence[float]) -> list[str]:
    """Lines of initial state variables."""
    texts = [f"{value:g}." for value in values]
    return [
        f"{name}, {', '.join(texts[:7])}",
        *(", ".join(texts[i : i + 8]) for i in range(7, len(texts), 8)),
    ]


def static(name: str, increments: str, direct: bool = False) -> list[str]:
    """Start of a static step with the unsymmetric solver."""
    return [
        "** unsymm=YES, because the tangent of a sliding joint is unsymmetric.",
        f"*Step, name={name}, nlgeom=NO, unsymm=YES, inc=1000",
        f"*Static{', direct' if direct else ''}",
        increments,
    ]


def dynamic(name: str, duration: float) -> list[str]:
    """Start of an explicit step."""
    return [f"*Step, name={name}, nlgeom=NO", "*Dynamic, Explicit", f", {duration}"]


def smooth(name: str, duration: float) -> list[str]:
    """Amplitude that starts and ends without acceleration."""
    return [f"*Amplitude, name={name}, definition=SMOOTH STEP", f"0., 0., {duration}, 1."]


def output(joint: str, nodes: str = "TOP") -> list[str]:
    """Output of a static step."""
    return [
        "*Output, field",
        "*Node Output",
        "U, RF",
        f"*Element Output, elset={joint}",
        "S, E, SDV",
        "*Output, history",
        f"*Node Output, nset={nodes}",
        "U, RF",
    ]


def explicit_output(nodes: str = "TOP") -> list[str]:
    """Output of an explicit step, and its end."""
    return [
        "*Output, history, time interval=0.0005",
        f"*Node Output, nset={nodes}",
        "RF1, U1, U3",
        "*Element Output, elset=JOINT",
        "S, SDV",
        "*End Step",
    ]


def slides(material: Material, theta: float, force: float, nodes: str = "TOP") -> str:
    """What the sum of the reactions must be at the end."""
    ratio = f"(mu + tan {theta:g})/(1 - mu tan {theta:g})"
    total = material.residual_strength(theta) * force
    return f"At the end RF1 of the nodes {nodes} sums to {ratio} times {force:g} N = {total:.6g} N."
