"""What the Python functions refuse: a ValueError with name, value and what was expected."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Point, Step, contract
from asperity.hosts import hosts
from asperity.installed import named_case
from asperity.model_checks import check_model
from asperity.tools.selection import LoadCase, select
from asperity.tools.slip_curves import slip_curves
from asperity.tools.surface.scan import Scan
from asperity.tools.surface.scan_files import planes_from_scan
from asperity.tools.uncertainty.spread import uncertainty

NAN, INF, HUGE = float("nan"), float("inf"), 10**400
TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
RT, RP_4 = (Interface(TABLE_2, Pattern.regular(sides, 30.0)) for sides in (2, 4))
ONE_PLANE = Interface(TABLE_2, Pattern.planes([[1, 0, 0]], [1.0]))
LOAD = {"material": TABLE_2, "theta": 30.0, "sigma_N": (-1.0,), "turns": (0.4,)}
MASONRY = {"kn": 82, "ks": 36, "ft": 0.25, "GfI": 0.018, "c": 0.35, "GfII": 0.125, "tan_phi": 0.75}
TWO, SIX = [[1, 0, 0], [1, 0, 0]], np.zeros((2, 3))
LONG, MINUS = r"1000+\.\.\.0+", r"-1000+\.\.\.0+"
X = np.arange(9.0)
BOWL = Scan(X, X, np.outer(X**2, X))
COMPLEX = np.array([0.1 + 0j, 0.2 + 1j, 0.3 + 0j])
PRESSED = {"traction": [-1.0, 0.0, 0.0]}
VISCOUS = Interface(Material(3.0, 0.3, 0.9, 0.5, tau_v=0.4), RP_4.pattern)


def joint(**constants: float) -> Material:
    """Joint without bond, some of whose constants are bad."""
    return Material.from_joint(**{"kn": 20.0, "ks": 5.0, "mu": 0.5} | constants)


def spread(**given: object) -> object:
    """Uncertainty of two constants, with a bad argument."""
    return uncertainty(named_case("figure05b"), **{"sd": {"mu": 0.05, "theta": 1.0}} | given)


def bad(shape: tuple[int, ...], entries: dict[int, float]) -> np.ndarray:
    """Zeros of a shape, with other entries in row 1."""
    array = np.zeros(shape)
    array[1, [*entries]] = [*entries.values()]
    return array


def in_shape(name: str, shape: tuple[int, ...], expected: str) -> str:
    """Message of an array of another shape."""
    return re.escape(f"{name} {shape}: expected {expected}")


ROWS: list[tuple[Callable[[], object], str]] = [
    # shapes
    (lambda: RP_4.update([0.0, 0.0, 0.0]), in_shape("s has shape", (3,), "(n, 3)")),
    (lambda: RP_4.update(np.zeros((2, 4))), in_shape("s has shape", (2, 4), "(n, 3)")),
    (lambda: RP_4.update(SIX, np.zeros((2, 22))), in_shape("state has shape", (2, 22), "(2, 23)")),
    (lambda: RP_4.update(SIX, s_old=np.zeros((3, 2))), in_shape("s_old has shape", (3, 2), "(2, 3)")),
    (lambda: RP_4.replay(np.zeros((2, 2, 3))), in_shape("S has shape", (2, 2, 3), "(n, 3)")),
    (lambda: RP_4.confined_slip(0.0, [[0.1]], 0.0), in_shape("slips has shape", (1, 1), "(T,)")),
    (lambda: RP_4.run(Step(), np.zeros(3)), in_shape("state has shape", (3,), "(23,)")),
    (lambda: Pattern.planes([[1, 0, 0]], [0.5, 0.5]), in_shape("normals has shape", (1, 3), "(2, 3)")),
    (lambda: Pattern.planes([1, 0, 0], 1.0), in_shape("weights has shape", (), "(k,)")),
    (lambda: Pattern.planes(np.ones((65, 3)), np.full(65, 1 / 65)), r"65,.: expected .k,. with k = 1 to 64"),
    (lambda: Scan(X, None, X**2), re.escape("z has shape (9,): expected (ny, nx) = (1, 9)")),
    # numbers that the library cannot have: too large integers, texts, None
    (lambda: Material(HUGE, 0.3, 0.9, 0.5), f"sigma0 = {LONG}: expected > 0"),
    (lambda: Material(3.0, 0.3, 0.9, 10**5000), "mu = an integer of 16610 bits: expected >= 0"),
    (lambda: Material(3.0, None, 0.9, 0.5), "Gc = None: expected > 0"),
    (lambda: Pattern.regular(HUGE, 30.0), f"sides = {LONG}: expected 0 or 2 to 64"),
    (lambda: Pattern.regular("4", 30.0), "^sides = '4': expected 0 or 2 to 64"),
    (lambda: Pattern.planes([[HUGE, 0, 0]], [1.0]), rf"normals\[0, 0\] = {LONG}: expected a"),
    (lambda: RP_4.props(h=HUGE), f"h = {LONG}: expected"),
    (lambda: RP_4.update([[0, -HUGE, 0]]), rf"s\[0, 1\] = {MINUS}: expected a finite number"),
    (lambda: RP_4.update([[0, 0, 0]], s_old=[["x", 0, 0]]), r"s_old\[0, 0\] = 'x': expected a finite"),
    (lambda: RP_4.update([[0, 0], [0, 0, 0]]), r"s.*: .*expected numbers|s\[.*expected a finite number"),
    (lambda: RP_4.confined_slip(HUGE, [0.1], 0.0), f"direction = {LONG}: expected a finite"),
    *(
        (lambda n=n: RP_4.confined_slip(0.0, [0.1], 0.0, preload=n), "preload = .+: expected a whole number")
        for n in (2**40, 2**31, HUGE, 2.5, NAN, INF, "x", None, 0)
    ),
    # patterns
    (lambda: Pattern.planes([[0, 1, 0], [1, 0, 0]], [0.5, 0.5]), "^n_N of listed plane 1 = 0: expected > 0"),
    (
        lambda: Pattern.planes([[1, NAN, 0], [1, 0, 0]], [0.5, 0.5]),
        "n_Tx of listed plane 1 = NaN: expected finite",
    ),
    (
        lambda: Pattern.planes([[1, 0, 0], [1, 0, INF]], [0.5, 0.5]),
        "n_Ty of listed plane 2 = Inf.*: expected fin",
    ),
    (
        lambda: Pattern.planes(TWO, [0.5, 0.4]),
        "weights gamma of the listed planes sum to 0.9: expected 1 within",
    ),
    (lambda: Pattern(-2), "m = -2: expected 0 for 0 listed planes"),
    (lambda: Pattern([(1.0, 0.0, 0.0)]), "expected a number of planes; Pattern.planes.normals, weights"),
    (lambda: Interface(TABLE_2, 8), "pattern = 8: expected a Pattern, as Pattern.regular"),
    # load paths
    (
        lambda: RP_4.confined_slip(NAN, [0.0, INF, 0.1], -INF, preload=0),
        r"^sigma_N = -Inf.*: exp.*\npreload = 0: exp.*\nslips\[1\] = Inf.*: exp.*\ndirection = NaN: exp",
    ),
    (lambda: RP_4.run([{"t_N": 1.0}]), "steps: expected one asperity.Step or more"),
    (lambda: RP_4.run(None), "steps: expected one asperity.Step or more"),
    (lambda: RP_4.run(Step(), Point(np.full(23, 2.0))), r"STATEV\(9\) alpha = 2"),
    (lambda: Step(slip="x"), "slip.* = 'x': expected a finite number"),
    (lambda: Step(follow="x"), "follow = 'x': expected 'stable' or 'branch'"),
    (lambda: RP_4.run([Step(), Step(time=-1.0)]), r"steps\[1\]: time = -1: expected >= 0"),
    (lambda: RP_4.run(Step(time=[])), r"steps\[0\]: time = 0 values: expected one or more"),
    (lambda: RP_4.run(Step(), tolerance=0.5), r"tolerance = 0\.5: expected 1e-8 to 0\.1"),
    *(
        (lambda options=options: RP_4.confined_slip(0.0, [0.2], -1.0, **options), message)
        for options, message in (
            ({"arc": 0.1}, "^arc without follow = 'branch'$"),
            ({"follow": "branch", "arc": 2.0}, "arc = 2: expected 0.00001 to 1"),
            ({"follow": "branch", "tolerance": 1e-3}, "tolerance with follow = 'branch': expected arc"),
            ({"follow": "branch", "stiffness": -1.0}, "stiffness = -1"),
        )
    ),
    (lambda: slip_curves(RT, NAN, [0.1]), "direction"),
    (lambda: slip_curves(RT, 0.0, [0.1], 0.0, 0), "preload = 0"),
    # separations that are not finite, and states that no update can return, with index as in the hosts
    *(
        (lambda call=call, s=s: call(s), rf"^{place} 1 \(of 0 to 2\): {name}{rest}")
        for call, place, rest in (
            (RP_4.update, "point", " = .*: expected a finite number"),
            (lambda s: RP_4.update(np.zeros((3, 3)), s_old=s), "point", " at the start = "),
            (RP_4.replay, "row", " = "),
        )
        for i, name in enumerate(("s_N", "s_Tx", "s_Ty"))
        for s in (bad((3, 3), {i: value}) for value in (NAN, INF, -INF, 1e80))
    ),
    *(
        (
            lambda i=i, value=value: RP_4.update(SIX, bad((2, 23), {i: value})),
            rf"^point 1 \(of 0 to 1\): STATEV\({i + 1}\) {name} = ",
        )
        for i, value, name in (
            (1, NAN, "stored"),
            (6, INF, "offset_Tx"),
            (8, -0.1, "alpha"),
            (11, 1.1, "alpha"),
        )
    ),
    # complex numbers, whose imaginary parts are not dropped
    *(
        (lambda call=call: call(COMPLEX), r"^(traction|s|S|slips|times)(\[.*\] = .*: expected a|: complex)")
        for call in (
            RP_4.initial,
            lambda z: RP_4.update(z[None]),
            lambda z: RP_4.replay([z]),
            lambda z: RP_4.confined_slip(0.0, z, -1.0),
            lambda z: RP_4.confined_slip(0.0, z.real, -1.0, times=z),
        )
    ),
    # masks and dates, which are not dropped either
    (lambda: RP_4.update(np.ma.masked_equal([[0.1, 0.2, 0.0]], 0.2)), "^s: masked values, expected numbers$"),
    (lambda: RP_4.update(np.zeros((1, 3), "M8[s]")), r"^s\[0, 0\] = .*: expected a"),
    # initial states
    *(
        (lambda given=given: RP_4.initial(**given), message)
        for given, message in (
            ({"traction": [1.0, 2.0]}, "traction has shape"),
            ({"traction": [NAN, 0.0, 0.0]}, "initial t_N = NaN: expected a finite traction"),
            (PRESSED | {"damage": [0.0, 1.0]}, r"damage has shape \(2,\)"),
            (PRESSED | {"damage": 1.5}, r"STATEV\(9\) alpha = 1.5"),
            (PRESSED | {"slip": np.zeros((2, 2))}, "slip has shape"),
            ({"traction": [[0.0, 0.0, 0.0], [7.0, 0.0, 0.0]]}, r"point 1 \(of 0 to 1\).*beyond the strength"),
        )
    ),
    # times
    *(
        (lambda dt=dt: VISCOUS.update([[0, 0, 0]], dt=dt), message)
        for dt, message in (
            (None, "dt is missing: expected for viscous damage, tau_v = 0.4"),
            (-1.0, "dt = -1: expected a finite time increment >= 0"),
        )
    ),
    *(
        (lambda times=times, n=n: VISCOUS.replay([[0, 0, 0]] * n, times), message)
        for times, n, message in (
            (None, 1, "times is missing: expected for viscous damage"),
            ([1.0, 2.0], 1, r"times has shape \(2,\): expected \(1,\)"),
            ([-1.0], 1, r"times\[0\] = -1: expected a finite number from 0"),
            ([1, 3, 2], 3, r"times\[2\] = 2: expected a finite number from 3"),
        )
    ),
    *(
        (lambda given=given: VISCOUS.confined_slip(0.0, [0.1], 0.0, **given), message)
        for given, message in (
            ({}, "times is missing: expected for viscous damage"),
            ({"times": [[1.0]]}, r"times has shape \(1, 1\): expected"),
            ({"times": [1.0], "preload_time": -1.0}, "preload_time = -1.0: expected a finite time >= 0"),
        )
    ),
    # joints without bond, masonry
    (lambda: joint(kn=-1.0, ks=NAN, mu=-2.0), r"^mu = -2: exp.*\nkn = -1.0: exp.*\nks = nan: expected"),
    (lambda: joint(sigma0=3.0), "sigma0 = 3.0: expected without kn and ks"),
    (lambda: joint(damage0=0.5), "damage0 = 0.5: expected"),
    (lambda: joint(kn=1e20, ks=1.0), r"kn = 1e\+20: expected at most 1e10 ks"),
    (lambda: joint(kn="a", ks=1e-45), "kn = 'a': .*\nks = 1e-45"),
    (lambda: Material.from_masonry(**MASONRY | {"ft": 0.0, "GfII": -1}), r"ft = 0.*\nGfII = -1"),
    (lambda: Material.from_masonry(**MASONRY | {"kn": 1.0}), r"kn = 1.0: expected more than ft\^2/\(2 GfI\)"),
    # cards
    *(
        (lambda arguments=arguments: RT.card(*arguments[:1], **arguments[1]), message)
        for arguments, message in (
            (
                ("ansys", {}),
                f"host = 'ansys': expected one of {', '.join(hosts('card'))}",
            ),
            (("abaqus", {"name": "2 joints"}), "name = '2 joints': expected a letter"),
            (("abaqus", {"h": -1.0}), "h = -1"),
            (("abaqus", {"dimension": 1}), "dimension = 1: expected 2 or 3"),
            (("abaqus", {"density": 0.0}), "density = 0: expected > 0"),
            (("abaqus", {"explicit": True}), "density is missing: expected a density"),
            (("abaqus", {"stress": 0.0}), "stress = 0: expected the normal traction in compression, < 0"),
            (("abaqus", {"modulus": 1.0}), "modulus and size: expected both or none"),
            (("abaqus", {"modulus": 1.0, "size": INF}), "size = inf: expected > 0"),
            (("akantu", {"h": 0.1}), "h = 0.1: expected 1 for akantu"),
            (("calculix", {"name": "NLJOINT"}), "expected none that begins with NL"),
            (("calculix", {"dimension": 2}), "dimension = 2: expected 3 for calculix"),
            (("calculix", {"explicit": True}), "explicit, density: expected for abaqus, .*only"),
            (("ogs", {"dalpha": 0.1}), "dalpha = 0.1: expected 0 for ogs, which ignores a request"),
        )
    ),
    (lambda: ONE_PLANE.card("calculix"), "m = -1: expected a regular pattern for calculix"),
    (
        lambda: Interface(TABLE_2, Pattern.regular(33, 30.0)).card("ogs"),
        "34 planes: expected fewer for ogs, whose library has no AsperityLayer34",
    ),
    (lambda: check_model(TABLE_2, RT.pattern, direction=NAN), "direction = nan: expected a finite angle"),
    # tools
    *(
        (lambda t=t: select(LoadCase(**LOAD), t), "tolerance = .*: expected 0 < tolerance < 1")
        for t in (0.0, -0.1, 1.0, NAN)
    ),
    *(
        (lambda p=p: select(LoadCase(**LOAD | {"sigma_N": p, "turns": (0.15,)}), 0.05), "sigma_N = 4.5: exp")
        for p in ((4.5,), (-5.0, 4.5), (4.5, -5.0))
    ),
    (lambda: LoadCase(**LOAD | {"flat": 1.5}), "flat = 1.5"),
    (lambda: LoadCase(**LOAD | {"sigma_N": ()}), "sigma_N = "),
    (lambda: LoadCase(**LOAD | {"turns": (0.0,)}), "turns = .*: expected a path"),
    (lambda: LoadCase(**LOAD | {"direction": INF}), "direction = inf"),
    (lambda: LoadCase(**LOAD | {"material": Material(3.0, 0.3, 0.9, 0.5, tau_v=1.0)}), "tau_v = 1"),
    (lambda: spread(samples=0), "samples = 0: expected a whole number, 2 to"),
    (lambda: spread(seed=-1), "seed = -1: expected a whole number >= 0"),
    (lambda: spread(levels=[0.5, 0.1]), "expected increasing numbers between 0 and 1"),
    (lambda: spread(correlations={("mu", "theta"): 0.2, ("theta", "mu"): 0.9}), "given twice"),
    (lambda: planes_from_scan(BOWL, direction=NAN), "direction = nan: expected a finite angle"),
    (lambda: planes_from_scan(BOWL, directions=0), "directions = 0: expected a whole number, 2 to"),
    (lambda: planes_from_scan(BOWL, flat_below=99, regular=True), "flat_below = 99: expected degrees, 0 to"),
    (lambda: planes_from_scan(np.zeros((9, 9))), r"scan = .*: expected a file, or Scan\(x, y, z\) of arrays"),
    (lambda: Scan(X[::-1], None, np.zeros((1, 9))), "x: expected two or more positions that increase"),
    (lambda: Scan(X, None, np.full((1, 9), NAN)), "z: expected finite numbers"),
]


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize(("call", "message"), ROWS, ids=[message for _, message in ROWS])
def test_refused(call: Callable[[], object], message: str) -> None:
    """The message names argument, value and what is expected."""
    with pytest.raises(ValueError, match=message):
        call()


def build(row: contract.Prop, value: float) -> object:
    """The object whose field a constant is."""
    if row.owner == "law":
        return Material(**({"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | {row.name: value}))
    if row.owner == "pattern":
        name = "sides" if row.name == "m" else row.name
        return Pattern.regular(**({"sides": 4, "theta": 30.0} | {name: value}))
    return RP_4.props(**{row.name: value})


def bad_values(row: contract.Prop) -> list[float]:
    """Values of a constant outside its range, which stands in tests/law/test_contract.pf, and no value."""
    if row.name == "m":
        return [1.0, -3.0, 65.0, 2.5, NAN, INF]
    beyond = [math.nextafter(row.lower, -INF), math.nextafter(row.upper, INF), NAN, INF]
    return [*beyond, 0.5] if row.integral else beyond


@pytest.mark.parametrize(
    ("row", "value"),
    [(row, value) for row in contract.props_table() if row.owner != "reserved" for value in bad_values(row)],
    ids=lambda part: getattr(part, "name", str(part)),
)
def test_every_bad_constant(row: contract.Prop, value: float) -> None:
    """A constant out of range is named as the caller names it, with its value and what was expected."""
    with pytest.raises(ValueError) as error:
        build(row, value)
    name, admissible = ("sides", "0 or 2 to 64") if row.name == "m" else (row.name, row.admissible)
    wanted = rf"{name} = ([^:\n]*)(?::[^\n]*)?: expected {re.escape(admissible)}"
    match = re.fullmatch(wanted, str(error.value))
    assert match and np.array_equal(float(match[1]), value, equal_nan=True)


def test_all_bad_values_at_once() -> None:
    """One error names all bad values, of a state of 65 planes and of 64 listed planes, too."""
    with pytest.raises(ValueError) as error:
        Material(sigma0=-3.0, Gc=NAN, eta=2.0, mu=-1.0, sigma02=-1.0, tau_v=-5.0)
    starts = ["sigma0", "Gc", "eta", "mu", "sigma02", "tau_v"]
    assert [line.split(" = ")[0] for line in str(error.value).splitlines()] == starts
    wide = Interface(TABLE_2, Pattern.regular(64, 30.0))
    for call, wanted in (
        (lambda: wide.update(np.zeros((1, 3)), np.full((1, wide.nstatv), NAN)),
         [f"STATEV({i}) " for i in range(1, wide.nstatv + 1)]),
        (lambda: Pattern.planes(np.full((64, 3), NAN), np.full(64, NAN)),
         [f"{n} of listed plane {k} = NaN" for n in ("n_N", "n_Tx", "n_Ty", "gamma") for k in range(1, 65)]),
    ):  # fmt: skip
        with pytest.raises(ValueError) as error:
            call()
        assert all(text in str(error.value) for text in wanted) and not str(error.value).endswith("...")
