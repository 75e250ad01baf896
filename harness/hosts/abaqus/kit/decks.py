"""Decks for Abaqus: complete input files with small meshes, written by code so that they fit the law."""

from __future__ import annotations

from asperity import Interface, Material, Pattern, contract
from asperity.export.element import ROWS, Element

from .deck_lines import (
    SOLID_DENSITY,
    card,
    deck,
    dynamic,
    explicit_output,
    output,
    single,
    slides,
    smooth,
    solids,
    solution,
    static,
)
from .mesh import Layer, Mesh, spaced, stack

THETA = 30.0
ROUGH = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=10.0)
"""Joint of the shear boxes (mm, N, MPa)."""

BOX_SLIP = 0.6
"""Slip of the shear boxes at the end."""

UNITS = "Units are those of the case; the element has the area 1. SDV1 is the damage."


def single_standard(one: Element) -> str:
    """One element, Abaqus/Standard."""
    stress = one.sigma_N or None
    return deck(
        f"One joint element, Abaqus/Standard: normal traction {one.sigma_N:g}, then a slip of {one.slip:g}",
        [UNITS, "The README has the five rows that the .dat file must show."],
        "single_standard",
        single(),
        card(one.interface, stress=stress),
        "*Boundary",
        "BOTTOM, 1, 3",
        "TOP, 1, 2",
        "** Increments are fixed, so that five of them are the rows.",
        *static("PRESS", f"{1.0 / one.press!r}, 1.", direct=True),
        "** A tighter equilibrium than Abaqus' default, so that the digits of the README can be compared.",
        "*Controls, parameters=field, field=displacement",
        "1e-6, 1e-3",
        "*Cload",
        f"TOP, 3, {one.sigma_N / 4.0!r}",
        "*End Step",
        *static("PULL", f"{1.0 / one.slide!r}, 1.", direct=True),
        "*Boundary",
        f"TOP, 1, 1, {one.slip!r}",
        f"*Node Print, nset=TOP, frequency={one.slide // ROWS}, totals=YES",
        "U1, U3, RF1",
        f"*El Print, elset=JOINT, frequency={one.slide // ROWS}",
        "SDV1",
        *output("JOINT"),
        "*End Step",
    )


def single_explicit(one: Element) -> str:
    """One element, Abaqus/Explicit; its density and durations suit mm, N, MPa, t, s."""
    return deck(
        f"One joint element, Abaqus/Explicit: normal traction {one.sigma_N:g}, then a slip of {one.slip:g}",
        [UNITS, "RF1 and U3 over U1 follow the rows of the README with oscillations."],
        "single_explicit",
        single(),
        card(one.interface, stress=one.sigma_N, explicit=True),
        *smooth("PRESSING", 0.01),
        *smooth("PULLING", 0.05),
        "*Boundary",
        "BOTTOM, 1, 3",
        "TOP, 2, 2",
        *dynamic("PRESS", 0.01),
        "*Boundary",
        "TOP, 1, 1",
        "*Cload, amplitude=PRESSING",
        f"TOP, 3, {one.sigma_N / 4.0!r}",
        "*End Step",
        *dynamic("PULL", 0.05),
        "*Boundary, amplitude=PULLING",
        f"TOP, 1, 1, {one.slip!r}",
        *explicit_output(),
    )


def shear_box_2d() -> str:
    """Two blocks in plane strain under constant pressure, Abaqus/Standard."""
    mesh = _blocks([spaced(0.0, 100.0, 10)], "CPE4", "COH2D4", 20.0, 2)
    return _shear_box(mesh, "shear_box_2d", Pattern.regular(2, THETA), 100.0, "P3")


def shear_box_3d() -> str:
    """Two blocks in three dimensions under constant pressure, Abaqus/Standard."""
    mesh = _blocks([spaced(0.0, 40.0, 4)] * 2, "C3D8", "COH3D8", 10.0, 1)
    return _shear_box(mesh, "shear_box_3d", Pattern.regular(4, THETA), 40.0 * 40.0, "P2")


def _blocks(plan: list[list[float]], kind: str, joint_kind: str, height: float, parts: int) -> Mesh:
    """Mesh of two equal blocks, LOWER and UPPER, with a joint."""
    lower, upper = spaced(0.0, height, parts), spaced(height, 2.0 * height, parts)
    return stack(plan, [Layer("LOWER", kind, lower), Layer("UPPER", kind, upper)], ["JOINT"], joint_kind)


def _shear_box(mesh: Mesh, name: str, pattern: Pattern, area: float, face: str) -> str:
    """Shear box of Abaqus/Standard: the platen on the upper block does not tilt."""
    up = mesh.dimension
    platen, *others = mesh.node_sets["UPPER_TOP"]
    mesh.node_sets["UPPER_OTHERS"] = others
    return deck(
        f"Shear box, {up}D, Abaqus/Standard: 1 MPa on the upper block, moved along x by {BOX_SLIP} mm",
        [
            "Units: mm, N, MPa. The platen does not tilt (*Equation), as in a shear box with guides.",
            slides(ROUGH, THETA, area, "UPPER_TOP"),
        ],
        name,
        mesh,
        card(Interface(ROUGH, pattern), dimension=up, stress=-1.0, modulus=20000.0, size=10.0),
        *solids(mesh, "STONE", 20000.0, 0.2),
        "** All nodes of the platen have the same displacement normal to the joint.",
        "*Equation",
        "2",
        f"UPPER_OTHERS, {up}, 1.0, {platen}, {up}, -1.0",
        "*Boundary",
        f"LOWER_BOTTOM, 1, {up}",
        f"UPPER_TOP, 1, {up - 1}",
        *static("PRESS", "0.2, 1., 1e-6, 0.2"),
        "*Dload",
        f"UPPER_ROOF, {face}, 1.0",
        "*End Step",
        *static("SLIDE", "0.02, 1., 1e-6, 0.02"),
        "*Boundary",
        f"UPPER_TOP, 1, 1, {BOX_SLIP}",
        *output("JOINT", "UPPER_TOP"),
        "*End Step",
    )


def shear_box_explicit() -> str:
    """Two blocks in three dimensions under constant pressure, Abaqus/Explicit."""
    mesh = _blocks([spaced(0.0, 60.0, 3)] * 2, "C3D8", "COH3D8", 6.0, 1)
    return deck(
        f"Shear box, 3D, Abaqus/Explicit: 1 MPa on the upper block, moved along x by {BOX_SLIP} mm",
        [
            "Units: mm, N, MPa, t, s. The movement is slow against the waves in the blocks.",
            "The blocks are flat, so that the force on the top does not tilt them.",
            slides(ROUGH, THETA, 60.0 * 60.0, "UPPER_TOP") + " There are oscillations.",
            "To wear the asperities, too, set W0 as described at the material.",
        ],
        "shear_box_explicit",
        mesh,
        card(Interface(ROUGH, Pattern.regular(4, THETA)), stress=-1.0, explicit=True),
        *solids(mesh, "STONE", 20000.0, 0.2, SOLID_DENSITY),
        *smooth("PRESSING", 0.005),
        *smooth("PULLING", 0.02),
        "*Boundary",
        "LOWER_BOTTOM, 1, 3",
        "UPPER_TOP, 2, 2",
        *dynamic("PRESS", 0.005),
        "*Boundary",
        "UPPER_TOP, 1, 1",
        "*Dload, amplitude=PRESSING",
        "UPPER_ROOF, P2, 1.0",
        "*End Step",
        *dynamic("SLIDE", 0.02),
        "*Boundary, amplitude=PULLING",
        f"UPPER_TOP, 1, 1, {BOX_SLIP}",
        *explicit_output("UPPER_TOP"),
    )


DCB_HEIGHT, DCB_MODULUS, DCB_NU, DCB_GC = 3.0, 70000.0, 0.3, 0.3
"""Height of an arm, its elastic constants, and the rupture energy of the bond."""


def dcb() -> str:
    """Double cantilever beam in plane strain, Abaqus/Standard."""
    notch, length = 30.0, 80.0
    layers = [
        Layer("LOWER", "CPE4I", spaced(-DCB_HEIGHT, 0.0, 2)),
        Layer("UPPER", "CPE4I", spaced(0.0, DCB_HEIGHT, 2)),
    ]
    mesh = stack([spaced(0.0, length, 80)], layers, ["JOINT"], "COH2D4", lambda point: point[0] > notch)
    for name, height in (("LOWER", -DCB_HEIGHT / 2), ("UPPER", DCB_HEIGHT / 2)):
        mesh.node_sets[f"{name}_TIP"] = [mesh.nodes.index((0.0, height)) + 1]
        mesh.node_sets[f"{name}_END"] = [
            i for i, p in enumerate(mesh.nodes, 1) if p[0] == length and p[1] * height > 0
        ]
    bond = Material(sigma0=10.0, Gc=DCB_GC, eta=0.95, mu=0.3)
    return deck(
        "Double cantilever beam, plane strain, Abaqus/Standard: the tips are pulled apart by 2 mm",
        [
            "Units: mm, N, MPa. Arms of 3 mm, width 1 mm, crack of 30 mm.",
            "In opening the energy is Gc, whatever the pattern.",
            "Energy balance: work of RF2 = elastic energy of the arms + SDV2 + SDV3 over the bond.",
            "Beam theory: P^2 12 a^2 (1 - nu^2)/(E h^3) = Gc; the load falls as the crack grows.",
        ],
        "dcb",
        mesh,
        card(Interface(bond, Pattern.regular(2, 20.0)), dimension=2, modulus=DCB_MODULUS, size=1.0),
        *solids(mesh, "ARM", DCB_MODULUS, DCB_NU),
        "*Boundary",
        "LOWER_END, 1, 2",
        "UPPER_END, 1, 2",
        *static("OPEN", "0.02, 1., 1e-6, 0.02"),
        "*Boundary",
        "LOWER_TIP, 2, 2, -1.0",
        "UPPER_TIP, 2, 2, 1.0",
        *output("JOINT", "UPPER_TIP"),
        "*End Step",
    )


WALL_THETA, WALL_PRESSURE, WALL_LENGTH = 15.0, 0.5, 400.0
"""Constants of the wallette."""


def wallette() -> str:
    """Wallette with three bed joints, the middle one cracked, under initial stress, Abaqus/Standard."""
    names = ["COURSE_1", "COURSE_2", "COURSE_3", "COURSE_4"]
    layers = [Layer(name, "CPS4", spaced(50.0 * i, 50.0 * (i + 1), 2)) for i, name in enumerate(names)]
    mesh = stack([spaced(0.0, WALL_LENGTH, 20)], layers, ["BED_1", "BED_2", "BED_3"], "COH2D4")
    joints = [i for name in ("BED_1", "BED_2", "BED_3") for i in mesh.types[name][1]]
    mesh.element_sets["JOINT"] = joints
    mesh.element_sets["UNITS"] = [i for name in names for i in mesh.types[name][1]]
    platen, *others = mesh.node_sets["COURSE_4_TOP"]
    mesh.node_sets["TOP_OTHERS"] = others
    mortar = Interface(
        Material(sigma0=1.0, Gc=0.02, eta=0.95, mu=0.6, kc=10.0), Pattern.regular(2, WALL_THETA)
    )
    # damage of all planes; nothing else is needed, and the status stays 0
    cracked = [1.0 if name.startswith("alpha") else 0.0 for name in contract.statev_names(mortar.n_planes)]
    return deck(
        "Wallette with three bed joints, the middle one cracked, plane stress, Abaqus/Standard",
        [
            f"Units: mm, N, MPa. It starts under {WALL_PRESSURE} MPa, and the step REST must not move it.",
            "Its top is then moved by 1 mm.",
            slides(mortar.material, WALL_THETA, WALL_PRESSURE * WALL_LENGTH, "COURSE_4_TOP"),
            "SDV1 of BED_1 and BED_3 stays 0: the cracked joint BED_2 slides.",
        ],
        "wallette",
        mesh,
        card(mortar, dimension=2, stress=-WALL_PRESSURE, modulus=5000.0, size=20.0),
        *solids(mesh, "UNIT", 5000.0, 0.15, sets=["UNITS"]),
        "** Initial stress of the units (S11, S22, S12) and of the joints (normal, shear).",
        "*Initial Conditions, type=STRESS",
        f"UNITS, 0., {-WALL_PRESSURE}, 0.",
        f"JOINT, {-WALL_PRESSURE}, 0.",
        "** Cracked planes of BED_2: its state variables, seven on the first line, then eight on a line.",
        "*Initial Conditions, type=SOLUTION",
        *solution("BED_2", cracked),
        "** The top of the wall stays level.",
        "*Equation",
        "2",
        f"TOP_OTHERS, 2, 1.0, {platen}, 2, -1.0",
        "*Boundary",
        "COURSE_1_BOTTOM, 1, 2",
        "** The load that is in equilibrium with the initial stress acts from the first increment on.",
        "*Amplitude, name=FROM_THE_START",
        "0., 1., 10., 1.",
        *static("REST", "1., 1.", direct=True),
        "*Dload, amplitude=FROM_THE_START",
        f"COURSE_4_ROOF, P3, {WALL_PRESSURE}",
        "*End Step",
        *static("SLIDE", "0.05, 1., 1e-6, 0.05"),
        "*Boundary",
        "COURSE_4_TOP, 1, 1, 1.0",
        *output("JOINT", "COURSE_4_TOP"),
        "*End Step",
    )


EXAMPLES = (shear_box_2d, shear_box_3d, shear_box_explicit, dcb, wallette)
"""Decks of larger models."""
