"""Decks for Abaqus: complete input files with small meshes, written by code so that they fit the law."""

from __future__ import annotations

import numpy as np
from asperity import Interface, Material, Pattern, contract
from asperity.export.element import ROWS, Element

from .deck_lines import card, deck, dynamic, output, single, smooth, solution, static, wall

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
        *output(),
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
        "*Output, history, time interval=0.0005",
        "*Node Output, nset=TOP",
        "RF1, U1, U3",
        "*Element Output, elset=JOINT",
        "S, SDV",
        "*End Step",
    )


WALL_THETA, WALL_PRESSURE, WALL_LENGTH = 15.0, 0.5, 400.0
"""Constants of the wallette."""


def wallette() -> str:
    """Wallette with three bed joints, the middle one cracked, under initial stress, Abaqus/Standard."""
    mesh = wall(np.linspace(0.0, WALL_LENGTH, 21).tolist(), courses=4, height=50.0, rows=2)
    platen, *others = mesh.node_sets["COURSE_4_TOP"]
    mesh.node_sets["TOP_OTHERS"] = others
    mortar = Interface(
        Material(sigma0=1.0, Gc=0.02, eta=0.95, mu=0.6, kc=10.0), Pattern.regular(2, WALL_THETA)
    )
    # damage of all planes; nothing else is needed, and the status stays 0
    cracked = [1.0 if name.startswith("alpha") else 0.0 for name in contract.statev_names(mortar.n_planes)]
    strength = mortar.material.residual_strength(WALL_THETA) * WALL_PRESSURE * WALL_LENGTH
    return deck(
        "Wallette with three bed joints, the middle one cracked, plane stress, Abaqus/Standard",
        [
            f"Units: mm, N, MPa. It starts under {WALL_PRESSURE} MPa, and the step REST must not move it.",
            "Its top is then moved by 1 mm.",
            f"At the end RF1 of the nodes COURSE_4_TOP sums to (mu + tan {WALL_THETA:g})/(1 - mu tan "
            f"{WALL_THETA:g}) times {WALL_PRESSURE * WALL_LENGTH:g} N = {strength:.6g} N.",
            "SDV1 of BED_1 and BED_3 stays 0: the cracked joint BED_2 slides.",
        ],
        "wallette",
        mesh,
        card(mortar, dimension=2, stress=-WALL_PRESSURE, modulus=5000.0, size=20.0),
        "** Elastic solids beside the joint.",
        "*Material, name=UNIT",
        "*Elastic",
        "5000.0, 0.15",
        "*Solid Section, elset=UNITS, material=UNIT",
        "1.0,",
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
        *output("COURSE_4_TOP"),
    )
