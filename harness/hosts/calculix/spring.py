"""Joints that slide under dead load behind a spring in CalculiX, with IMPL-EX and without; mm, N, MPa.

The element of the kit, of area 1, carries 1 MPa and is pulled through the spring until it slides by SLIDE.
The script prints a row for each joint, spring and tolerance, with the error e_t of IMPL-EX at the end.
"""

from __future__ import annotations

import argparse
import tempfile
import warnings
from pathlib import Path

import calculix_run
from asperity import Interface, Material, ModelWarning, Pattern

FLAT, ROUGH = Pattern.regular(0, 0.0), Pattern.regular(4, 10.0)
DRY = Material.from_joint(kn=200.0, ks=80.0, mu=0.5)
JOINTS = {
    "without bond, flat": Interface(DRY, FLAT),
    "without bond, RP-4": Interface(DRY, ROUGH),
    "with bond, flat": Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), FLAT),
    "with bond, RP-4": Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), ROUGH),
}

PRESSURE, SLIDE = 1.0, 0.5
SPRINGS, TOLERANCES = (100.0, 10.0), (0.0, 0.1, 0.05)
"""Stiffnesses, N/mm; tolerances of IMPL-EX, 0 for the law itself."""

KIT = Path(__file__).parent / "kit" / "single.inp"


def strength(law: Interface) -> float:
    """Shear at the end in closed form: all planes are broken, and one climbs where they are inclined."""
    return PRESSURE * float(law.material.residual_strength(law.pattern.theta))


def text(law: Interface, spring: float, implex: float) -> str:
    """Input of the press and of the pull."""
    pull = SLIDE + strength(law) / spring
    deck = KIT.read_text(encoding="utf-8").split("${card}")[0].replace("$h", "1.")
    with warnings.catch_warnings():  # the program of link.sh has room for all constants
        warnings.simplefilter("ignore", ModelWarning)
        deck += law.card("calculix", name="JOINT", implex=implex)
    deck += "*NODE\n9, 2., 0., 1.\n*ELEMENT, TYPE=SPRING2, ELSET=SPRING\n2, 5, 9\n"
    deck += f"*SPRING, ELSET=SPRING\n1, 1\n{spring}\n"
    deck += "".join(f"*EQUATION\n2\n{k}, {axis}, 1., 5, {axis}, -1.\n" for k in (6, 7, 8) for axis in (1, 3))
    deck += "*BOUNDARY\nBOTTOM, 1, 3\nTOP, 2\n9, 1, 3\n"
    deck += f"*STEP\n*STATIC, DIRECT\n0.1, 1.\n*CLOAD\n5, 3, {-PRESSURE}\n*END STEP\n"
    deck += f"*STEP, INC=1000\n*STATIC\n0.05, 1., 1e-6, 0.05\n*BOUNDARY\n9, 1, 1, {pull:.9g}\n"
    return f"{deck}*EL PRINT, ELSET=JOINT\nS, SDV\n*END STEP\n"


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="Joints that slide behind a spring in CalculiX.")
    parser.add_argument("program", type=calculix_run.program_file, help="ccx linked with libasperity")
    program = parser.parse_args().program
    print("joint               spring  implex  attempts  iterations  shear   closed form  error, %   e_t")
    for name, law in JOINTS.items():
        for spring in SPRINGS:
            for implex in TOLERANCES:
                with tempfile.TemporaryDirectory() as folder:
                    try:
                        done = calculix_run.run(program, Path(folder), text(law, spring, implex))
                    except RuntimeError:
                        print(f"{name:20}{spring:6g}{implex:8g}  ends early")
                        continue
                shear, expected = float(done.vectors("JOINT stresses")[-1, 0, 1]), strength(law)
                counts = f"{done.attempts:10d}{sum(done.iterations):12d}"
                error = 100.0 * (shear / expected - 1.0)
                told = f"{done.state('JOINT')[-1, 0, -1]:10.4f}" if implex else ""
                print(
                    f"{name:20}{spring:6g}{implex:8g}{counts}{shear:9.4f}{expected:12.4f}{error:+10.2f}{told}"
                )


if __name__ == "__main__":
    main()
