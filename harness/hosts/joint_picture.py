"""Picture of a structure and of its joints, from the files for ParaView: joint_picture.py FILE.pvd.

The files are those of paraview_files.py for a plane structure.  Beside the deformed mesh stand damage, slip
and shear traction of horizontal joints over x.  Below are the columns of --curves over its first one; the
column NAME_point, that of a material point, is drawn beside NAME.
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
from asperity.contract import Floats
from matplotlib.collections import PolyCollection

STYLES = ("C0-", "C1--", "k:")
"""Colours and lines of the joints from below."""

SHOWN = {"damage": "damage [-]", "separation": "slip [mm]", "traction": "shear traction [MPa]"}
"""Fields of the picture, with their units in the examples; of vectors the part along the joint."""

CURVES = {"slip": "slip [mm]", "force": "force [N]", "rise": "rise [mm]"}
"""Columns of --curves, with their units in the examples."""


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
    """Values of a field of the joints; of a vector the length of its part along the joint."""
    (values,) = joints.cell_data[name]
    return np.linalg.norm(values[:, 1:], axis=1) if values.ndim > 1 else values


def read_curves(csv: Path) -> dict[str, Floats]:
    """Columns of a CSV file by name."""
    names = csv.read_text(encoding="utf-8").splitlines()[0].split(",")
    unknown = [name for name in names if name.removesuffix("_point") not in CURVES]
    if unknown:
        raise ValueError(f"{csv}: column {unknown[0]}: expected {', '.join(CURVES)}, or NAME_point")
    return dict(zip(names, np.loadtxt(csv, delimiter=",", skiprows=1).T, strict=True))


def draw(
    png: Path, title: str, solids: meshio.Mesh, joints: meshio.Mesh, scale: float, curves: dict[str, Floats]
) -> None:
    """Draw the deformed mesh and the fields SHOWN, and the curves below them."""
    wide = [name for name in curves if not name.endswith("_point")][1:]
    figure = plt.figure(figsize=(8.0, 4.6 + 2.4 * bool(wide)), layout="constrained")
    above, *below = figure.subfigures(
        1 + bool(wide), 1, squeeze=False, height_ratios=[4.6, 2.4][: 1 + bool(wide)]
    )[:, 0]
    axes = above.subplot_mosaic([["mesh", name] for name in SHOWN], width_ratios=[1.3, 1.0])
    for part in below:
        x_name, x = next(iter(curves.items()))
        for ax, name in zip(part.subplots(1, len(wide), squeeze=False)[0], wide, strict=True):
            ax.plot(x, curves[name], STYLES[0], label="structure")
            if f"{name}_point" in curves:
                ax.plot(x, curves[f"{name}_point"], STYLES[1], label="material point")
                ax.legend(fontsize="x-small")
            ax.set_xlabel(CURVES[x_name])
            ax.set_ylabel(CURVES[name], fontsize="small")
            ax.grid(alpha=0.3)
    mesh = axes["mesh"]
    grey = {"facecolors": "#E8E4DC", "edgecolors": "#999999", "linewidths": 0.3}
    moved = (solids.points + scale * solids.point_data["displacement"])[:, :2]
    mesh.add_collection(PolyCollection(moved[solids.cells[0].data], **grey))
    mesh.set_aspect("equal")
    mesh.autoscale_view()
    mesh.set(xlabel="x [mm]", ylabel="y [mm]")
    mesh.set_title(f"displacements times {scale:g}", fontsize="small")
    # joints are farther from each other than the thickness of their cells
    x, y = joints.points[joints.cells[0].data].mean(axis=1)[:, :2].T
    order = np.argsort(y)
    lines = np.split(order, np.flatnonzero(np.diff(y[order]) > 0.05 * np.ptp(solids.points[:, 1])) + 1)
    for name, label in SHOWN.items():
        ax, values = axes[name], field(joints, name)
        for line, style in zip(lines, STYLES, strict=False):
            along = line[np.argsort(x[line])]
            ax.plot(x[along], values[along], style, label=f"y = {y[line].mean():.4g} mm")
        ax.set_ylabel(label, fontsize="small")
        ax.set_ylim(*((0.0, 1.02) if name == "damage" else (0.0, None)))
        ax.grid(alpha=0.3)
        if ax is not axes["traction"]:
            ax.sharex(axes["traction"])
            ax.tick_params(labelbottom=False)
    axes["traction"].set_xlabel("x [mm]")
    axes["damage"].legend(fontsize="x-small")
    figure.suptitle(title, fontsize="medium")
    png.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(png, dpi=150)
    plt.close(figure)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Structure and joints, drawn from a PVD file.")
    parser.add_argument("pvd", type=Path, metavar="FILE.pvd", help="written by an example with --pvd")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.png", help="default: FILE.png")
    parser.add_argument("--scale", type=float, default=1.0, help="of displacements (default: %(default)s)")
    parser.add_argument("--title", default="", help="of the picture")
    parser.add_argument("--curves", type=Path, metavar="FILE.csv", help="to be drawn below")
    options = parser.parse_args()
    if options.pvd.suffix != ".pvd" or not options.pvd.is_file():
        parser.error(f"{options.pvd}: expected a PVD file of an example")
    try:
        steps = read(options.pvd)
        curves = {} if options.curves is None else read_curves(options.curves)
    except (OSError, ValueError) as error:
        parser.error(str(error))
    spread = [np.ptp(values) if len(values := field(one, "damage")) else 0.0 for _, _, one in steps]
    k = int(np.argmax(spread))  # the step whose damage varies most
    _, solids, joints = steps[k]
    title = f"{options.title or options.pvd.stem}, step {k}"
    output = options.output or options.pvd.with_suffix(".png")
    draw(output, title, solids, joints, options.scale, curves)
    print(output)


if __name__ == "__main__":
    main()
