"""Draw a UMAT of a bilinear law without friction and the law of this project on one path, for any-umat.md.

The UMAT is that of the tests; gfortran builds it.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from asperity import ForeignUmat, Interface, Material, Pattern, Step
from asperity.tools.style import DILATION, SLIP, TRACTION, TWO, curves, new_figure, printed, save
from matplotlib.figure import Figure

from .program import program

SOURCE = Path("harness/examples/planted_umat.f")
PATH = [Step(t_N=-0.5, increments=20), Step(slip=[0.15, -0.05, 0.3], increments=[100, 150, 200])]
LAW = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0)


@printed()
def draw(library: Path) -> Figure:
    """Shear traction and dilation of both laws over the slip."""
    s_f = 2.0 * LAW.Gc / LAW.sigma0
    s_0 = (1.0 - LAW.eta) * s_f
    bilinear = ForeignUmat(library, s_0, LAW.sigma0 / s_0, (LAW.sigma0 / s_0, s_0, s_f, 1.0, 0.0), nstatv=2)
    laws = {
        "bilinear UMAT": bilinear.run(PATH),
        "asperity": Interface(LAW, Pattern.regular(2, 20.0)).run(PATH),
    }
    tests = {name: rows.after_step(1) for name, rows in laws.items()}
    figure, axes = new_figure(TWO, 2.5, ncols=2)
    shown = ("traction", 1, TRACTION), ("separation", 0, DILATION)
    for ax, (name, k, label) in zip(axes, shown, strict=True):
        lines = [
            (law, result.separation[:, 1], getattr(result, name)[:, k], False)
            for law, result in tests.items()
        ]
        curves(ax, lines, SLIP, label, "law", inside=True)
    return figure


def _write(options: argparse.Namespace) -> int:
    with TemporaryDirectory() as folder:
        library = Path(folder, "libbilinear.so")
        command = ["gfortran", "-ffree-form", "-shared", "-fPIC", "-O1", SOURCE, "-o", library]
        subprocess.run(command, check=True)
        save(draw(library), options.output)
    print(options.output)
    return 0


main = program(_write, ("-o --output FILE", "picture, .png or .pdf", Path("any-umat.png")))

if __name__ == "__main__":
    sys.exit(main())
