"""The joint for FEniCSx."""

from __future__ import annotations

from asperity import contract
from asperity.cards.blocks import Block, remarks, text_of


def block_of(block: Block) -> str:
    """FEniCSx: the law in Python, for `asperity.fenicsx`."""
    law, pattern = (
        ", ".join(f"{row.name}={block.prop(row.name)!r}" for row in contract.owned(owner) if row.name != "m")
        for owner in ("law", "pattern")
    )
    run = f'Model(mesh, {{"{block.name}": {block.name}}}, E, nu) of asperity.fenicsx'
    return text_of(
        *remarks(block, run, mark="# "),
        "from asperity import Interface, Material, Pattern",
        "",
        f"{block.name} = Interface(Material({law}), Pattern({block.prop('m'):.0f}, {pattern}))",
    )
