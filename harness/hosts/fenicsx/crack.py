"""Benchmarks with closed forms on FEniCSx: a crack, half length b, in a large plate, plane strain; mm, MPa.

- friction: a closed crack, inclined to a uniaxial compression, slips (Phan 2003).
- pressure: a fluid opens the crack (Sneddon).
- dilation: the crack of the first has planes of one constant slope.  Slip and opening are then ellipses, too.
- height: the same planes end at a finite height.  There is no closed form.

The joint is fully damaged in all of them.  Elements are linear and shrink towards the tips.
"""

from __future__ import annotations

import argparse
import math
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.fenicsx import COMM, Conditions, Model, State, Terms, solve
from asperity.mesh import split
from asperity.options import add_options
from asperity.tools.style import COLOURS, TWO, new_figure, printed, save

from harness.hosts.structured import grid

B, DOMAIN = 1000.0, 100.0
"""Half length of the crack, mm, and half width of the plate over it."""
MODULUS, POISSON = 25000.0, 0.25
PLANE_STRAIN = MODULUS / (1 - POISSON**2)
ANGLE, FRICTION = math.radians(20.0), math.radians(30.0)
FAR = 100.0 * np.array([math.cos(ANGLE), -math.sin(ANGLE)])
"""Traction on a face across the compression; it drives the upper side towards +x."""
PRESSURE, THETA, HEIGHT = 10.0, 10.0, 0.5
NORMAL, SLIDING = 100.0 * math.sin(ANGLE) ** 2, 100.0 * math.sin(ANGLE) * math.cos(ANGLE)
"""Far compression and shear stress on the plane of the crack."""
COMPLIANCE = 4 / PLANE_STRAIN
"""Slip or opening over stress and sqrt(b^2 - s^2)."""
STIFF = {"friction": 1e5, "pressure": 1e5, "dilation": 1e5, "height": 1e2}
"""Stiffness of the joint over that of the plate: without effect on the slip, or one for changes of slope."""


def interface(kind: str) -> Interface:
    """Joint of a benchmark."""
    stiffness = STIFF[kind] * PLANE_STRAIN / B
    height = HEIGHT if kind == "height" else 0.0
    material = Material.from_joint(kn=stiffness, ks=stiffness, mu=math.tan(FRICTION), height=height)
    inclined = kind in ("dilation", "height")
    return Interface(material, Pattern.regular(2, THETA) if inclined else Pattern.regular(0, 0.0))


def closed_form(kind: str) -> tuple[float, float, float]:
    """Factors of sqrt(b^2 - s^2) of opening and slip, and the normal traction on the crack.

    A uniform stress that the crack lacks opens it, or makes it slip, as an ellipse.  With the slope T the
    opening is T times the slip, which raises the compression p on the crack:
    T (far shear - p tan(phi + theta)) = p - far compression.
    """
    if kind == "pressure":
        return COMPLIANCE * PRESSURE, 0.0, 0.0
    slope = math.tan(math.radians(THETA)) if kind == "dilation" else 0.0
    resistance = math.tan(FRICTION + math.atan(slope))
    pressure = (NORMAL + slope * SLIDING) / (1 + slope * resistance)
    slip = COMPLIANCE * (SLIDING - resistance * pressure)
    return slope * slip, slip, -pressure


@dataclass(frozen=True)
class Crack:
    """Points of a crack: place, weight, separation (N, Tx, Ty) and traction."""

    x: Floats
    weights: Floats
    separation: Floats
    traction: Floats

    def error(self, kind: str) -> float:
        """L2 norm of the error of opening and slip, over that of the closed form."""
        exact = np.sqrt(B**2 - self.x**2)[:, None] * closed_form(kind)[:2]
        squares = (self.weights @ vector**2 for vector in (self.separation[:, :2] - exact, exact))
        error, size = (square.sum() for square in squares)
        return float(np.sqrt(error / size))

    def imbalance(self) -> float:
        """Relative error of mean opening and slip, which follow from the tractions (theorem of Betti).

        It holds for any law of the joint: the uniform stress of the closed form is the second load case.
        """
        missing = np.array([-NORMAL, SLIDING]) - self.traction[:, :2]
        mean = COMPLIANCE * (self.weights * np.sqrt(B**2 - self.x**2)) @ missing
        return float(np.abs(self.weights @ self.separation[:, :2] - mean).max() / mean.max())


def run(kind: str, n: int) -> Crack:
    """Solve a benchmark with n elements along the crack."""
    half = 1.0 - np.linspace(1.0, 0.0, n // 2 + 1) ** 2
    far = np.geomspace(half[-1] - half[-2], DOMAIN, n)
    far = (DOMAIN - 1.0) * np.cumsum(np.diff(far, prepend=0.0)) / DOMAIN
    right, up = B * np.r_[half, 1.0 + far], B * np.r_[0.0, far]
    x, y = (np.r_[-half_axis[:0:-1], half_axis] for half_axis in (right, up))
    inside = {"joint": lambda a, b, x, normal: np.abs(x[:, 0]) < B}
    mesh = split(grid(x, y, block=y[:-1] >= 0.0), inside)
    model = Model(mesh, {"joint": interface(kind)}, MODULUS, POISSON, plane="strain")
    load = np.zeros((model.n, 2))
    pressures = {"joint": PRESSURE} if kind == "pressure" else {}
    if not pressures:
        for name, normal in {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}.items():
            nodes, share = model.group(name)
            load[nodes] -= (FAR @ normal) / 100.0 * share[:, None] * FAR
    corners = (np.abs(model.x - [end, -up[-1]]).max(axis=1) < 1e-6 for end in (-right[-1], right[-1]))
    left, right_corner = (model.dofs(corner, 0, 1) for corner in corners)
    fixed, state = (
        np.r_[left, right_corner[1:]],
        State.virgin(model),
    )  # against rigid motions: without a force
    parts = np.linspace(0.0, 1.0, 11)[1:] if kind == "height" else [1.0]
    for part in parts:
        conditions = Conditions(fixed, load=part * load.ravel(), pressures=pressures)
        report = solve(model, state, conditions, Terms(tolerance=1e-9))
        if report.state is None:
            raise RuntimeError(f"{kind}, {n} elements, part {part:g} of the load: {report.reason}")
        state = report.state
    inner = model.area > 0.0
    parts = (model.places[:, 0], model.area, state.s, state.t)
    place, *values = (np.concatenate(COMM.allgather(values_here[inner])) for values_here in parts)
    order = np.argsort(place)
    return Crack(place[order], *(column[order] for column in values))


def draw(cracks: dict[str, Crack], path: Path) -> None:
    """Slip, opening and compression along the crack; lines are closed forms."""
    with printed():
        figure, (slip, opening, compression) = new_figure(TWO, 2.9, ncols=3)
        s = B * np.sin(np.linspace(-math.pi / 2, math.pi / 2, 201))
        ellipse = np.sqrt(B**2 - s**2)
        labels = {"dilation": "constant slope", "height": "finite height", "pressure": "fluid"}
        for colour, kind in zip(COLOURS, ("friction", *labels), strict=False):
            crack = cracks[kind]
            panels = [slip, compression] if kind != "pressure" else [opening]
            panels += [opening] if kind in ("dilation", "height") else []
            for panel in panels:
                column = 1 if panel is slip else 0
                plotted = -crack.traction[:, 0] if panel is compression else crack.separation[:, column]
                panel.plot(
                    crack.x / B, plotted, ".", color=colour, markersize=3, label=labels.get(kind, kind)
                )
                if kind != "height":
                    *factors, normal = closed_form(kind)
                    exact = np.full(len(s), -normal) if panel is compression else factors[column] * ellipse
                    panel.plot(s / B, exact, color=colour, linewidth=0.8)
        slip.set(ylabel="slip [mm]", ylim=(0, 5.2))
        opening.set(ylabel="opening [mm]", ylim=(0, 2.1))
        compression.set(ylabel="compression on the crack [MPa]", ylim=(8, 20))
        for panel in (slip, opening, compression):
            panel.set(xlabel="place s/b [-]")
            panel.legend()
            panel.grid(alpha=0.3)
        save(figure, path)


def main() -> None:
    """Run all benchmarks, print errors and orders, and draw the results of the second mesh."""
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    elements = "along the crack, even (default: %(default)s)"
    add_options(
        parser,
        ("--elements N", elements, int, {"nargs": "+", "default": [16, 32, 64]}),
        ("-o --output FILE", "picture", Path),
    )
    options = parser.parse_args()
    if bad := [n for n in options.elements if n < 2 or n % 2]:
        parser.error(f"--elements {bad[0]}: expected even numbers > 0")
    show = print if COMM.rank == 0 else lambda text: None
    show("benchmark, elements, error, order, largest slip and opening, normal traction at s = 0")
    for kind in STIFF:
        cracks = [run(kind, n) for n in options.elements]
        errors = [crack.imbalance() if kind == "height" else crack.error(kind) for crack in cracks]
        for k, (n, crack, error) in enumerate(zip(options.elements, cracks, errors, strict=True)):
            order = math.log(errors[k - 1] / error) / math.log(n / options.elements[k - 1]) if k else math.nan
            opening, slip, _ = crack.separation.max(axis=0)
            normal = crack.traction[np.abs(crack.x).argmin(), 0]
            show(f"{kind} {n} {error:.6f} {order:.2f} {slip:.5f} {opening:.5f} {normal:.4f}")
        options.shown = getattr(options, "shown", {}) | {kind: cracks[-1]}
    if options.output is not None and COMM.rank == 0:
        draw(options.shown, options.output)


if __name__ == "__main__":
    main()
