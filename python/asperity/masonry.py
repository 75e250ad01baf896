"""Command `asperity masonry`: constants of the law for a mortar joint, and what the law makes of them."""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from . import contract
from .interface import Interface
from .material import Material
from .pattern import Pattern
from .starters import assigned

REQUIRED = ("kn", "ks", "ft", "GfI", "c", "GfII", "tan_phi")

PRESSURES = "-0.05,-0.3,-1.21"
"""Normal tractions of the peaks, as in tests of mortar joints in MPa."""

INCREMENTS = 2000
"""Of the slip in which a peak is found."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    text = f"{', '.join(REQUIRED)}, and tan_psi: constants of the joint"
    parser.add_argument("values", nargs="+", metavar="NAME=VALUE", help=text)
    parser.add_argument(
        "--sigma-N",
        dest="sigma_N",
        default=PRESSURES,
        metavar="SIGMA_N,...",
        help="normal tractions of the peaks, <= 0 (default: %(default)s)",
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.nml", help="write &material to a new file")
    parser.set_defaults(action=_run)


def peak(material: Material, sigma_N: float) -> float:
    """Largest shear traction of the flat joint in a slip test."""
    reach = 2.0 * (material.Gc2 / material.sigma02)
    slips = np.linspace(0.0, reach, INCREMENTS + 1)[1:]
    return float(
        Interface(material, Pattern.regular(0, 0.0)).confined_slip(0.0, slips, sigma_N).traction[:, 1].max()
    )


def strength_for_peak(material: Material, sigma_N: float, wanted: float) -> float:
    """Return the sigma02 with which the peak is the wanted one, larger than that of the material."""
    from scipy.optimize import brentq

    def missing(sigma02: float) -> float:
        return peak(replace(material, sigma02=sigma02), sigma_N) - wanted

    return float(brentq(missing, material.sigma02, wanted, rtol=1e-6))


def _run(options: argparse.Namespace) -> int:
    """Print the constants and the losses, and write the group of a case."""
    import warnings

    texts = assigned(options.values)
    bad = [f"{name} is missing: expected {name}=VALUE" for name in REQUIRED if name not in texts]
    unknown = [name for name in texts if name not in (*REQUIRED, "tan_psi")]
    bad += [
        f"{name} = {texts[name]}: unknown name, expected one of {', '.join(REQUIRED)}, tan_psi"
        for name in unknown
    ]
    if bad:
        raise ValueError("\n".join(bad))
    values = {name: contract.number(name, text) for name, text in texts.items()}
    material = Material.from_masonry(**values)
    stresses = [contract.number("--sigma-N", text) for text in options.sigma_N.split(",")]
    for sigma_N in stresses:
        if not -np.inf < sigma_N <= 0.0:
            raise ValueError(f"--sigma-N {sigma_N:g}: expected a normal traction <= 0")
    shown = ("sigma0", "Gc", "eta", "mu", "kc", "sigma02", "Gc2")
    group = ", ".join(f"{name} = {asdict(material)[name]:.10g}" for name in shown)
    print(f"&material {group} /\n")
    Kt = material.sigma02**2 / (2.0 * material.Gc2 * (1.0 - material.eta))
    print(f"shear stiffness c^2/(2 GfII (1 - eta)) = {Kt:.3g}, and not ks = {values['ks']:g}")
    print("the peak is below c + mu |sigma_N|, because only the damaged share of the joint rubs:\n")
    print(f"{'sigma_N':>10}{'peak':>10}{'c + mu p':>10}{'sigma02 that meets it':>24}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for sigma_N in stresses:
            wanted = values["c"] - material.mu * sigma_N
            found = peak(material, sigma_N)
            better = strength_for_peak(material, sigma_N, wanted) if found < wanted else material.sigma02
            print(f"{sigma_N:>10g}{found:>10.3f}{wanted:>10.3f}{better:>24.3f}")
    if options.output is not None:
        with options.output.open("x", encoding="utf-8") as file:
            file.write(f"&material {group} /\n")
        print(f"\n{options.output}")
    return 0
