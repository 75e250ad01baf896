"""Benchmarks with closed forms on FEniCSx, a line each: found and expected; mm, N, MPa.

- peel: two arms of a beam that moments at their ends peel apart. By the J integral the energy to separate is
  12 M^2/(E h^3) at every length of the crack, whatever the law of the joint.
- period: a block that is pressed between its own next periods, plane stress.
- slope: 1 where a block rests 0.2 degrees below the angle of friction and slides 0.2 degrees above it.
- block: largest horizontal force over the weight that a block carries, mu.
- dam, uplift: largest horizontal force over the weight W of a dam on its foundation, without and with a
  pressure of water in the joint, U in sum: (W - U) mu/W.
"""

from __future__ import annotations

import math
import warnings

import meshio
import numpy as np
from asperity import Interface, Material, Pattern
from asperity.fenicsx import COMM, Conditions, Follow, Model, State, Terms, solve, total
from asperity.fenicsx.conditions import Pressure
from asperity.mesh import split

from harness.hosts.fenicsx.arch import settled
from harness.hosts.structured import grid

ARM, E_ARM = 2.0, 30000.0
BASE = 60.0
"""Width of the dam, m."""
BOND = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(0, 0.0))


def peel(length: float = 50.0, parts: int = 8, angle: float = 0.08) -> tuple[float, float]:
    """Energy to separate, by the moment at arms whose ends turn by an angle."""
    x, y = np.linspace(0.0, length, round(length / ARM * parts) + 1), np.linspace(-ARM, ARM, 2 * parts + 1)
    model = Model(split(grid(x, y, block=y[:-1] >= 0.0)), {"joint": BOND}, E_ARM, 0.2)
    nodes, _ = model.group("left")
    side = np.where(model.solid("block_1").reshape(-1, 2)[nodes, 0], 1.0, -1.0)
    turned = np.zeros((model.n, 2))
    turned[nodes, 0] = side * (model.x[nodes, 1] - 0.5 * side * ARM)
    fixed = np.r_[model.dofs(nodes, 0), model.dofs(model.group("right")[0], 0, 1)]
    start = State.virgin(model)
    follow = Follow(model, start, lambda t: Conditions(fixed, t * turned.ravel()[fixed]), 0.002, 0.004)
    *_, last = follow.to(angle)
    moment = 0.5 * total(last.reaction @ turned.ravel())
    return 12.0 * moment**2 / (E_ARM * ARM**3), BOND.material.Gc


def period(width: float = 3.0, nu: float = 0.2, strain: float = -0.01) -> tuple[float, float]:
    """Stress across a block whose right side presses on its left side, a period away."""
    mesh = split(grid(np.linspace(0.0, width, 4), range(3)), {"joint": {"right": "left"}})
    model = Model(mesh, {"joint": BOND}, E_ARM, nu)
    (bottom, _), (top, _) = model.group("bottom"), model.group("top")
    middle = np.abs(model.x - [1.0, 1.0]).max(axis=1) < 1e-9
    fixed = np.r_[model.dofs(np.r_[bottom, top], 1), model.dofs(middle, 0)]
    pressed = Conditions(fixed, 2.0 * strain * np.isin(fixed, model.dofs(top, 1)))
    state = solve(model, State.virgin(model), pressed, Terms(tolerance=1e-9)).taken()
    stress = total(state.t[:, 0] @ model.area) / total(model.area.sum())
    closing = float(BOND.update([[-1e-9, 0.0, 0.0]]).traction[0, 0]) / -1e-9
    # strain x = (stress x - nu stress y)/E closes the joint by width times it, strain y is given
    return stress, nu * E_ARM * strain / (1.0 + E_ARM / (width * closing) - nu**2)


def slope(mu: float = 0.7) -> tuple[float, float]:
    """Whether a block of 300 x 100 mm rests below the angle of friction and not above it."""
    mesh = split(grid(np.arange(4) * 100.0, np.arange(3) * 100.0, block=[0, 1]))
    law, rests = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=mu), Pattern.regular(0, 0.0)), []
    for angle in math.atan(mu) + np.radians([-0.2, 0.2]):
        model = Model(mesh, {"joint": law}, 2e4, 0.2)
        down = model.body([2.4e-5 * math.sin(angle), -2.4e-5 * math.cos(angle)])
        fixed = model.dofs(model.x[:, 1] < 1e-6, 0, 1)
        _, still = settled(model, State.virgin(model), Conditions(fixed, load=down), np.abs(down))
        rests.append(still)
    return float(rests == [True, False]), 1.0


def carried(
    model: Model, fixed: np.ndarray, down: np.ndarray, push: np.ndarray, **pressures: Pressure
) -> float:
    """Largest share of a force, which grows until there is no equilibrium with the weight."""

    def pushed(share: float) -> Conditions:
        return Conditions(fixed, load=down + share * push, pressures=pressures)

    start = solve(model, State.virgin(model), pushed(0.0)).taken()
    return Follow(model, start, pushed, 0.05, 0.2).run_to_limit(2.0).at


def block(mu: float = 0.5) -> tuple[float, float]:
    """Horizontal force over the weight of a block of 300 x 100 mm that rests by friction."""
    mesh = split(grid(np.arange(7) * 50.0, np.arange(5) * 50.0, block=[0, 0, 1, 1]))
    law = Interface(Material.from_joint(kn=200.0, ks=80.0, mu=mu), Pattern.regular(0, 0.0))
    model = Model(mesh, {"joint": law}, 2e4, 0.2)
    down, push = (model.body(force, "block_1") for force in ([0.0, -2.4e-5], [2.4e-5, 0.0]))
    return carried(model, model.dofs(model.x[:, 1] < 1e-6, 0, 1), down, push), mu


def dam(pressure: float, mu: float = 0.75) -> tuple[float, float]:
    """Horizontal force over the weight of a dam, 60 m wide and 80 m high, on rock; m, MN.

    pressure: of water in the joint at the heel, falling to 0 at the toe; it acts on both sides.
    """
    x, y = np.linspace(-BASE, 2.0 * BASE, 31), np.linspace(-40.0, 80.0, 13)
    unsplit = grid(x, y, block=np.where(y[:-1] < 0.0, 1, 2), names={"rock": 1, "dam": 2}, sides=())
    cells, tags = unsplit.cells[0].data, unsplit.cell_data["gmsh:physical"][0]
    middle = unsplit.points[cells].mean(axis=1)[:, 0]
    kept = (tags == 1) | ((middle > 0.0) & (middle < BASE))
    slender = unsplit.points.copy()
    slender[:, 0] *= 1.0 - 0.7 * np.maximum(slender[:, 1], 0.0) / 80.0
    mesh = meshio.Mesh(slender, [("quad", cells[kept])], field_data=unsplit.field_data,
                       cell_data={"gmsh:physical": [tags[kept]]})  # fmt: skip
    law = Interface(Material.from_joint(kn=1e5, ks=5e4, mu=mu), Pattern.regular(0, 0.0))
    model = Model(split(mesh), {"joint": law}, 3e4, 0.2, plane="strain")
    down, push = (model.body(force, "dam") for force in ([0.0, -0.024], [0.024, 0.0]))
    at = model.x[:, 0]
    fixed = model.dofs((model.x[:, 1] < -40.0 + 1e-6) | (np.abs(at - 0.5 * BASE) > 1.5 * BASE - 1e-6), 0, 1)
    weight = -total(down.sum())
    uplift = 0.5 * pressure * BASE

    def water(x: np.ndarray) -> np.ndarray:
        return pressure * (1.0 - x[:, 0] / BASE)

    return carried(model, fixed, down, push, joint=water), mu * (weight - uplift) / weight


def main() -> None:
    """Run all."""
    warnings.simplefilter("ignore")
    results = {
        "peel": peel(), "period": period(), "slope": slope(), "block": block(), "dam": dam(0.0),
        "uplift": dam(0.8),
    }  # fmt: skip
    for name, (computed, expected) in results.items() if COMM.rank == 0 else ():
        print(f"{name} {computed:.6g} {expected:.6g}")


if __name__ == "__main__":
    main()
