"""Picture of a structure in space, by PyVista."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from numpy.typing import NDArray

from ...installed import needed
from ..style import COLOURS
from .plane import limits
from .results import Results

PIXELS = 1440, 1080
"""Width and height of a picture, two columns of a journal at the resolution of the others."""

TYPES = {
    "tetra": 10, "hexahedron": 12, "wedge": 13, "tetra10": 24, "hexahedron20": 25, "triangle": 5, "quad": 9,
}  # fmt: skip
"""Cells of VTK by the name of meshio."""


def joints_of(step: Results, field: str, scale: float) -> Any:
    """Faces of the joints where they have moved, with a field, or with the numbers of their names."""
    import pyvista

    places, faces, first = [], [], 0
    for x, u in zip(step.x, step.u, strict=True):
        count, k = x.shape[:2]
        places.append((x + scale * u).reshape(-1, 3))
        nodes = first + np.arange(count * k).reshape(count, k)
        faces.append(np.column_stack([np.full(count, k), nodes]).ravel())
        first += count * k
    mesh = pyvista.PolyData(np.concatenate(places), np.concatenate(faces))
    mesh.cell_data[field] = np.concatenate(step.part if field == "name" else step.fields[field])
    return mesh


def draw_space(step: Results, field: str, scale: float, label: str, title: str) -> NDArray[np.uint8]:
    """Pixels of a picture: the joints in colours within the edges of the solids, which are transparent."""
    needed("picture", "pyvista")
    import pyvista
    from vtkmodules.vtkCommonCore import vtkObject

    vtkObject.GlobalWarningDisplayOff()  # no X server is needed, and VTK tells that it has none
    plotter = pyvista.Plotter(off_screen=True, window_size=list(PIXELS))
    plotter.background_color = "white"
    for x, u, kind, cells in step.solids:
        rows = np.column_stack([np.full(len(cells), cells.shape[1]), cells]).ravel()
        kinds = np.full(len(cells), TYPES[kind], np.uint8)
        solids = pyvista.UnstructuredGrid(rows, kinds, x + scale * u)
        surface = solids.extract_surface(algorithm="dataset_surface")
        plotter.add_mesh(surface, color="#E8E4DC", opacity=0.15)
        plotter.add_mesh(surface.extract_feature_edges(30.0), color="#807C74", line_width=2)
    mesh = joints_of(step, field, scale)
    bar = {
        "title": label,
        "color": "black",
        "vertical": True,
        "position_x": 0.86,
        "position_y": 0.2,
        "height": 0.6,
    }
    if field == "name":
        colours = [COLOURS[k % len(COLOURS)] for k in range(len(step.names))]
        ends = (-0.5, len(colours) - 0.5)
        shown = {"cmap": ListedColormap(colours), "clim": ends, "lighting": False}
        plotter.add_mesh(mesh, scalars=field, show_scalar_bar=False, **shown)
        marks = [[name, colour] for name, colour in zip(step.names, colours, strict=True)]
        plotter.add_legend(marks, bcolor="white", loc="upper right", size=(0.2, 0.05 * len(marks)))
    else:
        values = np.asarray(mesh.cell_data[field])
        plotter.add_mesh(
            mesh, scalars=field, cmap="viridis_r", clim=limits(field, values), show_edges=True,
            edge_color="#606060", scalar_bar_args=bar, lighting=False,
        )  # fmt: skip
    plotter.add_text(title, font_size=12, color="black")
    plotter.add_axes(color="black")
    plotter.camera_position = "iso"
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return np.asarray(image)
