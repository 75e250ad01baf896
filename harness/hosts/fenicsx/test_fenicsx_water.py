"""Water and initial stress on FEniCSx beside closed forms, on one and on two ranks."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from on_ranks import RANKS, WITH_FENICSX, assert_refused, of_all_ranks

pytestmark = WITH_FENICSX

HELPERS = """
import json, sys, warnings
import meshio
from harness.hosts.structured import simplices

warnings.simplefilter("ignore")
E, PRESS, MU = 2e4, 1.0, 0.5
flat = Pattern.regular(0, 0.0)
smooth = Interface(Material.from_joint(kn=200.0, ks=200.0, mu=MU), flat)

def meshed(axes, joints=None, simplex=False, **settings):
    # a grid, in simplices on request, whose sides are cut by the diagonals of the cells
    mesh = grid(*axes, **settings)
    if simplex:
        d, cells, tags = len(axes), [], []
        for block, tag in zip(mesh.cells, mesh.cell_data["gmsh:physical"]):
            data = block.data
            if block.type in ("quad", "hexahedron") and len(data[0]) == 2**d:
                data = simplices(mesh.points, data)
            elif block.type == "quad":
                start = (mesh.points[data].sum(2).argmin(1)[:, None] + np.arange(4)) % 4
                data = np.take_along_axis(data, start, 1)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
            cells.append(({2: "line", 3: "triangle", 4: "tetra"}[data.shape[1]], data))
            tags.append(np.repeat(tag, len(data) // len(tag)))
        mesh = meshio.Mesh(mesh.points, cells, cell_data={"gmsh:physical": tags}, field_data=mesh.field_data)
    return split(mesh, joints)

def sums(m, values):
    return [total(component) for component in values.reshape(-1, m.d).sum(0)]

def largest(values):
    return COMM.allreduce(float(np.abs(values).max(initial=0.0)), max)

def two_blocks(d, simplex=False, law=smooth, nu=0.0, **settings):
    # 3 mm wide, with a joint at half of 2 mm height; in space 2 mm deep
    axes = [np.linspace(0, 3, 7), *[np.linspace(0, 2, 5)] * (d - 1)]
    block = np.zeros([len(a) - 1 for a in axes], int)
    block[..., 2:] = 1
    return Model(meshed(axes, simplex=simplex, block=block), {"joint": law}, E, nu, **settings)

def held(m, *components):
    return np.r_[m.dofs(m.group("bottom")[0], *range(m.d)), m.dofs(m.group("top")[0], *components)]

def under(m, pressures, flows=(), state=None):
    # the state with these pressures, which hold the model at its top and bottom
    conditions = Conditions(held(m, *range(m.d)), pressures=pressures, flows=flows)
    return solve(m, state or State.virgin(m), conditions).taken()

def outer(m, **pressures):
    return found(m=m, fixed=np.arange(m.n * m.d), pressures=pressures).load
"""
"""What the scenes share."""


def run(code: str, ranks: int) -> dict:
    """Results of the scenes, which all ranks have."""
    return of_all_ranks(HELPERS + code, ranks)


@pytest.mark.parametrize("ranks", RANKS)
def test_pressures_on_faces(ranks: int) -> None:
    """Water on a side has the thrust and the moment of the closed form, in all kinds of cells.

    The level is inside of an element, whose nodal forces are those of a quadrature: 0.1 % of them.
    """
    results = run(
        """
for d, simplex in ((2, False), (2, True), (3, False), (3, True)):
    m = two_blocks(d, simplex, thickness=2.0 if d == 2 else 1.0)
    level = lambda x: np.maximum(1.7 - x[:, -1], 0.0)
    force = outer(m, left=level).reshape(-1, d)
    results[f"{d} {simplex}"] = [*sums(m, force), total(force[:, 0] @ m.x[:, -1])]
    sides = dict.fromkeys(("left", "right", "bottom", "top", "front", "back")[: 2 * d], level)
    results[f"{d} {simplex} all"] = sums(m, outer(m, **sides))
    results[f"{d} {simplex} without"] = sums(m, outer(m, **sides | {"left": 0.0}))
""",
        ranks,
    )
    thrust, moment, uplift = 2.0 * 1.7**2 / 2, 2.0 * 1.7**3 / 6, 2.0 * 3.0 * 1.7
    for name, values in results.items():
        d = int(name[0])
        if "all" in name:
            expected = [*[0.0] * (d - 1), uplift]
        elif "without" in name:
            expected = [-thrust, *[0.0] * (d - 2), uplift]
        else:
            expected = [thrust, *[0.0] * (d - 1), moment]
        assert values == pytest.approx(expected, abs=1e-3 * uplift), name


@pytest.mark.parametrize("ranks", RANKS)
def test_pressures_in_joints(ranks: int) -> None:
    """Pressed by 1 with p = 0.4 a joint slides at mu (1 - p); p beyond what presses opens it, t_N = -p.

    An opening h lowers p = 1/(1 + s_N/h) in a joint between two layers of the height 1: p = s_N E/2.
    The error of passes, which take the effective pressure of the joint, vanishes with water, too.
    """
    results = run(
        """
for d in (2, 3):
    m = two_blocks(d)
    fixed = m.dofs(m.group("bottom")[0], *range(d))
    top, area = m.group("top")
    down, push = np.zeros((2, m.n, d))
    down[top, -1], push[top, 0] = -PRESS * area, PRESS * area
    pushed = lambda t: Conditions(fixed, load=(down + t * push).ravel(), pressures={"joint": 0.4})
    start = solve(m, State.virgin(m), pushed(0.0)).taken()
    results[f"{d} slides"] = Follow(m, start, pushed, 0.02, 0.05).run_to_limit(1.0).at
    report = solve(m, start, pushed(0.2), Terms(passes=8, finish=False))
    results[f"{d} passes"] = [report.good, *report.errors]
    for name, p in {"opens": 1.0, "of opening": lambda x, s: 1.0 / (1.0 + s / 1e-4)}.items():
        state = under(m, {"joint": p})
        low = COMM.allreduce(float(state.s[:, 0].min(initial=1e9)), min)
        apart = largest(state.t[:, 0] + state.p)
        results[f"{d} {name}"] = [low, largest(state.s[:, 0]), apart, largest(state.p)]
    # a number for all places; `factor` is no opening
    results[f"{d} factor"] = largest(under(m, {"joint": lambda x, factor=0.5: factor}).p)
""",
        ranks,
    )
    E, h = 2e4, 1e-4
    opening = (-h + (h**2 + 8.0 * h / E) ** 0.5) / 2.0
    for d in "23":
        assert results[f"{d} slides"] == pytest.approx(0.5 * 0.6, rel=1e-3)
        assert results[f"{d} factor"] == 0.5
        assert results[f"{d} passes"] == [True, 0.0, pytest.approx(0.0, abs=1e-4)]  # SAME_FORCE
        for name, s, p in (("opens", 2.0 / E, 1.0), ("of opening", opening, opening * E / 2.0)):
            low, high, misfit, most = results[f"{d} {name}"]
            assert [low, high] == pytest.approx([s, s], rel=1e-5) and most == pytest.approx(p, rel=1e-5)
            assert misfit < 1e-9  # an open joint without bond has t_N = -p


FLOW = """
for d, simplex in ((2, False), (2, True), (3, False), (3, True)):
    m = two_blocks(d, simplex, thickness=2.0 if d == 2 else 1.0)
    flow, fixed = Flow("joint", {"left": 6.0, "right": 2.0}, 1e-9, a_0=0.02, a_min=0.01), held(m, *range(d))
    up = np.isin(fixed, m.dofs(m.group("top")[0], d - 1))
    # wide open: p does not change the aperture by much
    report = solve(m, State.virgin(m), Conditions(fixed, 1.0 * up, flows=[flow]))
    state = report.taken()
    results[f"{d} {simplex}"] = {
        "rates": report.rates[0], "p": largest(state.p - 6.0 + 4.0 * m.places[:, 0] / 3.0),
        "aperture": largest(state.s[:, 0] + 0.02 - 1.02),
    }
    Output(m, f"{FOLDER}/{d}_{simplex}.pvd").write(state, flows=[flow])
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_flow(ranks: int, tmp_path: Path) -> None:
    """Along a joint of one aperture q = a^3 dp/(12 viscosity L), and p is linear.

    The pressure opens the joint by 2 p/E more: 6e-4 of 1.02, hence 2e-3 of the flow.
    """
    results = run(f"FOLDER = {str(tmp_path)!r}\n{FLOW}", ranks)
    rate = 2.0 * 1.02**3 / (12.0 * 1e-9) * 4.0 / 3.0
    for name, result in results.items():
        assert result["rates"]["left"] == pytest.approx(rate, rel=3e-3), name
        assert sum(result["rates"].values()) == pytest.approx(0.0, abs=1e-9 * rate), name
        assert result["p"] < 6.0 * 2e-3 and result["aperture"] < 1e-3, name
        files = list((tmp_path / name.replace(" ", "_")).glob("joints_*.vtu"))
        fields = [meshio.read(file).cell_data for file in files]
        assert len(files) == ranks
        p, aperture = (np.concatenate([arrays[field][0] for arrays in fields]) for field in ("p", "aperture"))
        # faces of 0.5 mm: the first has its middle at 0.25
        ends = [
            6.0 - 4.0 * at / 3.0
            for at in ((0.25, 2.75) if "False" in name or name[0] == "2" else (0.5 / 3.0, 3.0 - 0.5 / 3.0))
        ]
        assert [p.max(), p.min()] == pytest.approx(ends, rel=5e-3), name
        assert aperture == pytest.approx(1.02, abs=1e-3), name


@pytest.mark.parametrize("ranks", RANKS)
def test_flow_through_wide_and_narrow_faces(ranks: int) -> None:
    """An open pocket of a closed joint has the mean pressure of both ends, however wide it is.

    A crack has the pressure of its mouth, and the inflow of what is closed ahead of it.  What a groove lets
    through is that of its a^3: the mean over its width, 1/4 where it closes.
    """
    results = run(
        """
from asperity.fenicsx.water import Water
viscosity, a_min = 1e-9, 1e-8
for d, simplex in ((2, False), (3, False), (3, True)):
    m = two_blocks(d, simplex)
    water = Water(m, {}, [Flow("joint", {"left": 6.0, "right": 2.0}, viscosity, a_min, a_min)])
    x, s = m.places, np.zeros((len(m.places), 3))
    inside = abs(x[:, 0] - 1.5) < 0.6
    for wide in (1e-5, 1e-3, 1.0, 1e3):  # 1e9 to 1e33 times as much as the closed joint
        s[:, 0] = wide * inside
        p, [rates] = water.at(s)
        change, turn = water.following(s), np.zeros_like(s)
        turn[inside, 0] = wide * (x[inside, 0] - 1.5)
        results[f"{d} {simplex} {wide}"] = [
            largest(p[inside] - 4.0), abs(rates["left"] + rates["right"]) / rates["left"],
            largest(change(turn)[inside]),
        ]
        s[:, 0] = wide * (x[:, 0] < 2.1)
        p, [rates] = water.at(s)
        results[f"{d} {simplex} {wide} crack"] = [
            largest(p[x[:, 0] < 2.1] - 6.0), abs(rates["left"] + rates["right"]) / rates["left"]
        ]
    if d == 3:
        s[:, 0] = x[:, 1] < 1.1
        p, [rates] = water.at(s)
        part = 1.125 if not simplex else rates["left"] * 12.0 * viscosity * 3.0 / 4.0
        results[f"groove {simplex}"] = [
            largest(p - 6.0 + 4.0 * x[:, 0] / 3.0), rates["left"] / (part / (12.0 * viscosity) * 4.0 / 3.0)
        ]
""",
        ranks,
    )
    for name, values in results.items():
        if "groove" in name:
            assert values == [pytest.approx(0.0, abs=1e-6), pytest.approx(1.0, rel=1e-6)], name
        else:
            assert max(values) < 6e-6, name  # 1e-6 of the pressure, as the equilibrium has it


def test_steps_that_are_not_finite() -> None:
    """GMRES hands out what is not finite, which ends an equilibrium with a reason, and raises nothing."""
    results = run(
        """
from asperity.fenicsx.coupling import solved
b = np.array([1.0, 2.0])
for name, matrix, side in (
    ("matrix", lambda v: np.nan * v, b), ("side", lambda v: v, np.inf * b), ("nothing", lambda v: v, 0.0 * b)
):
    results[name] = np.isfinite(solved(matrix, side)).tolist()
""",
        1,
    )
    assert results == {"matrix": [False] * 2, "side": [False] * 2, "nothing": [True] * 2}


@pytest.mark.parametrize("ranks", RANKS)
def test_flow_through_a_junction_and_a_standing_column(ranks: int) -> None:
    """Three equal branches share what comes in; under its weight water stands, p = weight times depth."""
    results = run(
        """
rigid = Interface(Material(sigma0=1e3, Gc=1e3, eta=0.9, mu=MU, kc=10.0), flat)
block = np.array([[0, 2], [1, 2]]).repeat(2, 0).repeat(2, 1)
mesh = meshed([np.linspace(0, 2, 5), np.linspace(0, 2, 5)], {"stem": ("0", "1"), "bar": ("*", "*")},
              block=block, names={"0": 0, "1": 1, "2": 2})
m = Model(mesh, {"stem": rigid, "bar": rigid}, E, 0.2)
fixed = held(m, 0, 1)
flow = Flow(["stem", "bar"], {"bottom": 3.0, "left": 0.0, "right": 0.0}, 1.0, a_0=0.5, a_min=1e-3)
report = solve(m, State.virgin(m), Conditions(fixed, flows=[flow]))
results["rates"] = report.rates[0]
results["junction"] = largest(report.taken().p[(abs(m.places - 1.0) < 1e-6).all(1)])
flow = Flow(["bar", "stem"], {"left": 0.0}, 1.0, {"stem": 0.5, "bar": 0.2}, 1e-3, weight=[0.0, -0.7])
report = solve(m, report.taken(), Conditions(fixed, flows=[flow]))
results["rest"] = [*map(abs, report.rates[0].values())]
results["column"] = largest(report.taken().p - 0.7 * (1.0 - m.places[:, 1]))
""",
        ranks,
    )
    # the aperture changes by 1e-3, as the stiffness of the bond is 500
    rate = 0.5**3 / 12.0
    assert results["junction"] == pytest.approx(1.0, rel=0.02)
    expected = {"bottom": 2.0 * rate, "left": -rate, "right": -rate}
    assert results["rates"] == pytest.approx(expected, rel=0.05)
    assert max(results["rest"]) < 1e-9 and results["column"] < 1e-9


@pytest.mark.parametrize("ranks", RANKS)
def test_initial_stress(ranks: int) -> None:
    """Stress that balances the weight moves nothing; joints carry it, together with their water.

    Less water then closes the joint by what the solids and the contact give way.
    """
    results = run(
        """
def rock(x):
    d = x.shape[1]
    stress = np.zeros((len(x), d, d))
    for k in range(d):
        stress[:, k, k] = 0.3 * (x[:, -1] - 2.0) * (1.0 if k == d - 1 else 0.6)
    return stress

for d, simplex in ((2, True), (3, False), (3, True)):
    m = two_blocks(d, simplex, nu=0.2, plane="strain")
    start = State.initial(m, rock, pressures={"joint": 0.1})
    weight = m.body([0.0] * (d - 1) + [-0.3])
    sides = [m.dofs(m.group(name)[0], k) for name, k in
             (("left", 0), ("right", 0), ("front", 1), ("back", 1))[: 2 * d - 2]]
    fixed = np.concatenate([m.dofs(m.group("bottom")[0], d - 1), *sides])
    # the water lifts the upper block: its pressure on the joint's sides is a part of the equilibrium
    state = solve(m, start, Conditions(fixed, load=weight, pressures={"joint": 0.1})).taken()
    results[f"{d} {simplex}"] = [largest(state.u), largest(state.t[:, 0] + 0.3), largest(state.s)]
    state = solve(m, state, Conditions(fixed, load=weight)).taken()
    results[f"{d} {simplex} dry"] = [-largest(state.s[:, 0]), largest(state.s[:, 0] + 0.1 / 200.0)]
""",
        ranks,
    )
    for name, values in results.items():
        if "dry" in name:
            # t' = -0.2 becomes -0.3 over the stiffness 200 in closing
            assert values[1] < 1e-6, name
        else:
            assert max(values) < 1e-9, name


WRONG = {
    'pressed("bed", 1.0)': "bed: no such joint or group: expected one of joint, ",
    'pressed("joint", -1.0)': "joint: p = -1 at (",
    'pressed("left", float("nan"))': "left: p = nan at (",
    'pressed("joint", lambda x: x)': "joint: p of the shape",
    'pressed("left", lambda x, s: s)': "left: p is a function of the opening: expected one of",
    'pressed("left", lambda x: 1j * x[:, 0])': "left: p[0] = ",
    'pressed("left", lambda x: "high")': "left: p[] = 'high': expected a finite number",
    'pressed("joint", np.ones(4))': "joint: p of the shape (4,): expected a number or a function",
    'pressed("heel", 1.0)': "heel: expected a group of faces",
    'pressed("cut", 1.0)': "cut: 2 of its 2 faces are inside the solids",
    'flowing("bed", {"left": 1.0}, 1.0, 0.0, 1e-3)': "bed: no such joint: expected one of joint",
    'flowing("joint", {}, 1.0, 0.0, 1e-3)': "expected the pressure at one group at least",
    'flowing("joint", "left", 1.0, 0.0, 1e-3)': "given 'left': expected pressures by group",
    'flowing("joint", {"left": 1.0}, "thin", 0.0, 1e-3)': "viscosity = 'thin': expected a finite",
    'flowing("joint", {"left": 1.0}, 1.0, 1j, 1e-3)': "a_0 of joint = 1j: expected a finite number",
    'flowing("joint", {"roof": 1.0}, 1.0, 0.0, 1e-3)': "roof: no such group: expected one of",
    'flowing("joint", {"top": 1.0}, 1.0, 0.0, 1e-3)': "top: no node of joint is in it",
    'flowing("joint", {"left": -1.0}, 1.0, 0.0, 1e-3)': "left: p = -1 at (",
    'flowing("joint", {"left": 1.0, "heel": 2.0}, 1.0, 0.0, 1e-3)': "heel: p = 2 at (0, 1), but 1 by",
    'flowing("joint", {"left": 1.0}, 0.0, 0.0, 1e-3)': "viscosity = 0.0: expected above 0",
    'flowing("joint", {"left": 1.0}, 1.0, 1e-3)': "a_min = 0.0: expected above 0",
    'flowing("joint", {"left": 1.0}, 1.0, {"bed": 1.0}, 1e-3)': "a_0 of bed: expected one for each",
    'flowing("joint", {"left": 1.0}, 1.0, 0.0, 1e-3, [1.0])': "weight = [1.0]: expected 2 finite",
    'flowing(["low", "high"], {"heel": 1.0}, 1.0, 0.0, 1e-3, m=layered())': "high: 4 nodes are cut off from",
    "flowing('joint', {'left': 1.0}, 1.0, 0.0, 1e-3, joint=1.0)": "joint: its pressure is that of a flow",
    "found(flows=[Flow('joint', {'left': 1.0}, 1.0, 0.0, 1e-3)] * 2)": "joint: it is in two flows",
    "initial([[0.0, 1.0], [1.0, -1.0]])": "joint: ",
    "initial(np.eye(2), pressures={'bed': 1.0})": "bed: no such joint: expected one of joint",
    "initial([1.0, 0.0])": "stress of the shape (2,): expected (2, 2) or",
    "initial([[1.0, 1.0], [0.0, 0.0]])": "stress: expected finite, symmetric components",
    # of one rank alone, where there are two
    "initial(lambda x: np.where(x[:, :1, None] > 2.9, np.nan, np.eye(2)))": "stress: expected finite",
    "initial(1j * np.eye(2))": "stress[0, 0] = 1j: expected a finite number",
    'initial(np.eye(2), "rock")': "rock: no such block: expected one of",
}
"""Expressions and what their errors say."""


@pytest.mark.parametrize("ranks", RANKS)
def test_wrong_input(ranks: int) -> None:
    """Every rank has the error, and it is one line."""
    code = """
def with_groups(rows):
    m = grid(range(4), range(rows + 1), block=range(rows))
    at = {tuple(x): k for k, x in enumerate(m.points.tolist())}
    line = [[at[1.0, float(y)], at[1.0, y + 1.0]] for y in range(rows)]
    cells = [*m.cells, ("vertex", [[at[0.0, 1.0]]]), ("line", line)]
    tags = [*m.cell_data["gmsh:physical"], [-20], [-21] * rows]
    names = m.field_data | {"heel": np.array([-20, 0]), "cut": np.array([-21, 1])}
    return meshio.Mesh(m.points, cells, cell_data={"gmsh:physical": tags}, field_data=names)

mesh = split(with_groups(2))
layers = split(with_groups(3), {"low": ("block_0", "block_1"), "high": ("block_1", "block_2")})

def initial(*words, **settings):
    return State.initial(model(), *words, **settings)

def layered():
    return Model(layers, {"low": law, "high": law}, E, 0.2)

def pressed(name, p):
    return found(pressures={name: p})

def flowing(*words, m=None, **pressures):
    return found(m=m, flows=[Flow(*words)], pressures=pressures)
"""
    assert_refused(WRONG, HELPERS + code, ranks)
