"""One joint in FEniCSx: pressed, then slid along Tx; its rows beside those of the material point."""

from pathlib import Path

import meshio
import numpy as np
from asperity.export.element import Element
from asperity.fenicsx import Conditions, Model, State, Terms, solve
from asperity.mesh import split

element = Element.of_kit(Path(__file__).parent)
sigma0 = element.interface.material.sigma0

square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
points = [[*corner, float(z)] for z in range(3) for corner in square]
cubes = [[*range(8)], [*range(4, 12)]]
mesh = meshio.Mesh(points, [("hexahedron", cubes)], cell_data={"block": [[1, 2]]})
model = Model(split(mesh), {"joint": element.interface}, 1e3 * sigma0, 0.0)
lower, upper = (model.solid(f"block_{k}").reshape(-1, 3)[:, 0] > 0.0 for k in (1, 2))
fixed = np.r_[model.dofs(lower, 0, 1, 2), model.dofs(upper, 0, 1)]
along = np.isin(fixed, model.dofs(upper, 0))
top = np.zeros((model.n, 3))
top[model.x[:, 2] > 1.5, 2] = 0.25
state = State.virgin(model)


def step(slip: float, sigma_N: float) -> tuple[float, float, float]:
    """Find the equilibrium at a slip under a normal traction; returns slip, opening and force."""
    global state
    conditions = Conditions(fixed, slip * along, sigma_N * top.ravel())
    report = solve(model, state, conditions, Terms(tolerance=1e-10))
    if report.state is None:
        raise SystemExit(f"slip {slip:g}: {report.reason}")
    state = report.state
    opening, slip, _ = state.s.mean(axis=0)
    return slip, opening, report.reaction.reshape(-1, 3)[upper, 0].sum()


element.follow(step)
