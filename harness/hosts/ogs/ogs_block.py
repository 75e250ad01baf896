"""Block of three parts with two rough joints in OpenGeoSys, 3D: slip oblique to the axes, under pressure.

The model is triplet.prj with the changes below; z is upwards.  As a script this module draws the damage of a
joint, from an output of OpenGeoSys, and the forces along and across the slip.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import ogs_run
from asperity import Interface, Material, Pattern
from asperity.installed import generic_library
from ogs_run import Floats, changed
from ogs_triplet import PRELOAD_STEPS, PRESSURE, PROJECT

LENGTH, DEPTH, HEIGHT, THICKNESS = 200.0, 100.0, 50.0, 0.01
YOUNG = 30000.0
DIRECTION = 20.0
"""Of the slip, degrees from x."""

JOINT = Interface(Material(sigma0=0.3, Gc=0.03, eta=0.95, mu=0.6, kc=20.0), Pattern.regular(3, theta=15.0))
"""A pattern that resists along and across a slip."""


@dataclass(frozen=True)
class Result:
    """Histories with a row for each step from the end of the preload on, and the run.

    slip, force along and across it (T, 2), rise of the top; nodes (x, y, levels); fields of all steps.
    """

    slip: Floats
    force: Floats
    rise: Floats
    nodes: np.ndarray
    fields: list[dict[str, Floats]]
    run: ogs_run.Run


def write_meshes(folder: Path, nx: int, ny: int, nz: int) -> np.ndarray:
    """Write the meshes of the project; return the nodes (x, y, levels)."""
    z = np.concatenate([np.linspace(0.0, HEIGHT, nz + 1) + k * (HEIGHT + THICKNESS) for k in range(3)])
    axes = (np.linspace(0.0, LENGTH, nx + 1), np.linspace(0.0, DEPTH, ny + 1), z)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    points, n = grid.reshape(-1, 3), np.arange(grid.size // 3).reshape(grid.shape[:3])
    cells = np.concatenate([quadrilaterals(n[:, :, :-1]), quadrilaterals(n[:, :, 1:])], axis=-1)
    material = np.zeros(cells.shape[:3], dtype="i4")
    material[:, :, [nz, 2 * nz + 1]] = 1
    ids = {"MaterialIDs": material.ravel()}
    ogs_run.write_mesh(folder / "triplet.vtu", points, cells.reshape(-1, 8), ogs_run.HEXAHEDRON, None, ids)
    ends = n[[0, -1], :, nz + 1 : 2 * nz + 2]
    parts = {"bottom": n[:, :, 0], "top": n[:, :, -1]}
    faces = {name: quadrilaterals(part).reshape(-1, 4) for name, part in parts.items()}
    faces["middle"] = np.concatenate([quadrilaterals(end).reshape(-1, 4) for end in ends])
    for name, cells_of_part in faces.items():
        ogs_run.write_part(folder / f"{name}.vtu", points, cells_of_part, ogs_run.QUADRILATERAL)
    return n


def quadrilaterals(n: np.ndarray) -> np.ndarray:
    """Cells (i, j, ..., 4) of a grid of nodes (i, j, ...)."""
    return np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1)


def in_space() -> str:
    """Patch of the project: three components, pressure along z, slip along x and y."""
    along, across = slip_axes()[0].tolist()
    conditions = "".join(
        f"<boundary_condition><mesh>{mesh}</mesh><type>{kind}</type><component>{axis}</component>"
        f"<parameter>{value}</parameter></boundary_condition>"
        for mesh, kind, axis, value in (
            *(("bottom", "Dirichlet", axis, "zero") for axis in range(3)),
            ("middle", "Dirichlet", 0, "slip"),
            ("middle", "Dirichlet", 1, "slip_y"),
            *(("top", "Dirichlet", axis, "zero") for axis in range(2)),
            ("top", "Neumann", 2, "pressure"),
        )
    )
    curve = "<parameter><name>slip_y</name><type>CurveScaled</type><curve>slip</curve>"
    of_field = "/*/process_variables/process_variable"
    return changed(
        ("replace", "/*/processes/process/specific_body_force/text()", "0 0 0"),
        ("replace", "/*/parameters/parameter[name='E']/value/text()", repr(YOUNG)),
        ("replace", "/*/parameters/parameter[name='rest']/values/text()", "0 0 0"),
        ("replace", f"{of_field}/components/text()", "3"),
        (
            "replace",
            f"{of_field}/boundary_conditions",
            f"<boundary_conditions>{conditions}</boundary_conditions>",
        ),
        ("replace", "/*/parameters/parameter[name='slip']/parameter/text()", "along"),
        ("add", "/*/parameters", f"{curve}<parameter>across</parameter></parameter>"),
        ("add", "/*/parameters", constant("along", along)),
        ("add", "/*/parameters", constant("across", across)),
    )


def constant(name: str, value: float) -> str:
    """A parameter of the project."""
    return f"<parameter><name>{name}</name><type>Constant</type><value>{float(value)!r}</value></parameter>"


def run(
    folder: Path, nx: int = 8, ny: int = 4, nz: int = 1, law: Interface = JOINT, *patches: str,
    library: Path | None = None,
) -> Result:
    """Apply the pressure, then move the ends of the middle part; parts of nx x ny x nz elements.

    Patches of the project come before the card of the law; library replaces that of the card.
    """
    n = write_meshes(folder, nx, ny, nz)
    card = law.card("ogs", h=THICKNESS)
    if library is not None:
        card = card.replace(f">{generic_library()}<", f">{library}<")
    done = ogs_run.run(PROJECT, folder, in_space(), *patches, card)
    if done.code != 0:
        raise RuntimeError(done.output)
    _, fields = done.steps()
    steps = fields[PRELOAD_STEPS:]
    middle = n[[0, -1], :, nz + 1 : 2 * nz + 2].ravel()
    axes = slip_axes()
    slip = np.array([axes[0] @ step["displacement"][middle[0], :2] for step in steps])
    force = np.array([axes @ step["NodalForces"][middle, :2].sum(axis=0) for step in steps])
    rise = np.array([step["displacement"][n[:, :, -1], 2].mean() for step in steps])
    return Result(slip, force, rise - rise[0], n, fields, done)


def slip_axes() -> Floats:
    """Unit vectors along and across the slip (2, 2)."""
    along, across = np.cos(np.radians(DIRECTION)), np.sin(np.radians(DIRECTION))
    return np.array([[along, across], [-across, along]])


def separations(result: Result) -> Floats:
    """Separations (N, Tx, Ty) of the lower and the upper joint at 2 x 2 points of each element.

    They are those of the nodes, interpolated: (2, T, x, y, 4, 3).
    """
    u, n = np.array([step["displacement"] for step in result.fields]), result.nodes
    level = (n.shape[2] - 3) // 3
    jump = np.array([u[:, n[:, :, k + 1]] - u[:, n[:, :, k]] for k in (level, 2 * level + 1)])[..., [2, 0, 1]]
    near, far = 0.5 + 0.5 / np.sqrt(3.0), 0.5 - 0.5 / np.sqrt(3.0)
    points = []
    for a, b in ((near, far), (far, near)):
        along = a * jump[:, :, :-1] + b * jump[:, :, 1:]
        points += [c * along[:, :, :, :-1] + d * along[:, :, :, 1:] for c, d in ((near, far), (far, near))]
    return np.stack(points, axis=-2)


def of_the_law(result: Result) -> Floats:
    """Forces along and across the slip (T, 2) by the law in Python on the separations of every point."""
    s = separations(result)
    paths = s.transpose(0, 2, 3, 4, 1, 5).reshape(2, -1, s.shape[1], 3)
    area = LENGTH * DEPTH / paths.shape[1]
    force = np.zeros((s.shape[1], 2))
    for sign, joint in zip((1.0, -1.0), paths, strict=True):
        for path in joint:
            force += sign * area * JOINT.replay(path).traction[:, 1:] @ slip_axes().T
    return force[PRELOAD_STEPS:]


def prediction(slip: Floats) -> tuple[Floats, Floats]:
    """Forces along and across the slip (T, 2) and rise of the top if all points have the same separation.

    The lower joint slips along the direction, the upper one against it.
    """
    forces, rise = np.zeros((len(slip), 2)), np.zeros(len(slip))
    for side in (1.0, -1.0):
        joint = JOINT.confined_slip(DIRECTION, side * slip, -PRESSURE)
        forces += LENGTH * DEPTH * side * joint.traction[:, 1:] @ slip_axes().T
        rise += joint.separation[:, 0] - joint.separation[0, 0]
    return forces, rise


def draw(result: Result, png: Path) -> None:
    """Draw the damage of the lower joint where it varies most, and the curves."""
    n = result.nodes
    level = (n.shape[2] - 3) // 3
    lower = n[:, :, level]
    steps = result.fields[PRELOAD_STEPS:]
    k = int(np.argmax([np.ptp(step["damage"][lower]) for step in steps]))
    fields = steps[k]
    x, y = (fields["Points"][lower, axis] for axis in range(2))
    force, rise = prediction(result.slip)
    figure, axes = plt.subplot_mosaic(
        [["joint", "joint"], ["force", "rise"]], figsize=(9, 7), layout="constrained"
    )
    drawn = axes["joint"].pcolormesh(x, y, fields["damage"][lower], shading="gouraud", cmap="cividis")
    figure.colorbar(drawn, ax=axes["joint"]).set_label("damage of the lower joint [-]")
    axes["joint"].set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    axes["joint"].set_title(f"OpenGeoSys: two joints under {PRESSURE:g} MPa, slip {result.slip[k]:.2g} mm")
    for i, (name, colour) in enumerate((("along", "#0072B2"), ("across", "#D55E00"))):
        axes["force"].plot(result.slip, result.force[:, i] / 1e3, color=colour, label=f"{name} the slip")
        axes["force"].plot(
            result.slip, force[:, i] / 1e3, "--", color=colour, label=f"{name}, material points"
        )
    axes["force"].set(xlabel="slip [mm]", ylabel="force on the middle part [kN]")
    axes["rise"].plot(result.slip, result.rise, label="OpenGeoSys")
    axes["rise"].plot(result.slip, rise, "--", label="material points")
    axes["rise"].set(xlabel="slip [mm]", ylabel="rise of the top [mm]")
    for name in ("force", "rise"):
        axes[name].grid(alpha=0.3)
        axes[name].legend(fontsize="small")
    png.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(png, dpi=150)
    plt.close(figure)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Block with two rough joints in OpenGeoSys, drawn.")
    parser.add_argument("-o", "--output", type=Path, default=Path("ogs-block.png"), metavar="FILE.png")
    parser.add_argument("--folder", type=Path, help="keep meshes, patches and output of OpenGeoSys there")
    parser.add_argument("--pvd", type=Path, metavar="FILE.pvd", help="write all steps for ParaView")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = options.folder or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        patches = [] if options.pvd is None else [ogs_run.with_points(JOINT)]
        result = run(folder, 8, 4, 1, JOINT, *patches)
        force, rise = prediction(result.slip)
        law = of_the_law(result)
        found = result.run.iterations
        print(f"{len(found)} steps, {sum(found)} iterations, at most {max(found)}")
        print(f"largest force {result.force[:, 0].max():.1f} N, of material points {force[:, 0].max():.1f} N")
        for i, what in enumerate(("along", "across")):
            print(
                f"force {what} the slip at the end {result.force[-1, i]:.2f} N, by the law in each point "
                f"{law[-1, i]:.2f} N, of material points {force[-1, i]:.2f} N"
            )
        print(f"rise at the end {result.rise[-1]:.4f} mm, of material points {rise[-1]:.4f} mm")
        draw(result, options.output)
        if options.pvd is not None:
            ogs_run.write_paraview(options.pvd, folder / "triplet.vtu", result.run, JOINT, THICKNESS)
            print(options.pvd)


if __name__ == "__main__":
    main()
