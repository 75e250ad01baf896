"""Dam on the joint along its base in OpenGeoSys, with the water in the joint and its steady flow; m, N.

The joint is a thin layer of HYDRO_MECHANICS, whose law gets the effective stress and whose permeability is
the cubic law (dam.prj).  As a script this module prints the separations and pressures at a level of the
water; harness/hosts/fenicsx/dam.py does the same on FEniCSx.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import meshio
import numpy as np
import ogs_run  # sets the path of dam_section
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.mesh import Jointed, write
from asperity.mesh.writing import layer_points
from dam_section import A_0, BASE, STIFFNESS, UPLIFTS, program, section

PROJECT = Path(__file__).parent / "dam.prj"
THICKNESS = 1e-3
"""Of the layer, m."""

LAW = Interface(Material.from_joint(kn=STIFFNESS, ks=STIFFNESS, mu=1000.0), Pattern.regular(0, 0.0))
"""No bond, no sliding."""


def write_meshes(folder: Path, mesh: Jointed) -> tuple[Floats, Floats]:
    """Write the meshes of the project; the nodes below and above the joint (n,), along the base."""
    write(folder / "dam.vtu", mesh, "ogs", layer=THICKNESS)
    points = np.pad(layer_points(mesh, THICKNESS), ((0, 0), (0, 1)))
    [joint] = mesh.joints["base"]
    pairs = np.unique(np.stack([joint.minus, joint.plus], axis=-1).reshape(-1, 2), axis=0)
    pairs = pairs[np.argsort(mesh.points[pairs[:, 0], 0])]
    solids = np.setdiff1d(np.arange(len(points)), pairs)
    for name, nodes in {"joint": pairs, "heel": pairs[0], "toe": pairs[-1], "solids": solids}.items():
        used = np.sort(nodes.ravel())
        ids = {"bulk_node_ids": used.astype("u8")}
        single = [("vertex", np.arange(len(used))[:, None])]
        meshio.Mesh(points[used], single, ids).write(folder / f"{name}.vtu")
    return pairs[:, 0], pairs[:, 1]


def patch(uplift: str, level: float, E: float, nu: float) -> str:
    """Patch of the project: constants, and the pressures that are given in the joint."""
    law = "/*/media/medium[@id='3']/properties/property[name='permeability']"
    numbers = {
        f"{law}/intrinsic_permeability": A_0**3 / (12.0 * THICKNESS),
        f"{law}/initial_aperture": A_0,
        f"{law}/mean_frac_distance": THICKNESS,
        "/*/parameters/parameter[name='E']/value": E,
        "/*/parameters/parameter[name='nu']/value": nu,
    }
    changes = [("replace", f"{where}/text()", repr(value)) for where, value in numbers.items()]
    for name, text in (
        ("thrust", f"9810*max({level!r}*t/1e20-y,0)"),
        ("full", f"9810*{level!r}*t/1e20"),
        ("linear", f"9810*{level!r}*t/1e20*(1-x/{BASE!r})"),
    ):
        changes.append(("replace", f"/*/parameters/parameter[name='{name}']/expression/text()", text))
    pressures = {
        "none": {"joint": "zero"},
        "linear": {"joint": "linear"},
        "flow": {"heel": "full", "toe": "zero"},
    }
    for where, p in pressures[uplift].items():
        words = f"<mesh>{where}</mesh><type>Dirichlet</type><parameter>{p}</parameter>"
        place = "/*/process_variables/process_variable[name='pressure']/boundary_conditions"
        changes.append(("add", place, f"<boundary_condition>{words}</boundary_condition>"))
    return ogs_run.changed(*changes)


def profile(folder: Path, uplift: str, level: float, parts: int, E: float = 3e12, nu: float = 0.0) -> Floats:
    """Rows x, s_N, p of the joint at a level; RuntimeError where OpenGeoSys finds no solution."""
    mesh = section(parts)
    below, above = write_meshes(folder, mesh)
    card = LAW.card("ogs", dimension=2, h=THICKNESS).replace(
        '<constitutive_relation id="1">', '<constitutive_relation id="3">'
    )
    run = ogs_run.run(folder, patch(uplift, level, E, nu), card, project=PROJECT)
    last = run.steps()[1][-1]
    s_N = (last["displacement"][above] - last["displacement"][below])[:, 1]
    return np.column_stack([mesh.points[below, 0], s_N, last["pressure"][below]])


def of_options(uplift: str, level: float, parts: int, E: float, nu: float) -> Floats:
    """Rows of the joint, of a run in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        return profile(Path(folder), uplift, level, parts, E, nu)


if __name__ == "__main__":
    program(of_options, __doc__, UPLIFTS)
