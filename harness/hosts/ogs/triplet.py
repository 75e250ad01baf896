"""Masonry triplet in OpenGeoSys: three bricks, two bed joints, slip of the middle brick under pressure.

The model is triplet.xml, a patch of the project of the kit: 2D plane strain in mm, N, MPa with thickness 1; a
joint is a layer of the thickness THICKNESS.  As a script this module prints force and dilation beside those
of a material point, and writes them, and all steps for ParaView.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
import ogs_run
from asperity import Interface, Material, Pattern
from asperity.case_files import read_run
from asperity.mesh import Jointed, split, write
from asperity.mesh.writing import layer_points
from asperity.options import add_options
from ogs_run import Floats
from structured import grid

TRIPLET, HYDRO = (Path(__file__).parent / f"{name}.xml" for name in ("triplet", "hydro"))
LENGTH, HEIGHT, THICKNESS = 210.0, 52.0, 0.1
PRESSURE, SLIP = 0.5, 0.6
WATER, VISCOSITY = 0.2, 1.0e-9
"""Of hydro.xml: water pressure at the ends of the joints, MPa; viscosity, MPa s."""

PRELOAD_STEPS = 4
THETA = 10.0
JOINT = Interface(Material(sigma0=0.3, Gc=0.03, eta=0.95, mu=0.6, kc=20.0), Pattern.regular(2, theta=THETA))
"""A bed joint of three planes."""


@dataclass(frozen=True)
class Result:
    """Histories with a row for each step from the end of the preload on, and the run.

    slip and force of the middle brick, rise of the top, lowest water pressure in the joints (0: dry).
    """

    slip: Floats
    force: Floats
    rise: Floats
    water: Floats
    run: ogs_run.Run


def jointed(nx: int, ny: int) -> Jointed:
    """Mesh of bricks of nx x ny elements, whose joints will take their thickness from them."""
    bricks = [np.linspace(0.0, HEIGHT, ny + 1) + k * (HEIGHT + THICKNESS) for k in range(3)]
    below, above = HEIGHT + 0.5 * THICKNESS, 2.0 * HEIGHT + 1.5 * THICKNESS
    y = np.r_[bricks[0][:-1], below, bricks[1][1:-1], above, bricks[2][1:]]
    mesh = grid(np.linspace(0.0, LENGTH, nx + 1), y)
    n = np.arange(len(mesh.points)).reshape(nx + 1, -1)
    ends, beds = n[[0, -1], ny : 2 * ny + 1], n[:, [ny, 2 * ny]]
    more = {"middle": (ends[:, :-1], ends[:, 1:]), "joint": (beds[:-1], beds[1:])}
    for k, (name, sides) in enumerate(more.items(), 1):
        lines = np.stack(sides, axis=-1).reshape(-1, 2)
        mesh.cells.append(meshio.CellBlock("line", lines))
        mesh.cell_data["gmsh:physical"].append(np.full(len(lines), k))
        mesh.field_data[name] = np.array([k, 1])
    return split(mesh, {"joint": None})


def write_meshes(folder: Path, mesh: Jointed) -> None:
    """Write the meshes of the project: bricks and joints, and parts of their boundary."""
    write(folder / "triplet.vtu", mesh, "ogs", layer=THICKNESS)
    points = np.pad(layer_points(mesh, THICKNESS), ((0, 0), (0, 1)))
    [joint] = mesh.joints["joint"]
    across = np.stack([joint.minus, joint.plus], axis=-1).reshape(-1, 2)
    at_end = np.isin(mesh.points[across[:, 0], 0], (0.0, LENGTH))
    parts = {name: np.concatenate(mesh.groups[name]) for name in ("bottom", "middle", "top")}
    for name, lines in (parts | {"ends": across[at_end]}).items():
        used, local = np.unique(lines, return_inverse=True)
        ids = {"bulk_node_ids": used.astype("u8")}
        meshio.Mesh(points[used], [("line", local.reshape(-1, 2))], ids).write(folder / f"{name}.vtu")


def run(folder: Path, nx: int, ny: int, *patches: str, law: Interface = JOINT, end: float = SLIP) -> Result:
    """Apply the pressure, then move the middle brick to a slip (mm); bricks of nx x ny elements.

    Patches of the project come before the card.
    """
    mesh = jointed(nx, ny)
    write_meshes(folder, mesh)
    moved = ogs_run.changed(ogs_run.values("slip", [0.0, 0.0, end]))
    patches = TRIPLET.read_text(encoding="utf-8"), *patches, moved, law.card("ogs", dimension=2, h=THICKNESS)
    done = ogs_run.run(folder, *patches)
    steps = done.steps()[1][PRELOAD_STEPS:]
    middle, top, [joint] = mesh.nodes("middle"), mesh.nodes("top"), mesh.joints["joint"]
    slip = np.array([step["displacement"][middle[0], 0] for step in steps])
    force = np.array([step["NodalForces"][middle, 0].sum() for step in steps])
    rise = np.array([step["displacement"][top, 1].mean() for step in steps])
    water = np.array([step["pressure"][joint.minus].min() if "pressure" in step else 0.0 for step in steps])
    return Result(slip, force, rise - rise[0], water, done)


def with_water(permeability: float) -> list[str]:
    """Patches for water in the joints, of this permeability, mm2."""
    where = "/*/media/medium[@id='1']/properties/property[name='permeability']/value/text()"
    return [HYDRO.read_text(encoding="utf-8"), ogs_run.changed(("replace", where, repr(permeability)))]


def suction(permeability: float) -> float:
    """Fall of the water pressure in the middle of a joint that slides, below that at its ends.

    Steady flow into the opening joint: THICKNESS k/viscosity p'' = rate of the dilation, SLIP in 1 s.
    """
    rate = SLIP * np.tan(np.radians(THETA))
    return float(rate * VISCOSITY * LENGTH**2 / (8.0 * THICKNESS * permeability))


def prediction(slip: Floats, pressure: float = PRESSURE, law: Interface = JOINT) -> tuple[Floats, Floats]:
    """Force on two joints and rise of the top if all points have the same separation."""
    history = law.confined_slip(0.0, slip, -pressure)
    rise = history.separation[:, 0]
    return 2.0 * LENGTH * history.traction[:, 1], 2.0 * (rise - rise[0])


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Masonry triplet in OpenGeoSys.")
    add_options(
        parser,
        ("--case CASE.nml", "interface of the joints", Path),
        ("--slip SLIP", "of the middle brick, mm, > 0", SLIP),
        ("--csv FILE.csv", "write force and rise over the slip", Path),
        ("--pvd FILE.pvd", "write all steps for ParaView", Path),
        ("--water K", "permeability, mm2, > 0, of joints with water; without: dry", float),
    )
    options = parser.parse_args()
    for name in ("slip", "water"):
        if (value := getattr(options, name)) is not None and not 0.0 < value < float("inf"):
            parser.error(f"--{name} {value:g}: expected more than 0")
    law = JOINT if options.case is None else read_run(options.case).interface
    patches = [] if options.water is None else with_water(options.water)
    patches += [] if options.pvd is None else [ogs_run.with_points(law)]
    pressure = PRESSURE if options.water is None else PRESSURE - WATER
    with tempfile.TemporaryDirectory() as name:
        result = run(Path(name), 21, 5, *patches, law=law, end=options.slip)
        force, rise = prediction(result.slip, pressure, law)
        iterations = result.run.iterations
        print(f"{len(iterations)} steps, {sum(iterations)} iterations, at most {max(iterations)}")
        print(f"largest force {result.force.max():.2f} N, of the material point {force.max():.2f} N")
        print(f"force at the end {result.force[-1]:.2f} N, of the material point {force[-1]:.2f} N")
        print(f"rise at the end {result.rise[-1]:.4f} mm, of the material point {rise[-1]:.4f} mm")
        if options.water is not None:
            lowest = f"{result.water[-1]:.4f} MPa, at their ends {WATER:g} MPa"
            print(f"lowest water pressure in the joints {lowest}")
        if options.csv is not None:
            table = np.column_stack([result.slip, result.force, result.rise, force, rise])
            head = "slip,force,rise,force_point,rise_point"
            np.savetxt(options.csv, table, "%.6f", ",", header=head, comments="")
        if options.pvd is not None:
            ogs_run.write_paraview(options.pvd, Path(name, "triplet.vtu"), result.run, law, THICKNESS)


if __name__ == "__main__":
    main()
