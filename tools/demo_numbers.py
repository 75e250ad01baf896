#!/usr/bin/env python3
"""Print the main numbers of a shear cycle the driver wrote: preload, turning points, peak and energies."""

from __future__ import annotations

import argparse
import csv
import itertools
from pathlib import Path


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("csv", type=Path, help="result of rie_driver")
    with parser.parse_args().csv.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    slips = [float(row["s_Tx"]) for row in rows]
    preload = next(i for i, row in enumerate(rows) if row["step"] != rows[0]["step"]) - 1
    steps = [b - a for a, b in itertools.pairwise(slips)]
    turns = [i for i in range(1, len(steps)) if steps[i - 1] * steps[i] < 0.0]
    peak = max(range(len(rows)), key=lambda i: abs(float(rows[i]["t_Tx"])))
    named = [("preload", preload), *(("turning point", i) for i in turns), ("end", len(rows) - 1)]
    print(f"{'mm, MPa, N/mm':18}{'slip':>10}{'traction':>12}{'dilation':>12}{'damage':>10}")
    for name, i in [*named, ("largest traction", peak)]:
        numbers = [float(rows[i][column]) for column in ("s_Tx", "t_Tx", "s_N", "damage")]
        print("{:18}{:10.4f}{:12.4f}{:12.5f}{:10.4f}".format(name, *numbers))
    last = rows[-1]
    energies = {name: float(last[name]) for name in ("work", "stored", "rupture", "friction")}
    print("energies at the end: " + ", ".join(f"{name} {value:.4f}" for name, value in energies.items()))


if __name__ == "__main__":
    main()
