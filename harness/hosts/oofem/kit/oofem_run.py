"""Runs an input of OOFEM step by step: oofem_run.py INPUT.in OUTPUT.npz.

Writes strain, stress (T, points, 6) and state (T, points, nstatv) of all integration points and displacement
(T, nodes, 3) after every step, and the messages of OOFEM to OUTPUT.log.  The exit code is 1 if a step has not
converged, or is not finite: OOFEM reports equilibrium then, and goes on.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import numpy as np
import oofem

KINDS = {
    "strain": oofem.InternalStateType.IST_StrainTensor,
    "stress": oofem.InternalStateType.IST_StressTensor,
    "state": oofem.InternalStateType.IST_AbaqusStateVector,
}
COMPONENTS = 6


def solve(source: Path, n_statev: int) -> dict[str, np.ndarray]:
    """Values of all integration points after every step."""
    reader = oofem.OOFEMTXTDataReader(str(source))
    problem = oofem.InstanciateProblem(reader, oofem.problemMode.processor, 0, None, False)
    problem.checkProblemConsistency()
    problem.init()
    problem.postInitialize()
    problem.setRenumberFlag()
    problem.giveTimer().startTimer(oofem.EngngModelTimerType.EMTT_AnalysisTimer)
    meta_step = problem.giveMetaStep(1)
    problem.initMetaStepAttributes(meta_step)
    rows: dict[str, list[list[list[float]]]] = {name: [] for name in (*KINDS, "displacement")}
    for _ in range(problem.giveNumberOfSteps(False)):
        problem.preInitializeNextStep()
        problem.giveNextStep()
        step = problem.giveCurrentStep(False)
        problem.initializeYourself(step)
        problem.solveYourselfAt(step)
        problem.updateYourself(step)
        problem.terminate(step)
        for name, kind in KINDS.items():
            size = n_statev if name == "state" else COMPONENTS
            rows[name].append(points(problem.giveDomain(1), kind, size, step))
        rows["displacement"].append(displacements(problem.giveDomain(1), step))
    return {name: np.array(values) for name, values in rows.items()}


def points(
    domain: oofem.Domain, kind: oofem.InternalStateType, size: int, step: oofem.TimeStep
) -> list[list[float]]:
    """Values of all integration points, element by element; zeros where a material has no such values."""
    rows = []
    for i in range(domain.giveNumberOfElements()):
        element = domain.giveElement(i + 1)
        rule = element.giveDefaultIntegrationRulePtr()
        for k in range(rule.giveNumberOfIntegrationPoints()):
            values = oofem.FloatArray()
            element.giveIPValue(values, rule.getIntegrationPoint(k), kind, step)
            rows.append(list(values) or [0.0] * size)
    return rows


def displacements(domain: oofem.Domain, step: oofem.TimeStep) -> list[list[float]]:
    """Displacements of all nodes."""
    mode = oofem.ValueModeType.VM_Total
    axes = (oofem.DofIDItem.D_u, oofem.DofIDItem.D_v, oofem.DofIDItem.D_w)
    nodes = (domain.giveDofManager(i + 1) for i in range(domain.giveNumberOfDofManagers()))
    return [[node.giveDofWithID(axis).giveUnknown(mode, step) for axis in axes] for node in nodes]


def setting(text: str, name: str) -> int:
    """Whole number after a keyword of the input."""
    m = re.search(rf"\b{name} (\d+)", text, re.IGNORECASE)
    if m is None:
        sys.exit(f"{name}: expected in the input, with a number")
    return int(m[1])


def main(source: Path, output: Path) -> None:
    """Run the command."""
    text = source.read_text(encoding="utf-8")
    most, n_statev = setting(text, "MaxIter"), setting(text, "numstate")
    log = output.with_suffix(".log")
    with log.open("wb") as file:
        os.dup2(file.fileno(), sys.stdout.fileno())
        results = solve(source, n_statev)
    np.savez(output, **results)
    messages = log.read_text(encoding="utf-8", errors="replace")
    counts = [
        int(n) for n in re.findall(r"^Equilibrium reached .* in (\d+) iterations", messages, re.MULTILINE)
    ]
    print(f"{len(counts)} steps, {sum(counts)} iterations, at most {max(counts, default=0)}", file=sys.stderr)
    for i, (n, stress) in enumerate(zip(counts, results["stress"], strict=True), 1):
        if n >= most or not np.isfinite(stress).all():
            sys.exit(f"step {i}: not converged, although OOFEM reports equilibrium after {n} iterations")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: oofem_run.py INPUT.in OUTPUT.npz")
    main(Path(sys.argv[1]), Path(sys.argv[2]))
