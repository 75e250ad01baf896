"""Material blocks of each host, the checks of a model, the command."""

from __future__ import annotations

import json
import re
import warnings
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, contract, remarks
from asperity.case_files import read_run
from asperity.cli import main
from asperity.installed import all_cases, kratos_adapter

ROOT = Path(__file__).parents[2]
TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
RT = Interface(TABLE_2, Pattern.regular(2, 30.0))
FLAT = Pattern.regular(0, 0.0)
CASE = """&case title = 'joint' /
&material SIGMA0 = 3.0d0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 2, theta = 30.0 /
&step t_N = -1.0, increments = 100 /
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(text: str) -> str:
    """A case file in the current folder."""
    Path("case.nml").write_text(text, encoding="utf-8")
    return "case.nml"


def keywords(card: str) -> dict[str, list[str]]:
    """Data lines of an input file by keyword line, comments left out."""
    found: dict[str, list[str]] = {}
    for line in card.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            found[line] = data = []
        else:
            data.append(line)
    return found


# --- blocks ---------------------------------------------------------------


def test_abaqus_standard() -> None:
    """Section and material have the same name, state variables have names, and no keyword deletes points."""
    card = RT.card("abaqus", name="JOINT", h=0.5)
    found = keywords(card)
    assert list(found) == [
        "*Material, name=JOINT",
        f"*User Material, constants={contract.N_FIXED_PROPS}, unsymm",
        "*Depvar",
        "*Cohesive Section, elset=JOINT, material=JOINT, response=TRACTION SEPARATION, thickness=SPECIFIED",
    ]
    constants = found[list(found)[1]]
    assert [float(one) for line in constants for one in line.split(",")] == RT.props(h=0.5).tolist()
    assert max(line.count(",") for line in constants) < 8
    names = contract.statev_names(3)
    rows = [f"{i}, {name}, {name}" for i, name in enumerate(names, 1)]
    assert found["*Depvar"] == [f"{len(names)},", *rows]
    assert found[list(found)[-1]] == ["0.5,"]
    assert "COH3D8" in card and "COH2D4" not in card
    assert "COH2D4" in RT.card("abaqus", dimension=2)
    assert max(map(len, card.splitlines())) < 256
    assert "The first call of a point reads an initial stress (TYPE=STRESS)" in card


def test_abaqus_explicit() -> None:
    """The explicit block has a density and no unsymmetric solver; SDV 6 to 8 are the separation."""
    card = RT.card("abaqus", explicit=True, density=2.5e-9)
    found = keywords(card)
    assert found["*Density"] == ["2.5e-09,"]
    assert f"*User Material, constants={contract.N_FIXED_PROPS}" in found and "unsymm" not in card
    assert "double=both" in card
    assert found["*Depvar"][6] == "6, separation_N, separation_N"
    with pytest.raises(ValueError, match=r"density is missing: expected a density"):
        RT.card("abaqus", explicit=True)


def test_calculix_section() -> None:
    """The block has a solid section of the same material and states the thickness."""
    card = RT.card("calculix", name="joint", h=0.01)
    found = keywords(card)
    assert found["*SOLID SECTION, ELSET=JOINT, MATERIAL=ABAQUSJOINT"] == []
    assert found["*DEPVAR"] == ["17"]
    assert "thickness h = 0.01" in card and "C3D8R" in card
    assert "TYPE=SOLUTION, USER" in card  # see harness/hosts/calculix
    # CalculiX misreads a full last line of constants
    constants = found["*USER MATERIAL, CONSTANTS=21"]  # the most that it passes
    assert len(constants[-1].split(",")) < 8
    expected = RT.props(h=0.01)[:21].tolist()
    assert [float(one) for line in constants for one in line.split(",")] == expected
    with pytest.raises(ValueError, match=r"crush = 2: expected 0 for calculix, which passes at most 21"):
        Interface(replace(TABLE_2, crush=2.0), RT.pattern).card("calculix", h=0.01)
    assert all(name in card for name in contract.statev_names(3)) and "*MATERIAL, NAME=ABAQUSJOINT\n" in card
    n = contract.N_FIXED_PROPS + contract.N_LISTED_VALUES
    with pytest.raises(ValueError, match=f"{n} constants: expected at most 21 for calculix"):
        Interface(TABLE_2, Pattern.planes([[1, 0, 0]], [1.0])).card("calculix")


@pytest.mark.parametrize(
    ("dimension", "law", "element"),
    [
        (3, "SmallStrainUMAT3DSurfaceInterfaceLaw", "Geo_USurfaceInterfaceElement4Plus4N"),
        (2, "SmallStrainUMAT2DLineInterfaceLaw", "Geo_ULineInterfacePlaneStrainElement2Plus2N"),
    ],
)
def test_kratos_dimensions(dimension: int, law: str, element: str) -> None:
    """The block has a law and elements that fit together."""
    block = json.loads(RT.card("kratos", dimension=dimension))
    material = block["properties"][0]["Material"]
    assert material["constitutive_law"]["name"] == law
    assert material["Variables"]["GEO_DRAINAGE_TYPE"] == "constant_pw_field"  # see harness/hosts/kratos
    assert material["Variables"]["BIOT_COEFFICIENT"] == 0.0
    assert element in block["elements"]
    assert block["remarks"][-2].startswith("UDSM_NAME is the commit adapter")
    assert material["Variables"]["UDSM_NAME"] == str(kratos_adapter())
    assert material["Variables"]["UMAT_PARAMETERS"] == RT.props().tolist()
    assert material["Variables"]["STATE_VARIABLES"] == [0.0] * RT.nstatv
    assert tuple(block["state_variables"].values()) == contract.statev_names(RT.n_planes)
    assert "Kratos passes no initial stress to a UMAT" in block["remarks"][-1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_ogs_patch(dimension: int) -> None:
    """The patch has a library that exists, all properties of its behaviour and right-handed axes."""
    joint = Interface(replace(TABLE_2, kc=20.0), Pattern.regular(5, 30.0, flat=0.25, turn=10.0))
    root = ElementTree.fromstring(joint.card("ogs", name="JOINT", dimension=dimension, h=0.1, r=1e-9))
    relation, frame, parameters = root.findall("add")
    assert Path(relation.findtext("constitutive_relation/library", "")).is_file()
    assert relation.findtext("constitutive_relation/behaviour") == "AsperityLayer6"
    names = [row.name for row in contract.owned("law", "pattern", "host", "numerics") if row.name != "map"]
    properties = {one.get("name"): one.get("parameter") for one in relation.iter("material_property")}
    assert list(properties) == names
    values = {one.findtext("name"): one.findtext("values", "") for one in parameters}
    props = joint.props(h=0.1, r=1e-9)
    for name, parameter in properties.items():
        assert parameter == f"JOINT_{name}"
        assert float(values[parameter]) == props[contract.index(name)]
    axes = np.array([values[vector.text].split() for vector in frame[0]], dtype=float)
    assert axes.shape == (dimension, dimension) and np.linalg.det(axes) == 1.0
    assert axes[0].tolist() == [0.0, 0.0, 1.0][-dimension:]


def test_fenicsx_law() -> None:
    """The block is Python and makes the same law."""
    found: dict[str, Interface] = {}
    exec(RT.card("fenicsx", name="bed"), found)
    assert found["bed"] == RT
    with pytest.raises(ValueError, match="map = 1: expected 0 for fenicsx"):
        RT.card("fenicsx", map=1)


def test_oofem_record() -> None:
    """One record with all constants, the number of state variables and a library that exists."""
    *comments, record = RT.card("oofem", name="JOINT", h=0.1).splitlines()
    assert all(line.startswith("# ") for line in comments)
    kind, number, *settings = record.split()
    assert (kind, number) == ("AbaqusUserMaterial", "1")
    props = RT.props(h=0.1).tolist()
    start = settings.index("properties")
    assert settings[: start + 2] == ["d", "0.0", "numstate", "17", "properties", str(len(props))]
    assert [float(text) for text in settings[start + 2 : start + 2 + len(props)]] == props
    m = re.search(r'umat "(.*)" name "JOINT"$', record)
    assert m and Path(m[1]).is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(host="ansys"), "host = 'ansys': expected one of abaqus, akantu, calculix, fenicsx, kratos"),
        (dict(host="abaqus", name="2 joints"), "name = '2 joints': expected a letter"),
        (dict(host="calculix", name="NLJOINT"), "expected none that begins with NL"),
        (dict(host="calculix", map=1), "map = 1: expected 0 for calculix"),
        (dict(host="abaqus", h=-1.0), r"h = -1"),
        (dict(host="oofem", map=1), "map = 1: expected 0 for oofem"),
        (dict(host="oofem", dimension=2), "dimension = 2: expected 3 for oofem"),
        (dict(host="ogs", map=1), "map = 1: expected 0 for ogs"),
        (dict(host="ogs", dalpha=0.1), "dalpha = 0.1: expected 0 for ogs, which ignores a request"),
        (dict(host="ogs", density=1.0), "explicit, density: expected for abaqus only, not for ogs"),
        (dict(host="kratos", map=1), r"map = 1: expected 0 for kratos' interface laws"),
        (dict(host="kratos", h=0.1), r"h = 0.1: expected 1 for kratos"),
        (dict(host="calculix", dimension=2), "dimension = 2: expected 3 for calculix"),
        (dict(host="abaqus", dimension=1), "dimension = 1: expected 2 or 3"),
        (dict(host="kratos", density=1.0), "explicit, density: expected for abaqus only, not for kratos"),
        (dict(host="calculix", explicit=True), "explicit, density: expected for abaqus only"),
        (dict(host="abaqus", density=0.0), "density = 0: expected > 0"),
        (dict(host="abaqus", density=float("nan")), "density = nan: expected > 0"),
        (dict(host="abaqus", stress=0.0), "stress = 0: expected the normal traction in compression, < 0"),
        (dict(host="abaqus", modulus=1.0), "modulus and size: expected both or none"),
        (dict(host="abaqus", modulus=-1.0, size=1.0), "modulus = -1: expected > 0"),
        (dict(host="abaqus", modulus=1.0, size=float("inf")), "size = inf: expected > 0"),
    ],
)
def test_refused(arguments: dict[str, object], message: str) -> None:
    """Values that a host cannot accept, and inadmissible checks, are errors."""
    with pytest.raises(ValueError, match=message):
        RT.card(**arguments)


@pytest.mark.parametrize(
    ("pattern", "message"),
    [
        (
            Pattern.regular(33, 30.0),
            "34 planes: expected fewer for ogs, whose library has no AsperityLayer34",
        ),
        (Pattern.planes([[1, 0, 0]], [1.0]), "m = -1: expected a regular pattern for ogs"),
    ],
)
def test_patterns_that_ogs_refuses(pattern: Pattern, message: str) -> None:
    """The library has behaviours for the planes of regular patterns of up to 32 sides with a flat plane."""
    with pytest.raises(ValueError, match=message):
        Interface(TABLE_2, pattern).card("ogs")
    assert "AsperityLayer33" in Interface(TABLE_2, Pattern.regular(32, 30.0)).card("ogs")


def test_akantu_section() -> None:
    """A section of the input file with every constant of the law and the pattern."""
    joint = Interface(replace(TABLE_2, kc=20.0, height=2.0, W0=1.0), Pattern.regular(5, 30.0, turn=10.0))
    card = joint.card("akantu", name="JOINT")
    lines = [line for line in card.splitlines() if not line.startswith("#")]
    assert lines[:2] == ["material asperity [", "  name = JOINT"] and lines[-1] == "]"
    values = dict(line.strip().split(" = ") for line in lines[2:-1])
    props = joint.props()
    assert list(values) == [row.name for row in contract.owned("law", "pattern")]
    assert all(float(value) == props[contract.index(name)] for name, value in values.items())
    with pytest.raises(ValueError, match=r"h = 0.1: expected 1 for akantu"):
        joint.card("akantu", h=0.1)
    with pytest.raises(ValueError, match=r"m = -1: expected a regular pattern for akantu"):
        Interface(TABLE_2, Pattern.planes([[1, 0, 0]], [1.0])).card("akantu")


PATH = """&step t_N = -0.5, increments = 10 /
&step slip = 0.2, -0.1, direction = 30.0, increments = 20, 30, cycles = 2, time = 3.0 /
&step slip = 0.3, increments = 5 /
"""


def test_mtest_input(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The input has all properties and a library that exists; its evolutions are the path of the driver."""
    case = write(CASE.replace("&step t_N = -1.0, increments = 100 /\n", PATH))
    assert main(["card", "mtest", case]) == 0
    text = capsys.readouterr().out
    assert Path(re.findall(r"@Behaviour<generic> '(.*)' 'AsperityJoint3';", text)[0]).is_file()
    found = dict(re.findall(r"@MaterialProperty<constant> '(\w+)' (.*);", text))
    props = RT.props()
    assert {name: float(value) for name, value in found.items()} == {
        row.name: props[contract.index(row.name)]
        for row in contract.owned("law", "pattern", "host", "numerics")
        if row.name not in ("map", "h", "r")
    }
    ends = [(float(end), int(n)) for end, n in re.findall(r"([\d.]+) in (\d+)", text.split("@Times")[1])]
    parts = zip([(0.0, 0), *ends[:-1]], ends, strict=True)
    times = np.concatenate([[0.0], *(np.linspace(a, b, n + 1)[1:] for (a, _), (b, n) in parts)])
    history = read_run(Path(case)).history()
    expected = {
        "Tn": history.traction[:, 0],
        "Ut1": history.separation[:, 1],
        "Ut2": history.separation[:, 2],
    }
    imposed = dict(re.findall(r"@Imposed\w+ '(\w+)' \{(.*)\};", text))
    assert list(imposed) == list(expected)
    for name, values in expected.items():
        pairs = np.array([pair.split(" : ") for pair in imposed[name].split(", ")], dtype=float)
        rows = np.interp(times, *pairs.T)[-len(values) :]
        # a traction is met within the tolerance of the driver, 1e-7 of the strength
        assert rows == pytest.approx(values, rel=0, abs=1e-7), name


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        ("&step t_N = -1.0, k_N = 2.0 /\n", "step 1: k_N = 2: expected 0 for mtest"),
        ("&step s_N = 0.1, follow = 'branch' /\n", "step 1: follow = 'branch': expected 'stable'"),
        (
            "&step t_N = -1.0 /\n&step s_N = 0.1 /\n",
            "steps with 2 sets of prescribed components: expected one",
        ),
        (
            "&initial damage = 0.5 /\n&step s_N = 0.1 /\n",
            "expected &step groups from a virgin joint for mtest",
        ),
    ],
)
def test_paths_that_mtest_refuses(
    steps: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What an input of MTest cannot express is an error."""
    case = write(CASE.replace("&step t_N = -1.0, increments = 100 /\n", steps))
    assert main(["card", "mtest", case]) == 1
    assert message in capsys.readouterr().err


# --- checks ---------------------------------------------------------------


def test_locking_and_contact() -> None:
    """The card warns of locking of the steepest listed plane, and of a soft contact under the pressure."""
    assert not remarks.remarks(TABLE_2, RT.pattern)
    steep = Pattern.planes([[1, 0, 0], [1, 0, -3]], [0.9, 0.1])
    [locking] = remarks.remarks(TABLE_2, steep)
    assert not locking.good and "mu tan(theta) = 1.5 of the steepest plane" in locking.text
    assert remarks.remarks(TABLE_2, FLAT, stress=-10.0) == []
    [soft] = remarks.remarks(TABLE_2, RT.pattern, stress=-10.0)
    assert not soft.good and "closes by 1 s_f" in soft.text
    stiff = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0)
    assert not remarks.remarks(stiff, RT.pattern, stress=-10.0)


@pytest.mark.parametrize(
    ("sides", "turn", "direction", "planes", "better"),
    [
        (4, 0.0, 0.0, "3, 5", 45.0),
        (4, 0.9, 0.0, "3, 5", 45.0),
        (4, 1.1, 0.0, "", 0.0),
        (6, 0.0, 0.0, "", 0.0),
        (6, 30.0, 0.0, "3, 6", 0.0),
        (3, 0.0, 30.0, "3", 30.0),
        (2, 0.0, 90.0, "2, 3", 90.0),
    ],
)
def test_planes_across_the_slip(
    sides: int, turn: float, direction: float, planes: str, better: float
) -> None:
    """The remark names the planes that face across the slip, and a turn for which there are none."""
    [found] = remarks.remarks(TABLE_2, Pattern.regular(sides, 10.0, turn=turn), direction=direction)
    assert found.good is not bool(planes)
    if planes:
        assert found.text.endswith(f": {planes}; expected another turn, best {better:g} degrees")
        [clear] = remarks.remarks(TABLE_2, Pattern.regular(sides, 10.0, turn=better), direction=direction)
        assert clear.good


def test_bad_direction() -> None:
    """A direction that is no angle is an error; a flat joint has no plane that faces anywhere."""
    with pytest.raises(ValueError, match="direction = nan: expected a finite angle"):
        remarks.remarks(TABLE_2, RT.pattern, direction=np.nan)
    assert remarks.remarks(TABLE_2, FLAT, direction=90.0)[0].good


@pytest.mark.parametrize("eta", [0.5, 0.9, 0.99])
def test_snap_back(eta: float) -> None:
    """The limit is the size at which element and joint in series snap back, computed with the law."""
    material = Material(sigma0=3.0, Gc=0.3, eta=eta, mu=0.5)
    modulus, s_f = 30000.0, 0.2
    opening = np.linspace((1 - eta) * s_f, s_f, 50)
    path = np.column_stack([opening, np.zeros((50, 2))])
    traction = Interface(material, RT.pattern).replay(path).traction[:, 0]

    def turns_back(size: float) -> bool:
        return bool(np.any(np.diff(opening + traction * size / modulus) < 0))

    limit = 2 * eta * modulus * 0.3 / 9.0
    for share in (0.999, 1.001):
        found = remarks.remarks(material, RT.pattern, modulus=modulus, size=share * limit)
        assert found[0].good is not turns_back(share * limit)
        assert turns_back(share * limit) is (share > 1)
        assert f"{limit:.4g} in mode I" in found[0].text


def test_cohesive_zone_and_compliance() -> None:
    """The number of elements in the cohesive zone and the elastic opening follow from E, Gc, sigma0 and K."""
    stiffness = float(RT.update([[0.0, 0, 0]]).tangent[0, 0, 0])
    for size, good in ((333.0, True), (334.0, False)):
        found = remarks.remarks(TABLE_2, RT.pattern, modulus=30000.0, size=size)
        assert found[1].good is good
        assert f"= 1000, {1000 / size:.3g} elements" in found[1].text
        assert f" {30000 / (stiffness * size):.3g} times" in found[2].text


def test_what_is_not_fine_is_a_warning() -> None:
    """A problem is in the block and a ModelWarning; a passed check is in the block only."""
    with pytest.warns(ModelWarning) as caught:
        card = RT.card("abaqus", stress=-10.0, modulus=30000.0, size=2000.0)
    assert [str(w.message).split()[0] for w in caught] == ["a", "element", "cohesive"]
    assert card.count("** WARNING: ") == 3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "WARNING" not in RT.card("calculix", stress=-0.1, modulus=30000.0, size=20.0)


# --- the command ----------------------------------------------------------


def test_command(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The block of Interface.card, on standard output or in a file; warnings go elsewhere."""
    path = write(CASE)
    assert main(["card", "abaqus", path, "--name", "JOINT", "--sigma-N", "-10"]) == 0
    out, err = capsys.readouterr()
    with pytest.warns(ModelWarning):
        assert out == RT.card("abaqus", name="JOINT", stress=-10.0)
    assert err.startswith("asperity: warning: a plane that carries") and err.count("\n") == 1
    assert main(["card", "calculix", path, "--h", "0.1", "--r", "1e-9", "-o", "card.inp"]) == 0
    assert capsys.readouterr().out == ""
    assert Path("card.inp").read_text(encoding="utf-8") == RT.card("calculix", h=0.1, r=1e-9)
    cracked = write(CASE + "&initial traction = -1.0, 0.0, 0.0, damage = 1.0 /\n")
    assert main(["card", "abaqus", cracked, "--name", "JOINT"]) == 0
    out, err = capsys.readouterr()
    assert out == RT.card("abaqus", name="JOINT")
    assert "&initial: not in the block" in err and err.count("\n") == 1


DEFAULTS = {"h": 1.0, "map": 0, "dalpha": 0.0, "r": 0.0}
"""A card has the PROPS of its host."""


def test_run_of_a_case(folder: Path) -> None:
    """The block has regular or listed planes, host constants of a replay, and a value of a sweep."""
    run = read_run(Path(write(CASE)))
    assert (run.interface, run.of_host()) == (RT, DEFAULTS)
    assert list(run.props) == RT.props().tolist()
    listed = "&pattern normals = 1.0, 0.0, 0.0, 1.0, 0.5, 0.0, weights = 0.25, 0.75 /"
    replay = "&replay file = 'a.csv', through = 'umat', ntens = 3, h = 0.5, map = 1, dalpha = 0.1 /"
    Path("a.csv").write_text("s_N,s_Tx,s_Ty\n0.1,0,0\n", encoding="utf-8")
    text = CASE.replace("&pattern sides = 2, theta = 30.0 /", listed)
    run = read_run(Path(write(re.sub("&step.*/", replay, text))))
    assert run.pattern == Pattern.planes([[1, 0, 0], [1, 0.5, 0]], [0.25, 0.75])
    assert run.of_host() == DEFAULTS | {"h": 0.5, "map": 1, "dalpha": 0.1} and run.steps == ()
    swept = CASE.replace("theta = 30.0", "theta = Angle") + "&sweep name = 'angle', values = 0.0, 30.0 /"
    run = read_run(Path(write(swept)), "30")
    assert (run.value, run.interface) == (30.0, RT)
    guarded = CASE.replace("mu = 0.5", "mu = 0.5, guard = .false.")
    assert read_run(Path(write(guarded))).interface == RT
    guarded = CASE.replace("mu = 0.5", "mu = 0.5, guard = .true.")
    assert read_run(Path(write(guarded))).material == replace(RT.material, guard=True)
    for path in all_cases().values():
        texts = path.read_text(encoding="utf-8")
        if "&sweep" not in texts or re.search(r"name = '(theta_L|sigma_N)'", texts):
            assert read_run(path).interface.n_planes >= 1


@pytest.mark.parametrize(
    ("old", "new", "value", "message"),
    [
        ("mu = 0.5", "mu = -0.5", None, "case.nml:2: &material: mu = -0.5: expected >= 0"),
        ("mu = 0.5", "nu = 0.5", None, "&material: nu = 0.5: unknown name, expected one of sigma0, Gc"),
        (", mu = 0.5", "", None, "&material: mu is missing"),
        ("mu = 0.5", "mu = 0.5, guard = 2", None, "&material: guard = 2"),
        ("theta = 30.0", "theta = steep", None, '&pattern: theta = "steep": expected a number'),
        ("sides = 2, ", "", None, r"&pattern: expected sides \(0: flat\), or normals and weights"),
        ("sides = 2", "sides = 2.5", None, "&pattern: sides = 2.5: expected a whole number"),
        ("sides = 2", "sides = 2, weights = 1.0", None, "sides, theta, flat, turn do not go with normals"),
        ("sides = 2, theta = 30.0", "normals = 1.0, 0.0, weights = 1.0", None, "2 values of normals"),
        ("mu = 0.5", "mu = 0.5", "3", "--value 3: expected where a constant is the name of a sweep only"),
        ("-1.0,", "x, /\n&sweep name = 'x', values = -1, -2 /\n&step", "-1", "--value -1: expected where"),
        ("0.5 /", "m /\n&sweep name = 'm', values = 1, 2 /", "3", "--value 3: expected one of m, as 1, 2"),
        ("0.5 /", "m /\n&sweep name = 'm', values = 1, 2 /", "x", "--value = 'x': expected a finite number"),
    ],
)
def test_bad_cases(old: str, new: str, value: str | None, message: str, folder: Path) -> None:
    """The messages of the driver have file, line, group and name."""
    with pytest.raises(ValueError, match=message):
        read_run(Path(write(CASE.replace(old, new))), value)


def test_command_errors(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Errors give exit code 1 and one line."""
    swept = CASE.replace("mu = 0.5", "mu = m") + "&sweep name = 'm', values = 0.1, 0.2 /"
    assert main(["card", "abaqus", write(swept)]) == 1
    message = "asperity: case.nml: --value is missing: expected one for m, as 0.1, 0.2\n"
    assert capsys.readouterr().err == message
    assert main(["card", "kratos", write(CASE), "--map", "1"]) == 1
    assert capsys.readouterr().err.startswith("asperity: map = 1: expected 0 for kratos")
