"""The input of MTest (TFEL)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from asperity import contract
from asperity.cards.blocks import Block, remarks
from asperity.cards.generic import behaviour, property_names
from asperity.installed import generic_library
from asperity.pattern import direction_vector
from asperity.steps import Step, prescribed

FORCES, OPENINGS = ("Tn", "Tt1", "Tt2"), ("Un", "Ut1", "Ut2")  # names of N, Tx, Ty in MTest


def block_of(block: Block) -> str:
    """MTest: behaviour and properties; `asperity card` adds the load path of the case."""
    law = behaviour(contract.check(block.props)[0], "mtest", "Joint", block.prop("water") > 0.0)
    return _head(law, block.props, remarks(block, "mtest THIS_FILE.mtest", mark="// "))


def _head(law: str, props: contract.Floats, comments: Sequence[str]) -> str:
    """Behaviour and all its material properties, after comments."""
    values = {name: float(props[contract.index(name)]) for name in property_names(law)}
    head = "@ModellingHypothesis 'Tridimensional';", f"@Behaviour<generic> '{generic_library()}' '{law}';"
    properties = (f"@MaterialProperty<constant> '{name}' {value!r};" for name, value in values.items())
    return "\n".join([*comments, *head, *properties]) + "\n"


def path_of(steps: Sequence[Step], wet: bool) -> str:
    """Evolutions of the prescribed components, and times.

    steps: of a case that was read, with lists of all targets, increments and times.  wet: whether the law has
    the water pressure as an external state variable. Raises ValueError for what MTest cannot take.
    """
    kinds = set(prescribed(steps))
    if len(kinds) != 1:
        raise ValueError(
            f"steps with {len(kinds)} sets of prescribed components: expected one for mtest, the same "
            "tractions and separations in all steps"
        )
    [tractions] = kinds
    times, values, numbers = [0.0], [np.zeros(4)], []  # N, Tx, Ty and the water pressure
    for number, step in enumerate(steps, 1):
        if step.follow == "branch":
            raise ValueError(f"step {number}: follow = 'branch': expected 'stable' for mtest")
        for name in ("k_N", "k_Tx", "k_Ty"):
            if getattr(step, name):
                raise ValueError(f"step {number}: {name} = {getattr(step, name):g}: expected 0 for mtest")
        targets = {
            i: np.asarray(given, float)
            for i, axis in enumerate(("N", "Tx", "Ty"))
            if (given := getattr(step, f"{'t' if tractions[i] else 's'}_{axis}")) is not None
        }
        if step.slip is not None:
            targets[1], targets[2] = np.outer(direction_vector(step.direction or 0.0), np.asarray(step.slip))
        if step.p is not None:
            targets[3] = np.asarray(step.p, float)
        counts = np.asarray(step.increments, float)
        for k, duration in enumerate(np.asarray(step.time, float).tolist()):
            values.append(values[-1].copy())
            for i, ends in targets.items():
                values[-1][i] = ends[k]
            times.append(times[-1] + duration)
            numbers.append(round(counts[k]))
    lines = []
    imposed = [
        ("@ImposedCohesiveForce", FORCES[i]) if tractions[i] else ("@ImposedOpeningDisplacement", OPENINGS[i])
        for i in range(3)
    ]
    if wet:
        imposed.append(("@ExternalStateVariable", "FluidPressure"))
    for (keyword, name), column in zip(imposed, np.array(values).T, strict=False):
        pairs = ", ".join(
            f"{time!r} : {float(value) + 0.0!r}" for time, value in zip(times, column, strict=True)
        )
        lines.append(f"{keyword} '{name}' {{{pairs}}};")
    parts = ", ".join(f"{time!r} in {n}" for time, n in zip(times[1:], numbers, strict=True))
    return "\n".join([*lines, f"@Times {{0.0, {parts}}};"]) + "\n"
