"""Command `asperity masonry`: constants of the law for a mortar joint, and the peaks that they give."""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from .. import contract
from ..case_writer import case_text, pattern_entries, rounded, slip_case
from ..interface import Interface
from ..material import Material
from ..options import add_options, add_output, assigned, check_outputs, replace_file
from ..pattern import Pattern
from .slip_curves import slip_curves

REQUIRED = ("kn", "ks", "ft", "GfI", "c", "GfII", "tan_phi")
OPTIONAL = ("tan_psi", "delta")

PRESSURES = "-0.05,-0.3,-1.21"  # normal tractions of the peaks, as in tests of mortar joints in MPa
INCREMENTS, SHOWN_INCREMENTS = 2000, 400  # of the slip in which a peak is found, and of that in the case
SHOWN = ("sigma0", "Gc", "eta", "mu", "kc", "sigma02", "Gc2", "height")
"""Constants in the group &material; others have their default."""

DIFFERENCES = """\
kc = 1: kn acts in compression, too, because it is that of a mortar joint as a whole.
The shear stiffness is c^2/(2 GfII (1 - eta)) = {Kt:.3g} and not ks = {ks:g}: one eta serves both modes.
The peak is below c + tan_phi |sigma_N|, because friction acts on the damaged part of the joint only. With a
sigma02 above c the peak reaches this value at one pressure:
"""
"""Where the law differs from an interface model of masonry."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    names = (
        f"constants of the joint: {', '.join(REQUIRED)}; and for a dilatancy tan_psi exp(-delta slip): "
        f"{', '.join(OPTIONAL)} (delta = 0: the dilation never ends)"
    )
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


def peak(material: Material, pattern: Pattern, sigma_N: float) -> float:
    """Largest shear traction of the joint in a slip test."""
    slips = np.linspace(0.0, _reach(material), INCREMENTS + 1)[1:]
    return float(np.nanmax(slip_curves(Interface(material, pattern), 0.0, slips, sigma_N).tau_L))


def strength_for_peak(material: Material, pattern: Pattern, sigma_N: float, wanted: float) -> float:
    """Return the sigma02 with which the peak is the wanted one, larger than that of the material."""
    from scipy.optimize import brentq

    def missing(sigma02: float) -> float:
        return peak(replace(material, sigma02=sigma02), pattern, sigma_N) - wanted

    most = wanted
    while missing(most) < 0.0:
        most *= 2.0
    return float(brentq(missing, material.sigma02, most, rtol=1e-6))


def _run(options: argparse.Namespace) -> int:
    values, stresses = _checked(options)
    check_outputs(options.force, [], ("-o", options.output))
    material = Material.from_masonry(**values)
    tan_psi = values.get("tan_psi", 0.0)
    pattern = pattern_of(tan_psi)
    given = {name: rounded(getattr(material, name), 10) for name in SHOWN if getattr(material, name)}
    print(case_text(("material", given), ("pattern", pattern_entries(pattern))))
    if tan_psi > 0.0:
        print(f"theta = arctan(tan_psi), mu = tan(phi - psi): {material.mu:.4g} on planes of that slope.")
        height = f"{material.height:.4g}" if material.height else "infinite"
        print(f"The dilation along Tx ends at the height tan_psi/delta: {height}.")
    Kt = material.sigma02**2 / (2.0 * material.Gc2 * (1.0 - material.eta))
    print(DIFFERENCES.format(Kt=Kt, ks=values["ks"]))
    print(f"{'sigma_N':>10}{'peak':>10}{'c + tan_phi |sigma_N|':>24}{'sigma02 for this peak':>24}")
    for sigma_N in stresses:
        wanted = values["c"] - values["tan_phi"] * sigma_N
        found = peak(material, pattern, sigma_N)
        better = material.sigma02
        if found < wanted:
            better = strength_for_peak(material, pattern, sigma_N, wanted)
        print(f"{sigma_N:>10g}{found:>10.5g}{wanted:>24.5g}{better:>24.5g}")
    if options.output is not None:
        slips = [_reach(material)]
        text = slip_case("Mortar joint", given, pattern, stresses, slips, increments=SHOWN_INCREMENTS)
        replace_file(options.output, text)
        print(f"\n{options.output}")
    return 0


def _reach(material: Material) -> float:
    """Slip at which the bond is broken."""
    return 2.0 * material.Gc2 / material.sigma02


def _checked(options: argparse.Namespace) -> tuple[dict[str, float], list[float]]:
    """Constants by name and normal tractions; raises ValueError with a line for every bad one."""
    known = (*REQUIRED, *OPTIONAL)
    stresses = " ".join(text for text in options.sigma_N if "=" not in text).replace(",", " ").split()
    texts = assigned([*options.values, *(text for text in options.sigma_N if "=" in text)])
    bad = [f"{name} is missing: expected {name}=VALUE" for name in REQUIRED if name not in texts]
    values, tractions = {}, []
    for name, text in [*texts.items(), *(("--sigma-N", text) for text in stresses)]:
        try:
            if name in known:
                values[name] = contract.number(name, text)
            elif name in texts:
                raise ValueError(f"{name} = {text}: expected one of {', '.join(known)}")
            elif not -np.inf < contract.number(name, text) <= 0.0:
                raise ValueError(f"--sigma-N = {text}: expected a normal traction <= 0")
            else:
                tractions.append(contract.number(name, text))
        except ValueError as error:
            bad.append(str(error))
    if bad:
        raise ValueError("\n".join(bad))
    return values, tractions
