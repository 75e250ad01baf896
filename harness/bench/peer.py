"""Time per point of Interface.update for one plane beside NEML2's bilinear traction law, on the same points.

Needs `pip install neml2 torch==2.10` beside asperity: with torch 2.15 NEML2 3.1 does not load what it has
compiled.  NEML2's law is the mixed-mode one of Camanho and Davila from the separation on, one plane with
damage, without friction and energies. It is timed without its tangent, as it is and compiled.
Interface.update gives traction, state with energies, and tangent. One thread each.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

os.environ["OMP_NUM_THREADS"] = "1"  # the library reads it when it is loaded

from asperity import Interface, Material, Pattern

MODELS = (
    "components VecComponents from='s' to='N T1 T2'",
    "opening MacaulaySplit from='N' to_positive='open' to_negative='shut'",
    "slip ScalarPNorm from='T1 T2' to='slip' exponent=2",
    "separation ScalarPNorm from='open slip' to='separation' exponent=2",
    "mixity ModeMixity normal_separation='open' tangential_separation='slip' mode_mixity='beta'",
    "onset CamanhoDavilaCriticalSeparation normal_separation='open' critical_separation='onset'"
    " mode_mixity='beta' penalty_stiffness={K} normal_strength={strength} shear_strength={strength}",
    "full BenzeggaghKenaneFullSeparation normal_separation='open' full_separation='full' mode_mixity='beta'"
    " critical_separation='onset' penalty_stiffness={K} shear_strength={strength}"
    " mode_I_fracture_toughness={Gc} mode_II_fracture_toughness={Gc} eta=2",
    "bilinear BilinearTraction effective_separation='separation' normal_separation='open'"
    " normal_penetration='shut' tangential_separation_1='T1' tangential_separation_2='T2' traction='t'"
    " damage='d' penalty_stiffness={K} critical_separation='onset' full_separation='full'",
    "law ComposedModel models='components opening slip separation mixity onset full bilinear'",
)
"""NEML2's law from the separation to the traction: name, type and values of its models."""


def law_text(**constants: float) -> str:
    """Input file of NEML2 for the law with K, strength and Gc."""
    lines = ["[Models]"]
    for model in MODELS:
        name, kind, values = model.format(**constants).split(" ", 2)
        pairs = re.findall(r"(\w+)=('[^']*'|\S+)", values)
        lines += [f"[{name}]", f"type = {kind}", *(f"{key} = {value}" for key, value in pairs), "[]"]
    return "\n".join([*lines, "[]", ""])


def neml2_laws(material: Material, s: np.ndarray) -> dict[str, Callable[[], object]]:
    """Return calls of NEML2's law at virgin points, as it is and compiled, which must agree."""
    import neml2
    import torch
    from neml2.cli.aoti_compile import compile_and_emit_stub

    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "law.i"
        stiffness = material.sigma0**2 / (2.0 * material.Gc * (1.0 - material.eta))
        text = law_text(K=stiffness, strength=material.sigma0, Gc=material.Gc)
        file.write_text(text, encoding="utf-8")
        laws = {"NEML2": neml2.load_model(file, "law")}
        laws["NEML2, compiled"] = neml2.load_model(
            compile_and_emit_stub(file, Path(folder), model="law"), "law"
        )
    inputs = {"s": neml2.Vec(torch.from_numpy(s)), "d~1": neml2.Scalar(torch.zeros(len(s)))}
    calls = {
        name: lambda law=law: law(*(inputs[key] for key in law.input_spec)) for name, law in laws.items()
    }
    with torch.no_grad():
        tractions = [call()[0].data.numpy() for call in calls.values()]
    np.testing.assert_allclose(tractions[1], tractions[0], rtol=1e-9, atol=1e-12)
    return calls


def main() -> None:
    """Time both laws in turn and print the medians."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--points", type=int, default=100_000, help="number of points [%(default)s]")
    parser.add_argument("--turns", type=int, default=51, help="number of turns [%(default)s]")
    options = parser.parse_args()
    try:
        import torch
    except ModuleNotFoundError:
        sys.exit("peer.py: NEML2 is not installed: expected `pip install neml2 torch==2.10` beside asperity")
    material = Material(3.0, 0.3, 0.9, 0.5)
    joint = Interface(material, Pattern.regular(0, 0.0))
    n = options.points
    s = np.random.default_rng(1).uniform(-1.0, 1.0, (n, 3)) * [0.01, 0.1, 0.1]
    state, s_old = np.zeros((n, joint.nstatv)), np.zeros((n, 3))
    out = np.empty((n, 3)), state, np.empty((n, 3, 3))
    calls = {"Interface.update": lambda: joint.update(s, state, s_old, out=out), **neml2_laws(material, s)}
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    with torch.no_grad():
        for _ in range(options.turns):
            for name, call in calls.items():
                start = time.perf_counter()
                call()
                seconds[name].append(time.perf_counter() - start)
    for name, times in seconds.items():
        ratios = [own / other for own, other in zip(seconds["Interface.update"], times, strict=True)]
        print(f"{name:16} {statistics.median(times) / n * 1e9:6.1f} ns a point, "
              f"Interface.update/this {statistics.median(ratios):5.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
