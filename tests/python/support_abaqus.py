"""UMAT and VUMAT of a shared library, called as Abaqus calls them, and the decks of one element with them."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
from deck_check import Keyword, Model, props_of
from support_calls import umat, vumat


def loads(model: Model) -> list[tuple[np.ndarray, float, float]]:
    """Numbers of the procedure, pressure and displacement along x at the end of each step; the area is 1."""
    steps: list[dict[str, Keyword]] = []
    pressure = slip = 0.0
    for keyword in model.keywords:
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
                pressure = -len(model.of(keyword, "nset", nodes)) * keyword.number(values[0])
            elif len(values) == 2:
                assert direction == values[0] == "1"
                slip = keyword.number(values[1])
        procedure = step["dynamic" if model.explicit else "static"]
        numbers = np.array([procedure.number(value) for value in procedure.data[0] if value])
        ends.append((numbers, pressure, slip))
    return ends


def run_standard(model: Model, library: Path) -> np.ndarray:
    """Displacements along x and z, force along x and damage after every increment of the last step."""
    [material] = model.materials.values()
    states = len(material["depvar"].data) - 1
    routines, props = ctypes.CDLL(str(library)), np.array(props_of(material["user material"]))
    stress, statev, strain = np.zeros(3), np.zeros(states), np.zeros(3)
    pressure = slip = 0.0
    for (size, duration), pressure_end, slip_end in loads(model):
        count, rows = round(duration / size), []
        for i in range(1, count + 1):
            held = pressure + (pressure_end - pressure) * i / count
            new = np.array([strain[0], slip + (slip_end - slip) * i / count, 0.0])
            for _ in range(16):
                out = umat(routines, props, stress, statev, strain, new - strain, size)
                assert out.pnewdt[0] >= 1.0 and np.isfinite(out.stress).all()
                unbalanced = out.stress[0] + held
                if abs(unbalanced) < 1.0e-12:
                    break
                new[0] -= unbalanced / out.tangent[0, 0]
            else:
                raise AssertionError(f"increment {i}: no convergence")
            stress, statev, strain = out.stress, out.state, new
            rows.append([strain[1], strain[0], stress[1], statev[0]])
        pressure, slip = pressure_end, slip_end
    return np.array(rows)


def run_explicit(model: Model, library: Path, single: bool = False) -> np.ndarray:
    """The same by central differences, with loads that grow smoothly; half the mass is on the upper face."""
    [material] = model.materials.values()
    density = props_of(material["density"])[0]
    kind = np.float32 if single else np.float64
    props = np.array(props_of(material["user material"]), dtype=kind)
    section = ctypes.CDLL(str(library)), props, np.full(1, density, dtype=kind)
    stress, statev = np.zeros((1, 3)), np.zeros((1, len(material["depvar"].data) - 1))
    probe = vumat(*section, (0.0, 1.0), np.array([[1.0e-6, 0.0, 0.0]]), stress, statev)
    assert (probe.state == statev).all()
    dt = 0.8 * 2.0 / np.sqrt(float(probe.stress[0, 0]) / 1.0e-6 / (0.5 * density))
    total = z = velocity = x = force = slip = 0.0
    for (duration,), pressure_end, slip_end in loads(model):
        count, rows, pressure, start = int(np.ceil(duration / dt)), [], -force, slip
        step = duration / count
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
            velocity += step * (force - stress[0, 0]) / (0.5 * density)
            slip = start + smooth * (slip_end - start)
            strain = np.array([[step * velocity, 0.0, 0.5 * (slip - x)]])
            z, x, total = z + step * velocity, slip, total + step
            out = vumat(*section, (total, step), strain, stress, statev)
            stress, statev = out.stress.astype(float), out.state.astype(float)
            force = -(pressure + smooth * (pressure_end - pressure))
            rows.append([x, z, stress[0, 2], statev[0, 0]])
    return np.array(rows)
