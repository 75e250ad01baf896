"""Command `asperity joint`: constants of the law for a joint with a bond, and the peaks that they give."""

from __future__ import annotations

import argparse
import warnings

import numpy as np

from .. import contract
from ..case_writer import case_text, entries_of, pattern_entries, rounded, slip_case
from ..interface import Interface
from ..material import Material, ModelWarning
from ..model_checks import shown_warnings
from ..options import add_options, add_output, assigned, check_outputs, replace_file
from ..pattern import Pattern
from ..plausible import doubts, doubts_of_bond
from .slip_curves import slip_curves
from .tables import raise_all

REQUIRED = ("kn", "ks", "ft", "GfI", "c", "GfII", "tan_phi")
OPTIONAL = ("tan_psi", "delta", "fm", "Gfc", "Css", "kp")
UNITS = ("fb", "E", "h")
"""Strength, modulus and height of the units beside the joint."""

ANGLES = {"phi": "tan_phi", "psi": "tan_psi"}
"""Angles in degrees that may be given instead of their tangents."""

ADHESION = ("K_N", "K_T", "mu", "adhesion")
"""Constants of a cohesion that never softens, as JOINT_MECA_FROT of Code_Aster has them."""

LASTING, SLIPS = 1.0e9, (10.0, 100.0)
"""Separation at rupture of that bond, and slips in the table, over the separation at the onset of damage."""

PRESSURES = "-0.05,-0.3,-1.21"  # normal tractions of the peaks, MPa, as in tests of mortar joints
INCREMENTS, SHOWN_INCREMENTS = 2000, 400  # of the slip in which a peak is found, and of that in the case
SHOWN = ("sigma0", "Gc", "eta", "mu", "kc", "sigma02", "Gc2", "height", "fc", "Gfc", "kp")
"""Constants in the group &material; others have their default."""

ABOUT = """\
Find the constants of a joint with a bond from those of other interface models: a mortar joint, the contact of
a dam and its foundation, a lift joint of concrete, a healed rock joint. For a joint without bond see asperity
barton, or give kn, ks and mu in a case. Units are any consistent set, such as N, mm and MPa."""

NEVER = """\
The cohesion does not soften: the bond yields at the slip s0 = adhesion/K_T = {s0:g}, and breaks at
{LASTING:g} s0. In opening it holds adhesion/mu = {sigma0:g}. Friction acts on the part 1 - s0/slip.
"""
"""What the constants of a lasting cohesion mean."""

DIFFERENCES = """\
kc = 1: kn acts in closing, too, as in a joint of mortar or concrete; a stiffer contact has a larger kc.
The shear stiffness is c^2/(2 GfII (1 - eta)) = {Kt:g} and not ks = {ks:g}: one eta serves both modes.
The peak is below c + tan_phi |sigma_N|, because friction acts on the damaged part of the joint only. With a
sigma02 above c the peak reaches this value at one pressure:
"""
"""Where the law differs from other interface models."""


SERIES = """\
One joint of a prism of n courses crushes, and takes the whole energy: Gfc is the area under the measured
stress over the shortening of the prism from the peak on, plus n fm^2/(2 K) of its springs.
"""
"""How the joint's share of a measured energy is found."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    names = (
        "kn, ks: stiffnesses; ft, GfI: tensile strength and energy of mode I; c, GfII: cohesion and energy "
        "of mode II; tan_phi, or phi in degrees: residual friction; and for a dilatancy "
        "tan_psi exp(-delta slip): tan_psi, or psi in degrees, and delta (0: the dilation never ends); for a "
        "compressive strength fm, Gfc, and Css, kp; of the units fb, their strength, and E, h, their modulus "
        "and height; or K_N, K_T, mu and adhesion, a cohesion that never softens"
    )
    parser.description = ABOUT
    pressures = f"normal tractions of the peaks, <= 0 (default: {PRESSURES})"
    add_options(
        parser,
        ("values NAME=VALUE", names, str, {"nargs": "*"}),
        ("--sigma-N SIGMA_N,...", pressures, str, {"nargs": "+", "default": [PRESSURES]}),
    )
    add_output(parser, "CASE.nml", "write a case, a slip under each of these tractions, a new file")
    parser.set_defaults(action=_run)


def pattern_of(tan_psi: float) -> Pattern:
    """Pattern of a joint with a dilatancy in both directions along Tx: two planes without a flat one."""
    theta = float(np.degrees(np.arctan(tan_psi)))
    return Pattern.regular(2, theta, 0.0) if tan_psi > 0.0 else Pattern.regular(0, 0.0)


def lasting(K_N: float, K_T: float, mu: float, adhesion: float) -> Material:
    """Material of a joint whose cohesion, the adhesion, never softens: its strength is adhesion + mu p.

    K_N, K_T: stiffnesses, stress/length.  The tensile strength is adhesion/mu, where this line ends.  The
    bond breaks at LASTING times the separation of its onset.  Raises ValueError naming a value that is not
    above 0.
    """
    constants = {"K_N": K_N, "K_T": K_T, "mu": mu, "adhesion": adhesion}
    raise_all([f"{name} = {value:g}: expected > 0" for name, value in constants.items() if not value > 0.0])
    sigma0 = adhesion / mu
    Gc, Gc2 = (LASTING * strength**2 / (2.0 * K) for strength, K in ((sigma0, K_N), (adhesion, K_T)))
    return Material(sigma0, Gc, 1.0 - 1.0 / LASTING, mu, sigma02=adhesion, Gc2=Gc2)


def series(kn: float, fb: float = np.inf, E: float = np.inf, h: float = 0.0) -> float:
    """Stiffness of a joint and a unit of the height h and the modulus E in series, stress/length."""
    return 1.0 / (1.0 / kn + h / E)


def of_masonry(fm: float) -> float:
    """Energy of crushed masonry of the strength fm (MPa) in N/mm (Lourenço 1996).

    15 + 0.43 fm - 0.0036 fm^2 between 12 and 80 MPa, below 1.6 mm fm, above 0.33 mm fm.
    """
    if fm < 12.0:
        return 1.6 * fm
    return 15.0 + 0.43 * fm - 0.0036 * fm**2 if fm <= 80.0 else 0.33 * fm


def doubts_of_strength(material: Material, kn: float, fb: float = np.inf, **units: float) -> list[str]:
    """Sentences about a joint that is stronger than its units, or falls in a jump together with them."""
    texts, K = [], series(kn, **units)
    if material.fc > fb:
        texts.append(f"fm = {material.fc:g}: expected at most fb = {fb:g}, as units crush before the joint")
    if units and material.Gfc * K <= material.fc**2:
        least = material.fc**2 / K
        texts.append(
            f"Gfc = {material.Gfc:g}: expected more than fm^2/K = {least:.4g} of a course, which jumps"
        )
    return texts


def peak(material: Material, pattern: Pattern, sigma_N: float) -> float:
    """Largest shear traction of the joint in a slip test."""
    slips = np.linspace(0.0, _reach(material), INCREMENTS + 1)[1:]
    return float(np.nanmax(slip_curves(Interface(material, pattern), 0.0, slips, sigma_N).tau_L))


def strength_for_peak(material: Material, pattern: Pattern, sigma_N: float, wanted: float) -> float:
    """Strength sigma02 with which the peak is the wanted one, larger than that of the material."""
    from scipy.optimize import brentq

    def missing(sigma02: float) -> float:
        return peak(Material(**material.values() | {"sigma02": sigma02}), pattern, sigma_N) - wanted

    most = wanted
    while missing(most) < 0.0:
        most *= 2.0
    return float(brentq(missing, material.sigma02, most, rtol=1e-6))


def _run(options: argparse.Namespace) -> int:
    with shown_warnings():
        values, stresses = _checked(options)
        check_outputs(options.force, [], ("-o", options.output))
        if {*values} == {*ADHESION}:
            return _lasting(options, values, stresses)
        units = {name: values.pop(name) for name in UNITS if name in values}
        material = Material.from_masonry(**values)
        bonds = {"GfI": (values["ft"], values["GfI"]), "GfII": (values["c"], values["GfII"])}
        _warn(doubts(**values) + doubts_of_bond(**bonds))
        if material.fc > 0.0:
            _warn(doubts_of_strength(material, values["kn"], **units))
    tan_psi = values.get("tan_psi", 0.0)
    pattern = pattern_of(tan_psi)
    shown = (*SHOWN, "Css") if material.fc > 0.0 else SHOWN
    entries = entries_of({name: getattr(material, name) for name in shown})
    print(case_text(("material", entries), ("pattern", pattern_entries(pattern))))
    if tan_psi > 0.0:
        print(f"theta = arctan(tan_psi), mu = tan(phi - psi): {material.mu:.4g} on planes of that slope.")
        height = f"{material.height:.4g}" if material.height else "infinite"
        print(f"The dilation along Tx ends at the height tan_psi/delta: {height}.")
    if material.fc > 0.0:
        K = series(values["kn"], **units)
        print(SERIES + f"Stiffness of a course, joint and unit in series: K = {K:.4g}.")
    Kt = material.sigma02**2 / (2.0 * material.Gc2 * (1.0 - material.eta))
    print(DIFFERENCES.format(Kt=rounded(Kt, 3), ks=values["ks"]))
    print(f"{'sigma_N':>10}{'peak':>10}{'c + tan_phi |sigma_N|':>24}{'sigma02 for this peak':>24}")
    for sigma_N in stresses:
        wanted = values["c"] - values["tan_phi"] * sigma_N
        strength = peak(material, pattern, sigma_N)
        better = material.sigma02
        if strength < wanted:
            better = strength_for_peak(material, pattern, sigma_N, wanted)
        print(f"{sigma_N:>10g}{strength:>10.5g}{wanted:>24.5g}{better:>24.5g}")
    if options.output is not None:
        slips = [_reach(material)]
        text = slip_case("Joint with a bond", entries, pattern, stresses, slips, increments=SHOWN_INCREMENTS)
        replace_file(options.output, text)
        print(f"\n{options.output}")
    return 0


def _lasting(options: argparse.Namespace, values: dict[str, float], stresses: list[float]) -> int:
    """Print the constants of a cohesion that never softens, and its shear tractions at two slips."""
    material, pattern = lasting(**values), Pattern.regular(0, 0.0)
    _warn(doubts(mu=values["mu"]))
    entries = entries_of({name: getattr(material, name) for name in SHOWN})
    print(case_text(("material", entries), ("pattern", pattern_entries(pattern))))
    s0 = values["adhesion"] / values["K_T"]
    print(NEVER.format(LASTING=LASTING, s0=s0, sigma0=material.sigma0))
    slips = [at * s0 for at in SLIPS]
    titles = "".join(f"{f'slip {slip:.4g}':>16}" for slip in slips)
    print(f"{'sigma_N':>10}{titles}{'adhesion + mu |sigma_N|':>26}")
    path = np.linspace(0.0, slips[-1], INCREMENTS + 1)[1:]
    for sigma_N in stresses:
        tau = slip_curves(Interface(material, pattern), 0.0, path, sigma_N).tau_L.ravel()
        shown = "".join(f"{np.interp(slip, path, tau):>16.5g}" for slip in slips)
        print(f"{sigma_N:>10g}{shown}{values['adhesion'] - values['mu'] * sigma_N:>26.5g}")
    if options.output is not None:
        text = slip_case(
            "Lasting cohesion", entries, pattern, stresses, slips[-1:], increments=SHOWN_INCREMENTS
        )
        replace_file(options.output, text)
        print(f"\n{options.output}")
    return 0


def _warn(texts: list[str]) -> None:
    """Give a ModelWarning for each text."""
    for text in texts:
        warnings.warn(text, ModelWarning, stacklevel=2)


def _reach(material: Material) -> float:
    """Slip at which the bond is broken."""
    return float(2.0 * material.Gc2 / material.sigma02)


def _checked(options: argparse.Namespace) -> tuple[dict[str, float], list[float]]:
    """Constants by name and normal tractions; raises ValueError with a line for every bad one."""
    known: tuple[str, ...] = (*REQUIRED, *OPTIONAL, *ANGLES, *UNITS)
    required: tuple[str, ...] = REQUIRED
    stresses = " ".join(text for text in options.sigma_N if "=" not in text).replace(",", " ").split()
    texts = assigned([*options.values, *(text for text in options.sigma_N if "=" in text)])
    if {*texts} & {*ADHESION}:
        known, required = ADHESION, ADHESION
    names = {*texts, *(ANGLES.get(name, "") for name in texts)}
    bad = [f"{name} is missing: expected {name}=VALUE" for name in required if name not in names]
    twice = [name for name, tangent in ANGLES.items() if {name, tangent} <= {*texts}]
    bad += [f"{name} = {texts[name]}: expected without {ANGLES[name]}" for name in twice]
    values: dict[str, float] = {}
    tractions = []
    for name, text in [*texts.items(), *(("--sigma-N", text) for text in stresses)]:
        try:
            if name in ANGLES:
                angle = contract.number(name, text)
                if not 0.0 <= angle < 90.0:
                    raise ValueError(f"{name} = {text}: expected degrees, >= 0 and < 90")
                values[ANGLES[name]] = float(np.tan(np.radians(angle)))
                _warn(doubts(**{name: angle}))
            elif name in known:
                values[name] = contract.number(name, text)
            elif name in texts:
                raise ValueError(f"{name} = {text}: expected one of {', '.join(known)}")
            elif not -np.inf < contract.number(name, text) <= 0.0:
                raise ValueError(f"--sigma-N = {text}: expected a normal traction <= 0")
            else:
                tractions.append(contract.number(name, text))
        except ValueError as error:
            bad.append(str(error))
    for name in UNITS:
        if not values.get(name, 1.0) > 0.0:
            bad.append(f"{name} = {texts[name]}: expected a value > 0")
    if len({"E", "h"} & {*values}) == 1:
        bad.append("E, h: expected both, the modulus and the height of the units")
    if values.get("fm", 0.0) > 0.0 and "Gfc" not in values:
        hint = f"that of masonry with fm in MPa is {of_masonry(values['fm']):.3g} N/mm"
        bad.append(f"Gfc is missing: expected Gfc=VALUE beside fm; {hint}")
    if not values.get("fm", 0.0) >= 0.0:
        bad.append(f"fm = {texts['fm']}: expected a compressive strength >= 0")
    if not values.get("fm"):
        alone = [name for name in ("Gfc", "Css", "kp", *UNITS) if name in values]
        bad += [f"{name} = {texts[name]}: expected fm=VALUE beside it" for name in alone]
    if bad:
        raise ValueError("\n".join(bad))
    return values, tractions
