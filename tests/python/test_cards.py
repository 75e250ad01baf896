"""Material blocks of each host, the checks of a model, the command."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, contract
from asperity.case_files import read_run
from asperity.cli import main
from asperity.installed import all_cases, named_case, named_library
from asperity.model_checks import check_model

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
RT = Interface(TABLE_2, Pattern.regular(2, 30.0))
FLAT = Pattern.regular(0, 0.0)
PROPS = contract.N_FIXED_PROPS
OWNERS = ("law", "pattern", "host", "numerics")
CASE = """&case title = 'joint' /
&material SIGMA0 = 3.0d0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 2, theta = 30.0 /
&step t_N = -1.0, increments = 100 /
"""


def write(text: str) -> Path:
    """A case file in the current folder."""
    Path("case.nml").write_text(text, encoding="utf-8")
    return Path("case.nml")


def keywords(card: str) -> dict[str, list[str]]:
    """Data lines of an input file by keyword line, comments left out."""
    entries: dict[str, list[str]] = {}
    for line in card.splitlines():
        if line.startswith("*") and not line.startswith("**"):
            entries[line] = data = []
        elif not line.startswith("**"):
            data.append(line)
    return entries


def numbers(lines: list[str]) -> list[float]:
    """Numbers of data lines."""
    return [float(cell) for line in lines for cell in line.split(",")]


# --- blocks ---------------------------------------------------------------


def test_abaqus_standard() -> None:
    """Section and material have the same name, state variables have names, and no keyword deletes points."""
    card = RT.card("abaqus", name="JOINT", h=0.5)
    entries = keywords(card)
    material = f"*User Material, constants={PROPS}, unsymm"
    section = "*Cohesive Section, elset=JOINT, material=JOINT, response=TRACTION SEPARATION"
    section += ", thickness=SPECIFIED"
    assert list(entries) == ["*Material, name=JOINT", material, "*Depvar", section]
    assert numbers(entries[material]) == RT.props(h=0.5).tolist()
    assert max(line.count(",") for line in entries[material]) < 8
    names = contract.statev_names(3)
    rows = [f"{i}, {name}, {name}" for i, name in enumerate(names, 1)]
    assert entries["*Depvar"] == [f"{len(names)},", *rows] and entries[section] == ["0.5,"]
    assert "COH3D8" in card and "COH2D4" not in card and "COH2D4" in RT.card("abaqus", dimension=2)
    assert max(map(len, card.splitlines())) < 256


def test_abaqus_explicit() -> None:
    """The explicit block has a density and no unsymmetric solver; SDV 6 to 8 are the separation."""
    card = RT.card("abaqus", explicit=True, density=2.5e-9)
    entries = keywords(card)
    assert entries["*Density"] == ["2.5e-09,"] and "double=both" in card
    assert f"*User Material, constants={PROPS}" in entries and "unsymm" not in card
    assert entries["*Depvar"][6] == "6, separation_N, separation_N"


def test_abaqus_contact() -> None:
    """The block of contact pairs has constants and counts; it refuses what UINTER and VUINTER do not get."""
    card = RT.card("abaqus", name="BED", contact=True)
    (keyword,) = keywords(card)
    assert keyword == f"*Surface Interaction, name=BED, user, depvar=17, properties={PROPS}, unsymm"
    assert numbers(keywords(card)[keyword]) == RT.props().tolist() and "** STATEV 17: s_dih_3" in card
    explicit = RT.card("abaqus", name="BED", contact=True, explicit=True)
    (keyword,) = keywords(explicit)
    assert "unsymm" not in keyword and "constraint=PENALTY" in explicit and "double=both" in explicit
    for options, message in (
        ({"explicit": True, "density": 1.0}, "density = 1: expected none for contact pairs"),
        ({"explicit": True, "implex": 0.1}, r"implex = 0\.1: expected 0 for Abaqus/Explicit"),
        ({"h": 0.5}, r"h = 0\.5: expected 1 for contact pairs"),
        ({"water": 1}, "water = 1: expected 0 for contact pairs"),
    ):
        with pytest.raises(ValueError, match=message):
            RT.card("abaqus", contact=True, **options)
    with pytest.raises(ValueError, match="contact: expected for abaqus only, not for calculix"):
        RT.card("calculix", contact=True)


def test_calculix_section() -> None:
    """The block has a solid section of the same material and states the thickness."""
    card = RT.card("calculix", name="joint", h=0.01)
    entries = keywords(card)
    assert entries["*SOLID SECTION, ELSET=JOINT, MATERIAL=ABAQUSJOINT"] == [] and entries["*DEPVAR"] == ["17"]
    assert "thickness h = 0.01" in card and "C3D8R" in card
    assert "TYPE=SOLUTION, USER" in card  # see harness/hosts/calculix
    # CalculiX misreads a full last line of constants
    constants = entries["*USER MATERIAL, CONSTANTS=21"]  # the most that it has room for
    assert len(constants[-1].split(",")) < 8 and numbers(constants) == RT.props(h=0.01)[:21].tolist()
    assert all(name in card for name in contract.statev_names(3)) and "*MATERIAL, NAME=ABAQUSJOINT\n" in card


@pytest.mark.parametrize(
    ("constant", "of_card"), [({"crush": 0.1}, {}), ({"c": 0.1}, {}), ({}, {"implex": 0.1})]
)
def test_more_constants_of_calculix(constant: dict[str, float], of_card: dict[str, float]) -> None:
    """Constants beyond the room of CalculiX come with a warning and a line; defaults are left out."""
    law = Interface(replace(TABLE_2, **constant), RT.pattern)
    (name,) = constant | of_card
    with pytest.warns(ModelWarning, match=f"^{name}: .* room for 21 constants .*: use the ccx of install.sh"):
        card = law.card("calculix", **of_card)
    constants = keywords(card)[f"*USER MATERIAL, CONSTANTS={contract.N_USED_PROPS}"]
    assert numbers(constants) == law.props(**of_card)[: contract.N_USED_PROPS].tolist()
    assert len(constants[-1].split(",")) < 8
    assert "has room for 21 constants" in card and "has room" not in RT.card("calculix")


@pytest.mark.parametrize("host", ["abaqus", "calculix"])
def test_numbers_have_twenty_characters(host: str) -> None:
    """Abaqus and CalculiX read no more of one, and CalculiX drops the rest without a word."""
    draw = np.random.default_rng(5)
    for stiffness in (200.0, *draw.uniform(1e4, 1e5, 50).tolist()):  # 8e-05 needs 21 characters for 200
        law = Interface(Material.from_joint(kn=stiffness, ks=0.4 * stiffness, mu=0.5), FLAT)
        entries = keywords(law.card(host, h=1e-5 / 3.0))
        lines = next(lines for keyword, lines in entries.items() if "constants" in keyword.lower())
        words = [word.strip() for line in lines for word in line.split(",")]
        assert max(map(len, words)) <= 20
        assert numbers(lines) == pytest.approx(law.props(h=1e-5 / 3.0)[: len(words)], rel=1e-13)


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
    assert material["constitutive_law"]["name"] == law and element in block["elements"]
    expected = {  # see harness/hosts/kratos
        "GEO_DRAINAGE_TYPE": "constant_pw_field", "BIOT_COEFFICIENT": 0.0,
        "UDSM_NAME": str(named_library("asperity_kratos")),
        "UMAT_PARAMETERS": RT.props().tolist(), "STATE_VARIABLES": [0.0] * RT.nstatv,
    }  # fmt: skip
    assert expected.items() <= material["Variables"].items()
    assert tuple(block["state_variables"].values()) == contract.statev_names(RT.n_planes)
    assert block["notes"][-2].startswith("UDSM_NAME is the commit adapter")
    assert "Kratos passes no initial stress to a UMAT" in block["notes"][-1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_ogs_patch(dimension: int) -> None:
    """The patch has a library that exists, all properties of its behaviour and right-handed axes."""
    joint = Interface(replace(TABLE_2, kc=20.0), Pattern.regular(5, 30.0, flat=0.25, turn=10.0))
    root = ElementTree.fromstring(joint.card("ogs", name="JOINT", dimension=dimension, h=0.1, r=1e-9))
    relation, frame, parameters = root.findall("add")
    assert Path(relation.findtext("constitutive_relation/library", "")).is_file()
    assert relation.findtext("constitutive_relation/behaviour") == "AsperityLayer6"
    values = {parameter.findtext("name"): parameter.findtext("values", "") for parameter in parameters}
    given = {entry.get("name"): entry.get("parameter", "") for entry in relation.iter("material_property")}
    names = [row.name for row in contract.owned(*OWNERS) if row.name not in ("map", "water", "implex")]
    assert given == {name: f"JOINT_{name}" for name in names}
    props = joint.props(h=0.1, r=1e-9)
    expected = {name: props[contract.index(name)] for name in names}
    assert {name: float(values[given[name]]) for name in names} == expected
    axes = np.array([values[vector.text].split() for vector in frame[0]], dtype=float)
    assert axes.shape == (dimension, dimension) and np.linalg.det(axes) == 1.0
    assert axes[0].tolist() == [0.0, 0.0, 1.0][-dimension:]
    assert "AsperityLayer33" in Interface(TABLE_2, Pattern.regular(32, 30.0)).card("ogs")


def test_fenicsx_law() -> None:
    """The block is Python and makes the same law."""
    laws: dict[str, Interface] = {}
    exec(RT.card("fenicsx", name="bed"), laws)
    assert laws["bed"] == RT


def test_oofem_record() -> None:
    """One record with all constants, the number of state variables and a library that exists."""
    *comments, record = RT.card("oofem", name="JOINT", h=0.1).splitlines()
    assert all(line.startswith("# ") for line in comments)
    start = f"AbaqusUserMaterial 1 d 0.0 numstate 17 properties {PROPS} "
    assert record.startswith(start)
    assert [float(x) for x in record[len(start) :].split()[:PROPS]] == RT.props(h=0.1).tolist()
    m = re.search(r'umat "(.*)" name "JOINT"$', record)
    assert m and Path(m[1]).is_file()


def test_akantu_section() -> None:
    """A section of the input file with every constant of the law and the pattern."""
    joint = Interface(replace(TABLE_2, kc=20.0, height=2.0, W0=1.0), Pattern.regular(5, 30.0, turn=10.0))
    lines = [line for line in joint.card("akantu", name="JOINT").splitlines() if not line.startswith("#")]
    assert lines[:2] == ["material asperity [", "  name = JOINT"] and lines[-1] == "]"
    values = {name: float(value) for name, value in (line.strip().split(" = ") for line in lines[2:-1])}
    props = joint.props()
    assert values == {row.name: props[row.index - 1] for row in contract.owned("law", "pattern")}


PATH = """&step t_N = -0.5, increments = 10 /
&step slip = 0.2, -0.1, direction = 30.0, increments = 20, 30, cycles = 2, time = 3.0 /
&step slip = 0.3, increments = 5 /
"""


@pytest.mark.usefixtures("folder")
def test_mtest_input(said: Callable) -> None:
    """The input has all properties and a library that exists; its evolutions are the path of the driver."""
    case = write(CASE.replace("&step t_N = -1.0, increments = 100 /\n", PATH))
    text, _ = said("card mtest case.nml")
    assert Path(re.findall(r"@Behaviour<generic> '(.*)' 'AsperityJoint3';", text)[0]).is_file()
    entries = re.findall(r"@MaterialProperty<constant> '(\w+)' (.*);", text)
    rows = [row for row in contract.owned(*OWNERS) if row.name not in ("map", "h", "r", "water", "implex")]
    expected = {row.name: RT.props()[row.index - 1] for row in rows}
    assert {name: float(value) for name, value in entries} == expected
    ends = [(float(end), int(n)) for end, n in re.findall(r"([\d.]+) in (\d+)", text.split("@Times")[1])]
    parts = zip([(0.0, 0), *ends[:-1]], ends, strict=True)
    times = np.concatenate([[0.0], *(np.linspace(a, b, n + 1)[1:] for (a, _), (b, n) in parts)])
    history = read_run(case).history()
    curves = {"Tn": history.traction[:, 0], "Ut1": history.separation[:, 1], "Ut2": history.separation[:, 2]}
    imposed = dict(re.findall(r"@Imposed\w+ '(\w+)' \{(.*)\};", text))
    assert list(imposed) == list(curves)
    for name, values in curves.items():
        pairs = np.array([pair.split(" : ") for pair in imposed[name].split(", ")], dtype=float)
        rows = np.interp(times, *pairs.T)[-len(values) :]
        # a traction is met within the tolerance of the driver, 1e-7 of the strength
        assert rows == pytest.approx(values, rel=0, abs=1e-7), name


# --- checks ---------------------------------------------------------------


def test_locking_and_contact() -> None:
    """The card warns of locking of the steepest listed plane, and of a soft contact under the pressure."""
    assert not check_model(TABLE_2, RT.pattern)
    [locking] = check_model(TABLE_2, Pattern.planes([[1, 0, 0], [1, 0, -3]], [0.9, 0.1]))
    assert not locking.good and "mu tan(theta) = 1.5 of the steepest plane" in locking.text
    assert check_model(TABLE_2, FLAT, stress=-10.0) == []
    [soft] = check_model(TABLE_2, RT.pattern, stress=-10.0)
    assert not soft.good and "closes by 1 s_f" in soft.text
    assert not check_model(replace(TABLE_2, kc=20.0), RT.pattern, stress=-10.0)


@pytest.mark.parametrize(
    ("sides", "turn", "direction", "planes", "better"),
    [
        (4, 0.0, 0.0, "3, 5", 45.0),
        (4, 1.1, 0.0, "", 0.0),
        (6, 30.0, 0.0, "3, 6", 0.0),
        (3, 0.0, 30.0, "3", 30.0),
    ],
)
def test_planes_across_the_slip(
    sides: int, turn: float, direction: float, planes: str, better: float
) -> None:
    """The check names the planes that face across the slip, and a turn for which there are none."""
    [warning] = check_model(TABLE_2, Pattern.regular(sides, 10.0, turn=turn), direction=direction)
    assert warning.good is not bool(planes)
    if planes:
        assert warning.text.endswith(f": {planes}; expected another turn, best {better:g} degrees")
        [clear] = check_model(TABLE_2, Pattern.regular(sides, 10.0, turn=better), direction=direction)
        assert clear.good


@pytest.mark.parametrize("eta", [0.5, 0.9, 0.99])
def test_snap_back(eta: float) -> None:
    """The limit is the size at which element and joint in series snap back, computed with the law."""
    material = Material(sigma0=3.0, Gc=0.3, eta=eta, mu=0.5)
    modulus, s_f = 30000.0, 0.2
    opening = np.linspace((1 - eta) * s_f, s_f, 50)
    path = np.column_stack([opening, np.zeros((50, 2))])
    traction = Interface(material, RT.pattern).replay(path).traction[:, 0]
    limit = 2 * eta * modulus * 0.3 / 9.0
    for share in (0.999, 1.001):
        size = share * limit
        warnings = check_model(material, RT.pattern, modulus=modulus, size=size)
        turns_back = bool(np.any(np.diff(opening + traction * size / modulus) < 0))
        assert warnings[0].good is not turns_back and turns_back is (share > 1)
        assert f"{limit:.4g} in mode I" in warnings[0].text


def test_cohesive_zone_and_compliance() -> None:
    """The number of elements in the cohesive zone and the elastic opening follow from E, Gc, sigma0 and K."""
    for size, good in ((333.0, True), (334.0, False)):
        warnings = check_model(TABLE_2, RT.pattern, modulus=30000.0, size=size)
        assert warnings[1].good is good and f"= 1000, {1000 / size:.3g} elements" in warnings[1].text
        assert f" {30000 / (TABLE_2.K * size):.3g} times" in warnings[2].text


def test_what_is_not_fine_is_a_warning() -> None:
    """A problem is in the block and a ModelWarning; a passed check is in the block only."""
    with pytest.warns(ModelWarning) as caught:
        card = RT.card("abaqus", stress=-10.0, modulus=30000.0, size=2000.0)
    assert [str(w.message).split()[0] for w in caught] == ["a", "element", "cohesive"]
    assert card.count("** WARNING: ") == 3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "WARNING" not in RT.card("calculix", stress=-0.1, modulus=30000.0, size=20.0)


def test_error_of_implex_without_bond() -> None:
    """IMPL-EX takes its error over sigma0, no strength of a joint without bond: in metres it is large."""
    for length, stress in ((1.0, 1.0), (1e-3, 1e6)):
        material = Material.from_joint(kn=200.0 * stress / length, ks=80.0 * stress / length, mu=0.5)
        checks = check_model(material, FLAT, stress=-1.0 * stress, implex=0.1)
        assert (
            checks[-1].good is (length == 1.0) and f"mu p {'is' if length == 1.0 else '='}" in checks[-1].text
        )
        assert len(check_model(material, FLAT, stress=-1.0 * stress)) == len(checks) - 1
        with pytest.warns(ModelWarning, match="IMPL-EX: e_t is over .* give the largest compression"):
            Interface(material, FLAT).card("abaqus", implex=0.1)
    assert len(check_model(TABLE_2, FLAT, implex=0.1)) == len(check_model(TABLE_2, FLAT))


# --- the command ----------------------------------------------------------


def test_command(folder: Path, said: Callable) -> None:
    """The block of Interface.card, on standard output or in a file; warnings go elsewhere."""
    write(CASE)
    out, err = said("card abaqus case.nml --name JOINT --sigma-N -10")
    with pytest.warns(ModelWarning):
        assert out == RT.card("abaqus", name="JOINT", stress=-10.0)
    assert err.startswith("asperity: warning: a plane that carries") and err.count("\n") == 1
    assert said("card calculix case.nml --h 0.1 --r 1e-9 -o card.inp")[0] == ""
    assert (folder / "card.inp").read_text(encoding="utf-8") == RT.card("calculix", h=0.1, r=1e-9)
    write(CASE + "&initial traction = -1.0, 0.0, 0.0, damage = 1.0 /\n")
    out, err = said("card abaqus case.nml --name JOINT")
    assert out == RT.card("abaqus", name="JOINT")
    assert "&initial: not in the block" in err and err.count("\n") == 1


DEFAULTS = {"h": 1.0, "map": 0, "dalpha": 0.0, "r": 0.0, "water": 0, "implex": 0.0}
"""A card has the PROPS of its host."""


@pytest.mark.usefixtures("folder")
def test_run_of_a_case() -> None:
    """The block has regular or listed planes, host constants of a replay, and a value of a sweep."""
    run = read_run(write(CASE))
    assert (run.interface, run.of_host()) == (RT, DEFAULTS) and list(run.props) == RT.props().tolist()
    listed = "&pattern normals = 1.0, 0.0, 0.0, 1.0, 0.5, 0.0, weights = 0.25, 0.75 /"
    replay = "&replay file = 'a.csv', ntens = 3, h = 0.5, map = 1, dalpha = 0.1 /"
    Path("a.csv").write_text("s_N,s_Tx,s_Ty\n0.1,0,0\n", encoding="utf-8")
    text = CASE.replace("&pattern sides = 2, theta = 30.0 /", listed)
    run = read_run(write(re.sub("&step.*/", replay, text)))
    assert run.pattern == Pattern.planes([[1, 0, 0], [1, 0.5, 0]], [0.25, 0.75])
    assert run.of_host() == DEFAULTS | {"h": 0.5, "map": 1, "dalpha": 0.1} and run.steps == ()
    swept = CASE.replace("theta = 30.0", "theta = Angle") + "&sweep name = 'angle', values = 0.0, 30.0 /"
    run = read_run(write(swept), "30")
    assert (run.value, run.interface) == (30.0, RT)
    guarded = read_run(write(CASE.replace("mu = 0.5", "mu = 0.5, guard = .true."))).material
    assert guarded == replace(TABLE_2, guard=True)
    for path in all_cases().values():
        texts = path.read_text(encoding="utf-8")
        if "&sweep" not in texts or re.search(r"name = '(theta_L|sigma_N)'", texts):
            assert read_run(path).interface.n_planes >= 1


def test_committed_mtest_input(capsys: pytest.CaptureFixture[str]) -> None:
    """The file for readers is what `asperity card` prints, but for comments and the folder of the library."""
    assert main(["card", "mtest", str(named_case("figure05b"))]) == 0
    printed = capsys.readouterr().out

    def plain(text: str) -> list[str]:
        return [re.sub(r"'/.*/", "'", line) for line in text.splitlines() if not line.startswith("//")]

    file = Path(__file__).parents[2] / "harness" / "hosts" / "mtest" / "figure05b.mtest"
    assert plain(file.read_text(encoding="utf-8")) == plain(printed)
