"""The material block of CalculiX."""

from __future__ import annotations

import warnings

from asperity import contract
from asperity.cards.blocks import AT_FIRST, Block, comments, constants, text_of
from asperity.material import ModelWarning

MAX_CONSTANTS = 21
"""Number of constants that CalculiX has room for; more overwrite its memory, unless install.sh made room."""


def block_of(block: Block) -> str:
    """Block for CalculiX, whose UMATs have a name that begins with ABAQUS; names of SDV are comments.

    A ModelWarning says that a CalculiX as it comes has no room for the constants, where some of them need it.
    """
    used = contract.props_table()[: contract.N_USED_PROPS]
    many = [row.name for row in used[MAX_CONSTANTS:] if block.prop(row.name) != row.default]
    props = block.props[: len(used) if many else MAX_CONSTANTS]
    room = (
        f"CalculiX 2.20 as it comes has room for {MAX_CONSTANTS} constants and overwrites its memory with "
        f"these {len(props)}, without a message: use the ccx of install.sh"
    )
    name = block.name.upper()
    if name.startswith("NL"):
        raise ValueError(
            f"name = {block.name!r}: expected none that begins with NL, which selects calculix' log strains"
        )
    if many:
        warnings.warn(f"{', '.join(many)}: {room} (harness/hosts/calculix)", ModelWarning, stacklevel=4)
    return text_of(
        comments(block, "ccx with the UMAT of asperity linked in", len(props)),
        *(f"** SDV{i}: {text}" for i, text in enumerate(block.statev, 1)),
        f"*MATERIAL, NAME=ABAQUS{name}",
        "** All constants are given: 8 or 16 of them would need a further line, with the temperature.",
        *([f"** {room}."] if many else []),
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
