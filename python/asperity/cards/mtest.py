"""Input of MTest (TFEL): a "generic" behaviour with its properties, and the load path of a case."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import contract
from ..installed import generic_library
from ..pattern import direction_vector
from ..steps import Step, prescribed
from . import opengeosys

FORCES, OPENINGS = ("Tn", "Tt1", "Tt2"), ("Un", "Ut1", "Ut2")
"""Names of N, Tx, Ty in MTest."""


def head(law: str, props: contract.Floats, comments: Sequence[str]) -> str:
    """Behaviour and all its material properties; it has no external state variable."""
    lines = [
        *(f"// {text}" for text in comments),
        "@ModellingHypothesis 'Tridimensional';",
        f"@Behaviour<generic> '{generic_library()}' '{law}';",
    ]
    for name in opengeosys.property_names(law):
        lines.append(f"@MaterialProperty<constant> '{name}' {float(props[contract.index(name)])!r};")
    return "\n".join(lines) + "\n"


def path(steps: Sequence[Step]) -> str:
    """Evolutions of the prescribed components, and times.

    steps: of a case that was read, with lists of all targets, increments and times. Raises ValueError for
    what MTest cannot take.
    """
    kinds = set(prescribed(steps))
    if len(kinds) != 1:
        raise ValueError(
            f"steps with {len(kinds)} sets of prescribed components: expected one for mtest, the same "
            "tractions and separations in all steps"
        )
    [tractions] = kinds
    times, values, numbers = [0.0], [np.zeros(3)], []
    for number, step in enumerate(steps, 1):
        if step.follow == "branch":
            raise ValueError(f"step {number}: follow = 'branch': expected 'stable' for mtest")
        for name in ("k_N", "k_Tx", "k_Ty"):
            if getattr(step, name):
                raise ValueError(f"step {number}: {name} = {getattr(step, name):g}: expected 0 for mtest")
        targets = {
            i: given
            for i, axis in enumerate(("N", "Tx", "Ty"))
            if (given := getattr(step, f"{'t' if tractions[i] else 's'}_{axis}")) is not None
        }
        if step.slip is not None:
            targets[1], targets[2] = np.outer(direction_vector(step.direction), step.slip)
        for k, duration in enumerate(step.time):
            values.append(values[-1].copy())
            for i, one in targets.items():
                values[-1][i] = one[k]
            times.append(times[-1] + duration)
            numbers.append(round(step.increments[k]))
    lines = []
    for i, column in enumerate(np.array(values).T):
        keyword, name = (
            ("@ImposedCohesiveForce", FORCES[i])
            if tractions[i]
            else ("@ImposedOpeningDisplacement", OPENINGS[i])
        )
        pairs = ", ".join(
            f"{time!r} : {float(value) + 0.0!r}" for time, value in zip(times, column, strict=True)
        )
        lines.append(f"{keyword} '{name}' {{{pairs}}};")
    parts = ", ".join(f"{time!r} in {n}" for time, n in zip(times[1:], numbers, strict=True))
    return "\n".join([*lines, f"@Times {{0.0, {parts}}};"]) + "\n"
