"""Water pressure in a joint: the total normal traction is that of the law less the pressure.

test_water_hosts.py has UMAT and VUMAT.
"""

from __future__ import annotations

import contextlib
import warnings
from pathlib import Path

import numpy as np
import pytest
from asperity import (
    EquilibriumLost,
    ForeignUmat,
    History,
    Interface,
    Material,
    Pattern,
    Step,
    library,
    read_case,
)
from asperity.cli import main
from asperity.installed import driver
from asperity.steps import Point
from support_driver import call

# CTest has no markers, and pytest need not repeat it
pytestmark = pytest.mark.long

MU, PRESSURE, WATER = 0.5, 1.0, 0.4
JOINT = Interface(Material(3.0, 0.3, 0.9, MU, kc=100.0, damage0=1.0), Pattern.regular(0, 0.0))
"""Flat joint without bond, of which everything is known in closed form."""
ROUGH = Interface(Material(3.0, 0.3, 0.9, MU, kc=20.0), Pattern.regular(4, 30.0, turn=10.0))
STIFFNESS = 100.0 * JOINT.material.K
ROUNDING = 1.0e-12
"""Relative rounding of sums of a few tractions."""


# --- Python and the driver ----------------------------------------------------------------------------------


def test_friction_acts_on_what_water_leaves() -> None:
    """A joint under a constant total pressure slides at mu (pressure - water) and closes less."""
    press = Step(t_N=-PRESSURE, increments=10)
    test = JOINT.run([press, Step(p=WATER, increments=10), Step(slip=0.1, increments=40)])
    assert test.traction[-1] == pytest.approx([-PRESSURE, MU * (PRESSURE - WATER), 0.0], rel=1e-9)
    assert test.dilation[[9, 19]] == pytest.approx([-PRESSURE / STIFFNESS, -(PRESSURE - WATER) / STIFFNESS])
    assert test.p[[9, 14, 19, -1]] == pytest.approx([0.0, WATER / 2, WATER, WATER], rel=ROUNDING)
    # the run goes on with its water; it is let off at a constant total traction
    again = JOINT.run([Step(t_N=-PRESSURE, p=0.0, increments=5), Step(slip=0.2, increments=5)], test.end)
    assert again.traction[-1] == pytest.approx([-PRESSURE, MU * PRESSURE, 0.0], rel=1e-9)


def test_an_open_joint_carries_the_water() -> None:
    """Where the water exceeds the pressure the sides part: under a prescribed opening t_N = -p."""
    test = JOINT.run(Step(s_N=0.05, p=[WATER, 2.0 * WATER], increments=4))
    assert test.traction[[3, 7], 0] == pytest.approx([-WATER, -2.0 * WATER], rel=ROUNDING)
    with pytest.raises(EquilibriumLost, match=r"none found: .* water pressure"):
        JOINT.run([Step(t_N=-PRESSURE), Step(p=1.5 * PRESSURE)])


def test_paths_with_water_are_those_of_effective_tractions() -> None:
    """Steps, springs, a tolerance and a branch: prescribed t_N and p are t_N + p without water."""
    slide = {"slip": [0.15, 0.05], "increments": 40}
    for more in ({}, {"k_N": 5.0}, {"p": [0.4, 0.9]}):
        p = np.array(more.get("p", [WATER, WATER]))
        with_water = ROUGH.run([Step(t_N=-1.0, p=WATER), Step(t_N=[-1.2, -2.0], **slide, **more)])
        spring = {name: more[name] for name in more if name == "k_N"}
        without = ROUGH.run([Step(t_N=-1.0 + WATER), Step(t_N=np.array([-1.2, -2.0]) + p, **slide, **spring)])
        assert with_water.separation == pytest.approx(without.separation, rel=1e-9, abs=1e-12)
        assert with_water.traction[:, 0] + with_water.p == pytest.approx(without.traction[:, 0], rel=1e-9)
        assert with_water.work == pytest.approx(without.work, rel=1e-9)
    refined = ROUGH.run([Step(t_N=-1.0, p=WATER), Step(slip=0.2)], tolerance=1e-3)
    coarse = ROUGH.run([Step(t_N=-1.0 + WATER), Step(slip=0.2)], tolerance=1e-3)
    assert refined.traction[-1, 1] == pytest.approx(coarse.traction[-1, 1], rel=2e-3)
    assert refined.p[-1] == pytest.approx(WATER, rel=ROUNDING)
    branches = (
        ROUGH.run([Step(t_N=t_N, p=p), Step(slip=0.2, follow="branch")])
        for t_N, p in ((-1.0, WATER), (-1.0 + WATER, None))
    )
    assert np.subtract(*(branch.tau[-1] for branch in branches)) == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize(
    ("path", "warned"),
    [
        ([Step(t_N=2.5, p=1.0, increments=1)], True),
        ([Step(t_N=-1.0, increments=1), Step(p=[0.5, 4.2], increments=[1, 1])], True),
        ([Step(t_N=3.5, increments=1)], True),
        ([Step(t_N=2.0, p=0.5, increments=1)], False),
        ([Step(t_N=1.0, increments=1), Step(s_N=0.0, increments=1), Step(p=2.5, increments=1)], False),
    ],
)
def test_tension_beyond_the_strength_counts_the_water(path: list, warned: bool) -> None:
    """A prescribed t_N + p above sigma0 = 3 gives a warning, as in the driver."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with contextlib.suppress(EquilibriumLost):
            Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(0, 0.0)).run(path)
    assert any("times the strength" in str(warning.message) for warning in caught) == warned


def test_points_and_initial_states() -> None:
    """Update gives total tractions, the tangent and the state are untouched; an initial traction is total."""
    s, p = np.array([[-0.001, 0.02, 0.0], [0.01, 0.0, 0.01]]), np.array([0.4, 0.0])
    wet, dry = ROUGH.update(s, p=p), ROUGH.update(s)
    assert np.array_equal(wet.traction, dry.traction - p[:, None] * [1.0, 0.0, 0.0])
    assert np.array_equal(wet.state, dry.state) and np.array_equal(wet.tangent, dry.tangent)
    start = ROUGH.initial([[-1.0, 0.2, 0.0]] * 2, p=p)
    assert np.array_equal(start[0], ROUGH.initial([-1.0 + 0.4, 0.2, 0.0]))
    at_rest = ROUGH.update(np.zeros((2, 3)), start, p=p).traction
    assert at_rest == pytest.approx(np.array([[-1.0, 0.2, 0.0]] * 2), rel=1e-10)
    wrong = (-0.1, "p = -0.1"), ([0.1, -2.0], r"p\[1\] = -2"), (np.nan, "p = nan"), ([1.0], "p has shape")
    rest = np.zeros((2, 3))
    for bad, words in wrong:
        for refused in (lambda p=bad: ROUGH.update(s, p=p), lambda p=bad: ROUGH.initial(rest, p=p)):
            with pytest.raises(ValueError, match=words):
                refused()
    out = np.full((1, 3), 0.4), np.zeros((1, ROUGH.nstatv)), np.zeros((1, 3, 3))
    with pytest.raises(ValueError, match=r"out\[0\] overlaps p"):
        ROUGH.update(s[:1], p=out[0][:, 0], out=out)
    with pytest.raises(ValueError, match=r"t_N = 0.2.*tension on a crack.*t_N is the total one and p"):
        JOINT.initial([-0.2, 0.0, 0.0], p=0.4)


@pytest.mark.parametrize("increments", [1, 2, 7, 100, 400])
@pytest.mark.parametrize("carried", [0.5, 0.3, -0.3, -1.0])
def test_water_takes_all_that_a_joint_carries(carried: float, increments: int) -> None:
    """An initial state is released to zero and beyond, by tractions and by water, without a loss."""
    start, slip = Point(ROUGH.initial([carried, 0.0, 0.0])), {"slip": 0.0, "increments": increments}
    for t_N in (0.0, -carried):
        test = ROUGH.run(Step(t_N=t_N, **slip), start)
        assert not test.lost and len(test) == increments
        assert test.traction[-1, 0] == pytest.approx(t_N, abs=1e-9)
    # to zero in the middle, then twice as far
    wet = Point(ROUGH.initial([-1.0, 0.0, 0.0], p=0.4), p=0.4)
    test = ROUGH.run([Step(t_N=-1.0, p=1.0, **slip), Step(p=1.6, **slip)], wet)
    assert not test.lost and test.p[[increments - 1, -1]] == pytest.approx([1.0, 1.6])
    assert test.traction[:, 0] == pytest.approx(-1.0, abs=1e-9)


CASE = f"""&case title = 'Water' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = {MU}, kc = 100.0, damage0 = 1.0 /
&pattern sides = 0 /
&initial traction = -{PRESSURE}, 0.0, 0.0, p = {WATER} /
&step t_N = -{PRESSURE}, slip = 0.1, increments = 20 /
&step p = 0.0, {WATER}, slip = 0.2, increments = 20 /
&expect t_N = -{PRESSURE}, t_Tx = {MU * (PRESSURE - WATER)}, tolerance = 1e-8 /
"""


def test_case_with_water(tmp_path: Path) -> None:
    """The driver has a column p; Python reads the case and gives the same rows."""
    (tmp_path / "wet.nml").write_text(CASE, encoding="utf-8")
    assert call(driver(), "wet.nml", folder=tmp_path).returncode == 0
    rows = History.from_csv(tmp_path / "wet.csv")
    assert rows.p[[0, 19, 39, 59]] == pytest.approx([WATER, WATER, 0.0, WATER], rel=ROUNDING, abs=1e-300)
    assert rows.tau[[19, 39, 59]] == pytest.approx(MU * (PRESSURE - rows.p[[19, 39, 59]]), rel=1e-9)
    (run,) = read_case(tmp_path / "wet.nml").runs
    history = run.history()
    assert np.array_equal(history.separation, rows.separation) and np.array_equal(history.p, rows.p)


def test_aperture(tmp_path: Path) -> None:
    """The driver and Python give the gap of the cubic law, which is a_min in a joint that is closed enough.

    The plane without bond closes by pressure over stiffness; the water opens it again.
    """
    a_0, a_min = 1.5 * PRESSURE / STIFFNESS, 1.2 * PRESSURE / STIFFNESS
    entries = f"title = 'Water', a_0 = {a_0!r}, a_min = {a_min!r}"
    (tmp_path / "wet.nml").write_text(CASE.replace("title = 'Water'", entries), encoding="utf-8")
    assert call(driver(), "wet.nml", folder=tmp_path).returncode == 0
    rows = History.from_csv(tmp_path / "wet.csv")
    carried = PRESSURE - rows.p
    # the run starts at s_N = 0 from the pressure of the initial state
    expected = np.maximum(a_min, a_0 - (carried - (PRESSURE - WATER)) / STIFFNESS)
    assert np.isclose(expected, a_min).any() and not np.isclose(expected, a_min).all()
    assert rows.aperture == pytest.approx(expected, rel=1e-6)
    (run,) = read_case(tmp_path / "wet.nml").runs
    history = run.history()
    assert (run.a_0, run.a_min) == (a_0, a_min) and np.array_equal(history.aperture, rows.aperture)
    history.to_csv(tmp_path / "again.csv")
    assert np.array_equal(History.from_csv(tmp_path / "again.csv").aperture, rows.aperture)
    last = history.after_step(1)
    assert np.array_equal(last.aperture, rows.aperture[20:]) and len(last) == 40
    # without a_0 and a_min it is the opening
    plain = run.interface.run(run.steps, run.state)
    assert np.array_equal(plain.aperture, np.maximum(0.0, plain.dilation))
    assert np.array_equal(plain.with_aperture(a_0, a_min).aperture, rows.aperture)


@pytest.mark.parametrize(
    ("a_0", "a_min", "words"),
    [
        (np.nan, 0.0, "a_0 = nan"),
        (np.inf, 0.0, "a_0 = inf"),
        (0.1, -1e-9, "a_min = -1e-09"),
        (0.1, np.nan, "a_min = nan"),
    ],
)
def test_bad_aperture(a_0: float, a_min: float, words: str, tmp_path: Path) -> None:
    """A gap that is no number, and a least one below zero, are named by Python and by the driver."""
    with pytest.raises(ValueError, match=rf"{words}: expected a finite length"):
        JOINT.run(Step(t_N=-PRESSURE)).with_aperture(a_0, a_min)
    entries = f"title = 'Water', a_0 = {a_0!r}, a_min = {a_min!r}"
    (tmp_path / "bad.nml").write_text(CASE.replace("title = 'Water'", entries), encoding="utf-8")
    done = call(driver(), "bad.nml", folder=tmp_path)
    assert done.returncode == 1 and f"bad.nml:1: &case: {words.split()[0]} = " in done.stderr


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("p = -1.0", "p = -1"),
        ("p = 1.0, nan", "p = 1.0, nan: expected a finite pressure >= 0"),
        ("p = 'a'", 'p = "a": '),
    ],
)
def test_bad_water_in_a_case(entry: str, message: str, tmp_path: Path) -> None:
    """A pressure that is negative or no number is named with its line."""
    (tmp_path / "bad.nml").write_text(CASE.replace(f"p = 0.0, {WATER}", entry), encoding="utf-8")
    done = call(driver(), "bad.nml", folder=tmp_path)
    assert done.returncode == 1
    assert f"bad.nml:6: &step: {message}" in done.stderr and "expected" in done.stderr


LOST = """&case title = 'Lifted by water' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 0 /
&step t_N = -1.0, p = 0.25 /
&step p = 6.0, increments = 20 /
"""


def test_a_failed_increment_with_water_is_repeated(tmp_path: Path) -> None:
    """The warning counts water on a constant t_N, and the case of the lost increment ends where it ended."""
    (tmp_path / "lost.nml").write_text(LOST, encoding="utf-8")
    first = call(driver(), "lost.nml", folder=tmp_path)
    again = call(driver(), "lost.failed.nml", folder=tmp_path)
    assert first.returncode == again.returncode == 2
    rows, row = (History.from_csv(tmp_path / name) for name in ("lost.csv", "lost.failed.csv"))
    assert np.array_equal(row.separation, rows.separation[-1:])
    # the flat bond carries sigma0 = 3: t_N = -1 and p = 6 ask for 5
    assert "the normal traction reaches 1.66667 times the strength" in first.stderr
    assert row.traction[-1, 0] == pytest.approx(rows.traction[-1, 0] + rows.p[-1], rel=1e-9)


def test_a_umat_of_others_goes_on_with_its_water() -> None:
    """A run by the UMAT as one of others, and a run from its end, are those of the law itself."""
    hosted = ForeignUmat(library(), 0.2, STIFFNESS, tuple(ROUGH.props()), ROUGH.nstatv)
    first, second = [Step(t_N=-1.0, p=WATER), Step(slip=0.05)], Step(t_N=-1.0, slip=0.1)
    runs = [(start := law.run(first), law.run(second, start.end)) for law in (hosted, ROUGH)]
    for theirs, own in zip(*runs, strict=True):
        assert theirs.p == pytest.approx(own.p, rel=ROUNDING)
        assert theirs.separation == pytest.approx(own.separation, rel=1e-9, abs=1e-12)
        assert theirs.traction == pytest.approx(own.traction, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("initial", "replay", "words"),
    [
        (", p = 0.5", "", "&initial: p = 0.5: expected 0 with &replay"),
        ("", ", water = 1", "&replay: water = 1: expected 0"),
    ],
)
def test_replays_have_no_water(initial: str, replay: str, words: str, tmp_path: Path) -> None:
    """A file of strains has no predefined field, so that water in a replay is refused."""
    head = CASE.partition("&initial")[0]
    text = f"{head}&initial traction = -1.0, 0.0, 0.0{initial} /\n&replay file = 'e.csv'{replay} /\n"
    (tmp_path / "case.nml").write_text(text, encoding="utf-8")
    (tmp_path / "e.csv").write_text("s_N,s_Tx,s_Ty\n0,0.001,0\n", encoding="utf-8")
    done = call(driver(), "case.nml", folder=tmp_path)
    assert done.returncode == 1
    assert words in done.stderr


# --- cards --------------------------------------------------------------------------------------------------


VIRGIN = CASE.replace("&initial traction = -1.0, 0.0, 0.0, p = 0.4 /", "&step t_N = -1.0, slip = 0.0 /")
"""The same case from a virgin joint."""


def test_mtest_input_with_water(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The pressure of a case is the external state variable of a wet behaviour, which a dry one has not."""
    (tmp_path / "wet.nml").write_text(VIRGIN, encoding="utf-8")
    assert main(["card", "mtest", str(tmp_path / "wet.nml")]) == 0
    text, errors = capsys.readouterr()
    assert "'AsperityWetJoint1';" in text and not errors
    line = "@ExternalStateVariable 'FluidPressure' {0.0 : 0.0, 1.0 : 0.0, 2.0 : 0.0, 2.5 : 0.0, 3.0 : 0.4};"
    assert line in text.splitlines()
    assert main(["card", "mtest", str(tmp_path / "wet.nml"), "--water", "1"]) == 0
    assert capsys.readouterr().out == text
    for water, words in ("0", "wet.nml: p, and --water 0: expected 1"), ("2", "water = 2: expected 0 or 1"):
        assert main(["card", "mtest", str(tmp_path / "wet.nml"), "--water", water]) == 1
        out, errors = capsys.readouterr()
        assert not out and words in errors
    (tmp_path / "dry.nml").write_text(VIRGIN.replace("p = 0.0, 0.4, ", ""), encoding="utf-8")
    assert main(["card", "mtest", str(tmp_path / "dry.nml")]) == 0
    dry = capsys.readouterr().out
    assert "'AsperityJoint1';" in dry and "FluidPressure" not in dry
    assert main(["card", "mtest", str(tmp_path / "dry.nml"), "--water", "1"]) == 0
    assert "'FluidPressure' {0.0 : 0.0, 1.0 : 0.0, 2.0 : 0.0, 3.0 : 0.0};" in capsys.readouterr().out


def test_castem_card_with_water(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The model of Cast3M passes the pressure beside the temperature to a wet joint."""
    (tmp_path / "wet.nml").write_text(VIRGIN, encoding="utf-8")
    assert main(["card", "cast3m", str(tmp_path / "wet.nml"), "--water", "1"]) == 0
    text, errors = capsys.readouterr()
    assert not errors and "'FCT_LOI' 'AsperityWetCastem1'" in text and "PARA = 'MOTS' 'T' 'PF' ;" in text
    assert "'C_VARINTER' STAT 'PARA_LOI' PARA" in text
    assert max(len(line) for line in text.splitlines() if not line.startswith("*")) <= 72
    assert main(["card", "cast3m", str(tmp_path / "wet.nml"), "--water", "2"]) == 1
    assert "water = 2: expected 0 or 1 for cast3m" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("host", "words"),
    [
        ("abaqus", "expected --water N, the number of the field that is the pressure"),
        ("kratos", "its elements carry the water, with BIOT_COEFFICIENT 1"),
        ("ogs", "its elements carry the water, in HYDRO_MECHANICS"),
        ("fenicsx", "pressures and flows of Conditions"),
        ("calculix", "calculix passes no field to the law"),
    ],
)
def test_a_block_without_the_water_of_its_case(
    host: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A case with water whose block has none is a warning that says how the host gets it."""
    (tmp_path / "wet.nml").write_text(CASE, encoding="utf-8")
    assert main(["card", host, str(tmp_path / "wet.nml")]) == 0
    assert f"wet.nml: p: the block has no water: {words}" in capsys.readouterr().err
    if host != "abaqus":
        assert main(["card", host, str(tmp_path / "wet.nml"), "--water", "1"]) == 1
        assert f"water = 1: expected 0 for {host}" in capsys.readouterr().err
    dry = CASE.replace(", p = 0.4", "").replace("p = 0.0, 0.4, ", "")
    (tmp_path / "dry.nml").write_text(dry, encoding="utf-8")
    assert main(["card", host, str(tmp_path / "dry.nml")]) == 0
    assert "no water" not in capsys.readouterr().err


def test_card_names_the_field() -> None:
    """Abaqus' block says which field is the water pressure, and only where there is water."""
    card = ROUGH.card("abaqus", water=3)
    assert "** *Field, variable=3 is the water pressure" in card
    # a remark for each block with water, not a finding of a check, which would be on standard error too
    assert "** Elements with a pore pressure (COH2D4P, COH3D8P)" in card and "WARNING" not in card
    assert "water pressure" not in ROUGH.card("abaqus")
