"""The material block of Abaqus."""

from __future__ import annotations

import math

from asperity.cards.blocks import AT_FIRST, Block, comments, constants, numeral, text_of


def block_of(block: Block) -> str:
    """Block for Abaqus, with names of the state variables; friction needs `unsymm`, but not with IMPL-EX."""
    run = f"abaqus job=NAME user=asperity_abaqus.f90{' double=both' if block.explicit else ''}"
    if block.explicit and block.density is None:
        raise ValueError("density is missing: expected a density (> 0) for Abaqus/Explicit")
    implex = block.prop("implex")
    if block.explicit and implex > 0.0:
        raise ValueError(f"implex = {implex:g}: expected 0 for Abaqus/Explicit, which solves no equations")
    # A VUMAT stores the separation there, because the host passes none.
    names = [text.replace("offset", "separation") if block.explicit else text for text in block.statev]
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
