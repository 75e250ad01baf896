"""Results for ParaView."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

from jointed_model import Model  # isort: skip  # loads MPI
import numpy as np
from asperity import contract
from jointed_mesh import BASIX, COMM, NAMES

sys.path.append(str(Path(__file__).parent.parent))  # of paraview_files, where it is not beside this file
import paraview_files


class Output:
    """Results for ParaView: FILE.pvd, and in a folder FILE the solids and joints of every rank and step."""

    def __init__(self, model: Model, pvd: str | Path) -> None:
        """Make the folder; FILE must end with .pvd."""
        self.model, self.pvd, self.names, m = model, Path(pvd), [], model
        self.folder = paraview_files.folder_of(self.pvd)
        kind = {there: here for here, there in NAMES.items()}
        self.kind = kind.get(name := m.mesh.topology.cell_name(), name)
        own = m.mesh.topology.index_map(m.d).size_local
        self.solids = m.V.dofmap.list[:own][:, np.argsort(BASIX[self.kind])]
        x = m.V.tabulate_dof_coordinates()[m.sides]
        self.near = np.ptp(x, axis=0).max((1, 2)) < 1e-9 * np.ptp(m.x)  # those across a period are not drawn
        low, high = m.sides[:, self.near]
        self.joints = np.concatenate([low, high[:, ::-1] if m.d == 2 else high], 1)

    def write(self, time: float) -> None:
        """Write a step: displacements; damage, separation, traction, energies and water of the joints.

        Tractions are total, p is the pressure, and apertures are those of `Model.flow` or the openings.
        """
        m = self.model
        nodes, u = m.V.tabulate_dof_coordinates()[:, : m.d], m.spread(m.u).reshape(-1, m.d)
        water = [m.water.p[p] for p in m.parts]
        rows = zip(m.laws, m.s, m.state, water, strict=True)
        results = [law.update(s, state, s, 1.0, p=p) for law, s, state, p in rows]
        room = contract.N_POINT_STATEV  # laws may have another number of planes
        values = m.s, [r.traction for r in results], [state[:, :room] for state in m.state]
        of_faces = (np.concatenate(by_law)[m.face_points[self.near]] for by_law in values)
        numbers = m.cell_block[: len(self.solids)], m.face_joint[self.near], m.names, m.joints
        fields = {"p": m.water.p[m.face_points], "aperture": m.water.aperture(m.s)}
        fields = {name: at_points[self.near] for name, at_points in fields.items()}
        step = paraview_files.Step(
            time, nodes, u, self.kind, self.solids, self.joints, *of_faces, *numbers, fields
        )
        files = step.write(self.folder, f"{len(self.names):04}_{COMM.rank}")
        self.names.append((time, [*itertools.chain(*COMM.allgather(files))]))
        if COMM.rank == 0:
            paraview_files.write_collection(self.pvd, self.names)
