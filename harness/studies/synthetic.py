"""Synthetic shear-box tests, to try fits: `python -m harness.studies.synthetic RECORD.csv`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas
from asperity.contract import Floats
from asperity.tools.fit import ShearTest
from asperity.tools.fit.model import Problem, slip_curve

from .program import program

TRUTH = {"sigma0": 1.5, "Gc": 0.15, "eta": 0.9, "mu": 0.5, "theta": 20.0, "flat": 1.0 / 3.0, "kc": 20.0}
"""Parameters of the synthetic tests: mm, MPa, degrees."""

FREE = ("sigma0", "Gc", "mu", "theta")
"""Parameters that a fit of these tests usually leaves free."""

SIDES = 8
"""Inclined planes."""

SET = {name: value for name, value in TRUTH.items() if name not in FREE}
"""The others, fixed at their true values."""

SIGMA_N = (-1.0, -2.0, -4.0)
"""Normal tractions, MPa."""

TURNS = (0.8,)
CYCLE = (0.5, -0.5, 0.5)
"""Slips at the reversals, mm."""

K_N = 5.0
"""Stiffness of a box, MPa/mm."""

ROWS = 60
"""Of a test."""

FINE = 4000
FINE_CYCLE = 100000
"""Increments of a synthetic test: far more than those of a fit, whose discretisation error then shows."""

CYCLIC: dict[str, object] = {"turns": CYCLE, "rows": 150, "increments": FINE_CYCLE}
"""Arguments of `synthetic`."""

DEFAULT_NOISE = 0.03
"""Standard deviation of the noise, as a fraction of the range of tau and of s_N in each test."""


def synthetic(
    noise: float,
    seed: int,
    truth: Mapping[str, float] = TRUTH,
    sigma_N: Sequence[float] = SIGMA_N,
    turns: Sequence[float] = TURNS,
    k_N: float = 0.0,
    rows: int = ROWS,
    dilation: bool = True,
    increments: int = FINE,
    sides: int = SIDES,
) -> list[ShearTest]:
    """Tests computed with `truth` in fine increments, with Gaussian noise on tau and s_N."""
    rng = np.random.default_rng(seed)
    nodes = np.array([0.0, *turns])
    lengths = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(nodes)))])
    slip = np.interp(np.linspace(0.0, lengths[-1], rows + 1)[1:], lengths, nodes)
    tests = []
    for number, held in enumerate(sigma_N, 1):
        clean = ShearTest(f"test {number}", slip, slip, None, held, k_N)
        problem = Problem([clean], (), truth, sides, 0.0, increments)
        [(slips, places)] = problem.paths
        tau, s_N, done = slip_curve(problem.interface(truth).props(), clean, slips, places, 0.0, 200)
        if done < slips.size:
            raise ValueError(f"sigma_N = {held:g}: no equilibrium at slip {slips[done]:g}")
        measured = [noisy(y[places], noise, rng) for y in (tau, s_N)]
        tests.append(replace(clean, tau=measured[0], s_N=measured[1] if dilation else None))
    return tests


def noisy(y: Floats, noise: float, rng: np.random.Generator) -> Floats:
    """Values with Gaussian noise, whose deviation is a fraction of their range."""
    disturbed: Floats = y + noise * float(np.ptp(y)) * rng.standard_normal(y.size)
    return disturbed


def write_record(path: Path, tests: Sequence[ShearTest]) -> None:
    """Write a CSV file of tests, with five digits."""
    parts = []
    for number, test in enumerate(tests, 1):
        columns = {"test": number, "slip [mm]": test.slip, "tau [MPa]": test.tau}
        columns |= {} if test.s_N is None else {"dilation [mm]": test.s_N}
        parts.append(pandas.DataFrame(columns | {"sigma_N [MPa]": test.sigma_N, "k_N [MPa/mm]": test.k_N}))
    pandas.concat(parts).to_csv(path, index=False, float_format="%.5g")


def _run(options: argparse.Namespace) -> int:
    """Write synthetic tests to a file."""
    write_record(options.record, synthetic(options.noise, options.seed))
    print(options.record)
    return 0


main = program(
    _run,
    ("record RECORD.csv", "file of the tests", Path),
    ("--noise NOISE", "of the range", DEFAULT_NOISE),
    ("--seed SEED", "of the noise", 0),
)

if __name__ == "__main__":
    sys.exit(main())
