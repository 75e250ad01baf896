"""Structures with joints on FEniCSx: elastic solids by UFL, joints by the law at pairs of nodes, PETSc.

A `Model` has solids and joints and never changes; a frozen `State` is what an equilibrium leaves;
`Conditions` are what holds and loads the model.  `solve(model, state, conditions, terms)` finds an
equilibrium and returns a `Report`.  `Follow` goes along a path, `Branch` beyond its limit load, `Shake`
through time: each holds a `State`, which it replaces by the next one or keeps.  `Output` writes for ParaView.
The ranks of MPI share the mesh.
"""

from __future__ import annotations

from mpi4py import MPI  # first: loads the library of MPI that dolfinx needs

from .branch import Branch
from .conditions import Conditions, Flow
from .equilibrium import Report, Terms, solve
from .ledger import Ledger
from .measures import Measures, measure
from .model import Model
from .output import Output
from .path import Follow
from .ranks import COMM, largest, total
from .state import State
from .stopped import Stopped
from .time import Shake

assert MPI.Is_initialized()

__all__ = [
    "COMM",
    "Branch",
    "Conditions",
    "Flow",
    "Follow",
    "Ledger",
    "Measures",
    "Model",
    "Output",
    "Report",
    "Shake",
    "State",
    "Stopped",
    "Terms",
    "largest",
    "measure",
    "solve",
    "total",
]
