"""Gravity dam on rock with a fault: weight, in-situ stress, water, uplift, overload; m, MN, per metre."""

import warnings

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.mesh import split
from gravity_dam_mesh import BASE, CREST, HEIGHT, mesh
from jointed import COMM, Follow, Model, Output, Steps

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
    model.pressure("fault", lambda x: -WATER * x[:, 1])  # of the groundwater, before the dam
    model.initial(in_situ, "rock")
    weight = model.body([0.0, -ROCK], "rock")
    bottom, ends = model.group("bottom")[0], model.group("ends")[0]
    steps = Steps(model, np.r_[model.dofs(bottom, 1), model.dofs(ends, 0)])
    none = np.zeros(len(steps.fixed))
    carries = steps.solve(none, weight)
    if not carries or COMM.allreduce(np.abs(model.u).max(initial=0.0), max) > 1e-9:
        raise SystemExit(f"the in-situ stress does not carry the weight of the rock: {steps.message}")
    weight += model.body([0.0, -CONCRETE], "dam")

    def filled(level: float, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        for name, more in (("upstream", factor), ("reservoir", 1.0)):
            model.pressure(name, lambda x, more=more: more * WATER * np.maximum(level - x[:, 1], 0.0))
        model.pressure("base", lambda x: uplift * WATER * level * (1.0 - x[:, 0] / BASE))
        return none, weight

    for level in np.linspace(0.0, HEIGHT, 5):
        if not steps.solve(*filled(level)):
            raise SystemExit(f"water at {level:g} m: {steps.message}")
    opening, slip = (COMM.allreduce(model.s[1][:, k].max(initial=0.0), max) for k in (0, 1))
    Output(model, f"uplift_{uplift}.pvd").write(0.0)
    thrust = WATER * HEIGHT**2 / 2.0
    follow = Follow(steps, lambda t: filled(HEIGHT, 1.0 + t), 0.05, 0.1, 1e-4)
    while not follow.reason and follow.at < 10.0:
        follow.advance(10.0)
    return thrust * (1.0 + follow.at), slip, opening


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
