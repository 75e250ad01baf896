"""The material block of Akantu."""

from __future__ import annotations

from asperity import contract
from asperity.cards.blocks import Block, remarks, text_of


def block_of(block: Block) -> str:
    """Akantu: the section of a material that asperity_akantu.py of `asperity export akantu` reads."""
    run = "in Python before aka.parseInput: joints = asperity_akantu.register()"
    constants = (row.name for row in contract.owned("law", "pattern"))
    return text_of(
        *remarks(block, run, "at the end of every step: joints[0].commit()", mark="# "),
        "material asperity [",
        f"  name = {block.name}",
        *(f"  {name} = {block.prop(name)!r}" for name in constants),
        "]",
    )
