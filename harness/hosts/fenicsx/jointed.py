"""Meshes with joints on FEniCSx: elastic solids by UFL, joints by the law at pairs of nodes, steps by PETSc.

`Model` has solids and joints, `Steps` solves a step, `Follow` takes many, `Shake` takes steps in time,
`Output` writes them for ParaView.  The ranks of MPI share the mesh.
"""

from __future__ import annotations

from jointed_follow import Follow
from jointed_mesh import COMM, total
from jointed_model import LawError, Model
from jointed_output import Output
from jointed_shake import Shake
from jointed_steps import Steps

__all__ = ["COMM", "Follow", "LawError", "Model", "Output", "Shake", "Steps", "total"]
