"""Concrete dam on its joint beside two codes and closed forms: tables and picture of its page."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import meshio
import numpy as np
import pandas
from asperity.tools.style import COLOURS, TWO, new_figure
from asperity.tools.tables import markdown
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from scipy.optimize import brentq

from harness.hosts.dam_section import BASE, CREST, HEIGHT, STIFFNESS, WATER
from harness.hosts.dam_section import WEIGHT as CONCRETE

from .common import DATA, Constants, Study, rows
from .wall_runs import BUILD, PROGRAM, start

LEVEL, FRICTION = 9.0, 0.75
WEIGHT = CONCRETE * HEIGHT * (BASE + CREST) / 2.0
CENTROID = (CREST**2 + HEIGHT * 0.0 + BASE * CREST + BASE**2) / (3.0 * (BASE + CREST))
"""Place of the weight from the heel: of a trapezium with a vertical side."""

PROFILES = {
    "none": "none",
    "linear": "linear",
    "flow": "flow --nu 0.25",
    "rigid linear": "linear --E 3e15",
    "rigid flow": "flow --E 3e15",
}
"""Options of the profiles at LEVEL by their name."""

HOSTS = {
    "ogs none": "none",
    "ogs linear": "linear",
    "ogs flow": "flow --nu 0.25",
}
"""The same for OpenGeoSys."""

OTHERS = {
    "none": {"Code_Aster": [3.33416e-8, -8.74980e-8, -1.85263e-7, -2.88139e-7, -3.71977e-7]},
    "linear": {
        "Code_Aster": [4.22749e-7, 1.33680e-7, -1.38295e-7, -3.18963e-7, -4.41827e-7],
        "independent program": [4.28437e-7, 1.35765e-7, -1.38375e-7, np.nan, -4.41332e-7],
        "GEFDYN": [4.01e-7, np.nan, np.nan, np.nan, -4.25e-7],
    },
    "flow": {
        "Code_Aster": [1.41589e-6, 8.47962e-7, 5.79196e-8, -3.62105e-7, -5.84546e-7],
        "independent program": [1.42144e-6, 8.53997e-7, 5.85270e-8, np.nan, -5.82745e-7],
        "GEFDYN": [1.52e-6, np.nan, np.nan, np.nan, -5.23e-7],
    },
}
"""s_N of other codes at PLACES, m."""

PLACES = 0.0, 1.3, 3.2, 4.6, BASE
BESIDE = 0.02
"""Share of the largest separation by which meshes of 1/8 m differ, of which Code_Aster's is one of its own.

With linear uplift it is 0.013 between Code_Aster and the independent program, both at the heel.
"""

LEVELS = [
    *((uplift, "held") for uplift in ("none", "linear", "flow")),
    *(
        (uplift, joint)
        for joint in ("plain", "rough", "bonded", "rough bonded")
        for uplift in ("linear", "flow")
    ),
]
"""Water and joint of the overloads."""

LAST = ("flow", "held")
"""The one of the picture."""


def uplift(kind: str, level: float, contact: float) -> tuple[float, float]:
    """Uplift and its moment about the middle of the base, positive where it turns towards the toe."""
    p = WATER * level
    if kind == "none":
        return 0.0, 0.0
    ahead = BASE if kind == "linear" else contact
    crack = BASE - ahead
    part = p * ahead / 2.0
    return p * crack + part, p * crack * (BASE - crack) / 2.0 + part * (BASE / 2.0 - crack - ahead / 3.0)


def contact_of(kind: str, level: float) -> float:
    """Length of contact of a rigid dam: the pressure is a triangle that ends at the toe."""

    def excess(contact: float) -> float:
        force, moment = uplift(kind, level, contact)
        moment += WATER * level**3 / 6.0 - WEIGHT * (BASE / 2.0 - CENTROID)
        return contact - 3.0 * (BASE / 2.0 - moment / (WEIGHT - force))

    return float(brentq(excess, 1e-9, BASE)) if excess(BASE) > 0.0 else BASE


def opened(kind: str) -> tuple[float, float]:
    """s_N of a rigid dam at heel and toe, whose joint is open at the heel."""
    contact = contact_of(kind, LEVEL)
    toe = -2.0 * (WEIGHT - uplift(kind, LEVEL, contact)[0]) / (contact * STIFFNESS)
    return -toe * (BASE - contact) / contact, toe


def overturned(kind: str) -> float:
    """Level at which a rigid dam stands on its toe."""
    arm = BASE / 2.0

    def moment(level: float) -> float:
        force, about = uplift(kind, level, 0.0)
        return WATER * level**3 / 6.0 + about + force * arm - WEIGHT * (BASE - CENTROID)

    return float(brentq(moment, 1.0, 20.0))


def slid(kind: str) -> float:
    """Level at which a rigid dam slides, unless it overturns before."""

    def excess(level: float) -> float:
        return WATER * level**2 / 2.0 - FRICTION * (WEIGHT - uplift(kind, level, contact_of(kind, level))[0])

    return float(brentq(excess, 1.0, overturned(kind) - 1e-6))


def fit() -> dict[str, Constants]:
    """Run all models on FEniCSx whose results are not in a folder; store profiles, levels and a picture."""
    folder = BUILD / "dam"
    folder.mkdir(parents=True, exist_ok=True)
    profiles, levels = [], []
    for name, words in PROFILES.items():
        out = folder / f"{name.replace(' ', '_')}.csv"
        _run(f"profile {words} --out {out}", out.with_suffix(".txt"))
        profiles.append(pandas.read_csv(out).assign(run=name))
    for name, words in HOSTS.items():
        out = folder / f"{name.replace(' ', '_')}.csv"
        if not out.exists():
            host = name.split()[0]
            program = PROGRAM.parents[1] / host / f"dam_{host}.py"
            subprocess.run([sys.executable, program, *words.split(), "--out", out], check=True)
            print(f"{program.name} {words}", flush=True)
        profiles.append(pandas.read_csv(out).assign(run=name))
    for water, joint in LEVELS:
        words = f"overload {water} --joint '{joint}'"
        if (water, joint) == LAST:
            words += f" --pvd {folder / 'last.pvd'}"
        done = _run(words, folder / f"{water}_{joint.replace(' ', '_')}.txt")
        level, end = done.split(maxsplit=2)[1:]
        levels.append({"water": water, "joint": joint, "level": float(level), "end": end.strip()})
    _store("profiles", pandas.concat(profiles))
    _store("levels", pandas.DataFrame(levels))
    _store("picture", pandas.DataFrame(_lines(folder / "last"), columns=["line", "x", "y", "u", "v", "p"]))
    return {}


def _run(words: str, output: Path) -> str:
    """Output of a run, which a file keeps."""
    if not output.exists():
        done = start(words, "dam")
        if done.returncode not in (0, 3):  # 3: an overload ends before a limit is found, as its row says
            raise RuntimeError(f"dam.py {words}: {done.stderr}")
        output.write_text(done.stdout, encoding="utf-8")
        print(words, done.stdout.strip(), flush=True)
    return output.read_text(encoding="utf-8")


def _store(name: str, table: pandas.DataFrame) -> None:
    heading = "# Made by python -m harness.studies.validation.dam --fit\n"
    text = heading + table.to_csv(index=False, float_format="%.7g")
    (DATA / f"dam_{name}.csv").write_text(text, encoding="utf-8")


def _lines(folder: Path) -> Iterator[tuple[float, ...]]:
    """Ends of the edges of dam and rock that bound them, near the dam, and of the faces of the joint."""
    [file], [joints] = folder.glob("solids_*.vtu"), folder.glob("joints_*.vtu")
    solids = meshio.read(file)
    [cells] = [block.data for block in solids.cells if block.type == "quad"]
    edges = np.concatenate([cells[:, [k, (k + 1) % 4]] for k in range(4)])
    _, at, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    number = 0
    for a, b in edges[at[count == 1]]:
        x, u = solids.points[[a, b], :2], solids.point_data["displacement"][[a, b], :2]
        if x[:, 1].min() > -1e-9 and x[:, 0].min() > -2.0 and x[:, 0].max() < 7.0:
            yield from ((number, *x[k], *u[k], np.nan) for k in (0, 1))
            number += 1
    faces = meshio.read(joints)
    for nodes, p in zip(faces.cells[0].data, faces.cell_data["p"][0], strict=True):
        x, u = faces.points[nodes[:2], :2], faces.point_data["displacement"][nodes[:2], :2]
        yield from ((number, *x[k], *u[k], p) for k in (0, 1))
        number += 1


def _at(run: str) -> list[float]:
    """s_N of a profile at PLACES."""
    table = rows("dam_profiles").query("run == @run")
    return [float(np.interp(x, table.x, table.s_N)) for x in PLACES]


def _micro(values: Sequence[float]) -> list[str]:
    return ["" if np.isnan(value) else f"{1e6 * value:.4f}" for value in values]


def _percent(computed: float, exact: float) -> str:
    """Difference in percent, without the sign of a zero."""
    return f"{round(100.0 * (computed / exact - 1.0), 2) + 0.0:.2f}"


def tables(_: Mapping[str, Constants]) -> dict[str, str]:
    """Tables of the page."""
    body = []
    for run, name in {"none": "none", "linear": "linear", "flow": "flow"}.items():
        body.append([f"**{name}**, asperity, FEniCSx", *_micro(_at(run))])
        body.append([f"**{name}**, asperity, OpenGeoSys", *_micro(_at(f"ogs {run}"))])
        body += [[f"{name}, {code}", *_micro(values)] for code, values in OTHERS[run].items()]
    compared = markdown(["water, code", "heel", "1.3 m", "3.2 m", "4.6 m", "toe"], body)
    body = []
    for kind in ("linear", "flow"):
        profile, exact = _at(f"rigid {kind}"), opened(kind)
        ends = profile[0], profile[-1]
        away = [100.0 * (computed / closed - 1.0) for computed, closed in zip(ends, exact, strict=True)]
        heel, toe = (_micro([computed, closed]) for computed, closed in zip(ends, exact, strict=True))
        body.append([kind, f"{contact_of(kind, LEVEL):.3f}", *heel, f"{away[0]:.2f}", *toe, f"{away[1]:.2f}"])
    head = [
        "water",
        "contact, m",
        "heel, µm",
        "closed form",
        "error, %",
        "toe, µm",
        "closed form",
        "error, %",
    ]
    rigid = markdown(head, body)
    levels = rows("dam_levels").set_index(["water", "joint"]).level
    body = []
    for kind in ("none", "linear", "flow"):
        exact = overturned(kind)
        body.append([kind, "overturns", f"{levels[kind, 'held']:.3f}", f"{exact:.3f}",
                     _percent(levels[kind, "held"], exact)])  # fmt: skip
    for kind in ("linear", "flow"):
        exact = slid(kind)
        body.append([kind, f"slides, µ = {FRICTION}", f"{levels[kind, 'plain']:.3f}", f"{exact:.3f}",
                     _percent(levels[kind, "plain"], exact)])  # fmt: skip
    reached = markdown(["water", "failure", "level, m", "rigid dam, m", "difference, %"], body)
    ends = rows("dam_levels").set_index(["water", "joint"]).end
    bounds = {key: "at least " for key, end in ends.items() if end != "limit"}
    body = [
        [joint, *(f"{bounds.get((kind, joint), '')}{levels[kind, joint]:.2f}" for kind in ("linear", "flow"))]
        for joint in ("plain", "rough", "bonded", "rough bonded")
    ]
    joints = markdown(["joint", "linear uplift, m", "flow, m"], body)
    return {"compared": compared, "rigid": rigid, "levels": reached, "joints": joints}


def draw(_: Mapping[str, Constants]) -> Figure:
    """The dam at its last level, deformed, with crack and pressure; and s_N of the three profiles."""
    figure, (left, right) = new_figure(TWO, 3.2, ncols=2)
    table = rows("dam_picture")
    x = table[["x", "y"]].to_numpy(float).reshape(-1, 2, 2)
    u = table[["u", "v"]].to_numpy(float).reshape(-1, 2, 2)
    p = table.p.to_numpy(float)[::2]
    solid = np.isnan(p)
    scale = 0.5 / np.abs(u[solid][:, :, 1]).max()
    left.add_collection(LineCollection((x + scale * u)[solid], colors=COLOURS[0], linewidths=0.8))
    faces = x[~solid]
    order = np.argsort(faces[:, :, 0].mean(1))
    base, pressure = faces[order][:, :, 0], p[~solid][order]
    largest = pressure.max()
    left.fill_between(
        base.mean(1), -2.0 * pressure / largest, 0.0, color=COLOURS[1], alpha=0.4, linewidth=0.0
    )
    left.annotate(f"{1e-3 * largest:.0f} kPa", (0.1, -2.0), va="top")
    level = rows("dam_levels").set_index(["water", "joint"]).level[LAST]
    left.fill([-2.0, 0.0, 0.0, -2.0], [0.0, 0.0, level, level], color=COLOURS[1], alpha=0.2, linewidth=0.0)
    left.set(xlim=(-2, 8), ylim=(-3, 14.5), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    left.set_title(f"level {level:.3f} m, displacements × {round(scale, -2):.0f}")
    for colour, run in zip(COLOURS, ("none", "linear", "flow"), strict=False):
        run_profile = rows("dam_profiles").query("run == @run")
        right.plot(run_profile.x, 1e6 * run_profile.s_N, color=colour, label=run)
        right.plot(PLACES, 1e6 * np.array(OTHERS[run]["Code_Aster"]), "o", color=colour, markersize=3)
    right.set(xlabel="x [m]", ylabel="separation s_N [µm]")
    right.grid(alpha=0.3)
    right.legend(title="water")
    return figure


STUDY = Study("dam", fit, tables, draw)

if __name__ == "__main__":
    sys.exit(STUDY.main())
