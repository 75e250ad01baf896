"""The material block of CalculiX."""

from __future__ import annotations

from asperity import contract
from asperity.cards.blocks import AT_FIRST, Block, comments, constants, text_of

MAX_CONSTANTS = 21
"""Number of constants that CalculiX has room for; more overwrite its memory, unless install.sh made room."""


def block_of(block: Block) -> str:
    """Block for CalculiX, whose UMATs have a name that begins with ABAQUS; names of SDV are comments."""
    used = contract.props_table()[: contract.N_USED_PROPS]
    many = any(block.prop(row.name) != row.default for row in used[MAX_CONSTANTS:])
    props = block.props[: len(used) if many else MAX_CONSTANTS]
    room = (
        f"** CalculiX as it comes has room for {MAX_CONSTANTS} constants and overwrites its memory with "
        f"these {len(props)}: use the one of install.sh."
    )
    name = block.name.upper()
    if name.startswith("NL"):
        raise ValueError(
            f"name = {block.name!r}: expected none that begins with NL, which selects calculix' log strains"
        )
    return text_of(
        comments(block, "ccx with the UMAT of asperity linked in", len(props)),
        *(f"** SDV{i}: {text}" for i, text in enumerate(block.statev, 1)),
        f"*MATERIAL, NAME=ABAQUS{name}",
        "** All constants are given: 8 or 16 of them would need a further line, with the temperature.",
        *([room] if many else []),
        f"*USER MATERIAL, CONSTANTS={len(props)}",
        *constants(props),
        *AT_FIRST,
        "** TYPE=SOLUTION, USER gives cracked planes.",
        "*DEPVAR",
        f"{len(block.statev)}",
        "** The section is one layer of C3D8 (not C3D8R or C3D8I) with its normal along z, without NLGEOM, "
        f"of the thickness h = {block.thickness()!r}.",
        f"** r = {block.prop('r')!r}: 0 suits a layer bonded on both faces, 1e-9 one that stretches freely.",
        f"*SOLID SECTION, ELSET={name}, MATERIAL=ABAQUS{name}",
    )
