"""Picture of the fields on the joints of a structure, from the files for ParaView: joint_picture.py FILE.pvd.

The files are those of paraview_files.py.  A joint is seen from the side, as a line of the structure, or from
above, where the structure is left out.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import meshio
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

Floats = NDArray[np.float64]

AXES = {"y": 1, "z": 2}

SHOWN = {"damage": "-", "dilation": "mm", "slip": "mm", "friction": "N/mm"}
"""Fields of the picture and their units in the examples."""


def read(pvd: Path) -> list[tuple[float, meshio.Mesh, meshio.Mesh]]:
    """Time, solids and joints of every step."""
    rows: dict[float, list[meshio.Mesh]] = {}
    for one in ET.parse(pvd).getroot().iter("DataSet"):
        mesh = meshio.read(pvd.parent / one.attrib["file"])
        rows.setdefault(float(one.attrib["timestep"]), []).append(mesh)
    if not rows or any(len(meshes) != 2 for meshes in rows.values()):
        raise ValueError(f"{pvd}: expected solids and joints of every step, as an example writes with --pvd")
    return [(time, *meshes) for time, meshes in rows.items()]


def field(joints: meshio.Mesh, name: str) -> Floats:
    """Values of a field of the joints; of a vector its length."""
    (values,) = joints.cell_data[name]
    return np.linalg.norm(values, axis=1) if values.ndim > 1 else values


def outlines(mesh: meshio.Mesh, plane: list[int], scale: float) -> list[Floats]:
    """Outlines of the displaced cells in a plane of two axes."""
    (block,) = mesh.cells
    moved = (mesh.points + scale * mesh.point_data["displacement"])[:, plane]
    found = []
    for corners in moved[block.data]:
        try:
            found.append(corners[ConvexHull(corners).vertices])
        except QhullError:  # the cell is a line in this view
            found.append(corners[np.lexsort(corners.T)[[0, -1]]])
    return found


def at_level(joints: meshio.Mesh, z: float) -> meshio.Mesh:
    """The joints that are nearest to a height."""
    (block,) = joints.cells
    away = np.abs(joints.points[block.data, 2].mean(axis=1) - z)
    near = away <= away.min() + 1e-6 * np.ptp(joints.points)
    of_cells = {name: [values[near]] for name, (values,) in joints.cell_data.items()}
    return meshio.Mesh(joints.points, [(block.type, block.data[near])], joints.point_data, of_cells)


def draw(
    png: Path,
    title: str,
    solids: meshio.Mesh,
    joints: meshio.Mesh,
    up: str,
    level: float | None,
    scale: float,
) -> None:
    """Draw the fields SHOWN, from the side or, at a level, from above."""
    plane = [0, 1] if level is not None else [0, AXES[up]]
    if level is not None:
        joints = at_level(joints, level)
    wide = np.ptp(solids.points[:, plane], axis=0)
    rows, columns = (2, 2) if wide[1] < wide[0] else (1, 4)
    height = 9.2 / columns * wide[1] / wide[0] + 1.4
    figure, axes = plt.subplots(rows, columns, figsize=(10.6, rows * height + 0.3), layout="constrained")
    for ax, (name, unit) in zip(axes.ravel(), SHOWN.items(), strict=True):
        if level is None:
            grey = {"facecolors": "#EEEEEE", "edgecolors": "#BBBBBB", "linewidths": 0.3}
            ax.add_collection(PolyCollection(outlines(solids, plane, scale), **grey))
        width = 4.0 if level is None else 0.2
        shapes = outlines(joints, plane, scale)
        cells = PolyCollection(shapes, cmap="cividis", linewidths=width, capstyle="butt")
        cells.set_array(field(joints, name))
        cells.set_edgecolor("face")
        ax.add_collection(cells)
        bar = figure.colorbar(cells, ax=ax, location="top", shrink=0.8, pad=0.01, aspect=30)
        bar.set_label(f"{name} [{unit}]")
        bar.locator = MaxNLocator(5)
        ax.set_aspect("equal")
        ax.autoscale_view()
        ax.set_xlabel("x [mm]")
        ax.set_ylabel(f"{'xyz'[plane[1]]} [mm]")
    figure.suptitle(title, fontsize="medium")
    png.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(png, dpi=150)
    plt.close(figure)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Fields on joints, drawn from a PVD file.")
    parser.add_argument("pvd", type=Path, metavar="FILE.pvd", help="written by an example with --pvd")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.png", help="default: FILE.png")
    parser.add_argument("--step", type=int, help="from 0; default: that whose damage varies most")
    parser.add_argument("--up", default="y", choices=("y", "z"), help="axis (default: %(default)s)")
    parser.add_argument("--level", type=float, metavar="Z", help="draw the joints at this height from above")
    parser.add_argument("--scale", type=float, default=1.0, help="of displacements (default: %(default)s)")
    parser.add_argument("--title", default="", help="of the picture")
    options = parser.parse_args()
    if options.pvd.suffix != ".pvd" or not options.pvd.is_file():
        parser.error(f"{options.pvd}: expected a PVD file of an example")
    try:
        steps = read(options.pvd)
    except ValueError as error:
        parser.error(str(error))
    if options.step is not None and not 0 <= options.step < len(steps):
        parser.error(f"--step {options.step}: expected 0 to {len(steps) - 1}")
    spread = [np.ptp(values) if len(values := field(one, "damage")) else 0.0 for _, _, one in steps]
    k = int(np.argmax(spread)) if options.step is None else options.step
    _, solids, joints = steps[k]
    times = "" if options.level is not None else f", displacements times {options.scale:g}"
    title = f"{options.title or options.pvd.stem}, step {k}{times}"
    output = options.output or options.pvd.with_suffix(".png")
    draw(output, title, solids, joints, options.up, options.level, options.scale)
    print(output)


if __name__ == "__main__":
    main()
