"""The material block of LS-DYNA."""

from __future__ import annotations

from collections.abc import Sequence

from asperity import contract
from asperity.cards.blocks import Block, numeral, remarks, text_of

MODEL, PREVIOUS = 41, 3
"""Number of the user material, and history variables behind STATEV: the separation at the start."""

FIELDS = 8
"""Fields of a line, of 20 characters each where the keyword ends with a plus sign."""


def block_of(block: Block) -> str:
    """A cohesive user material, with the density per area; P35 and P36 are stiffnesses for contacts."""
    if block.density is None:
        raise ValueError("density is missing: expected a density (> 0), the mass per area, for LS-DYNA")
    constants = [0.0, 0.0, *block.props[: contract.N_FIXED_PROPS].tolist(), *reversed(block.stiffness)]
    history = len(block.statev) + PREVIOUS
    names = (f"history {i}: {text.replace('offset', 'separation')}" for i, text in enumerate(block.statev, 1))
    last = f"history {history - 2} to {history}: separation of the last call"
    run = "umat41c.f of `asperity export lsdyna` in place of umat41c; double precision; ELFORM 19 or 20"
    bulk = len(constants) - 1
    return text_of(
        *remarks(block, run, *names, last, mark="$ "),
        "*MAT_USER_DEFINED_MATERIAL_MODELS_TITLE +",
        block.name,
        "$ mid, ro (per area, as P1 is 0), mt, lmc, nhv, iortho, ibulk, ig",
        _line([1, numeral(block.density), MODEL, len(constants), history, 0, bulk, bulk + 1]),
        "$ ivect, ifail: the routine is one of blocks, and no element fails",
        _line([1, 0, 0, 0, 0, 0]),
        "$ P3 to P34 are PROPS",
        *(
            _line([numeral(value) for value in constants[i : i + FIELDS]])
            for i in range(0, len(constants), FIELDS)
        ),
    )


def _line(fields: Sequence[object]) -> str:
    return "".join(f"{field:>20}" for field in fields)
