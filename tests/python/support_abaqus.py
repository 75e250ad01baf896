"""UMAT and VUMAT of a shared library, called as Abaqus calls them, and the decks of one element with them."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
from deck_check import Keyword, Model, props_of

GARBAGE = -7.7e77
"""Value of outputs before a call, and of arguments that Abaqus does not define."""


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


class Umat:
    """UMAT: traction, state and tangent of one point at the end of an increment."""

    def __init__(self, library: Path, props: np.ndarray, ntens: int, nstatv: int) -> None:
        """Take the routine of a library for one material and one number of components."""
        self.routine = ctypes.CDLL(str(library)).umat_
        self.props = np.array(props)
        self.stress, self.tangent = np.zeros(ntens), np.zeros((ntens, ntens), order="F")
        self.statev, self.energies = np.zeros(nstatv), np.zeros(3)
        self.stran, self.dstran, self.unused = np.zeros(ntens), np.zeros(ntens), np.full(64, GARBAGE)
        self.time, self.dtime, self.pnewdt = np.zeros(2), np.zeros(1), np.zeros(1)
        self.calls = 0
        numbers = {name: ctypes.c_int(value) for name, value in (("one", 1), ("zero", 0))}
        one, none = ctypes.byref(numbers["one"]), _address(self.unused)
        self.keep = (numbers, ctypes.c_int(ntens), ctypes.c_int(ntens - 1), ctypes.c_int(nstatv))
        tens, shear, states = (ctypes.byref(value) for value in self.keep[1:])
        self.nprops = ctypes.c_int(len(props))
        self.arguments = [
            *map(_address, (self.stress, self.statev, self.tangent)),
            *(ctypes.c_void_p(self.energies.ctypes.data + 8 * i) for i in range(3)),
            *[none] * 4,
            *map(_address, (self.stran, self.dstran, self.time, self.dtime)),
            *[none] * 4,
            ctypes.create_string_buffer(b"JOINT".ljust(80), 80),
            *(one, shear, tens, states),
            *(_address(self.props), ctypes.byref(self.nprops)),
            *(none, none, _address(self.pnewdt), none, none, none),
            *[one] * 6,
            ctypes.c_size_t(80),
        ]

    def call(
        self, stress: np.ndarray, statev: np.ndarray, stran: np.ndarray, dstran: np.ndarray, dtime: float
    ) -> bool:
        """Update a point; results are in stress, statev, tangent; False: a smaller increment is asked for."""
        self.stress[:], self.statev[:], self.stran[:], self.dstran[:] = stress, statev, stran, dstran
        self.tangent[:], self.energies[:] = GARBAGE, GARBAGE
        self.dtime[0], self.pnewdt[0] = dtime, 1.0
        self.routine(*self.arguments)
        self.calls += 1
        return bool(self.pnewdt[0] >= 1.0 and np.isfinite(self.stress).all())


class Vumat:
    """VUMAT: a block of points, in double or in single precision."""

    def __init__(self, library: Path, props: np.ndarray, density: float, single: bool = False) -> None:
        """Take the routine of a library for one material; `density` is that of the section."""
        self.kind = np.float32 if single else np.float64
        self.routine = getattr(ctypes.CDLL(str(library)), "vumat_single_" if single else "vumat_")
        self.props, self.density = np.array(props, dtype=self.kind), density

    def call(
        self, total_time: float, dt: float, increment: np.ndarray, stress: np.ndarray, statev: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Stress and state variables of all points at the end; the arrays have a point in each row."""
        n, components = stress.shape
        kind = self.kind
        numbers = [ctypes.c_int(i) for i in (n, 1, components - 1, statev.shape[1], 0, len(self.props), 0)]
        times = [np.array([value], dtype=kind) for value in (total_time, total_time, dt)]
        new_stress = np.full(stress.shape, -7.7e30, dtype=kind, order="F")
        new_state = np.full(statev.shape, -7.7e30, dtype=kind, order="F")
        strain, old_stress, old_state = (
            np.asfortranarray(a, dtype=kind) for a in (increment, stress, statev)
        )
        unused, density = np.full(9 * n, -7.7e30, dtype=kind), np.full(n, self.density, dtype=kind)
        energies = [np.zeros(n, dtype=kind) for _ in range(4)]
        none = _address(unused)
        self.routine(
            *(ctypes.byref(number) for number in numbers),
            *map(_address, times),
            ctypes.create_string_buffer(b"JOINT".ljust(80), 80),
            *(none, none, _address(self.props), _address(density), _address(strain)),
            *[none] * 5,
            *map(_address, (old_stress, old_state, *energies[:2])),
            *[none] * 4,
            *map(_address, (new_stress, new_state, *energies[2:])),
            ctypes.c_size_t(80),
        )
        return np.ascontiguousarray(new_stress, dtype=float), np.ascontiguousarray(new_state, dtype=float)


def loads(found: Model) -> list[tuple[np.ndarray, float, float]]:
    """Numbers of the procedure, pressure and displacement along x at the end of each step; the area is 1."""
    steps: list[dict[str, Keyword]] = []
    pressure = slip = 0.0
    for keyword in found.keywords:
        if keyword.name == "step":
            steps.append({})
        elif steps:
            steps[-1][keyword.name] = keyword
    ends = []
    for step in steps:
        for keyword in (step[name] for name in ("cload", "boundary") if name in step):
            [(nodes, direction, *values)] = keyword.data
            if keyword.name == "cload":
                assert direction == "3"
                pressure = -len(found.of(keyword, "nset", nodes)) * keyword.number(values[0])
            elif len(values) == 2:
                assert direction == values[0] == "1"
                slip = keyword.number(values[1])
        procedure = step["dynamic" if found.explicit else "static"]
        numbers = np.array([procedure.number(value) for value in procedure.data[0] if value])
        ends.append((numbers, pressure, slip))
    return ends


def run_standard(found: Model, library: Path) -> np.ndarray:
    """Displacements along x and z, force along x and damage after every increment of the last step."""
    [material] = found.materials.values()
    states = len(material["depvar"].data) - 1
    umat = Umat(library, props_of(material["user material"]), 3, states)
    stress, statev, strain = np.zeros(3), np.zeros(states), np.zeros(3)
    pressure = slip = 0.0
    for (size, duration), pressure_end, slip_end in loads(found):
        count, rows = round(duration / size), []
        for i in range(1, count + 1):
            held = pressure + (pressure_end - pressure) * i / count
            new = np.array([strain[0], slip + (slip_end - slip) * i / count, 0.0])
            for _ in range(16):
                assert umat.call(stress, statev, strain, new - strain, size)
                unbalanced = umat.stress[0] + held
                if abs(unbalanced) < 1.0e-12:
                    break
                new[0] -= unbalanced / umat.tangent[0, 0]
            else:
                raise AssertionError(f"increment {i}: no convergence")
            stress, statev, strain = umat.stress.copy(), umat.statev.copy(), new
            rows.append([strain[1], strain[0], stress[1], statev[0]])
        pressure, slip = pressure_end, slip_end
    return np.array(rows)


def run_explicit(found: Model, library: Path, single: bool = False) -> np.ndarray:
    """The same by central differences, with loads that grow smoothly; half the mass is on the upper face."""
    [material] = found.materials.values()
    density = props_of(material["density"])[0]
    vumat = Vumat(library, props_of(material["user material"]), density, single)
    stress, statev = np.zeros((1, 3)), np.zeros((1, len(material["depvar"].data) - 1))
    probe, same = vumat.call(0.0, 1.0, np.array([[1.0e-6, 0.0, 0.0]]), stress, statev)
    assert (same == statev).all()
    dt = 0.8 * 2.0 / np.sqrt(probe[0, 0] / 1.0e-6 / (0.5 * density))
    total = z = velocity = x = force = slip = 0.0
    for (duration,), pressure_end, slip_end in loads(found):
        count, rows, pressure, start = int(np.ceil(duration / dt)), [], -force, slip
        step = duration / count
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
            velocity += step * (force - stress[0, 0]) / (0.5 * density)
            slip = start + smooth * (slip_end - start)
            strain = np.array([[step * velocity, 0.0, 0.5 * (slip - x)]])
            z, x, total = z + step * velocity, slip, total + step
            stress, statev = vumat.call(total, step, strain, stress, statev)
            force = -(pressure + smooth * (pressure_end - pressure))
            rows.append([x, z, stress[0, 2], statev[0, 0]])
    return np.array(rows)
