"""The material block of OOFEM."""

from __future__ import annotations

from asperity.cards.blocks import Block, remarks, text_of
from asperity.installed import library


def block_of(block: Block) -> str:
    """OOFEM: the record of a material; it loads the UMAT of the library."""
    names = ", ".join(f"{i} {text}" for i, text in enumerate(block.statev, 1))
    props = " ".join(repr(value) for value in block.props.tolist())
    return text_of(
        *remarks(
            block,
            "NonLinearStatic with lstype 0 smtype 1 (unsymmetric), LSpace elements",
            f"layer of LSpace elements, its normal along z, of the thickness h = {block.thickness()!r}",
            "OOFEM goes on after a step that has not converged: look at the iterations",
            f"state: {names}",
            mark="# ",
        ),
        f"AbaqusUserMaterial 1 d 0.0 numstate {len(block.statev)} properties {len(block.props)} {props} "
        f'umat "{library()}" name "{block.name}"',
    )
