"""Command `asperity picture`: a structure and its joints, drawn from the files for ParaView."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ...contract import Floats
from ...options import add_options, add_output, check_outputs, check_picture, units_of

FIELDS = {
    "damage": ("damage", ""), "slip": ("slip", "length"), "opening": ("opening", "length"),
    "shear": ("shear traction", "stress"), "normal": ("normal traction", "stress"), "name": ("joint", ""),
}  # fmt: skip
"""Fields that colour the joints: their label and the kind of their unit."""


def add_arguments(picture: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    picture.description = (
        "Draw a deformed structure and its joints, in colours of their damage, slip or name."
    )
    add_options(
        picture,
        ("results FILE.pvd", "results that a host writes for ParaView", Path),
        ("--field FIELD", "colours of the joints", "damage", {"choices": list(FIELDS)}),
        ("--step K", "number of the step, from 0; -1: the last one", -1),
        ("--scale S", "factor of the displacements (default: one at which they are seen)", float),
        ("--title TEXT", "title of the picture (default: the name of the file and the time)", str),
        ("--curves FILE.csv", "columns that are drawn below a plane structure, over the first one", Path),
        ("--label-units LENGTH,STRESS", "units for the labels", str),
    )
    add_output(picture, "FILE.png", "picture, .png or .pdf; in space .png (default: FILE.png)", Path)
    picture.set_defaults(action=_picture)


def _picture(options: argparse.Namespace) -> int:
    """Read a step and draw it."""
    output = options.output or Path(options.results.with_suffix(".png").name)
    check_picture(output, "-o ")
    check_outputs(options.force, [options.results, options.curves], ("--plot", output))
    if options.scale is not None and not np.isfinite(options.scale):
        raise ValueError(f"--scale {options.scale:g}: expected a number")
    label, kind = FIELDS[options.field]
    length = ""
    if options.label_units is not None:
        units = dict(zip(("length", "stress"), units_of(options.label_units), strict=True))
        length = f" [{units['length']}]"
        label += f" [{units[kind]}]" if kind else ""

    from ..style import save, save_pixels
    from .results import read_results

    steps = read_results(options.results)
    if not -len(steps) <= options.step < len(steps):
        raise ValueError(f"--step {options.step}: expected 0 to {len(steps) - 1}, or -1 for the last one")
    step = steps[options.step]
    if options.field != "name" and options.field not in step.fields:
        raise ValueError(f"--field {options.field}: expected one of {', '.join([*step.fields, 'name'])}")
    scale = step.scale if options.scale is None else options.scale
    title = options.title or f"{options.results.stem}, time {step.time:g}"
    title += f"; displacements times {scale:g}"
    if step.plane:
        from .plane import draw_plane

        curves = None if options.curves is None else read_curves(options.curves)
        save(draw_plane(step, options.field, scale, label, title, curves, length), output)
    else:
        from .space import draw_space

        if options.curves is not None:
            raise ValueError(f"--curves {options.curves}: expected with a plane structure")
        if output.suffix != ".png":
            raise ValueError(f"-o {output}: expected a name that ends in .png for a structure in space")
        save_pixels(draw_space(step, options.field, scale, label, title), output)
    print(output)
    return 0


def read_curves(csv: Path) -> dict[str, Floats]:
    """Columns of a CSV file by name; ValueError with the file."""
    lines = csv.read_text(encoding="utf-8").splitlines() if csv.is_file() else []
    names = [name.strip() for name in lines[0].lstrip("# ").split(",")] if lines else []
    try:
        data = np.array([line.split(",") for line in lines[1:] if line.strip()], float)
    except ValueError as error:
        raise ValueError(f"{csv}: {error}: expected a heading and rows of numbers") from None
    if len(names) < 2 or data.ndim != 2 or data.shape[1] != len(names):
        raise ValueError(f"{csv}: expected a heading and rows of two numbers or more")
    return dict(zip(names, data.T, strict=True))
