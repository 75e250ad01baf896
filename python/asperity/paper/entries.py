"""The figures and tables of the paper: what it says, what is assumed, and the function that makes each."""

from __future__ import annotations

from .direction_figures import figure_7, figure_8, figure_9, figure_10, figure_11, figure_12, figure_13
from .isotropy_figures import figure_15, figure_16, table_5
from .outcome import Entry
from .pattern_figures import figure_1, figure_3, figure_6, figure_14
from .planar_figures import figure_2, figure_4a, figure_4b, figure_5a, figure_5b

ASSUMED_SLIP = "slip from 0 to 0.6 mm"
ASSUMED_STRESS = r"$\sigma_N$ = 2, 0, −2, −5, −10, −20 MPa"
ASSUMED_CYCLE = "slip 0, +0.4, −0.4, +0.4 mm"

ENTRIES = (
    Entry(
        "1",
        "Example of a RIE with five planes",
        (),
        "The RIE has a flat plane and four inclined ones.",
        "θ = 30°.",
        figure_1,
    ),
    Entry(
        "2",
        "Mode I law of one plane",
        ("figure02",),
        "The law is bilinear: the traction rises to $\\sigma_0$ at $s_0$ and falls to zero at $s_f$. The "
        "area is $G_c$.",
        "",
        figure_2,
    ),
    Entry(
        "3",
        "RIE of three planes of Section 4.1",
        (),
        "The planes are those of Table 1.",
        "θ = 30°.",
        figure_3,
    ),
    Entry(
        "4a",
        "Flat interface, monotonic slip",
        ("figure04a",),
        "The 2D results are recovered. The curves are linear at first and horizontal at the end, where only "
        "friction is left (Remark 3). $\\sigma_N$ is −20 to 2 MPa.",
        f"{ASSUMED_SLIP}; {ASSUMED_STRESS}.",
        figure_4a,
    ),
    Entry(
        "4b",
        "Inclination of the planes, σ_N = −10 MPa",
        ("figure04b",),
        "The 2D results are recovered. $\\theta_m$ is 0 to 45°.",
        f"{ASSUMED_SLIP}; $\\theta_m$ = 0, 15, 25, 30, 35, 45°.",
        figure_4b,
    ),
    Entry(
        "5a",
        "Small pressures, 35°",
        ("figure05a",),
        "The 2D results are recovered. $\\sigma_N$ is −2 to 0 MPa.",
        f"{ASSUMED_SLIP}; $\\sigma_N$ = 0, −0.5, −1, −1.5, −2 MPa.",
        figure_5a,
    ),
    Entry(
        "5b",
        "Cyclic slip, 30°, σ_N = −10 MPa",
        ("figure05b",),
        "The 2D results are recovered.",
        f"{ASSUMED_CYCLE}.",
        figure_5b,
    ),
    Entry(
        "6", "The five planes in plan", (), "$\\theta_L$ is the direction of slip from $T_x$.", "", figure_6
    ),
    Entry(
        "7",
        "Five planes, monotonic slip along 0° and 45°",
        ("figure07a_08a_10a", "figure07b_08b_10a"),
        "The response depends on the direction. $\\eta$ is 0.99. At $\\sigma_N$ = 0 the traction falls to "
        "zero.",
        f"{ASSUMED_SLIP}; {ASSUMED_STRESS}.",
        figure_7,
    ),
    Entry(
        "8",
        "Five planes, dilation along 0° and 45°",
        ("figure07a_08a_10a", "figure07b_08b_10a"),
        "The dilation is unbounded, because the asperities do not wear.",
        f"{ASSUMED_SLIP}; {ASSUMED_STRESS}.",
        figure_8,
    ),
    Entry(
        "9",
        "Five planes, cyclic slip along 0° and 45°",
        ("figure09a_10b", "figure09b_10b"),
        "The response depends on the direction. $\\eta$ is 0.9.",
        f"{ASSUMED_CYCLE}; $\\sigma_N$ = 0, −5, −10 MPa.",
        figure_9,
    ),
    Entry(
        "10",
        "Five planes, 0° against 45°",
        ("figure07a_08a_10a", "figure07b_08b_10a", "figure09a_10b", "figure09b_10b"),
        "The anisotropy is more pronounced under confinement.",
        "the slips and pressures of Figures 7 and 9; $\\eta$ = 0.99 in (a), 0.9 in (b).",
        figure_10,
    ),
    Entry(
        "11",
        "Five planes, several directions, σ_N = −5 MPa",
        ("figure11",),
        "The response depends on the direction, which goes from 0 to 90°.",
        f"{ASSUMED_SLIP}; $\\theta_L$ every 15°.",
        figure_11,
    ),
    Entry(
        "12",
        "Five planes, fracture energy over the direction, σ_N = 0",
        ("figure12",),
        "The energy depends on the direction.",
        f"{ASSUMED_SLIP}; the case file has $\\theta_L$ every 15°, the picture every 5.625°.",
        figure_12,
    ),
    Entry(
        "13a",
        "Zero normal traction, several inclinations",
        ("figure13a_00", "figure13a_45"),
        "The elastic part depends neither on the inclination nor on the direction. The traction and the "
        "energy grow with the inclination and depend on the direction.",
        f"{ASSUMED_SLIP}; $\\theta_m$ = 0, 15, 30, 45°; the five planes of Table 3.",
        figure_13,
    ),
    Entry(
        "13b",
        "The same without friction",
        ("figure13b_00", "figure13b_45"),
        "The curves differ, but the energy is the same for all.",
        f"{ASSUMED_SLIP}; $\\theta_m$ = 0, 15, 30, 45°; the five planes of Table 3.",
        figure_13,
    ),
    Entry(
        "14",
        "RP-3, RP-4, RP-6 in plan",
        (),
        "The patterns are truncated pyramids with the weights of Table 4.",
        "θ = 30°.",
        figure_14,
    ),
    Entry(
        "15",
        "Sensitivity to the direction: RT, RP-3, RP-4",
        ("figure15a", "figure15b", "figure15c"),
        "The curves coincide for small slip and differ more and more later. With more sides they overlap, "
        "and the polar graph becomes a circle.",
        f"{ASSUMED_SLIP}; $\\theta_L$ every 15°.",
        figure_15,
    ),
    Entry(
        "16",
        "Sensitivity to the direction: RP-6, RP-32",
        ("figure16a", "figure16b"),
        "The statement is that of Figure 15.",
        f"{ASSUMED_SLIP}; $\\theta_L$ every 15°.",
        figure_16,
    ),
    Entry(
        "Table 5",
        "Largest and smallest fracture energy",
        (),
        "The energy of RP-3 spreads less than 5 %, that of RP-4 less than 0.2 %, “negligible for the vast "
        "majority of applications”. The table gives 1.2 % for RP-6.",
        "the sampling.",
        table_5,
    ),
)
"""Figures and tables in the order of the paper."""
