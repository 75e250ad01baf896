"""Gravity dam on rock with a fault: weight, in-situ stress, water, uplift, overload; m, MN, per metre."""

import warnings

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.fenicsx import COMM, Conditions, Follow, Model, Output, State, largest, solve
from asperity.mesh import split
from gravity_dam_mesh import BASE, CREST, HEIGHT, mesh

CONCRETE, ROCK, WATER = 0.024, 0.026, 0.00981  # weights
K0, FRICTION = 0.7, 1.0  # horizontal over vertical stress of the rock, friction of the base
JOINTS, FLAT = {"fault": None, "base": ("rock", "dam")}, Pattern.regular(0, 0.0)
LAWS = {
    "fault": Interface(Material.from_joint(kn=1e4, ks=5e3, mu=0.6), FLAT),
    "base": Interface(Material.from_joint(kn=2e4, ks=1e4, mu=FRICTION), FLAT),
}


def in_situ(x: np.ndarray) -> np.ndarray:
    """Return the total stress of the rock (n, 2, 2) at places (n, 2)."""
    return ROCK * x[:, 1, None, None] * np.diag([K0, 1.0])


def run(path: str, uplift: bool) -> tuple[float, float, float]:
    """Return the largest thrust, MN, largest slip and opening of the base under full water, m."""
    jointed = split(path, JOINTS) if COMM.rank == 0 else None
    model = Model(jointed, LAWS, {"dam": 24e3, "rock": 20e3}, 0.2, plane="strain")
    bottom, ends = model.group("bottom")[0], model.group("ends")[0]
    fixed = np.r_[model.dofs(bottom, 1), model.dofs(ends, 0)]
    groundwater = {"fault": lambda x: -WATER * x[:, 1]}  # before the dam
    weight = model.body([0.0, -ROCK], "rock")
    state = State.initial(model, in_situ, "rock", pressures=groundwater)
    state = solve(model, state, Conditions(fixed, load=weight, pressures=groundwater)).taken()
    if largest(state.u) > 1e-9:
        raise SystemExit("the in-situ stress does not carry the weight of the rock")
    weight += model.body([0.0, -CONCRETE], "dam")

    def filled(level: float, factor: float = 1.0) -> Conditions:
        water = {
            "upstream": lambda x: factor * WATER * np.maximum(level - x[:, 1], 0.0),
            "reservoir": lambda x: WATER * np.maximum(level - x[:, 1], 0.0),
            "base": lambda x: uplift * WATER * level * (1.0 - x[:, 0] / BASE),
        }
        return Conditions(fixed, load=weight, pressures=groundwater | water)

    for level in np.linspace(0.0, HEIGHT, 5):
        state = solve(model, state, filled(level)).taken()
    base = state.s[model.parts[model.joints.index("base")]]
    opening, slip = largest(np.maximum(base[:, 0], 0.0)), largest(base[:, 1])
    Output(model, f"uplift_{uplift}.pvd").write(state)
    follow = Follow(model, state, lambda t: filled(HEIGHT, 1.0 + t), 0.05, 0.1, 1e-4)
    thrust = WATER * HEIGHT**2 / 2.0
    return thrust * (1.0 + follow.run_to_limit(10.0).at), slip, opening


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    if COMM.rank == 0:
        mesh("dam.msh")
    COMM.barrier()
    heavy = CONCRETE * HEIGHT * (BASE + CREST) / 2.0
    for uplift in (False, True):
        sliding, slip, opening = run("dam.msh", uplift)
        hand = FRICTION * (heavy - uplift * WATER * HEIGHT * BASE / 2.0)
        if COMM.rank == 0:
            words = f"slip {1e3 * slip:.3f} mm, opening {1e3 * opening:.3f} mm under full water"
            print(f"uplift {uplift}: slides at {sliding:.3f} MN, by hand {hand:.3f}; {words}", flush=True)
