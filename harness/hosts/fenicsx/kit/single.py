"""One joint in FEniCSx: pressed, then slid along Tx; its rows beside those of the material point."""

import json
from pathlib import Path

import meshio
import numpy as np
from asperity.export.element import Element
from asperity.mesh import split
from jointed import Model, Steps

HERE = Path(__file__).parent
value = json.loads((HERE / "model.json").read_text(encoding="utf-8"))["value"]
element = Element.of_case(HERE / "joint.nml", value)
sigma0 = element.interface.material.sigma0

square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
points = [[*corner, float(z)] for z in range(3) for corner in square]
cubes = [[*range(8)], [*range(4, 12)]]
mesh = meshio.Mesh(points, [("hexahedron", cubes)], cell_data={"block": [[1, 2]]})
model = Model(split(mesh), {"joint": element.interface}, 1e3 * sigma0, 0.0)
lower, upper = (model.solid(f"block_{k}").reshape(-1, 3)[:, 0] > 0.0 for k in (1, 2))
steps = Steps(model, np.r_[model.dofs(lower, 0, 1, 2), model.dofs(upper, 0, 1)], 1e-10)
along = np.isin(steps.fixed, model.dofs(upper, 0))
load = np.zeros((model.n, 3))
load[model.x[:, 2] > 1.5, 2] = 0.25 * element.sigma_N


def step(slip: float, part: float) -> None:
    """Find the equilibrium at a slip under a part of the normal traction."""
    if not steps.solve(slip * along, part * load.ravel()):
        raise SystemExit(f"slip {slip:g}: {steps.message}")


for k in range(1, element.press + 1):
    step(0.0, k / element.press)
found = []
for k in range(1, element.slide + 1):
    step(element.slip * k / element.slide, 1.0)
    if k % element.every == 0:
        opening, slip, _ = model.s[0].mean(axis=0)
        found.append((slip, opening, steps.reaction.reshape(-1, 3)[upper, 0].sum()))
element.compare(found)
