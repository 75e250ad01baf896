"""Results with names: energies, planes, tables, pictures and short texts of History and Update."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import EquilibriumLost, History, Interface, Material, Pattern, contract, plot
from asperity.history import COLUMNS, ENERGIES

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0), Pattern.regular(4, theta=30.0))
SLIPS = np.concatenate([np.linspace(0.0, 0.3, 61)[1:], np.linspace(0.3, -0.3, 121)[1:]])


@pytest.fixture(scope="module")
def history() -> History:
    """A slip with a reversal under pressure."""
    return JOINT.confined_slip(20.0, SLIPS, -1.0)


def test_energies_have_names(history: History) -> None:
    """The work is the sum of the energies to second order, and each is the state variable of its name."""
    names = contract.statev_names(5)
    for name in ("stored", "rupture", "friction"):
        assert np.array_equal(getattr(history, name), history.state[:, names.index(name)])
    total = history.stored + history.rupture + history.friction
    # the trapezoids of the work and of the energies differ by their discretisation
    assert np.allclose(total, history.work, rtol=0.02, atol=0.02 * JOINT.material.Gc)
    assert np.all(np.diff(history.friction) >= 0.0) and history.friction[-1] > 0.1
    assert np.array_equal(history.dilation, history.separation[:, 0])


def test_planes_have_numbers(history: History) -> None:
    """The damage of the point is the mean of that of its planes; the slips are the state variables."""
    names = contract.statev_names(5)
    mean = sum(weight * history.alpha(k) for k, weight in enumerate(JOINT.pattern.weights, 1))
    assert np.allclose(mean, history.damage, rtol=0, atol=1e-14)
    for k in range(1, 6):
        first = names.index(f"s_dit_{k}")
        assert np.array_equal(history.slip(k), history.state[:, first : first + 2])
    for bad in (0, 6, 1.0, True, "1"):
        with pytest.raises(ValueError, match=r"plane = .*: expected 1 to 5"):
            history.alpha(bad)  # type: ignore[arg-type]
    points = JOINT.update(np.array([[0.01, 0.05, 0.0], [0.0, 0.0, 0.0]]))
    assert np.array_equal(points.alpha(2), points.state[:, names.index("alpha_2")])
    assert np.array_equal(points.damage, points.state[:, names.index("damage")])
    assert points.rupture[0] > 0.0 == points.rupture[1]
    assert points.slip(1).shape == (2, 2) and points.stored.shape == points.friction.shape == (2,)


def test_short_texts(history: History) -> None:
    """The text of a result is one line without arrays."""
    assert repr(JOINT.update(np.zeros((7, 3)))) == "Update(7 points, 5 planes)"
    assert repr(history).startswith("History(rows: 180, events: ") and len(repr(history)) < 160
    assert "damage 1" in repr(history) and repr(history) == str(history) and len(history) == 180
    assert repr(JOINT.replay(np.zeros((0, 3)))) == "History(no rows)"


def test_csv_is_that_of_the_driver(history: History, tmp_path: Path) -> None:
    """The file has the columns of the driver and all digits, and is read as its results are."""
    path = tmp_path / "history.csv"
    history.to_csv(path, planes=True)
    rows = History.from_csv(path)
    assert np.array_equal(rows.separation, history.separation)
    assert np.array_equal(rows.traction, history.traction)
    assert np.array_equal(rows.damage, history.damage)
    for name in ENERGIES:
        assert np.array_equal(getattr(rows, name), getattr(history, name))
    assert rows.columns()["event"] == history.columns()["event"]
    header = path.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert header == [*COLUMNS, *contract.statev_names(5)[contract.N_POINT_STATEV :]]
    history.to_csv(path)
    assert path.read_text(encoding="utf-8").splitlines()[0].split(",") == list(COLUMNS)


def test_a_lost_equilibrium_has_a_history(tmp_path: Path) -> None:
    """The rows before the loss can be written, and the loss is an event of the last one."""
    with pytest.raises(EquilibriumLost) as lost:
        Interface(JOINT.material, Pattern.regular(0, 0.0)).confined_slip(0.0, np.linspace(0.0, 0.1, 101), 2.0)
    history = pickle.loads(pickle.dumps(lost.value)).history
    history.to_csv(tmp_path / "lost.csv")
    rows = History.from_csv(tmp_path / "lost.csv")
    assert len(rows) == len(history) and "no equilibrium" in rows.events[-1][1]
    assert history.planes == 1 and history.alpha(1).shape == (len(history),)


def test_columns(history: History) -> None:
    """The columns are those of the CSV, with the state of every plane if it is asked for."""
    found = history.columns(planes=True)
    assert list(found)[:12] == list(COLUMNS) and all(len(one) == 180 for one in found.values())
    assert np.array_equal(found["alpha_3"], history.alpha(3))


def test_plot(history: History, tmp_path: Path) -> None:
    """The figure has the rows and the units; it is written where a name is given; no window is chosen."""
    figure = plot(history, tmp_path / "a.png", "A title", ("m", "kPa"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    lines = [ax.lines[0].get_xydata() for ax in figure.axes]
    assert np.array_equal(lines[1][:, 1], history.dilation) and np.array_equal(lines[2][:, 1], history.damage)
    assert [ax.get_ylabel().split("[")[1] for ax in figure.axes] == ["kPa]", "m]", "-]"]
    with pytest.raises(ValueError, match="plot: expected a history with rows"):
        plot(JOINT.replay(np.zeros((0, 3))))
    script = (
        "import matplotlib; matplotlib.use('svg'); import asperity\n"
        "j = asperity.Interface(asperity.Material(3, .3, .9, .5), asperity.Pattern.regular(0, 0))\n"
        "asperity.plot(j.replay([[0.01, 0, 0]])); print(matplotlib.get_backend())"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip().lower() == "svg"


@pytest.mark.parametrize("sides", [1, -3, 65, 2.5, np.nan, np.inf, "4"])
def test_errors_have_the_words_of_the_caller(sides: Any) -> None:
    """An error names the argument, not the place of its value in PROPS."""
    with pytest.raises(ValueError, match=r"^sides = .*: expected 0 or 2 to 64$"):
        Pattern.regular(sides, 30.0)
    with pytest.raises(ValueError, match=r"^n_N of listed plane 2 = 0: expected > 0$"):
        Pattern.planes([[1, 0, 0], [0, 1, 0]], [0.5, 0.5])
    with pytest.raises(ValueError, match=r"^mu = -1: expected >= 0"):
        Material(3.0, 0.3, 0.9, -1.0)


def test_wear_has_a_name(tmp_path: Path) -> None:
    """With W0 > 0 the worn share of a plane is a state variable; without it there is none."""
    worn = Interface(
        Material(3.0, 0.3, 0.9, 0.5, kc=100.0, height=0.5, W0=1.0), Pattern.regular(2, 30.0)
    ).confined_slip(0.0, np.linspace(0.0, 0.4, 101), -1.0)
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


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("x", "column damage: x: expected a finite"),
        ("nan", "column damage: nan: expected"),
        ("", "column damage: empty: expected"),
    ],
)
def test_files_with_other_cells(cell: str, message: str, history: History, tmp_path: Path) -> None:
    """A cell of a file that is no number is named with its line; so is a row that ends early."""
    path = tmp_path / "rows.csv"
    history.to_csv(path)
    head, first, *rows = path.read_text().splitlines()
    parts = first.split(",")
    parts[COLUMNS.index("damage")] = cell
    path.write_text("\n".join([head, ",".join(parts), *rows]))
    with pytest.raises(ValueError, match=f"rows.csv: line 2, {message}"):
        History.from_csv(path)
    path.write_text("\n".join([head, first, "1,2,3", ""]))
    with pytest.raises(ValueError, match=r"rows.csv: line 3: 3 values: expected \d+"):
        History.from_csv(path)


def test_what_a_history_does_not_know(history: History, tmp_path: Path) -> None:
    """Directions are finite, and rows of a file have no steps."""
    with pytest.raises(ValueError, match="direction = nan: expected a finite angle"):
        history.slip_along(np.nan)
    history.to_csv(tmp_path / "rows.csv")
    with pytest.raises(ValueError, match="rows of a file have no steps"):
        History.from_csv(tmp_path / "rows.csv").after_step(1)
