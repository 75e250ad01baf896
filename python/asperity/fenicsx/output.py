"""Results for ParaView."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path

import numpy as np

from .. import contract
from ..mesh import paraview
from .conditions import Flow
from .distribution import BASIX, NAMES
from .ledger import Ledger
from .model import Model
from .ranks import COMM, agree, expect, real
from .state import State
from .water import Water


class Output:
    """Results for ParaView: FILE.pvd, and in a folder FILE the solids and joints of every rank and step.

    FILE.csv has the energies of the steps that are written with a ledger.
    """

    def __init__(self, model: Model, pvd: str | Path) -> None:
        """Make the folder; raises ValueError on all ranks unless FILE ends with .pvd."""
        expect(Model, model=model)
        text = f"pvd of the type {type(pvd).__name__}: expected str or Path"
        agree("" if isinstance(pvd, str | Path) else text)
        self.model, self.pvd, m = model, Path(pvd), model
        self.names: list[tuple[float, list[str]]] = []
        self.rows: list[list[float]] = []
        self.folder = paraview.folder_of(self.pvd)
        kind = {there: here for here, there in NAMES.items()}
        self.kind = kind.get(name := m.mesh.topology.cell_name(), name)
        local_cells = m.mesh.topology.index_map(m.d).size_local
        self.solids = m.V.dofmap.list[:local_cells][:, np.argsort(BASIX[self.kind])]
        x = m.V.tabulate_dof_coordinates()[m.sides]
        self.near = np.ptp(x, axis=0).max((1, 2)) < 1e-9 * np.ptp(m.x)  # those across a period are not drawn
        low, high = m.sides[:, self.near]
        self.joints = np.concatenate([low, high[:, ::-1] if m.d == 2 else high], 1)

    def write(
        self,
        state: State,
        time: float | None = None,
        flows: Sequence[Flow] = (),
        ledger: Ledger | None = None,
    ) -> None:
        """Write a state: displacements; damage, separation, traction, energies and water of the joints.

        time: of ParaView, default the parameter of the state.  ledger: energies, a row of FILE.csv; balance
        is what all others have more than the work.  Tractions are total,
        p is the pressure of the water, `pressure` that of the sides on each other, and apertures are those of
        the flows or openings.  Raises ValueError on all ranks for wrong input, by its name.
        """
        expect(State, state=state)
        state.check(self.model)
        agree("" if time is None or real(time) else f"time = {time}: expected a finite number")
        expect(Sequence, flows=flows)
        expect(Flow, **{f"flows[{k}]": flow for k, flow in enumerate(flows)})
        if ledger is not None:
            expect(Ledger, ledger=ledger)
        m, time = self.model, state.at if time is None else time
        nodes, u = m.V.tabulate_dof_coordinates()[:, : m.d], m.spread(state.u).reshape(-1, m.d)
        room = contract.N_POINT_STATEV  # laws may have another number of planes
        at = m.face_points[self.near]
        states = np.concatenate([joint[:, :room] for joint in state.joints])
        aperture = Water(m, {}, flows).aperture(state.s)
        step = paraview.Step(
            time,
            nodes,
            u,
            self.kind,
            self.solids,
            self.joints,
            state.s[at],
            state.t[at],
            states[at],
            m.cell_block[: len(self.solids)],
            m.face_joint[self.near],
            m.names,
            m.joints,
            {
                "p": state.p[at],
                "aperture": aperture[self.near],
                "opening": np.maximum(state.s[at, 0], 0.0),
                "slip": np.linalg.norm(state.s[at, 1:], axis=-1),
                "pressure": -state.t[at, 0] - state.p[at],
                "shear": np.linalg.norm(state.t[at, 1:], axis=-1),
            },
        )
        files = step.write(self.folder, f"{len(self.names):04}_{COMM.rank}")
        self.names.append((time, [*itertools.chain(*COMM.allgather(files))]))
        if ledger:
            self.rows.append([time, *astuple(ledger), ledger.balance])
        if COMM.rank == 0:
            paraview.write_collection(self.pvd, self.names)
            if ledger:
                head = ",".join(["at", *(part.name for part in fields(Ledger)), "balance"])
                lines = [",".join(f"{number:.12g}" for number in row) for row in self.rows]
                self.pvd.with_suffix(".csv").write_text("\n".join([head, *lines, ""]), encoding="utf-8")
