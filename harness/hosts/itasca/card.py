"""The material block of 3DEC and UDEC."""

from __future__ import annotations

from asperity.cards.blocks import Block, remarks, text_of

PER_LINE = 4
"""Properties of a command."""


def block_of(block: Block) -> str:
    """Commands that give a joint model and its properties to the contacts of a range."""
    values = [f"p{i}={value!r}" for i, value in enumerate(block.props.tolist(), 1)]
    where = f"range group '{block.name}'"
    run = "the joint model jmodelasperity of `asperity export itasca`, built and loaded as a plugin"
    axes = "n-x to t-z: N and Tx in the axes of the shear vectors, which need not be those below"
    return text_of(
        *remarks(block, run, axes, mark="; "),
        f"block contact jmodel assign asperity {where}",
        *(
            f"block contact property {' '.join(values[i : i + PER_LINE])} {where}"
            for i in range(0, len(values), PER_LINE)
        ),
        f"block contact property n-x=0 n-y=0 n-z=1 t-x=1 t-y=0 t-z=0 {where}",
    )
