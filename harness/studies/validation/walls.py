"""Masonry walls under shear: tables and pictures of docs/validation/walls.md."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.tools.style import COLOURS, TWO, new_figure, printed, save
from asperity.tools.tables import markdown
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from . import wall_costs, wall_runs, wall_scale
from .common import DOCS, Constants, Study, rows

CRACKS, OWN = (DOCS / "images" / f"validation_walls_{name}.png" for name in ("cracks", "own"))

FORCES = {"WS40": 44.8, "WS100": 104.8, "WS175": 179.8, "WS250": 254.8,
          "SW30": 33.6, "SW100": 103.6, "SW200": 203.6, "SW250": 253.6}  # fmt: skip
"""Vertical forces on the dry walls, kN."""

LEVEL = {"WS": 1325.0, "SW": 1000.0}
"""Height of the horizontal force, mm; the walls are 1000 mm long."""

UNTIL = {"WS": 20.0, "SW": 12.0, "SW30": 9.0}
"""Displacements up to which the strengths are compared, mm; after 9 mm SW30 leans on its rig."""

MORTAR = ("J4D", "J6D", "J7D")


def until(name: str) -> float:
    """Displacement up to which a dry wall is compared."""
    return UNTIL.get(name, UNTIL[name[:2]])


def measured(wall: str) -> dict[str, Floats]:
    """Displacements and forces (n, 2) of the tests of a wall."""
    parts = rows("walls").query("wall == @wall").groupby("test", sort=False)
    return {test: part[["displacement", "force"]].to_numpy(float) for test, part in parts}


def most(curve: Floats, limit: float) -> float:
    """Largest force up to a displacement, between the points of a curve, too."""
    inside = curve[:, 0] <= limit
    return float(max(curve[inside, 1].max(), np.interp(limit, curve[:, 0], curve[:, 1])))


def strengths(wall: str) -> list[float]:
    """Measured strengths of a wall, kN."""
    if wall in FORCES:
        return [most(test_curve, until(wall)) for test_curve in measured(wall).values()]
    names = ("J4D", "J5D") if wall == "J4D" else (wall,)
    table = rows("walls_mortar")
    return table.peak[table.test.isin(names)].tolist()


def errors(curves: dict[str, Floats]) -> dict[str, float]:
    """Error of the strength of every wall over the mean of the measured ones."""
    error_of = {}
    for wall in (*FORCES, *MORTAR):
        model = most(curves[wall], until(wall) if wall in FORCES else np.inf)
        error_of[wall] = float(model / np.mean(strengths(wall)) - 1.0)
    return error_of


def dry(curves: dict[str, Floats]) -> str:
    """Table of the dry walls."""
    away, body = errors(curves), []
    for name, force in FORCES.items():
        bound = force * 500.0 / LEVEL[name[:2]]
        tests = ", ".join(f"{x:.1f}" for x in strengths(name))
        model = most(curves[name], until(name))
        body.append([name, f"{force:g}", f"{bound:.1f}", f"{until(name):g}", tests, f"{model:.1f}",
                     f"**{100.0 * away[name]:.0f}**"])  # fmt: skip
    head = ["wall", "N, kN", "N L/(2 H0), kN", "up to, mm", "measured, kN", "model, kN", "error, %"]
    return markdown(head, body)


def mortar(curves: dict[str, Floats]) -> str:
    """Table of the Eindhoven walls."""
    body = []
    for name in MORTAR:
        tests = strengths(name)
        line = [name, ", ".join(f"{x:g}" for x in tests)]
        for curve in (curves[name], curves[f"{name} 10 0.1"]):
            k = curve[:, 1].argmax()
            away = 100.0 * (curve[k, 1] / np.mean(tests) - 1.0)
            line += [f"{curve[k, 1]:.1f}", f"**{away:.0f}**"]
        body.append(line)
    head = ["wall", "measured, kN", "flat, kN", "error, %", "10°, 0.1 mm, kN", "error, %"]
    return markdown(head, body)


ENDS = {"J4D": "2/3 of 50, 52"}
"""Forces after the peak as they are recalled of the tests, kN."""


def crush(curves: dict[str, Floats], summaries: pandas.DataFrame) -> str:
    """Table of the Eindhoven walls whose joints have a compressive strength, and one of them by IMPL-EX."""
    body = []
    for label, name, other in (
        *((name, name, f"crush {name}") for name in MORTAR),
        ("J4D, IMPL-EX", "flat implex 0.05 0.02", "crush implex"),
    ):
        both = [curves[run_name] for run_name in (name, other)]
        peaks = [f"{curve[:, 1].max():.2f}" for curve in both]
        last = [f"{np.interp(4.0, curve[:, 0], curve[:, 1]):.1f}" for curve in both]
        body.append([label, *peaks, *last, ENDS.get(name, ""), f"{summaries.loc[other].e_t:.1g}"])
    head = ["wall", "peak, kN", "with fc", "at 4 mm, kN", "with fc", "measured then", "e_t with fc"]
    return markdown(head, body)


JOINTS = {
    "J4D": ("0", "flat"),
    "J4D 5 0.1": ("5", "0.1"),
    "J4D 10 0.1": ("10", "0.1"),
    "J4D 20 0.1": ("20", "0.1"),
    "J4D 10 0.5": ("10", "0.5"),
    "J4D 10 0": ("10", "straight"),
}
"""Theta in degrees and height in mm of J4D with inclined planes."""


def dilation(curves: dict[str, Floats]) -> str:
    """Table of J4D with inclined planes."""
    body = []
    for name, joint in JOINTS.items():
        curve = curves[name]
        vertical = [f"{np.interp(x, curve[:, 0], curve[:, 2]):.0f}" for x in (2.0, 4.0)]
        body.append([*joint, f"{curve[:, 1].max():.1f}", *vertical])
    head = ["theta, °", "height, mm", "peak, kN", "vertical at 2 mm, kN", "at 4 mm, kN"]
    return markdown(head, body)


CHOICES = {
    "step 0.2": "largest step 0.2 mm",
    "step 0.1": "0.1 mm",
    "J4D": "0.05 mm, mesh 4 x 3",
    "step 0.0125": "0.0125 mm",
    "J4D 2 2": "0.05 mm, mesh 2 x 2",
    "J4D 8 6": "0.05 mm, mesh 8 x 6",
}
"""Steps and meshes of J4D with flat joints."""

SOLID = {
    "3D 0": "turn 0: two planes face across the slip",
    "3D 45": "turn 45°",
}


CHANGES = {
    "WS100 4 4": ("WS100", "elements of half the size"),
    "SW100 4 4": ("SW100", "elements of half the size"),
    "J4D 8 6": ("J4D", "elements of half the size"),
    "WS100 kn": ("WS100", "joints of twice the stiffness"),
}
"""Runs with another mesh or another assumed constant: wall and change."""


def changes(curves: dict[str, Floats]) -> str:
    """Table of the strengths with other meshes and assumed constants."""
    body = []
    for name, (wall, change_text) in CHANGES.items():
        limit, end = until(wall) if wall in FORCES else np.inf, float(curves[name][-1, 0])
        if end < min(limit, curves[wall][-1, 0]) - 1e-6:
            change_text, limit = f"{change_text}, which stops at {end:.1f} mm", end
        new, old = (most(curves[run_name], limit) for run_name in (name, wall))
        body.append([wall, change_text, f"{100.0 * (new / old - 1.0):+.1f}"])
    return markdown(["wall", "change", "strength, %"], body)


def outcomes(summaries: pandas.DataFrame, labels: dict[str, str], first_title: str, end: float = 4.0) -> str:
    """Table of runs: peak, cost, and what the passes left."""
    body = []
    for name, label in labels.items():
        summary = summaries.loc[name]
        if summary.end < end:
            raise ValueError(f"{name}: stops at {summary.end:g} mm: expected {end:g}")
        steps = f"{summary.by_passes:.0f} of {summary.steps:.0f}"
        cost = f"{summary.iterations:.0f}", f"{summary.seconds:.0f}", steps
        body.append([label, f"{summary.peak:.1f}", *cost, wall_costs.left_by_passes(summary)])
    return markdown([first_title, "peak, kN", "factorizations", "seconds", "steps by passes", "e_t"], body)


def ends(summaries: pandas.DataFrame) -> str:
    """Table of the walls that were tested: factorizations, steps by passes, snaps, errors of forces."""
    body = []
    for label, names in {
        "dry": FORCES,
        "mortar, flat": MORTAR,
        "mortar, 10°": [f"{name} 10 0.1" for name in MORTAR],
    }.items():
        chosen = summaries.loc[[*names]]
        counts = [f"{least:.0f} to {most:.0f}" for least, most in (
            (part.min(), part.max()) for part in (chosen.iterations, chosen.by_passes))]  # fmt: skip
        calm = chosen.calm.fillna(chosen.e_t).max()
        shares = (100.0 * chosen[name].abs().max(skipna=False) for name in ("unbalanced", "released"))
        remaining, freed = ("" if np.isnan(share) else f"{share:.2g}" for share in shares)
        body.append([label, *counts, f"{chosen.snaps.sum():.0f}", f"{calm:.1g}", remaining, freed])
    head = [
        "walls",
        "factorizations",
        "steps by passes",
        "snaps",
        "largest e_t",
        "unbalanced, %",
        "released, %",
    ]
    return markdown(head, body)


def draw(_: Mapping[str, Constants]) -> Figure:
    """Draw model and measurement of all walls."""
    curves = wall_runs.curves()
    figure, axes = new_figure(TWO, 5.4, nrows=2, ncols=2)
    for ax, kind, title in zip(axes, ("WS", "SW"), ("dry granite", "dry sandstone"), strict=False):
        for name, colour in zip((wall for wall in FORCES if wall[:2] == kind), COLOURS, strict=False):
            ax.plot(*curves[name][:, :2].T, color=colour, label=f"{name}, {FORCES[name]:g} kN")
            for test_curve in measured(name).values():
                ax.plot(*test_curve[:, :2].T, color=colour, linestyle="--", linewidth=0.8)
        ax.set_xlim(0.0, UNTIL[kind])
        ax.set_title(f"{title}: lines model, dashed measured")
    for name, colour in zip(MORTAR, COLOURS, strict=False):
        axes[2].plot(*curves[name][:, :2].T, color=colour, label=f"{name}, flat")
        axes[2].plot(*curves[f"{name} 10 0.1"][:, :2].T, color=colour, linestyle=":", label=f"{name}, 10°")
        for peak in strengths(name):
            axes[2].axhline(peak, color=colour, linestyle="--", linewidth=0.8)
    axes[2].set_title("Eindhoven: lines model, dashed measured peaks")
    if "cyclic WS100" in curves:
        for test_curve in measured("cyclic WS100").values():
            axes[3].plot(*test_curve[:, :2].T, color="0.6", linewidth=0.8, label="measured, WS2.100")
        axes[3].plot(*curves["cyclic WS100"][:, :2].T, color=COLOURS[1], label="model")
    axes[3].set_title("dry granite, cyclic")
    for ax in axes:
        ax.set(xlabel="displacement [mm]", ylabel="horizontal force [kN]")
        ax.grid(alpha=0.3)
    for ax, top, columns in zip(axes, (100.0, 140.0, 130.0), (2, 2, 3), strict=False):
        ax.set_ylim(0.0, top)
        ax.legend(loc="upper left", ncols=columns)
    axes[3].legend()
    return figure


def arches() -> str:
    """Table of the arches."""
    keys = ["ratio", "mu", "tan_psi", "limit"]
    body = []
    for key, part in rows("arches", dtype=str).groupby(keys, sort=False):
        by_dimension = dict(zip(part.dim, part.model, strict=True))
        body.append([*key, *(by_dimension.get(dim, "") for dim in "23")])
    return markdown(["t/R", "mu", "tan(theta)", "limit analysis, g", "model in 2D, g", "in 3D, g"], body)


PANELS = {
    CRACKS: (
        ("WS100", "dry granite, 20 mm", 4.0, "separation"),
        ("SW100", "dry sandstone, 12 mm", 8.0, "separation"),
        ("J4D", "J4D, 4 mm", 20.0, "damage"),
    ),
    OWN: (
        ("arch_0.15_2", "arch, t/R = 0.15, as it falls", None, "separation"),
        ("window", "wall with a window, 1 mm", 60.0, "damage"),
    ),
}
"""Pictures of deformed structures: run, title, scale of the displacements, field of the joints."""


def draw_deformed(folder: Path, panels: Sequence[tuple[str, str, float | None, str]]) -> Figure:
    """Draw deformed structures, their joints with the colour of damage or separation."""
    import meshio

    figure, axes = new_figure(TWO, 3.2, ncols=len(panels))
    for ax, (name, title, scale, field) in zip(axes, panels, strict=True):
        last = sorted((folder / name).glob("solids_*.vtu"))[-1]
        solids, joints = meshio.read(last), meshio.read(last.with_name(last.name.replace("solids", "joints")))
        if scale is None:  # the largest displacement is drawn as a tenth of the structure
            most = np.abs(solids.point_data["displacement"]).max()
            scale = float(f"{0.1 * np.ptp(solids.points) / most:.1g}")
        shapes = [
            (part.points + scale * part.point_data["displacement"])[:, :2][part.cells[0].data]
            for part in (solids, joints)
        ]
        grey = {"facecolors": "#E4DCCF", "edgecolors": "#C8BBA5", "linewidths": 0.2}
        ax.add_collection(PolyCollection(shapes[0], **grey))
        values = joints.cell_data[field][0]
        values = np.linalg.norm(values, axis=1) if field == "separation" else values
        shown = values > 0.05 * (values.max() if field == "separation" else 1.0)
        cells = PolyCollection(shapes[1][shown], cmap="plasma_r", linewidths=1.4, edgecolors="face")
        cells.set_array(values[shown])
        cells.set_edgecolor("face")
        ax.add_collection(cells)
        label = "separation [mm]" if field == "separation" else field
        figure.colorbar(cells, ax=ax, location="bottom", shrink=0.8, pad=0.02, aspect=25, label=label)
        ax.set_title(f"{title}\ndisplacements × {scale:g}")
        ax.set_aspect("equal")
        ax.autoscale_view()
        ax.set_axis_off()
    return figure


def tables(_: Mapping[str, Constants]) -> dict[str, str]:
    """Tables of the page from the stored rows."""
    curves, summaries = wall_runs.curves(), wall_runs.summaries()
    return {
        "dry": dry(curves),
        "mortar": mortar(curves),
        "crush": crush(curves, summaries),
        "dilation": dilation(curves),
        "ends": ends(summaries),
        "aims": wall_costs.aims(summaries),
        "costs": wall_costs.costs(summaries),
        "choices": outcomes(summaries, CHOICES, "J4D, flat"),
        "planes": wall_costs.planes(summaries),
        "solid": outcomes(summaries, SOLID, "RP-4", 3.5),
        "changes": changes(curves),
        "scale": wall_scale.costs(),
        "growth": wall_scale.growth(),
        "iterations": wall_scale.iterations(),
        "arches": arches(),
    }


def run() -> dict[str, Constants]:
    """Run the walls whose rows are not in build/walls, store their rows and draw them; no constants."""
    folder = wall_runs.BUILD / "walls"
    wall_runs.execute_all(folder)
    wall_runs.store(folder)
    wall_scale.execute()
    with printed():
        for picture, panels in PANELS.items():
            save(draw_deformed(folder, panels), picture)
        save(wall_costs.draw_costs(), wall_costs.COSTS)
        save(wall_costs.draw_planes(), wall_costs.PLANES)
    return {}


STUDY = Study("walls", run, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
