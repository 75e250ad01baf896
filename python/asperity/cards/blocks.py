"""Material blocks for the input of host programs."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass

from .. import contract
from ..contract import refuse
from ..installed import kratos_adapter, library
from . import generic

PER_LINE = 8  # largest number of constants on a line of an Abaqus or CalculiX input
CALCULIX_MAX_CONSTANTS = 21
"""Largest number of constants that CalculiX accepts; it does not check their number."""


KRATOS = {
    2: ("SmallStrainUMAT2DLineInterfaceLaw", "Geo_ULineInterfacePlaneStrainElement", (2, 3)),
    3: ("SmallStrainUMAT3DSurfaceInterfaceLaw", "Geo_USurfaceInterfaceElement", (4, 3, 8, 6)),
}
"""Law and interface element of Kratos by dimension, and the numbers of nodes of its faces."""

REGULAR = ("akantu", "calculix", "cast3m", "fenicsx", "mtest", "ogs")
"""Hosts that take no listed planes, m < 0."""
ONLY: dict[str, dict[str, float]] = {
    "akantu": {"h": 1, "map": 0, "dalpha": 0, "water": 0},
    "calculix": {"map": 0, "dimension": 3, "water": 0},
    "cast3m": {"h": 1, "map": 0, "r": 0, "water": 0},
    "fenicsx": {"h": 1, "map": 0, "dalpha": 0, "water": 0},
    "kratos": {"h": 1, "map": 0, "water": 0},
    "mtest": {"h": 1, "map": 0, "r": 0, "dimension": 3, "water": 0},
    "ogs": {"map": 0, "dalpha": 0, "water": 0},
    "oofem": {"map": 0, "dalpha": 0, "dimension": 3, "water": 0},
}
"""Constants, and the dimension, of which a host takes one value only."""

WHY = {
    "h": ", whose joints pass separations", "map": ", whose order of components is fixed",
    "dalpha": ", which ignores a request for a smaller step", "r": ", whose joint has no other stress",
    "water": ", which passes no predefined field to the law",
}  # fmt: skip


AT_FIRST = (
    "** Zero state variables are the initial state of the joint, so no initial conditions are needed.",
    "** The first call of a point reads an initial stress (TYPE=STRESS).",
)


@dataclass(frozen=True)
class Block:
    """Contents of a material block; props and statev are in the order of the library."""

    name: str
    props: contract.Floats
    statev: tuple[str, ...]
    notes: Sequence[str] = ()
    dimension: int = 3
    explicit: bool = False
    density: float | None = None
    stiffness: tuple[float, float] = (0.0, 0.0)  # largest in shear and in opening, for Cast3M

    def prop(self, name: str) -> float:
        """Entry of PROPS by name."""
        return float(self.props[contract.index(name)])

    def thickness(self) -> float:
        """Thickness by which the host divides; 0 stands for 1."""
        return self.prop("h") or 1.0


def card(host: str, block: Block) -> str:
    """Text for the input of a host; raises ValueError for a value that the host cannot take."""
    refuse(host not in HOSTS, f"host = {host!r}: expected one of {', '.join(HOSTS)}")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", block.name):
        raise ValueError(
            f"name = {block.name!r}: expected a letter, then up to 39 letters, digits or underscores"
        )
    refuse(block.dimension not in (2, 3), f"dimension = {block.dimension}: expected 2 or 3")
    if host != "abaqus" and (block.explicit or block.density is not None):
        raise ValueError(f"explicit, density: expected for abaqus only, not for {host}")
    if block.density is not None and not 0.0 < block.density < float("inf"):
        raise ValueError(f"density = {block.density:g}: expected > 0")
    if host in REGULAR and block.prop("m") < 0.0:
        raise ValueError(f"m = {block.prop('m'):g}: expected a regular pattern for {host}, not listed planes")
    for name, expected in ONLY.get(host, {}).items():
        of_host = {"dimension": block.dimension, "h": block.thickness()}
        if (value := of_host[name] if name in of_host else block.prop(name)) != expected:
            raise ValueError(f"{name} = {value:g}: expected {expected:g} for {host}{WHY.get(name, '')}")
    return HOSTS[host](block)


def _abaqus(block: Block) -> str:
    """Block for Abaqus, with the unsymmetric solver that friction needs and names of the state variables."""
    run = f"abaqus job=NAME user=asperity_abaqus.f90{' double=both' if block.explicit else ''}"
    if block.explicit and block.density is None:
        raise ValueError("density is missing: expected a density (> 0) for Abaqus/Explicit")
    # A VUMAT stores the separation there, because the host passes none.
    names = [text.replace("offset", "separation") if block.explicit else text for text in block.statev]
    element = "COH3D8, COH3D6" if block.dimension == 3 else "COH2D4, COHAX4"
    density = [] if block.density is None else ["*Density", f"{block.density!r},"]
    field = block.prop("water")
    water = f"** *Field, variable={field:.0f} is the water pressure in the joint, >= 0; stresses are total."
    return _text(
        _comments(block, run),
        f"*Material, name={block.name}",
        *density,
        f"*User Material, constants={len(block.props)}{'' if block.explicit else ', unsymm'}",
        *_constants(block.props),
        "** No DELETE, because contact survives rupture. status is 1 after the first call of a point.",
        *AT_FIRST,
        "** TYPE=SOLUTION gives cracked planes.",
        *([water] if field else []),
        "*Depvar",
        f"{len(block.statev)},",
        *(f"{i}, {text}, {text}" for i, text in enumerate(names, 1)),
        f"** Elements: {element}. Tx is their first shear direction, which an orientation rotates.",
        f"*Cohesive Section, elset={block.name}, material={block.name}, response=TRACTION SEPARATION, "
        "thickness=SPECIFIED",
        f"{block.thickness()!r},",
    )


def _calculix(block: Block) -> str:
    """Block for CalculiX, whose UMATs have a name that begins with ABAQUS; names of SDV are comments."""
    for row in contract.props_table()[CALCULIX_MAX_CONSTANTS : contract.N_USED_PROPS]:
        if block.prop(row.name) != row.default:
            raise ValueError(
                f"{row.name} = {block.prop(row.name):g}: expected {row.default:g} for calculix, which passes "
                f"at most {CALCULIX_MAX_CONSTANTS} constants"
            )
    props = block.props[:CALCULIX_MAX_CONSTANTS]
    name = block.name.upper()
    if name.startswith("NL"):
        raise ValueError(
            f"name = {block.name!r}: expected none that begins with NL, which selects calculix' log strains"
        )
    return _text(
        _comments(block, "ccx with the UMAT of asperity linked in", len(props)),
        *(f"** SDV{i}: {text}" for i, text in enumerate(block.statev, 1)),
        f"*MATERIAL, NAME=ABAQUS{name}",
        "** All constants are given: 8 or 16 of them would need a further line, with the temperature.",
        f"*USER MATERIAL, CONSTANTS={len(props)}",
        *_constants(props),
        *AT_FIRST,
        "** TYPE=SOLUTION, USER gives cracked planes.",
        "*DEPVAR",
        f"{len(block.statev)}",
        "** The section is one layer of C3D8 (not C3D8R or C3D8I) with its normal along z, without NLGEOM, "
        f"of the thickness h = {block.thickness()!r}.",
        f"** r = {block.prop('r')!r}: 0 suits a layer bonded on both faces, 1e-9 one that stretches freely.",
        f"*SOLID SECTION, ELSET={name}, MATERIAL=ABAQUS{name}",
    )


def _kratos(block: Block) -> str:
    """Block for Kratos GeoMechanicsApplication: properties of the zero-thickness interface elements."""
    law, element, nodes = KRATOS[block.dimension]
    material = {
        "model_part_name": block.name,
        "properties_id": 1,
        "Material": {
            "constitutive_law": {"name": law},
            "Variables": {
                "UDSM_NAME": str(kratos_adapter()),
                "IS_FORTRAN_UDSM": True,
                "GEO_DRAINAGE_TYPE": "constant_pw_field",  # else the rows of the water pressure are 0/0
                "BIOT_COEFFICIENT": 0.0,  # the water pressure is not coupled with the displacements
                "UMAT_PARAMETERS": block.props.tolist(),
                "STATE_VARIABLES": [0.0] * len(block.statev),
            },
        },
    }
    names = {f"STATE_VARIABLE_{i}": text for i, text in enumerate(block.statev, 1)}
    history = (
        "UDSM_NAME is the commit adapter, because these elements commit no step. An analysis with "
        "libasperity.so in its place runs, but damage heals on unloading"
    )
    initial = (
        "Zero STATE_VARIABLES are the initial state of the joint. Kratos passes no initial stress to a UMAT; "
        "a state of Interface.initial in place of the zeros has an initial stress"
    )
    elements = [f"{element}{k}Plus{k}N" for k in nodes]
    notes = {"elements": elements, "notes": [*block.notes, history, initial], "state_variables": names}
    return json.dumps(notes | {"properties": [material]}, indent=2) + "\n"


def _ogs(block: Block) -> str:
    """OpenGeoSys: a patch of the project, `ogs -p CARD PROJECT`."""
    law = generic.behaviour(contract.check(block.props)[0])
    comments = _remarks(
        block,
        "ogs -p THIS_FILE PROJECT.prj",
        f"the layer has the material id 1 and the thickness h = {block.thickness()!r}: adapt both",
        "axes: N, Tx, Ty of the layer, here of a horizontal one; a project has one local_coordinate_system, "
        "whose parameters may be of the type MeshElement",
        "zero state variables are the initial state of the joint; initial_values gives another one",
    )
    return generic.patch(block.name, law, block.props, block.dimension, comments)


def _mtest(block: Block) -> str:
    """MTest: behaviour and properties; `asperity card` adds the load path of the case."""
    law = generic.behaviour(contract.check(block.props)[0], "mtest", "Joint")
    return generic.mtest_head(law, block.props, _remarks(block, "mtest THIS_FILE.mtest", mark="// "))


def _cast3m(block: Block) -> str:
    """Cast3M: model and material of joint elements, in Gibiane."""
    law = generic.behaviour(contract.check(block.props)[0], "cast3m", "Castem")
    comments = _remarks(
        block,
        "LD_LIBRARY_PATH=FOLDER_OF_THE_LIBRARY castem THIS_FILE.dgibi",
        f"{block.name}: the mesh of joint elements, JOI4 or JOT3, in two dimensions JOI2",
        "KS and KN are those of the operator with which Cast3M iterates, not constants of the law",
        "MTest calls this function as Cast3M does; Cast3M itself was not run",
        mark="* ",
    )
    return _text(*comments, *generic.castem(block.name, law, block.props, block.stiffness))


def _oofem(block: Block) -> str:
    """OOFEM: the record of a material; it loads the UMAT of the library."""
    names = ", ".join(f"{i} {text}" for i, text in enumerate(block.statev, 1))
    props = " ".join(repr(value) for value in block.props.tolist())
    return _text(
        *_remarks(
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


def _akantu(block: Block) -> str:
    """Akantu: the section of a material that asperity_akantu.py of `asperity export akantu` reads."""
    run = "in Python before aka.parseInput: joints = asperity_akantu.register()"
    constants = (row.name for row in contract.owned("law", "pattern"))
    return _text(
        *_remarks(block, run, "at the end of every step: joints[0].commit()", mark="# "),
        "material asperity [",
        f"  name = {block.name}",
        *(f"  {name} = {block.prop(name)!r}" for name in constants),
        "]",
    )


def _fenicsx(block: Block) -> str:
    """FEniCSx: the law in Python, for harness/hosts/fenicsx/jointed.py."""
    law, pattern = (
        ", ".join(f"{row.name}={block.prop(row.name)!r}" for row in contract.owned(owner) if row.name != "m")
        for owner in ("law", "pattern")
    )
    run = f'Model(mesh, {{"{block.name}": {block.name}}}, E, nu) of jointed.py'
    return _text(
        *_remarks(block, run, mark="# "),
        "from asperity import Interface, Material, Pattern",
        "",
        f"{block.name} = Interface(Material({law}), Pattern({block.prop('m'):.0f}, {pattern}))",
    )


def _comments(block: Block, run: str, count: int = contract.N_USED_PROPS) -> str:
    """Head of a block: its origin, the first entries of PROPS, how to run it, and the notes."""
    names = ", ".join(row.name for row in contract.props_table()[:count])
    head, *others = _remarks(block, run, mark="** ")
    return "\n".join([f"{head}: {names}", *others])


def _remarks(block: Block, run: str, *more: str, mark: str = "") -> list[str]:
    """Lines at the head of a block, after a mark: its origin, how to run it, the notes, and more."""
    units = "units: one consistent set, such as mm, N, MPa, N/mm; theta and turn in degrees"
    texts = f"asperity {contract.library_version()}", units, run, *block.notes, *more
    return [f"{mark}{text}" for text in texts]


def _text(*lines: str) -> str:
    return "\n".join(lines) + "\n"


def _constants(props: contract.Floats) -> list[str]:
    texts = [repr(value) for value in props.tolist()]
    return [", ".join(texts[i : i + PER_LINE]) for i in range(0, len(texts), PER_LINE)]


HOSTS = {
    "abaqus": _abaqus, "akantu": _akantu, "calculix": _calculix, "cast3m": _cast3m, "fenicsx": _fenicsx,
    "kratos": _kratos, "mtest": _mtest, "ogs": _ogs, "oofem": _oofem,
}  # fmt: skip
"""Writers of the blocks by host."""
