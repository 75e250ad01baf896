"""UMAT and VUMAT of a shared library, called as Abaqus calls them, and the decks of one element with them."""

from __future__ import annotations

import ctypes
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from asperity.mesh.abaqus import read_model
from asperity.mesh.deck import Block
from asperity.mesh.deck_model import Model
from support_calls import umat, vumat


def model(text: str) -> Model:
    """What a deck of one file names, by the resolver of the package."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "job.inp"
        path.write_text(text, encoding="utf-8")
        return read_model(path)


def numbers(deck: Model, keyword: str) -> np.ndarray:
    """All numbers below the only block of a keyword."""
    [block] = [block for block in deck.deck if block.keyword == keyword]
    return np.array([value for k, words in block.rows() for value in block.numbers(words, k)])


def states_of(deck: Model) -> int:
    """Number of state variables."""
    [block] = [block for block in deck.deck if block.keyword == "DEPVAR"]
    return int(next(block.rows())[1][0])


def loads(deck: Model) -> list[tuple[np.ndarray, float, float]]:
    """Numbers of the procedure, pressure and displacement along x at the end of each step; the area is 1."""
    steps: list[dict[str, Block]] = []
    pressure = slip = 0.0
    for block in deck.deck:
        if block.keyword == "STEP":
            steps.append({})
        elif steps:
            steps[-1][block.keyword] = block
    ends = []
    for step in steps:
        for block in (step[name] for name in ("CLOAD", "BOUNDARY") if name in step):
            [(_, (nodes, direction, *values))] = block.rows()
            if block.keyword == "CLOAD":
                assert direction == "3"
                pressure = -len(deck.members(deck.model, "NSET", nodes.upper())) * float(values[0])
            elif len(values) == 2:
                assert direction == values[0] == "1"
                slip = float(values[1])
        [(_, words), *_] = step.get("DYNAMIC", step.get("STATIC")).rows()
        ends.append((np.array([float(word) for word in words if word]), pressure, slip))
    return ends


def run_standard(deck: Model, library: Path) -> np.ndarray:
    """Displacements along x and z, force along x and damage after every increment of the last step."""
    states = states_of(deck)
    routines, props = ctypes.CDLL(str(library)), numbers(deck, "USER MATERIAL")
    stress, statev, strain = np.zeros(3), np.zeros(states), np.zeros(3)
    pressure = slip = 0.0
    for (size, duration), pressure_end, slip_end in loads(deck):
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


def run_explicit(deck: Model, library: Path, single: bool = False) -> np.ndarray:
    """The same by central differences, with loads that grow smoothly; half the mass is on the upper face."""
    density = numbers(deck, "DENSITY")[0]
    kind = np.float32 if single else np.float64
    props = np.array(numbers(deck, "USER MATERIAL"), dtype=kind)
    section = ctypes.CDLL(str(library)), props, np.full(1, density, dtype=kind)
    stress, statev = np.zeros((1, 3)), np.zeros((1, states_of(deck)))
    probe = vumat(*section, (0.0, 1.0), np.array([[1.0e-6, 0.0, 0.0]]), stress, statev)
    assert (probe.state == statev).all()
    dt = 0.8 * 2.0 / np.sqrt(float(probe.stress[0, 0]) / 1.0e-6 / (0.5 * density))
    total = z = velocity = x = force = slip = 0.0
    for (duration,), pressure_end, slip_end in loads(deck):
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
