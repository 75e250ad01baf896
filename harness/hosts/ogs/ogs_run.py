"""Runs of OpenGeoSys: meshes as VTU files, patches of the project, the run, and its output."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from asperity import Interface, contract
from asperity.contract import Floats
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parent.parent))
from asperity.mesh import paraview

PROJECT = Path(__file__).parent / "kit" / "single.prj"
"""One layer; the patch triplet.xml makes a masonry triplet of it."""

STATE = "material_state_variable_"
"""Beginning of the names of state variables at integration points."""


@dataclass(frozen=True)
class Run:
    """A run: output, and the folder of its VTU files."""

    output: str
    folder: Path

    @property
    def iterations(self) -> list[int]:
        """Iterations of Newton's method in every attempted step."""
        counters = re.findall(r"^info: Iteration #(\d+) started", self.output, re.MULTILINE)
        numbers = [int(counter) for counter in counters]
        return [n for n, after in zip(numbers, [*numbers[1:], 1], strict=True) if after == 1]

    @property
    def rejected(self) -> int:
        """Number of rejected steps."""
        m = re.search(r"rejected steps are (\d+)", self.output)
        assert m, self.output
        return int(m[1])

    def steps(self) -> tuple[Floats, list[dict[str, Floats]]]:
        """Times (T,) and the fields at the nodes of every output, by name."""
        (collection,) = self.folder.glob("*.pvd")
        sets = ET.parse(collection).getroot().iter("DataSet")
        rows = [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in sets]
        return np.array([time for time, _ in rows]), [fields(self.folder / name) for _, name in rows]


def fields(path: Path) -> dict[str, Floats]:
    """Fields of an output: those at the nodes, `Points` (n, 3), and those of integration points (NAME_ip)."""
    mesh = meshio.read(path)
    of_points = {name: field for name, field in mesh.field_data.items() if name.endswith("_ip")}
    return mesh.point_data | of_points | {"Points": mesh.points}


def with_points(interface: Interface) -> str:
    """Patch that adds the integration points of the joint to the output: strain, stress, state variables."""
    variables = contract.statev_names(interface.n_planes, True, True)
    names = ["sigma", "epsilon", *(f"{STATE}{name}" for name in variables)]
    lines = "".join(f"<variable>{name}_ip</variable>" for name in names)
    return changed(("add", "/*/time_loop/output/variables", lines))


def of_points(
    step: Mapping[str, Floats], layer: NDArray[np.bool_], interface: Interface, h: float
) -> list[Floats]:
    """Separation, traction (N, Tx, Ty) and state of the points of horizontal layers, (cells, 4, components).

    layer: which cells of a plane mesh of quadrilaterals they are.  The run needs the patch `with_points`.
    """
    # components of OpenGeoSys: xx, yy, zz, xy; Tx of the layer is -x
    at, sign = [1, 3, 2], np.array([1.0, -1.0, 0.0])
    names = [f"{STATE}{name}_ip" for name in contract.statev_names(interface.n_planes, True, True)]
    state = np.stack([step[name] for name in names], axis=1)  # of the layers only
    at_points = (step[f"{name}_ip"][:, at].reshape(-1, 4, 3)[layer] for name in ("epsilon", "sigma"))
    strain, traction = (values * sign for values in at_points)
    return [h * strain * [1.0, 2.0, 2.0], traction, state.reshape(-1, 4, len(names))]


def write_paraview(pvd: Path, mesh: Path, run: Run, interface: Interface, h: float) -> None:
    """Write the steps of a run on a plane mesh, whose joints are horizontal layers (material 1)."""
    layered_mesh = meshio.read(mesh)
    cells, layer = layered_mesh.cells_dict["quad"], np.concatenate(layered_mesh.cell_data["MaterialIDs"]) == 1
    nodes, rows = layered_mesh.points[:, :2], []
    for time, step in zip(*run.steps(), strict=True):
        moved = nodes, step["displacement"], "quad", cells[~layer], cells[layer]
        rows.append(paraview.Step(float(time), *moved, *of_points(step, layer, interface, h)))
    paraview.write(pvd, rows)


def program() -> Path:
    """Path of ogs, which its wheel installs beside this Python."""
    return Path(sys.executable).parent / "ogs"


def run(folder: Path, *patches: str, fails: bool = False, project: Path = PROJECT) -> Run:
    """Run a project with patches (texts) on the meshes of a folder, with one thread; output in `out`.

    Raises RuntimeError unless OpenGeoSys ends well, or with an error where it `fails`.
    """
    command = [str(program()), str(project), "-m", str(folder), "-o", str(folder / "out")]
    out = folder / "out"
    out.mkdir(exist_ok=True)
    for old in [*out.glob("*.vtu"), *out.glob("*.pvd")]:
        old.unlink()
    for k, patch in enumerate(patches):
        (folder / f"patch_{k}.xml").write_text(patch, encoding="utf-8")
        command += ["-p", str(folder / f"patch_{k}.xml")]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if (done.returncode != 0) != fails:
        raise RuntimeError(done.stdout + done.stderr)
    return Run(done.stdout + done.stderr, folder / "out")


def changed(*changes: tuple[str, str, str]) -> str:
    """Patch of (change, where, text): change is add, replace or remove, where a path in the project."""
    lines = [f'<{change} sel="{where}">{text}</{change}>' for change, where, text in changes]
    return "\n".join(['<?xml version="1.0"?>', "<OpenGeoSysProjectDiff>", *lines, "</OpenGeoSysProjectDiff>"])


def values(name: str, numbers: Sequence[float]) -> tuple[str, str, str]:
    """Change of the values of a curve of the project."""
    return "replace", f"/*/curves/curve[name='{name}']/values/text()", " ".join(map(repr, numbers))
