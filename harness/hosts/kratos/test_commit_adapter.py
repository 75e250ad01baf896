"""The commit adapter alone, called as Kratos calls a UMAT, on addresses that the test chooses.

Kratos is not needed. `make hosts` runs these tests.
"""

from __future__ import annotations

import ctypes
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.contract import Floats
from asperity.installed import named_library
from exported import from_state
from numpy.typing import ArrayLike

LIBRARY = ctypes.CDLL(str(named_library("asperity_kratos")))
ROUGH = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(4, theta=30.0))
PATH = np.array([[0.0, 0.05, 0.0], [0.03, 0.1, 0.0], [0.01, 0.01, 0.02], [-0.01, -0.05, 0.0]])
"""Separations of the steps: sliding, opening, unloading, closing."""

ROUNDING = 1.0e-12
"""Tolerance of tractions, MPa: here the separation is the sum of a start and an increment."""


class Point:
    """An integration point that never commits: every call has the initial STRESS and STATEV, and no STRAN."""

    def __init__(
        self,
        statev: ArrayLike | None = None,
        stress: ArrayLike = (0.0, 0.0, 0.0),
        props: ArrayLike | None = None,
        nstatv: int = ROUGH.nstatv,
    ) -> None:
        """Initial STATEV (nstatv,), None for zeros, and STRESS (3,); PROPS, None for those of ROUGH."""
        self.stress, self.statev = np.zeros(3), np.zeros(nstatv)
        self.props = np.array(ROUGH.props() if props is None else props)
        self.start(statev, stress)

    def start(self, statev: ArrayLike | None = None, stress: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Other initial values, on the same addresses."""
        self.initial = np.zeros(len(self.statev)) if statev is None else np.array(statev)
        self.initial_stress = np.array(stress, dtype=float)

    def call(self, step: int, separation: ArrayLike, stran: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
        """Traction (3,) at a separation (3,)."""
        self.stress[:], self.statev[:] = self.initial_stress, self.initial
        tangent, energies = np.zeros((3, 3)), np.zeros((3, 1))
        strain, increment = np.array(stran), np.array(separation) - stran
        name = ctypes.create_string_buffer(b"JOINT".ljust(80), 80)

        def double(values: Floats) -> ctypes.c_void_p:
            return ctypes.c_void_p(values.ctypes.data)

        def integer(value: int) -> object:
            return ctypes.byref(ctypes.c_int(value))

        unit, null = np.ones(2), None
        LIBRARY.umat_(
            double(self.stress), double(self.statev), double(tangent), *map(double, energies),
            null, null, null, null, double(strain), double(increment), double(unit), double(unit),
            null, null, null, null, name, *map(integer, (1, 2, 3, len(self.statev))), double(self.props),
            integer(len(self.props)), null, null, null, null, null, null,
            integer(0), integer(0), null, null, integer(step), integer(1),
        )  # fmt: skip
        return self.stress.copy()

    def follow(self, first: int = 1, path: Floats = PATH) -> Floats:
        """Tractions (T, 3) along separations, one for each step, after the trial calls of Newton's method."""
        rows = []
        for step, separation in enumerate(path, first):
            self.call(step, 3.0 * separation)
            rows.append(self.call(step, separation))
        return np.array(rows)


@pytest.fixture(autouse=True)
def forgotten() -> None:
    """Every test begins without the points of the test before, because addresses may be used again."""
    LIBRARY.asperity_kratos_reset()


def same(traction: Floats, expected: Floats) -> bool:
    """Whether tractions are equal except for rounding."""
    return bool(np.abs(traction - expected).max() <= ROUNDING)


def test_steps_are_committed() -> None:
    """The last call of a step determines the history; trial calls before it have no effect."""
    expected = ROUGH.replay(PATH).traction
    assert same(Point().follow(), expected)
    assert np.abs(ROUGH.update(PATH).traction - expected).max() > 1.0


def test_a_number_that_falls_begins_anew() -> None:
    """Another analysis with the same address and initial values starts with step 1 again."""
    point = Point()
    first = point.follow()
    assert np.array_equal(point.follow(), first)


@pytest.mark.parametrize("kind", ["statev", "stress"])
def test_other_initial_values_begin_anew(kind: str) -> None:
    """Other initial values at the same address start another analysis, although the step numbers continue."""
    point, traction = Point(), np.array([-1.0, 0.3, -0.2])
    point.follow()
    point.start(**{kind: ROUGH.initial(traction) if kind == "statev" else traction})
    tractions = point.follow(first=len(PATH) + 1)
    at_rest = np.concatenate([np.zeros((1, 3)), PATH])
    assert same(tractions, from_state(ROUGH, ROUGH.initial(traction), at_rest)[1:])


def test_numbers_that_go_on_need_a_reset() -> None:
    """Limit of the adapter: it does not recognise another analysis with the same values and address."""
    expected = ROUGH.replay(PATH).traction
    point = Point()
    point.follow()
    assert not same(point.follow(first=len(PATH) + 1), expected)
    LIBRARY.asperity_kratos_reset()
    assert same(point.follow(first=2 * len(PATH) + 1), expected)


def test_initial_stress_that_is_no_number() -> None:
    """The history of the points is correct for a host with the same arbitrary STRESS in every call."""
    tractions = Point(stress=[np.nan, np.inf, 0.0]).follow()
    assert same(tractions, ROUGH.replay(PATH).traction)


def test_a_host_that_commits() -> None:
    """A host that stores its history itself gets the results of the UMAT alone."""
    point, old = Point(), np.zeros(3)
    for step, (separation, expected) in enumerate(zip(PATH, ROUGH.replay(PATH).traction, strict=True), 1):
        point.call(step, 3.0 * separation, old)
        traction = point.call(step, separation, old)
        point.start(point.statev, traction)
        assert same(traction, expected)
        old = separation


@pytest.mark.parametrize("spare", [0, 1, 9])
@pytest.mark.parametrize("W0", [0.0, 0.5])
@pytest.mark.parametrize("pattern", [ROUGH.pattern, Pattern.planes([[1, 0.3, 0], [1, -0.3, 0]], [0.5, 0.5])])
def test_errors_of_implex(pattern: Pattern, W0: float, spare: int) -> None:
    """They are found where the contract says, although the host has more state variables than needed."""
    rough = Interface(replace(ROUGH.material, height=0.5, W0=W0), pattern)
    planes = len(rough.pattern.weights)
    place = (8 + (5 if W0 else 3) * planes) + 5 + planes
    point = Point(props=rough.props(implex=0.5), nstatv=place + 2 + spare)
    point.follow(path=PATH[:2])
    errors = (ctypes.c_double * 2)()
    LIBRARY.asperity_kratos_errors(errors)
    assert list(errors) == list(point.statev[place : place + 2])
    assert min(errors) > 0.0


def test_threads() -> None:
    """Points of several threads have separate histories."""
    points = [Point() for _ in range(400)]
    paths = [PATH * (1.0 + k / len(points)) for k in range(len(points))]
    with ThreadPoolExecutor(4) as pool:
        tractions = list(pool.map(lambda pair: pair[0].follow(path=pair[1]), zip(points, paths, strict=True)))
    for path, rows in zip(paths, tractions, strict=True):
        assert same(rows, ROUGH.replay(path).traction)
