"""Runs and their results: load paths in Python, energies, planes, tables, pictures and texts of History."""

from __future__ import annotations

import doctest
import subprocess
import sys
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path

import asperity
import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern, Step, contract, load_path, steps
from asperity.history import COLUMNS, ENERGIES
from asperity.tools.plots import plot

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0), Pattern.regular(4, theta=30.0))
SLIPS = np.concatenate([np.linspace(0.0, 0.3, 61)[1:], np.linspace(0.3, -0.3, 121)[1:]])
NAMES = contract.statev_names(5)
EXAMPLES = ("interface", "steps", "case_files", "history", "material", "tools.fit.fitting",
            "tools.barton.envelope", "tools.surface.scan_files", "tools.uncertainty.spread")  # fmt: skip


@pytest.fixture(scope="module")
def history() -> History:
    """A slip with a reversal under pressure."""
    return JOINT.confined_slip(20.0, SLIPS, -1.0)


# --- runs -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples(name: str) -> None:
    """Examples of docstrings run."""
    failed, tried = doctest.testmod(import_module(f"asperity.{name}"))
    assert failed == 0 < tried


def test_names() -> None:
    """Each public name has a value, and Step has the entries of &step."""
    assert all(hasattr(asperity, name) for name in asperity.__all__)
    assert [part.name for part in fields(Step)] == [entry.name for entry in steps.entries()]


@pytest.mark.parametrize(
    "step",
    [Step(), Step(s_N=0.1, increments=7), Step(slip=[0.1, 0.2, 0.3], increments=[2, 5], cycles=3)],
    ids=["default", "one end", "lists and cycles"],
)
def test_length_is_the_number_of_rows(step: Step) -> None:
    """Lists, cycles and a shorter list of increments."""
    assert len(JOINT.run(step)) == len(step)


@pytest.mark.parametrize(
    "constants",
    [
        {},
        {"c": 3000.0, "damage0": 1.0},
        {"c": 300.0, "tau_v": 5.0},
        {"guard": True},
        {"W0": 1.0, "crush": 3.0},
    ],
    ids=["plain", "dashpot", "dashpot and viscous damage", "guard", "wear"],
)
def test_a_run_goes_on(constants: dict[str, float]) -> None:
    """The rows after any point of a run are those of a run from there."""
    joint = replace(JOINT, material=replace(JOINT.material, kc=20.0, **constants))
    press, slide = Step(t_N=-0.4, increments=10), {"direction": 20.0, "increments": 20}
    whole = joint.run([press, Step(slip=[0.1, 0.2], time=[1.0, 1.0], **slide)])
    first = joint.run([press, Step(slip=0.1, **slide)])
    rest = joint.run(Step(t_N=-0.4, slip=0.2, **slide), first.end)
    for name in ("separation", "traction", "state", "work"):
        np.testing.assert_allclose(getattr(rest, name), getattr(whole, name)[30:], rtol=0, atol=1e-9)


def test_traction_at_the_start() -> None:
    """A state without dashpot and guard has one traction: another one is an error, with the value."""
    end = JOINT.run(Step(t_N=-0.4, increments=10)).end
    with pytest.raises(ValueError, match=r"traction = t_N = -0\.5: expected -0\.4"):
        JOINT.run(Step(slip=0.1), replace(end, traction=(-0.5, 0.0, 0.0)))
    with pytest.raises(ValueError, match="traction = t_Tx = NaN: expected a finite traction"):
        JOINT.run(Step(slip=0.1), replace(end, traction=(-0.4, np.nan, 0.0)))


# --- results ----------------------------------------------------------------------------------------------


def test_planes_have_numbers(history: History) -> None:
    """The damage of the point is the mean of that of its planes; the slips are the state variables."""
    mean = sum(weight * history.alpha(k) for k, weight in enumerate(JOINT.pattern.weights, 1))
    assert np.allclose(mean, history.damage, rtol=0, atol=1e-14)
    for k in range(1, 6):
        first = NAMES.index(f"s_dit_{k}")
        assert np.array_equal(history.slip(k), history.state[:, first : first + 2])
    for bad in (0, 6, 1.0, True, "1"):
        with pytest.raises(ValueError, match=r"plane = .*: expected 1 to 5"):
            history.alpha(bad)  # type: ignore[arg-type]
    points = JOINT.update(np.array([[0.01, 0.05, 0.0], [0.0, 0.0, 0.0]]))
    assert np.array_equal(points.alpha(2), points.state[:, NAMES.index("alpha_2")])
    assert np.array_equal(points.damage, points.state[:, NAMES.index("damage")])
    assert points.rupture[0] > 0.0 == points.rupture[1]
    assert points.slip(1).shape == (2, 2) and points.stored.shape == points.friction.shape == (2,)


def test_wear_has_a_name(tmp_path: Path) -> None:
    """With W0 > 0 the worn share of a plane is a state variable; without it there is none."""
    material = Material(3.0, 0.3, 0.9, 0.5, kc=100.0, height=0.5, W0=1.0)
    worn = Interface(material, Pattern.regular(2, 30.0)).confined_slip(0.0, np.linspace(0.0, 0.4, 101), -1.0)
    names = contract.statev_names(3, True)
    assert worn.wears and worn.planes == 3
    assert np.array_equal(worn.worn(2), worn.state[:, names.index("worn_2")])
    assert max(worn.worn(k)[-1] for k in (1, 2, 3)) > 0.1 and np.all(np.diff(worn.worn(2)) >= 0.0)
    worn.to_csv(tmp_path / "worn.csv", planes=True)
    assert (tmp_path / "worn.csv").read_text(encoding="utf-8").splitlines()[0].endswith(names[-1])
    plain = JOINT.replay([[0.01, 0.0, 0.0]])
    assert not plain.wears
    with pytest.raises(ValueError, match="worn: expected a material whose facets wear"):
        plain.worn(1)


def test_texts_and_arrays(history: History) -> None:
    """The text of a result is one line; a history can be made of arrays, which are read-only in it."""
    assert repr(JOINT.update(np.zeros((7, 3)))) == "Update(7 points, 5 planes)"
    assert repr(history).startswith("History(rows: 180, events: ") and len(repr(history)) < 160
    assert "damage 1" in repr(history) and repr(history) == str(history) and len(history) == 180
    assert repr(JOINT.replay(np.zeros((0, 3)))) == "History(no rows)"
    rows = np.zeros((1, 3))
    plain = History(rows, rows, rows[:, 0], rows, rows[:, 0])
    assert plain.events == ()
    for array in (plain.separation, plain.traction, plain.damage, plain.state, plain.work):
        with pytest.raises(ValueError):
            array[0] = 1.0
    with pytest.raises(ValueError, match="direction = nan: expected a finite angle"):
        history.slip_along(np.nan)


def test_csv_is_that_of_the_driver(history: History, tmp_path: Path) -> None:
    """The file has the columns of the driver and all digits, and is read as its results are."""
    path = tmp_path / "history.csv"
    history.to_csv(path, planes=True)
    rows, columns = History.from_csv(path), history.columns(planes=True)
    for name in ("separation", "traction", "damage", *ENERGIES):
        assert np.array_equal(getattr(rows, name), getattr(history, name))
    assert rows.columns()["event"] == history.columns()["event"]
    header = path.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert header == list(columns) == [*COLUMNS, *NAMES[contract.N_POINT_STATEV :]]
    assert np.array_equal(columns["alpha_3"], history.alpha(3))
    assert {len(column) for column in columns.values()} == {180}
    history.to_csv(path)
    assert path.read_text(encoding="utf-8").splitlines()[0].split(",") == list(COLUMNS)
    with pytest.raises(ValueError, match="rows of a file have no steps"):
        rows.after_step(1)


HEAD, ROW = ",".join(COLUMNS), ",".join(["0"] * (len(COLUMNS) - 1))
DAMAGE = COLUMNS.index("damage")


def damaged(cell: str) -> str:
    """Header and a row with this damage."""
    return f"{HEAD}\n{','.join(cell if i == DAMAGE else '0' for i in range(len(COLUMNS) - 1))},\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected columns s_N"),
        ("s_N,s_Tx,s_Ty,t_N,t_Tx,t_Ty,event\n", "expected columns damage"),
        (HEAD + "\n", "expected rows after the header"),
        (damaged(""), "line 2, column damage: empty: expected"),
        (damaged("1_0"), "line 2, column damage: 1_0: expected"),
        (f"{HEAD}\n{ROW},\n1,2,3\n", f"line 3: 3 values: expected {len(COLUMNS)}"),
        (f"{HEAD}\n{ROW},,,\n", f"line 2: {len(COLUMNS) + 2} values: expected {len(COLUMNS)}"),
        (f"{HEAD}\n{ROW},\n{ROW},,,\n", f"line 3: {len(COLUMNS) + 2} values: expected {len(COLUMNS)}"),
    ],
)
def test_files_that_are_no_result(text: str, message: str, tmp_path: Path) -> None:
    """A cell that is no number is named with its line; so is a row that ends early, and another file."""
    (tmp_path / "rows.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"rows\.csv: {message}"):
        History.from_csv(tmp_path / "rows.csv")


@pytest.mark.slow
def test_plot(history: History, tmp_path: Path) -> None:
    """The figure has the rows and the units; it is written where a name is given; no window is chosen."""
    figure = plot(history, tmp_path / "a.png", "A title", ("m", "kPa"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert np.array_equal(figure.axes[1].lines[0].get_xydata()[:, 1], history.dilation)
    # a case has no units, and its title is no formula
    figure = plot(history, tmp_path / "b.png", "mu$\\frac$2")
    assert [ax.get_xlabel()[-9:] for ax in figure.axes] == [" [length]"] * len(figure.axes)
    with pytest.raises(ValueError, match="plot: expected a history with rows"):
        plot(JOINT.replay(np.zeros((0, 3))))
    script = (
        "import matplotlib; matplotlib.use('svg'); import asperity\nfrom asperity.tools import plots\n"
        "j = asperity.Interface(asperity.Material(3, .3, .9, .5), asperity.Pattern.regular(0, 0))\n"
        "before = dict(matplotlib.rcParams)\n"
        "plots.plot(j.replay([[0.01, 0, 0]])); assert dict(matplotlib.rcParams) == before"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


@pytest.mark.parametrize(
    "path",
    [
        [Step(t_N=-1.0, increments=10), Step(slip=0.1, increments=20)],
        [Step(t_N=6.0, k_N=40.0, follow="branch")],
        [Step(t_N=6.0, increments=20)],
    ],
    ids=["path", "branch", "lost"],
)
def test_rows_in_parts(monkeypatch: pytest.MonkeyPatch, path: list[Step]) -> None:
    """A run whose rows do not fit into the room gives the same rows, in parts, and the same loss."""
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5, kc=20.0), Pattern.regular(0, theta=0.0))
    whole = load_path.rows_of(joint.props(), path)
    monkeypatch.setattr(load_path, "MOST_ROOM", 3)
    parts = load_path.rows_of(joint.props(), path)
    assert len(whole[0]) > 3 and parts[1] == whole[1]
    np.testing.assert_array_equal(parts[0].traction, whole[0].traction)
    np.testing.assert_array_equal(parts[0].state, whole[0].state)
    np.testing.assert_array_equal(parts[0].step, whole[0].step)
    assert parts[0].events == whole[0].events
