"""Pictures of structures with joints: what is drawn where, in which colour, and wrong input."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from asperity import contract
from asperity.cli import main
from asperity.mesh import split
from asperity.tools.picture import read_results
from asperity.tools.picture.plane import draw_plane
from asperity.tools.picture.space import joints_of
from matplotlib.collections import LineCollection

from harness.hosts import structured
from harness.hosts.paraview_files import Step, write

MOVED = np.array([[0.0, 0.0, 0.0], [1.2, -0.8, 0.3], [-0.2, 0.9, 0.5]])
"""Displacements of three rigid blocks: left below, right, left above."""


def results(pvd: Path, d: int) -> Step:
    """Two steps of three blocks with the joints `head` and `bed`; the blocks move in the second one."""
    n = (6, 4, 3)[:d]
    block = np.zeros(n, int)
    block[3:] = 1
    block[:3, 2:] = 2
    names = {"left": 0, "right": 1, "above": 2}
    mesh = split(
        structured.grid(*(np.arange(k + 1) * 250.0 for k in n), block=block, names=names, sides=()),
        {"head": ("*", "right"), "bed": ("*", "*")},
    )
    ((kind, cells),) = mesh.cells.items()
    own = np.zeros(len(mesh.points), int)
    for k in range(3):
        own[np.unique(cells[mesh.block[kind] == k])] = k
    u = MOVED[own][:, :d]
    parts = [(k, joint) for k, some in enumerate(mesh.joints.values()) for joint in some]
    minus, plus, axes = (
        np.concatenate([getattr(joint, name) for _, joint in parts]) for name in ("minus", "plus", "axes")
    )
    number = np.concatenate([np.full(len(joint.area), k) for k, joint in parts])
    separation = np.zeros((len(number), 1, 3))
    separation[:, 0, :d] = np.einsum("fij,fj->fi", axes, (u[plus] - u[minus]).mean(1))
    state = np.zeros((len(number), 1, contract.N_POINT_STATEV))
    state[:, 0, contract.statev_index("damage")] = np.linspace(0.0, 1.0, len(number))
    between = np.concatenate([minus, plus[:, ::-1] if d == 2 else plus], 1)
    data = separation, 3.0 * separation, state, mesh.block[kind], number, mesh.names, list(mesh.joints)
    step = Step(1.0, mesh.points, u, kind, cells, between, *data)
    write(pvd, [replace(step, time=0.0, displacement=0.0 * u), step])
    return step


@pytest.mark.parametrize("d", [2, 3])
def test_results(tmp_path: Path, d: int) -> None:
    """Fields, names and the middles between the sides of the joints are those of the files."""
    given = results(tmp_path / "run.pvd", d)
    _, step = read_results(tmp_path / "run.pvd")
    assert step.time == 1.0 and step.plane == (d == 2) and step.names == ["head", "bed"]
    assert (np.concatenate(step.part) == given.joint).all()
    slip = np.linalg.norm(given.separation[:, 0, 1:], axis=1)
    fields = {"slip": slip, "opening": given.separation[:, 0, 0], "shear": 3.0 * slip}
    fields |= {"normal": 3.0 * given.separation[:, 0, 0], "damage": np.linspace(0.0, 1.0, len(slip))}
    assert {name: np.concatenate(values).tolist() for name, values in step.fields.items()} == {
        name: pytest.approx(values.tolist()) for name, values in fields.items()
    }
    u = np.concatenate(step.u)
    mean = [0.5 * (MOVED[0] + MOVED[1]), 0.5 * (MOVED[1] + MOVED[2]), 0.5 * (MOVED[0] + MOVED[2])]
    mean = np.array(mean) * [1.0, 1.0, float(d == 3)]
    assert all((np.abs(move - mean).max(1) < 1e-12).any() for move in u.reshape(-1, 3))
    # the longest displacement, 1.2 along x, times 50 is below a twentieth of 1500, times 100 above
    assert step.scale == 50.0


def test_plane(tmp_path: Path) -> None:
    """Lines lie in the middle of the moved sides and have the values of their joints."""
    given = results(tmp_path / "run.pvd", 2)
    step = read_results(tmp_path / "run.pvd")[1]
    axes = draw_plane(step, "slip", 10.0, "slip", "title").axes[0]
    (lines,) = [artist for artist in axes.collections if isinstance(artist, LineCollection)]
    assert lines.get_array().tolist() == pytest.approx(
        np.linalg.norm(given.separation[:, 0, 1:], axis=1).tolist()
    )
    x, u = np.concatenate(step.x), np.concatenate(step.u)
    assert np.abs(np.array(lines.get_segments()) - (x + 10.0 * u)[..., :2]).max() == 0.0
    head = x[given.joint == 0]
    assert (head[..., 0] == 750.0).all()
    legend = draw_plane(step, "name", 1.0, "joint", "title").axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["head", "bed"]


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("field", ["damage", "name"])
def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], field: str, d: int) -> None:
    """A picture with the dark end of the scale of colours, or with the colours of both joints."""
    if d == 3:
        pytest.importorskip("pyvista", reason="asperity[picture] is not installed")
    pvd, png = tmp_path / "run.pvd", tmp_path / "run.png"
    results(pvd, d)
    assert main(["picture", str(pvd), "-o", str(png), "--field", field]) == 0
    assert capsys.readouterr().out == f"{png}\n"
    pixels = matplotlib.image.imread(png)[..., :3].reshape(-1, 3) * 255.0
    colours = [[68.0, 1.0, 84.0]] if field == "damage" else [[0.0, 114.0, 178.0], [213.0, 94.0, 0.0]]
    for colour in colours:
        assert (np.abs(pixels - colour).max(1) < 24.0).sum() > 200
    assert main(["picture", str(pvd), "-o", str(png)]) == 0  # a picture of this package is replaced


def test_surfaces_in_space(tmp_path: Path) -> None:
    """The faces have the area of the joints where nothing has moved, and their values."""
    pytest.importorskip("pyvista", reason="asperity[picture] is not installed")
    given = results(tmp_path / "run.pvd", 3)
    mesh = joints_of(read_results(tmp_path / "run.pvd")[0], "damage", 1.0)
    assert mesh.n_cells == len(given.joints) and mesh.area == pytest.approx(250.0**2 * len(given.joints))
    assert np.asarray(mesh.cell_data["damage"]).tolist() == np.linspace(0.0, 1.0, mesh.n_cells).tolist()


def test_curves(tmp_path: Path) -> None:
    """Columns of a CSV file are drawn over the first one."""
    results(tmp_path / "run.pvd", 2)
    csv = tmp_path / "run.csv"
    csv.write_text("slip,force,force_point\n0,0,0\n1,2,3\n", encoding="utf-8")
    words = ["picture", str(tmp_path / "run.pvd"), "-o", str(tmp_path / "run.png"), "--curves", str(csv)]
    assert main(words) == 0
    csv.write_text("slip,force\n0,x\n", encoding="utf-8")
    assert main(words) == 1


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["none.pvd"], "none.pvd: no such file: expected a file of results"),
        (["run.pvd", "--step", "2"], "--step 2: expected 0 to 1, or -1"),
        (["run.pvd", "-o", "run.jpg"], "run.jpg: expected a name that ends in .png or .pdf"),
        (["run.pvd", "-o", "other.png"], "other.png: this file is there and is not replaced"),
        (["bad.pvd"], "bad.pvd: .*expected a file of results"),
        (["solids.pvd"], "solids.pvd: expected solids and joints in every step"),
        (["lost.pvd"], r"nowhere.vtu: .*expected a file of results"),
    ],
)
def test_wrong_input(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    error: str,
) -> None:
    """It is named, in one line, and files that are there stay."""
    monkeypatch.chdir(tmp_path)
    results(Path("run.pvd"), 2)
    Path("other.png").write_text("mine", encoding="utf-8")
    Path("bad.pvd").write_text("<VTKFile>", encoding="utf-8")
    entry = '<VTKFile><Collection><DataSet timestep="0" file="{}"/></Collection></VTKFile>'
    Path("solids.pvd").write_text(entry.format("run/solids_0000.vtu"), encoding="utf-8")
    Path("lost.pvd").write_text(entry.format("nowhere.vtu"), encoding="utf-8")
    assert main(["picture", *words]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(error, line), line
    assert Path("other.png").read_text(encoding="utf-8") == "mine"
