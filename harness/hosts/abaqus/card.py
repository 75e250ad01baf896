"""The material block of Abaqus."""

from __future__ import annotations

import math

from asperity.cards.blocks import AT_FIRST, Block, comments, constants, numeral, text_of


def block_of(block: Block) -> str:
    """Block for Abaqus, with names of the state variables; friction needs `unsymm`, but not with IMPL-EX."""
    if block.contact:
        return _interaction(block)
    run = f"abaqus job=NAME user=asperity_abaqus.f90{' double=both' if block.explicit else ''}"
    if block.explicit and block.density is None:
        raise ValueError("density is missing: expected a density (> 0) for Abaqus/Explicit")
    implex = block.prop("implex")
    if block.explicit and implex > 0.0:
        raise ValueError(f"implex = {implex:g}: expected 0 for Abaqus/Explicit, which solves no equations")
    names = _names(block)
    element = "COH3D8, COH3D6" if block.dimension == 3 else "COH2D4, COHAX4"
    density = [] if block.density is None else ["*Density", f"{numeral(block.density)},"]
    damped = []
    if block.explicit and block.density is not None and block.prop("c") > 0.0:
        # kc Kn is the larger one of the two stiffnesses
        xi = 0.5 * block.prop("c") / math.sqrt(block.stiffness[1] * block.density * block.thickness())
        share = math.hypot(1.0, xi) - xi
        damped = [
            f"** Dashpot: *Dynamic, Explicit, scale factor={share:.4g}, as the data check finds the stable",
            "** increment without c.",
        ]
    variable = block.prop("water")
    water = [
        f"** *Field, variable={variable:.0f} is the water pressure in the joint, >= 0; stresses are total.",
        "** Elements with a pore pressure (COH2D4P, COH3D8P) would count it twice: they need water = 0.",
    ]
    return text_of(
        comments(block, run),
        f"*Material, name={block.name}",
        *density,
        f"*User Material, constants={len(block.props)}{'' if block.explicit or implex else ', unsymm'}",
        *constants(block.props),
        "** No DELETE, because contact survives rupture. status is 1 after the first call of a point.",
        *AT_FIRST,
        "** TYPE=SOLUTION gives cracked planes.",
        *(water if variable else []),
        *damped,
        "*Depvar",
        f"{len(block.statev)},",
        *(f"{i}, {text}, {text}" for i, text in enumerate(names, 1)),
        f"** Elements: {element}. Tx is their first shear direction, which an orientation rotates.",
        f"*Cohesive Section, elset={block.name}, material={block.name}, response=TRACTION SEPARATION, "
        "thickness=SPECIFIED",
        f"{numeral(block.thickness())},",
    )


def _interaction(block: Block) -> str:
    """Interaction of contact pairs (UINTER, VUINTER), whose state variables are those of the nodes."""
    if block.density is not None:
        raise ValueError(f"density = {block.density:g}: expected none for contact pairs of Abaqus")
    for name, value, expected in (("h", block.thickness(), 1.0), ("water", block.prop("water"), 0.0)):
        if value != expected:
            raise ValueError(f"{name} = {value:g}: expected {expected:g} for contact pairs of Abaqus")
    implex = block.prop("implex")
    if block.explicit and implex > 0.0:
        raise ValueError(f"implex = {implex:g}: expected 0 for Abaqus/Explicit, which solves no equations")
    run = f"abaqus job=NAME user=asperity_abaqus.f90{' double=both' if block.explicit else ''}"
    options = ", mechanical constraint=PENALTY" if block.explicit else ""
    unsymm = "" if implex or block.explicit else ", unsymm"
    return text_of(
        comments(block, run),
        f"** *Contact Pair, interaction={block.name}{options}: the secondary surface,",
        "** whose nodes carry the state, then the main one. No *Surface Behavior and no *Friction beside it.",
        "** Surfaces begin in contact: s_N is the gap.",
        *(f"** STATEV {i}: {text}" for i, text in enumerate(_names(block), 1)),
        f"*Surface Interaction, name={block.name}, user, depvar={len(block.statev)}, "
        f"properties={len(block.props)}{unsymm}",
        *constants(block.props),
    )


def _names(block: Block) -> list[str]:
    """Names of the state variables; a VUMAT stores the separation as offset, because the host passes none."""
    return [text.replace("offset", "separation") if block.explicit else text for text in block.statev]
