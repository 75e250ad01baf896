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
from .mesh import Layer, spaced, stack

THETA = 30.0
ROUGH = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=10.0)
"""Joint of the shear box (mm, N, MPa)."""

BOX_SLIP = 0.6
"""Slip of the shear box at the end."""

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


def shear_box_explicit() -> str:
    """Two blocks in three dimensions under constant pressure, Abaqus/Explicit."""
    layers = [Layer("LOWER", "C3D8", spaced(0.0, 6.0, 1)), Layer("UPPER", "C3D8", spaced(6.0, 12.0, 1))]
    mesh = stack([spaced(0.0, 60.0, 3)] * 2, layers, ["JOINT"], "COH3D8")
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


EXAMPLES = (shear_box_explicit, wallette)
"""Decks of larger models."""
