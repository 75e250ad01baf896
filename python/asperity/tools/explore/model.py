"""What the page shows: curves, planes and a section of a joint along a slip cycle, and texts to copy."""

from __future__ import annotations

import re
import textwrap
import warnings
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ... import contract
from ...case_writer import case_text, props_line
from ...contract import Floats
from ...history import EquilibriumLost, History
from ...interface import Interface
from ...material import Material, ModelWarning
from ...pattern import Pattern, direction_vector
from ..fit.model import MATERIAL, TIMELESS, plausible
from ..pattern_pictures import outlines
from ..surface.slopes import Planes

START = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 20.0, "theta": 30.0}
"""Values at the start that are not the defaults."""

LARGEST_STRESS, LARGEST_SLIP = 3.0, 0.4  # MPa and mm, with which the plausible ranges are multiplied
LABELS = {"stress": "MPa", "length": "mm", "stress*length": "N/mm", "degree": "°"}  # units of the page
DECADES = 3.0  # range of a constant above which its slider moves the logarithm to the base 10


def _slider(row: contract.Prop) -> tuple[float, str, float, float, float]:
    """Value, title, ends (0 from a linear scale on) and step of the slider of a constant."""
    value = START.get(row.name, row.default or 0.0)
    title = f"{re.split(r'[;,(]', row.meaning)[0].strip()}, {row.name} [{LABELS.get(row.unit, row.unit)}]"
    low, high = plausible(row.name, LARGEST_STRESS, LARGEST_SLIP)
    if row.scale == "log" and np.log10(high / low) > DECADES:
        return value, title, float(np.floor(np.log10(low))), float(np.ceil(np.log10(high))), 0.01
    # a logit scale ends at 0 and 1, which only a pattern and the damage may have
    least, most = (low, high) if row.lower > 0.0 else (0.0, 1.0 if row.scale == "logit" else high)
    return value, title, least, most, 0.5 if high > 10.0 else 0.01


SLIDERS = {row.name: _slider(row) for row in TIMELESS} | {
    "sides": (8.0, "inclined planes", 0, 16, 1),
    "direction": (0.0, "direction of the slip [°]", 0.0, 180.0, 1.0),
    "sigma_N": (-1.0, "normal traction sigma_N [MPa], pressure < 0", -20.0, 4.0, 0.1),
    "slip": (0.4, "slip [mm]", -2.0, 2.0, 0.01),
}
"""Value at the start, title, ends (logarithms of those of LOGARITHMIC) and step of a slider, by name."""

LOGARITHMIC = (*(row.name for row in TIMELESS if SLIDERS[row.name][2] < 0.0), "slip")
"""Values whose sliders move their logarithms to the base 10; the lowest place of OPTIONAL is 0, none."""

OPTIONAL = tuple(name for name in LOGARITHMIC if SLIDERS[name][0] == 0.0)

VALUES = {name: row[0] for name, row in SLIDERS.items()}

CYCLES: dict[str, tuple[float, ...]] = {
    "one way": (1.0,),
    "there and back": (1.0, 0.0),
    "one cycle": (1.0, -1.0, 1.0),
    "three cycles": (1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0),
}
"""Slips at the reversals, over the value of `slip`."""

PRELOAD = 50  # increments of the preload
INCREMENTS = 100  # increments of a stroke from 0 to `slip`
MARGIN = 1.15  # half width of the section over its longest slip
WIDTH = 56  # characters of a line of the material in the script
POINTS = 60  # points of a slope of the section


@dataclass(frozen=True, eq=False)
class Choice:
    """Values by name, as in VALUES, and the cycle, one of CYCLES."""

    values: dict[str, float]
    cycle: str

    @property
    def interface(self) -> Interface:
        """Joint; raises ValueError with the message of the library."""
        material = Material(**{name: self.values[name] for name in MATERIAL})
        sides, theta, flat = (self.values[name] for name in ("sides", "theta", "flat"))
        return Interface(material, Pattern.regular(int(sides), theta if sides else 0.0, flat))

    @property
    def turns(self) -> list[float]:
        """Slips at the reversals and at the end."""
        return [share * self.values["slip"] for share in CYCLES[self.cycle]]

    @property
    def parts(self) -> list[int]:
        """Increments between them."""
        return [round(INCREMENTS * abs(b - a)) for a, b in pairwise((0.0, *CYCLES[self.cycle]))]

    @property
    def slips(self) -> Floats:
        """Slips of all rows, from zero on."""
        ends = np.cumsum([0, *self.parts])
        return np.interp(np.arange(ends[-1] + 1), ends, [0.0, *self.turns])


@dataclass(frozen=True, eq=False)
class Answer:
    """Rows of a choice, and warnings; lost: what happened where they end early."""

    choice: Choice
    interface: Interface
    history: History
    warnings: tuple[str, ...]
    lost: str

    @property
    def slip(self) -> Floats:
        """Slip along the direction of the test."""
        return self.history.slip_along(self.choice.values["direction"])

    @property
    def tau(self) -> Floats:
        """Traction along this direction."""
        return self.history.tau_along(self.choice.values["direction"])

    @property
    def e(self) -> Floats:
        """Direction of the slip."""
        return direction_vector(self.choice.values["direction"])


def answer(choice: Choice) -> Answer:
    """Rows of a choice; raises ValueError with the message of the library for values that it refuses."""
    interface = choice.interface
    sigma_N, direction = choice.values["sigma_N"], choice.values["direction"]
    lost = ""
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always", ModelWarning)
        try:
            history = interface.confined_slip(direction, choice.slips, sigma_N, PRELOAD)
        except EquilibriumLost as error:
            history, lost = error.history, str(error)
    texts = dict.fromkeys(str(warning.message) for warning in issued)
    return Answer(choice, interface, history, tuple(texts), lost)


def plan(pattern: Pattern) -> tuple[list[list[float]], list[list[float]]]:
    """Outlines of the planes of the lower side from above, in their order; areas are those of their weights.

    The flat plane is the bottom of a hollow, and each inclined plane stands where a slip climbs it.
    """
    if pattern.m == 0 or pattern.flat == 1.0:
        shapes = [np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])]
    else:
        size = np.sqrt(2.0) / np.cos(np.pi / (pattern.m if pattern.m > 2 else 4))
        flat, sides = outlines(pattern, size)
        shapes = [-part for part in ([flat, *sides] if pattern.flat > 0.0 else sides)]
    return [shape[:, 0].tolist() for shape in shapes], [shape[:, 1].tolist() for shape in shapes]


def section(answer: Answer, row: int) -> tuple[Floats, Floats, tuple[float, float]]:
    """Profile of the lower side along the slip, x and z, and the place (slip, s_N) of the upper one in a row.

    On either side of a flat part stands the plane that climbs most steeply in this direction, as steep as the
    slip meets it; the end of the asperities and their wear show.
    """
    values = answer.choice.values
    width = MARGIN * 2.0 * max(abs(turn) for turn in answer.choice.turns)
    flat = width * min(float(values["flat"]), 0.9) if values["sides"] else width
    u = np.linspace(0.0, width, POINTS)
    right = np.column_stack([u + 0.5 * flat, _climb(answer, row, u, 1.0)])
    left = np.column_stack([-u - 0.5 * flat, _climb(answer, row, u, -1.0)])[::-1]
    x, z = np.vstack([left, right]).T
    history = answer.history
    place = (float(answer.slip[row]), float(history.dilation[row])) if len(history) else (0.0, 0.0)
    return x, z, place


def _climb(answer: Answer, row: int, u: Floats, sense: float) -> Floats:
    """Height of the plane that climbs most steeply along the slip, or against it."""
    slopes = sense * (Planes.of(answer.interface.pattern).gradients @ answer.e)
    plane = int(np.argmax(slopes))
    return _profile(answer, row, plane, np.maximum(slopes[plane], 0.0) * u)


def in_contact(answer: Answer, row: int) -> list[bool]:
    """Whether the two sides of each plane touch."""
    s_N, *slip = answer.history.separation[row]
    rises = Planes.of(answer.interface.pattern).gradients @ slip
    return [bool(s_N < _profile(answer, row, plane, rise)) for plane, rise in enumerate(rises)]


def _profile(answer: Answer, row: int, plane: int, rise: Floats) -> Floats:
    """Height of a facet from that of its straight plane: it ends at the height, and wears."""
    height = answer.interface.material.height
    if height > 0.0:
        rise = np.where(rise > 0.0, -height * np.expm1(-np.maximum(rise, 0.0) / height), rise)
    if answer.history.wears and len(answer.history):
        rise = rise * (1.0 - answer.history.worn(plane + 1)[row])
    return rise


def as_case(choice: Choice) -> str:
    """Case file of a choice."""
    values = choice.values
    pattern = {name: values[name] for name in ("theta", "flat")} if values["sides"] else {}
    slip = {"slip": choice.turns, "direction": values["direction"], "increments": choice.parts}
    return case_text(
        ("case", {"title": "Explored"}),
        ("material", {name: values[name] for name in MATERIAL}),
        ("pattern", {"sides": values["sides"]} | pattern),
        ("step", {"t_N": values["sigma_N"], "increments": PRELOAD}),
        ("step", slip),
    )


def as_python(choice: Choice) -> str:
    """Python script of a choice."""
    values = choice.values
    material = textwrap.wrap(", ".join(f"{name}={values[name]!r}" for name in MATERIAL), WIDTH)
    theta = values["theta"] if values["sides"] else 0.0
    return "\n".join([
        "from asperity import Interface, Material, Pattern, Step\n",
        "material = Material(", *(f"    {line}" for line in material), ")",
        "pattern = Pattern.regular(",
        f"    {int(values['sides'])}, theta={theta!r}, flat={values['flat']!r}\n)",
        "test = Interface(material, pattern).run([",
        f"    Step(t_N={values['sigma_N']!r}, increments={PRELOAD}),",
        f"    Step(slip={choice.turns}, direction={values['direction']!r},",
        f"         increments={choice.parts}),\n])\nprint(test)\n",
    ])  # fmt: skip


def as_props(choice: Choice) -> str:
    """Line with PROPS; raises ValueError for values that the library refuses."""
    return props_line(choice.interface.props(), 17) + "\n"


TEXTS = {"case": as_case, "Python": as_python, "PROPS": as_props}  # what can be copied
