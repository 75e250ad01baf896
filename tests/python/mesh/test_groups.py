"""Kinds of meshes that once gave a wrong model without a word: curved faults, cell data, decks of editors."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split, write
from asperity.mesh.files import read_raw

from harness.hosts import structured
from mesh import drawn_meshes
from mesh.test_files import MSH, STRIP, placed, read, same_counts

DRAWN = 20
"""Drawn files of each kind."""


def curved(draw: np.random.Generator, d: int) -> tuple[meshio.Mesh, list[str]]:
    """Cells around an axis, one block, and a fault at the middle radius in parts whose faces are as drawn."""
    n, closed = int(draw.integers(6, 14)), bool(draw.random() < 0.5)
    turns = 2.0 * np.pi if closed else float(draw.uniform(1.0, 5.5))
    angle = float(draw.uniform(0.0, 6.0)) + turns * np.linspace(0.0, 1.0, n + 1)
    radii, heights = (1.0, 2.0, 3.0), range(3 if d == 3 else 1)
    columns = n if closed else n + 1
    number = np.arange(len(heights) * len(radii) * columns).reshape(len(heights), len(radii), columns)
    points = [[r * np.cos(a), r * np.sin(a), h] for h in heights for r in radii for a in angle[:columns]]
    cells, faces = [], []
    for k in range(n):
        a, b = k, (k + 1) % columns
        for h in range(max(len(heights) - 1, 1)):
            for r in range(2):
                flat = [number[h, r, a], number[h, r + 1, a], number[h, r + 1, b], number[h, r, b]]
                cells.append(flat + [node + number[0].size for node in flat] if d == 3 else flat)
            low = [number[h, 1, a], number[h, 1, b]]
            faces.append((k, low + [node + number[0].size for node in low[::-1]] if d == 3 else low))
    cuts = np.sort(draw.choice(np.arange(1, n), int(draw.integers(1, 4)), replace=False))
    part = [int(np.searchsorted(cuts, k, "right")) for k, _ in faces]
    order = draw.permutation(len(faces))
    data = np.array([faces[k][1] for k in order])
    data = np.array([row[::-1] if draw.random() < 0.5 else row for row in data])
    names = [f"part_{k}" for k in range(len(cuts) + 1)]
    tags = [np.ones(len(cells), int), np.array([part[k] + 2 for k in order])]
    field = {name: np.array([k + 2, d - 1]) for k, name in enumerate(names)} | {"rock": np.array([1, d])}
    kinds = ("hexahedron", "quad") if d == 3 else ("quad", "line")
    mesh = meshio.Mesh(
        np.array(points), list(zip(kinds, (np.array(cells), data), strict=True)),
        cell_data={"gmsh:physical": tags}, field_data=field,
    )  # fmt: skip
    return mesh, names


@pytest.mark.parametrize("d", [2, 3])
def test_curved_fault_in_parts(d: int) -> None:
    """N of an arc or a ring is on one side along all of its parts, whatever the nodes of their faces."""
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, d])
        mesh, names = curved(draw, d)
        jointed = split(mesh, dict.fromkeys(draw.permutation(names).tolist()))
        outward = [
            float(np.sign(n @ x))
            for (joint,) in jointed.joints.values()
            for n, x in zip(joint.axes[:, 0, :2], jointed.points[joint.minus].mean(1)[:, :2], strict=True)
        ]
        assert len(outward) == sum(len(block.data) for block in mesh.cells[1:])
        assert abs(sum(outward)) == len(outward), seed


@pytest.mark.parametrize("d", [2, 3])
def test_many_blocks(d: int) -> None:
    """N of all faces between stones in any order is on one side along each bed and each through joint.

    It is that of the later stones, by area; heads that end at beds are parts of their own.
    """
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, d, 2])
        axes = [np.cumsum([0.0, *draw.uniform(0.5, 2.0, 2 * int(draw.integers(2, 4)))]) for _ in range(d)]
        cells = [len(x) - 1 for x in axes]
        at = list(np.indices(cells))
        bond = bool(draw.random() < 0.5)  # every other row is shifted by half a stone
        shift = at[-1] // 2 % 2 if bond else 0
        stone = np.ravel_multi_index(
            [(at[0] + shift) // 2, *(k // 2 for k in at[1:])],
            [cells[0] // 2 + 1, *(n // 2 for n in cells[1:])],
        )
        _, stone = np.unique(stone, return_inverse=True)
        number = draw.permutation(stone.max() + 1)[stone.ravel()].reshape(cells)
        jointed = split(structured.grid(*axes, block=number + 1, sides=()))
        total: dict[tuple[int, float, int], float] = {}
        signs: dict[tuple[int, float, int], set[float]] = {}
        (joint,) = jointed.joints["joint"]
        block = np.concatenate(list(jointed.block.values()))
        for N, nodes, area, pair in zip(
            joint.axes[:, 0], joint.minus, joint.area, block[joint.cells], strict=True
        ):
            axis = int(np.abs(N).argmax())
            later = float(np.sign(N[axis]) * np.sign(pair[1] - pair[0]))
            x = jointed.points[nodes].mean(0)
            row = int(np.searchsorted(axes[-1][::2], x[-1])) if bond and axis == 0 else 0
            line = axis, float(x[axis].round(9)), row
            total[line] = total.get(line, 0.0) + float(area) * later
            signs.setdefault(line, set()).add(float(np.sign(N[axis])))
        assert len(total) >= sum(n // 2 - 1 for n in cells[1:]) + (cells[0] // 2 - 1)
        for line, found in signs.items():
            [sign] = found
            assert total[line] * sign > 0.0, (seed, line)


@pytest.mark.parametrize("d", [2, 3])
def test_ring_between_blocks(d: int) -> None:
    """N between segments and rock is on one side, whatever the order of their groups."""
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, d, 1])
        mesh, _ = curved(draw, d)
        cells = mesh.cells[0].data
        inner = np.linalg.norm(mesh.points[cells].mean(1)[:, :2], axis=1) < 1.6
        segments = 2 + np.arange(len(cells)) * 3 // len(cells)
        tags = np.where(
            inner, segments, int(draw.integers(1, 6)) + 0.5
        )  # of the rock between those of others
        numbers = np.unique(tags, return_inverse=True)[1].ravel() + 1
        named = {
            f"lining_{k}" if inner[numbers == k].all() else "rock": np.array([k, d]) for k in set(numbers)
        }
        ring = meshio.Mesh(
            mesh.points, mesh.cells[:1], cell_data={"gmsh:physical": [numbers]}, field_data=named
        )
        jointed = split(ring, {"ring": ("lining*", "rock")})
        (joint,) = jointed.joints["ring"]
        x = np.einsum("fd,fd->f", joint.axes[:, 0, :2], jointed.points[joint.minus].mean(1)[:, :2])
        assert abs(np.sign(x).sum()) == len(x), seed


def test_direction_along_a_ring() -> None:
    """A direction that would turn N to the other side is refused; along an arc it sets the sides."""
    angles = np.linspace(0.1, 2.0 * np.pi + 0.1, 13)
    for last, words in ((12, "by its direction N of . of 12 connected faces is on the other side"), (5, "")):
        number = np.arange(39).reshape(3, 13)
        points = np.array([[r * np.cos(a), r * np.sin(a)] for r in (1.0, 2.0, 3.0) for a in angles])
        number[:, 12] = number[:, 0]
        cells = [
            [number[r, k], number[r + 1, k], number[r + 1, k + 1], number[r, k + 1]]
            for r in range(2) for k in range(12)
        ]  # fmt: skip
        line = np.stack([number[1, :last], number[1, 1 : last + 1]], 1)
        mesh = meshio.Mesh(
            points, [("quad", np.array(cells)), ("line", line)],
            cell_data={"gmsh:physical": [np.ones(24, int), np.full(last, 2)]},
            field_data={"rock": np.array([1, 2]), "fault": np.array([2, 1])},
        )  # fmt: skip
        if words:
            with pytest.raises(ValueError, match=words):
                split(mesh, {"fault": None}, direction=(1.0, 0.0))
        else:
            (joint,) = split(mesh, {"fault": None}, direction=(1.0, 0.0)).joints["fault"]
            assert (joint.axes[:, 0, 1] > 0.0).all()


def test_indented_keywords(tmp_path: Path) -> None:
    """The first sign of a line that is no blank makes it a keyword or a comment."""
    for seed in range(DRAWN):
        drawn = drawn_meshes.deck(seed)
        draw = np.random.default_rng([seed, 3])
        indented = {
            name: "".join(f"{' ' * int(draw.integers(4))}{line}\n" for line in text.splitlines())
            for name, text in drawn.files.items()
        }
        same_counts(split(placed(tmp_path, indented)), read("deck", drawn.files))


def plate(**data: list[float]) -> meshio.Mesh:
    """Six squares in two rows with cell data."""
    points = [[float(i), float(j), 0.0] for j in range(3) for i in range(4)]
    cells = [[4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4] for j in range(2) for i in range(3)]
    return meshio.Mesh(
        np.array(points), [("quad", np.array(cells))],
        cell_data={name: [np.array(values)] for name, values in data.items()},
    )  # fmt: skip


ROWS = [1, 1, 1, 2, 2, 2]


@pytest.mark.parametrize("ending", [".vtk", ".vtu"])
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("vtkProcessId", [0, 1, 0, 1, 0, 1]), ("rank", ROWS), ("partition", ROWS), ("GlobalCellIds", ROWS),
        ("cell_id", [1, 2, 3, 4, 5, 6]), ("material", [5, 3, 4, 1, 2, 6]), ("is_active", [1, 1, 1, 1, 1, 0]),
        ("damage_flag", ROWS), ("PartitionId", ROWS), ("MPI_rank", ROWS), ("offsets", ROWS), ("stage", ROWS),
        ("processor_of_part", ROWS), ("vtkOriginalCellIds", ROWS), ("elementId", ROWS), ("format", ROWS),
        ("MatFraction", [0.5, 1.0, 1.0, 1.0, 1.0, 1.0]), ("owner", ROWS),
    ],
)  # fmt: skip
def test_cell_data_of_no_blocks(tmp_path: Path, name: str, values: list[float], ending: str) -> None:
    """Ranks, numbers of cells, flags and fractions are no blocks unless --blocks says so."""
    path = tmp_path / f"plate{ending}"
    plate(**{name: values}).write(path)
    with pytest.raises(ValueError, match="the mesh has no groups: expected"):
        split(path)
    if values == ROWS:
        assert split(path, blocks=name).names == ["block_1", "block_2"]
    plate(**{name: values, "material": ROWS}).write(path)
    if name != "material":
        assert split(path).joints["joint"][0].area.sum() == 3.0


@pytest.mark.parametrize(
    "name",
    [
        "MaterialIDs",
        "material",
        "region_id",
        "Layer",
        "CellEntityIds",
        "matid",
        "PartId",
        "BLOCK_ID",
        "ElementBlockIds",
    ],
)
def test_cell_data_of_blocks(tmp_path: Path, name: str) -> None:
    """Numbers of blocks may be written as floats."""
    for values in (ROWS, [float(value) for value in ROWS]):
        plate(**{name: values}).write(tmp_path / "plate.vtu")
        mesh = split(tmp_path / "plate.vtu")
        assert mesh.names == ["block_1", "block_2"] and mesh.joints["joint"][0].area.sum() == 3.0


def test_ghosts_and_two_materials() -> None:
    """Cells of another rank are refused, and so are two arrays that may be those of blocks."""
    with pytest.raises(
        ValueError, match="2 cells are ghosts, of another rank, by vtkGhostType: expected the"
    ):
        split(plate(material=ROWS, vtkGhostType=[0, 1, 0, 0, 1, 0]))
    assert split(plate(material=ROWS, vtkGhostType=[0] * 6)).joints["joint"][0].area.sum() == 3.0
    with pytest.raises(ValueError, match="several arrays with numbers of blocks, material, zone: expected"):
        split(plate(material=ROWS, zone=ROWS[::-1]))


TWO = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
5
2 1 "low"
2 2 "high"
1 3 "foot, left/right"
0 4 "corner"
2 5 "wet"
$EndPhysicalNames
$Nodes
8
1 0 0 0
2 2 0 0
3 0 1 0
4 2 1 0
5 0 3 0
6 2 3 0
7 5 0 0
8 5 1 0
$EndNodes
$Elements
8
1 15 2 4 1 6
2 1 2 3 1 1 2
3 1 2 3 1 2 7
4 3 2 1 1 1 2 4 3
5 3 2 1 2 2 7 8 4
6 3 2 2 3 3 4 6 5
7 3 2 5 2 2 7 8 4
8 3 2 5 3 3 4 6 5
$EndElements
"""
"""Two squares below, one above; two faces on the lower outline, a corner, and a group of two cells."""


@pytest.mark.parametrize(("host", "layer"), [("ogs", 0.01), ("vtu", 0.0)])
def test_groups_beside_a_vtu_file(host: str, layer: float, tmp_path: Path) -> None:
    """Each is a mesh whose nodes lie at those of the whole mesh, and whose faces are edges of its cells."""
    path = placed(tmp_path, {"two.msh": TWO})
    files = write(
        tmp_path / "wall.vtu", split(path, {"joint": ("low", "high")}, "low,high"), host, layer=layer
    )
    names = ["wall", "wall_foot_left_right", "wall_corner", "wall_wet"]
    assert sorted(file.stem for file in files) == sorted(names)
    whole, foot, corner, wet = (meshio.read(tmp_path / f"{name}.vtu") for name in names)
    for part in (foot, corner, wet):
        assert part.points.tolist() == whole.points[part.point_data["bulk_node_ids"]].tolist()
    assert foot.cells_dict["line"].tolist() == [[0, 1], [1, 2]]
    assert foot.points[:, :2].tolist() == [[0.0, 0.0], [2.0, 0.0], [5.0, 0.0]]
    cells = np.concatenate([block.data for block in whole.cells if block.type == "quad"])
    for part, kind in ((foot, "line"), (wet, "quad")):
        beside = cells[np.concatenate(part.cell_data["bulk_element_ids"])]
        nodes = part.point_data["bulk_node_ids"][part.cells_dict[kind]]
        assert all(set(own) <= set(cell) for own, cell in zip(nodes.tolist(), beside.tolist(), strict=True))
    assert corner.cells_dict["vertex"].tolist() == [[0]] and corner.points[0, :2].tolist() == [2.0, 3.0]
    # of both sides of the joint each cell has its own nodes
    assert len(wet.cells_dict["quad"]) == 2 and len(wet.points) == 8


def test_two_groups_in_one_file(tmp_path: Path) -> None:
    """Groups whose names become one file, or that of the mesh, are refused; own files alone are replaced."""
    text = TWO.replace('"corner"', '"foot, left:right"')
    with pytest.raises(
        ValueError, match=r"groups 'foot, left/right' and 'foot, left:right': one file .*wall_f"
    ):
        write(tmp_path / "wall.vtu", split(placed(tmp_path, {"two.msh": text}), None, "low,high"))


def test_files_of_groups_that_are_there(said: Callable, folder: Path) -> None:
    """A file of something else is not replaced, one of this command is."""
    placed(folder, {"two.msh": TWO})
    (folder / "wall_corner.vtu").write_text("my own", encoding="utf-8")
    words = "mesh two.msh --blocks low,high -o wall.vtu"
    assert "wall_corner.vtu: this file is there and is not replaced" in said(words, 1)[1]
    assert not (folder / "wall.vtu").exists()
    (folder / "wall_corner.vtu").unlink()
    assert "wall_corner.vtu" in said(words)[0] and "wall_wet.vtu" in said(words)[0]


def test_names_that_a_host_cannot_read(tmp_path: Path) -> None:
    """They are written with underscores, which a warning says; two that become one are refused."""
    text = MSH.replace('"rock"', '"rock (lower)"').replace('"foot"', '"my foot"')
    mesh = split(placed(tmp_path, {"wall.msh": text}))
    with pytest.warns(ModelWarning, match="'rock .lower.' is rock_lower, 'my foot' is my_foot"):
        (path,) = write(tmp_path / "wall.inp", mesh)
    written = path.read_text(encoding="utf-8")
    assert "elset=rock_lower\n" in written and "nset=my_foot\n" in written
    text = text.replace('"rim"', '"my_foot"')
    with pytest.raises(ValueError, match="'my foot' and 'my_foot' both become my_foot"):
        write(tmp_path / "wall.inp", split(placed(tmp_path, {"wall.msh": text})))


def test_sets_of_programs(tmp_path: Path) -> None:
    """Sets internal to CAE are no blocks; the advice names sets of elements, not those of loads."""
    inner = STRIP + "*Elset, elset=Picked, internal\n1, 2\n"
    mesh = split(placed(tmp_path, {"strip.inp": inner}))
    assert mesh.names == ["DAM", "ROCK"] and list(mesh.sets) == ["Picked"]
    parted = STRIP.replace("CPE4\n1", "CPE4, elset=ROCK\n1").replace(
        "\n2, 3, 4", "\n*Element, type=CPE4, elset=DAM\n2, 3, 4"
    )
    loaded = parted.split("*Elset")[0] + "*Elset, elset=ALOAD\n2, 3\n*Elset, elset=PUSHED\n3\n"
    with pytest.raises(ValueError, match="name the blocks, as --blocks DAM,ROCK"):
        split(placed(tmp_path, {"strip.inp": loaded}))


def test_a_mesh_of_a_file_is_constant(tmp_path: Path) -> None:
    """Neither its arrays nor its groups can be changed."""
    raw = read_raw(placed(tmp_path, {"strip.inp": STRIP}))
    with pytest.raises(ValueError, match="read-only"):
        raw.points[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        raw.cells[0].nodes[0] = 1
    with pytest.raises(TypeError):
        raw.groups["ROCK"] = ()  # type: ignore[index]
    with pytest.raises(FrozenInstanceError):
        raw.points = raw.points  # type: ignore[misc]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert split(raw).names == ["DAM", "ROCK"]
