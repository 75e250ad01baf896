"""Models and steps on FEniCSx: wrong input is refused by one line, and so is a step without equilibrium."""

from __future__ import annotations

import pytest
from on_ranks import RANKS, WITH_FENICSX, assert_refused, of_all_ranks

pytestmark = WITH_FENICSX

WRONG = {
    'model(plane="strian")': "plane = 'strian': expected 'stress' or 'strain'",
    "model(nu=0.6)": "nu = 0.6: expected -1 < nu < 0.5",
    "model(0.0)": "E of block_0 = 0.0: expected above 0",
    'model({"block_0": 1.0})': "E of block_0: expected one of block_1, too",
    'model({"block_0": 1.0, "block_1": 1.0, "rock": 1.0})': "E of rock: no such block: expected one of",
    'model(laws={"bed": law})': "laws of bed: expected those of joint",
    "model(thickness=-1.0)": "thickness = -1.0: expected above 0",
    "Model(solid, {'joint': law}, 2e4, 0.2, thickness=5.0)": "thickness = 5.0: expected 1 in 3D",
    "Model(unsplit, {'joint': law}, 2e4, 0.2)": "mesh of the type Mesh: expected Jointed, as of asperity",
    "Model('wall.msh', {'joint': law}, 2e4, 0.2)": "mesh of the type str: expected Jointed, as of asperity",
    "Model(None, {'joint': law}, 2e4, 0.2)": "mesh of the type NoneType: expected Jointed",
    "model(laws=law)": "laws of the type Interface: expected Mapping",
    "model(laws={'joint': law.material})": "laws of joint of the type Material: expected Interface",
    "(m := model()).dofs(m.x[:, 0] < 1)": "no components: expected one or more, of 0 to 1",
    "(m := model()).dofs(m.x[:, 0] < 1, 2)": "component 2: expected 0 to 1 in 2D",
    "(m := model()).dofs(np.ones(3, bool), 0)": "a mask of the shape (3,): expected one for",
    "(m := model()).dofs(np.array([10**6]), 0)": "nodes 1000000 to 1000000: expected owned ones",
    'model().solid("rock")': "rock: no such block: expected one of block_0, block_1",
    'model().group("roof")': "roof: no such group: expected one of",
    'model().body([0.0, -1.0], "rock")': "rock: no such block: expected one of block_0, block_1",
    "model().body([0.0, -1.0, 0.0])": "force [0.0, -1.0, 0.0]: expected 2 finite components",
    "model().body([0.0, 1j])": "force[1] = 1j: expected a finite number",
    "found(fixed=[])": "nothing is fixed and there is no drag",
    "found(fixed=[10**6])": "expected components 0 to",
    "found(fixed=[0.5])": "fixed of the type float64 and the shape (1,): expected a row of indices",
    "found(fixed=[0, 0], values=[1.0, 2.0])": "component 0: prescribed as 1 and as 2",
    "found(Terms(tolerance=0.0))": "tolerance = 0.0: expected between 0 and 1",
    "found(Terms(drag=[1.0]))": "drag of the shape (1,): expected",
    "found(Terms(drag=-1.0))": "drag: expected at least 0",
    "found(values=np.zeros(3))": "values of the shape (3,): expected",
    "found(load=np.zeros(5))": "load of the shape (5,): expected 0 or (",
    "found(load=5.0)": "load = 5 on every component: expected 0 or (",
    "found(Terms(openings=np.zeros((2, 3))))": "openings of the shape (2, 3): expected finite numbers of",
    "found(Terms(openings=np.full((len((m := model()).area), 3), np.nan)), m)": "openings of the shape (",
    "found(Terms(passes=2, aim=np.zeros(3)))": "aim of the shape (3,): expected finite numbers of",
    "found(values=np.nan)": "values: expected finite numbers",
    "found(Terms(dt=0.0))": "dt = 0.0: expected above 0",
    "found(Terms(dt=np.nan))": "dt = nan: expected above 0",
    "found(Terms(ahead=np.inf))": "ahead: expected finite numbers",
    "found(Terms(dt=np.float32('inf')))": "dt = inf: expected above 0",
    "found(Terms(passes=-1))": "passes = -1: expected a whole number of at least 0",
    "found(Terms(passes=1.5))": "passes = 1.5: expected a whole number of at least 0",
    "found(Terms(iterations=2.5))": "iterations = 2.5: expected a whole number of at least 1",
    "solve(m := model(), State.virgin(m), None)": "conditions of the type NoneType: expected Conditions",
    "solve(m := model(), of_others(), Conditions(bottom(m)))": "state: expected one of this model",
    "Follow(model(), of_others(), refused, 0.1)": "state: expected one of this model",
    "solve(model(), replace(State.virgin(model()), scale=np.inf), None)": "scale = inf of the state",
    "solve(model(), not_finite('p'), None)": "p of the state: expected finite numbers",
    "Follow(model(), not_finite('t'), refused, 0.1)": "t of the state: expected finite numbers",
    "Follow(m := model(), State.virgin(m), refused, 0.1, passes=1.5)": "passes = 1.5, limit = ",
    "Follow(m := model(), State.virgin(m), refused, 0.1).advance(1.0)": "no conditions at 0.1",
    "Follow(m := model(), State.virgin(m), lambda t: t, 0.1).advance(1.0)": "conditions of the type float",
    "found(Terms(search='cp'))": "search = 'cp': expected one of root, residual, none",
    "found(Terms(options='-snes_max_it 3'))": "-snes_max_it: expected options of PETSc for linear equations",
    "found(Terms(options='gamg'))": "options 'gamg': expected options of PETSc",
    "Follow(m := model(), State.virgin(m), refused, 0.1, 0.05)": "step = 0.1, most = 0.05, least = 1e-05",
    "Follow(m := model(), State.virgin(m), refused, 0.1).advance(np.nan)": "end = nan: expected a finite",
    "Follow(m := model(), State.virgin(m), refused, 0.1).run(np.inf)": "end = inf: expected a finite number",
    "found(Terms(tolerance='fine'))": "tolerance = fine: expected between 0 and 1",
    "found(Terms(dt='1'))": "dt = 1: expected above 0",
    "found(Terms(damping=1j))": "damping = 1j: expected at least 0",
    "found(Terms(passes=True))": "passes = True: expected a whole number of at least 0",
    "found(Terms(at=True))": "at = True: expected a finite number",
    "found(Terms(drag='high'))": "drag[] = 'high': expected a finite number",
    "found(Terms(drag=True))": "drag of the type bool: expected numbers",
    "found(Terms(options=3))": "options of the type int: expected str",
    "found({'dt': 1.0})": "terms of the type dict: expected Terms",
    "found(values=['0.1'], fixed=[0])": "values of the type <U3: expected numbers",
    "found(load=True)": "load of the type bool: expected numbers",
    "found(fixed=3)": "fixed of the type int64 and the shape (): expected a row of indices",
    "found(fixed=[[0, 1]])": "fixed of the type int64 and the shape (1, 2): expected a row of indices",
    "found(fixed=[True])": "fixed of the type bool and the shape (1,): expected a row of indices",
    "found(pressures=[1.0])": "pressures of the type list: expected Mapping",
    "found(flows=1.0)": "flows of the type float: expected Sequence",
    "found(flows=[1.0])": "flows[0] of the type float: expected Flow",
    "found(pressures={'joint': True})": "joint: p of the type bool: expected numbers",
    "found(flows=[Flow('joint', {'left': 1.0}, 'thin', 1e-3, 1e-4)])": "viscosity = 'thin': expected",
    "solve(m := model(), None, Conditions(bottom(m)))": "state of the type NoneType: expected State",
    "solve(State.virgin(m := model()), m, Conditions(bottom(m)))": "model of the type State: expected Model",
    "solve(m := model(), replace(State.virgin(m), at=np.nan), None)": "at = nan of the state: expected",
    "Follow(m := model(), State.virgin(m), refused, 0.1, terms=Terms(damping=0.5))": "damping = 0.5: ",
    "Follow(m := model(), State.virgin(m), None, 0.1)": "conditions None: expected a function",
    "Follow(m := model(), State.virgin(m), refused, '0.1')": "step = 0.1, most = 0.1, least = 1e-05",
    "Follow(m := model(), State.virgin(m), refused, 0.1, errors=0.1)": "errors = 0.1: expected a whole",
    "Follow(m := model(), State.virgin(m), refused, 0.1, limit='x')": "limit = x, errors = (0.1, 0.01)",
    "Follow(m := model(), State.virgin(m), refused, 0.1).advance('1')": "end = 1: expected a finite number",
    "model(thickness=True)": "thickness = True: expected above 0",
    "model(nu='0.2')": "nu = 0.2: expected -1 < nu < 0.5",
    "model('stiff')": "E of block_0 = stiff: expected above 0",
    "(m := model()).dofs(np.array([0.5]), 0)": "nodes of the type float64 and the shape (1,): expected",
    "(m := model()).dofs(3, 0)": "nodes of the type int64 and the shape (): expected a row of",
    "(m := model()).dofs(np.array([0]), True)": "component True: expected 0 to 1 in 2D",
    "weighed('-ksp_type none_such')": "options '-ksp_type none_such': PETSc ends with 'Unable to find",
    "weighed('-pc_factor_mat_solver_type nix')": "options '-pc_factor_mat_solver_type nix': PETSc ends with",
    "weighed('-kps_type cg')": "-kps_type: expected an option that these solvers of PETSc read",
    "weighed('-pc_type gamg -pc_gamg_treshold 0.1')": "-pc_gamg_treshold: expected an option that these",
    "State.load('none', model())": "none: expected the files of a run with the same mesh, laws and ranks",
}
"""Expressions and what their errors say."""


@pytest.mark.parametrize("ranks", RANKS)
def test_wrong_input(ranks: int) -> None:
    """Every rank has the error, and it is one line."""
    code = """
rough = Interface(law.material, Pattern.regular(4, 10.0))
unsplit = grid(range(4), range(3), block=[0, 1])
solid = split(grid(range(4), range(3), range(3), block=[0, 1])) if COMM.rank == 0 else None

def of_others():
    return State.virgin(model(laws={"joint": rough}))

def not_finite(name):
    state = State.virgin(model())
    return replace(state, **{name: np.full_like(getattr(state, name), np.nan)})

def weighed(options):
    m = model()
    return found(Terms(options=options), m, load=m.body([0.0, -1e-2], "block_1"))

def refused(t):
    if COMM.rank == COMM.size - 1:  # one rank alone
        raise ValueError(f"no conditions at {t:g}")
    return Conditions(bottom(m))
"""
    assert_refused(WRONG, code, ranks)


@pytest.mark.parametrize("ranks", RANKS)
def test_options_of_another_solution(ranks: int) -> None:
    """Options of PETSc, also wrong ones, hold for the solution that has them alone."""
    code = """
m = model()
down = m.body([0.0, -1e-2], "block_1")
of = Conditions(bottom(m), load=down)
def count(more):
    return solve(m, State.virgin(m), of, Terms(options=f"-pc_type gamg {more}")).linear
results["counts"] = count(""), count("-mg_coarse_pc_type jacobi"), count("")
results["refused"] = []
for wrong in ("-ksp_type none_such", "-kps_type cg"):
    for _ in range(2):
        try:
            solve(m, State.virgin(m), of, Terms(options=wrong))
        except Exception as error:
            results["refused"].append(type(error).__name__)
results["after"] = count(""), solve(m, State.virgin(m), of).good
"""
    results = of_all_ranks(code, ranks)
    first, other, again = results["counts"]
    assert first == again == results["after"][0] != other
    assert results["refused"] == ["ValueError"] * 4 and results["after"][1]


@pytest.mark.parametrize("ranks", RANKS)
def test_measures(ranks: int) -> None:
    """The resultant in the joint is that of weight and push, and so are its factors of safety.

    A block 3 wide and 1 high, pushed by a share of its weight W at half of its height.  A path ends at the
    friction mu and says how the block moves; its energies balance the better the shorter its steps are.
    """
    code = """
import tempfile
m = model()
down, push = (m.body(force, "block_1") for force in ([0.0, -1e-2], [1e-2, 0.0]))
of = lambda t: Conditions(bottom(m), load=down + t * push, pressures={"joint": 2e-3})
start = solve(m, State.virgin(m), of(0.0)).taken()
follow = Follow(m, start, of, 0.05, 0.1)
state = follow.run(0.2)
found_here = measure(m, "joint", state, follow.before)
results["reported"] = [found_here.sliding, found_here.normal] == [
    getattr(follow.report.measures["joint"], name) for name in ("sliding", "normal")
]
folder = COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None)
output = Output(m, f"{folder}/block.pvd")
output.write(state, ledger=follow.ledger)
results["csv"] = open(f"{folder}/block.csv").read() if COMM.rank == 0 else ""
results["csv"] = COMM.bcast(results["csv"])
results["ledger"] = follow.ledger.work, follow.ledger.balance
results["normal"], results["place"] = found_here.normal, found_here.place.tolist()
results["safety"] = found_here.against_sliding, found_here.against_overturning
results["sums"] = found_here.area, found_here.cracked, found_here.open, found_here.shear.tolist()
results["slid"] = found_here.sliding
last = follow.run_to_limit(1.0)
results["limit"] = follow.kind, last.at, follow.reason
moved = np.abs(follow.mechanism.reshape(-1, 2)) * m.solid("block_1").reshape(-1, 2)
results["mechanism"] = largest(moved[:, 1]) / largest(moved[:, 0])
results["unbalanced"] = []
for step in (0.1, 0.02):
    path = Follow(m, start, of, step, step)
    path.run(0.4)
    results["unbalanced"].append(path.unbalanced)
"""
    results = of_all_ranks(code, ranks)
    W, water, share = 3e-2, 6e-3, 0.2
    assert results["normal"] == pytest.approx(W - water, rel=1e-6)
    # moments about the middle: of the push by W share at half of the height
    away = W * share * 0.5 / (W - water)
    assert results["place"] == pytest.approx([1.5 + away, 1.0], rel=1e-6)
    assert results["safety"] == pytest.approx([0.5 * (W - water) / (W * share), 1.5 / away], rel=1e-6)
    area, cracked, apart, shear = results["sums"]
    assert (area, cracked, apart) == pytest.approx((3.0, 3.0, 0.0))
    assert [abs(force) for force in shear] == pytest.approx([0.0, W * share, 0.0], abs=1e-8)
    kind, at, reason = results["limit"]
    assert kind == "limit" and at == pytest.approx(0.5 * (W - water) / W, rel=1e-3)
    assert "an equilibrium farther away may carry more" in reason
    assert "block block_1 moves most, along (1, " in reason and results["mechanism"] < 0.1
    assert 0.0 <= results["slid"] <= 1.0 and results["reported"]
    head, row, _ = results["csv"].split("\n")
    written = dict(zip(head.split(","), map(float, row.split(",")), strict=True))
    assert [written["at"], written["work"], written["balance"]] == pytest.approx(
        [0.2, *results["ledger"]], rel=1e-9
    )
    kept = sum(written[name] for name in ("elastic", "stored", "spent", "damped", "released"))
    assert kept - written["work"] == pytest.approx(written["balance"], abs=1e-9 * kept)
    coarse, fine = map(abs, results["unbalanced"])
    assert fine < 0.5 * coarse < 0.05


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("search", ["root", "residual", "none"])
def test_no_equilibrium_without_forces(search: str, ranks: int) -> None:
    """A block slides under more than the friction; forces of the block that flies off are rounding errors."""
    code = f"""
m = model()
down, push = (m.body(force, "block_1") for force in ([0.0, -1e-2], [1e-2, 0.0]))
state, results["solved"] = State.virgin(m), []
for share in (0.0, 0.3, 0.45, 0.51, 0.55, 0.6):
    report = solve(m, state, Conditions(bottom(m), load=down + share * push), Terms(search="{search}"))
    state = report.state or state
    results["solved"].append(report.good)
"""
    assert of_all_ranks(code, ranks)["solved"] == [True, True, True, False, False, False]


def test_nothing_holds_along_a_roller() -> None:
    """No equilibrium where a force moves a block off an open joint along a roller, or about a pin.

    A force of 1.5e4 of it on another block hides it: it is below the rounding errors of large displacements.
    """
    code = """
bond = Material(sigma0=0.25, Gc=0.018, eta=0.95, mu=0.0)
flat = Pattern.regular(0, 0.0)
laws = {"bonded": Interface(bond, flat), "broken": Interface(replace(bond, damage0=1.0), flat)}
beside = split(grid([-1.0, 0.0, 1.0], range(3), block=[[0, 0], [1, 1]]))
for name, law in laws.items():
    m = Model(beside, {"joint": law}, 2e4, 0.0)
    (left, area), (right, _) = m.group("left"), m.group("right")
    low = lambda nodes: nodes[m.x[nodes, 1] < 0.5]
    far = np.zeros((m.n, 2))
    far[left, 1] = -150.0 * area / area.sum()
    held = np.r_[m.dofs(left, 0), m.dofs(low(left), 1)]
    for kind, others in (("roller", m.dofs(right, 0)), ("pin", m.dofs(low(right), 0, 1))):
        up = m.body([0.0, 5e-3], "block_1")
        report = found(m=m, fixed=np.r_[held, others], load=far.ravel() + up)
        results[f"{name} {kind}"] = report.good
"""
    results = of_all_ranks(code, 1)
    assert results == {"bonded roller": True, "bonded pin": True, "broken roller": False, "broken pin": False}
