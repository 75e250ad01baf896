"""Runs of the walls: harness/hosts/fenicsx/walls.py with the options of each."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas
from asperity.contract import Floats

from .common import DATA, rows

ROOT = Path(__file__).parents[3]
PROGRAM = ROOT / "harness" / "hosts" / "fenicsx" / "walls.py"
EXAMPLES = PROGRAM.parents[2] / "examples"
BUILD = ROOT / "build"
PYTHON = BUILD / "fenicsx" / "bin" / "python"
"""Made by `make hosts`."""

DRY = "--tolerance 1e-5 --step 0.1 --most 0.5"
MORTAR = "--tau 0.002"
"""Options of the dry walls and of those with mortar."""

ROCKING, SLIDING = "--to 5 10 15 20", "--to 4 8 12"

SOLID = "--theta 10 --height 0.1 --to 3.5"
"""Options of a wall in three dimensions."""

NEWTON, SNAPS = "--passes 0", "--limit 0.2"
"""Newton's method alone; in a snap even a shortest step by passes has an error above the default limit."""

COST = {
    "flat": "--wall J4D",
    "rough": "--wall J4D --theta 10 --height 0.1",
    "dry": f"--wall SW30 {DRY} --elements 2 2 --to 9",
    "3D": f"--elements 2 1 2 {SOLID}",
}
"""Walls of the chart of costs; that in three dimensions has planes that face exactly across the slip."""

IMPLEX = {
    errors: f"--passes 1 --always --limit 0.4 --errors {errors}"
    for errors in ("0.2 0.1", "0.1 0.05", "0.05 0.02")
}
"""One pass from extrapolated separations, by its errors of a damage and of forces."""

METHODS = {
    **{
        f"{wall} tau {tau}": f"{COST[wall]} --tau {tau}"
        for wall, viscosities in (
            ("flat", (0.05, 0.02, 0.005, 0.0005)),
            ("rough", (0.05, 0.02, 0.005, 0.0005)),
        )
        for tau in viscosities
    },
    "flat newton": f"{COST['flat']} {NEWTON}",
    "flat passes": f"{COST['flat']} {SNAPS}",
    "flat always": f"{COST['flat']} --tau 0.002 --always",
    "rough newton": f"{COST['rough']} {NEWTON}",
    "rough passes": f"{COST['rough']} {SNAPS}",
    "dry newton": f"{COST['dry']} {NEWTON}",
    "dry drag 1e-6": f"{COST['dry']} --drag 1e-6 {NEWTON}",
    "dry drag 1e-5": f"{COST['dry']} --drag 1e-5 {NEWTON}",
    "dry passes": COST["dry"],
    **{
        f"{wall} implex {errors}": f"{COST[wall]} {words}"
        for wall in ("flat", "rough", "dry", "3D")
        for errors, words in IMPLEX.items()
    },
    "3D passes": f"{COST['3D']} {SNAPS}",
    "3D newton 0.005": f"{COST['3D']} --tau 0.005 {NEWTON}",
    **{f"3D tau {tau}": f"{COST['3D']} --tau {tau}" for tau in (0.02, 0.005)},
}
"""Options by wall and method; those of the walls with viscosity are by Newton's method with passes."""

AIMS = {
    **{
        f"aim {name}": f"--wall {name} {DRY} --elements 2 2 --drag 1e-6 {NEWTON} --to {end}"
        for name, end in (("SW100", 9), ("SW200", 9), ("WS100", 12))
    },
    **{f"aim {name}": f"--wall {name} {MORTAR} {NEWTON}" for name in ("J6D", "J7D")},
    **{
        f"own {name}": f"--wall {name} {DRY} --elements 2 2 --to {end}"
        for name, end in (("SW100", 9), ("SW200", 9), ("WS100", 12))
    },
}
"""Walls of the aims by Newton's method alone, with a drag or viscosity, and as the kit does by itself."""

ROUGH = "10 0", "20 0.1", "10 0.5", "5 0.1"
"""Theta and height of the planes in the joints of J4D."""

CRUSH = {"J4D": "fc=10.5 Gfc=60", "J6D": "fc=11.5 Gfc=66", "J7D": "fc=11.5 Gfc=66"}
"""Strength and energy of crushing of the joints of the walls with mortar: MPa, N/mm."""

PLANES = {
    f"planes {sides} {turn:g}": f"{COST['rough']} {MORTAR} --sides {sides} --turn {turn}"
    for sides, turns in ((2, (0,)), (4, (45,)), (6, (0, 30)), (8, (0, 22.5)), (16, (0, 11.25)), (64, (0,)))
    for turn in turns
}
"""J4D with other patterns; a turn of half of the angle between two planes."""

RUNS = {
    "J4D": f"--wall J4D {MORTAR}",
    **{name: f"--wall {name} {DRY} --elements 2 2 {ROCKING}" for name in ("WS40", "WS100", "WS175", "WS250")},
    **{name: f"--wall {name} {DRY} --elements 2 2 {SLIDING}" for name in ("SW30", "SW100", "SW200", "SW250")},
    **{name: f"--wall {name} {MORTAR}" for name in ("J6D", "J7D")},
    **{
        f"{name} {planes}": f"--wall {name} {MORTAR} --theta {planes.replace(' ', ' --height ')}"
        for names, planes in (("J4D J6D J7D", "10 0.1"), *(("J4D", plane) for plane in ROUGH))
        for name in names.split()
    },
    **{f"crush {name}": f"--wall {name} {MORTAR} --joint {words}" for name, words in CRUSH.items()},
    "crush implex": f"--wall J4D {IMPLEX['0.05 0.02']} --joint {CRUSH['J4D']}",
    **METHODS,
    **AIMS,
    **PLANES,
    "cyclic WS100": f"--wall WS100 {DRY} --elements 2 2 --to 5 -5 10 -10 0",
    "J4D 2 2": f"{MORTAR} --elements 2 2",
    "SW100 4 4": f"--wall SW100 {DRY} --elements 4 4 {SLIDING}",
    "WS100 4 4": f"--wall WS100 {DRY} --elements 4 4 {ROCKING}",
    "WS100 kn": f"--wall WS100 {DRY} --elements 2 2 {ROCKING} --joint kn=15.8 ks=6.32",
    **{f"step {step}": f"{MORTAR} --step {step} --most {step}" for step in (0.0125, 0.1, 0.2)},
    "J4D 8 6": f"{MORTAR} --elements 8 6",
    **{f"3D {turn}": f"--tau 0.005 --elements 4 1 3 {SOLID} --turn {turn}" for turn in (45, 0)},
}
"""Options by the name of a run."""

SUMMARY = (
    *(
        "unknowns",
        "points",
        "ranks",
        "steps",
        "cuts",
        "repeated",
        "by_passes",
        "e_a",
        "e_t",
        "snaps",
        "calm",
        "work",
        "dissipated",
        "unbalanced",
        "released",
    ),
    *("iterations", "linear", "seconds", "law", "memory", "peak", "at", "end"),
    *("entries", "operations", "gigabytes"),
)
"""What is stored of the summary of a run."""

FIELDS = ("WS100", "SW100", "J4D")
"""Runs of the picture of cracks."""

ARCHES = {
    "0.7,0,2": "0.11 0.12 0.15 0.2 --pvd",
    "0.7,0,3": "0.12 0.15 --dim 3 --size 75",
    "0.35,0,2": "0.2 --mu 0.35",
    "0.35,0.1,2": "0.2 --mu 0.35 --tan-psi 0.1",
}
"""Options of arch.py by friction, inclination of the planes and dimension."""

ARCH = re.compile(r"t/R ([\d.]+): ([\d.]+) g, limit analysis ([\d.]+) g, (\d+) unknowns")
"""Line of arch.py."""


def launch(
    words: str, name: str | Path, ranks: int, code: str = ""
) -> tuple[list[str | Path], dict[str, str]]:
    """Command and environment of a program of this host, or a code, with options, one thread a rank.

    A name that is a path is that of a script.
    A rank of MPICH that waits keeps its core, and answers at once.  Where ranks are more than the cores, they
    sleep while they wait, which takes them several times as long.
    """
    mpiexec = [PYTHON.parent / "mpiexec", "-n", str(ranks)] if ranks > 1 else []
    script: list[str | Path] = [name] if isinstance(name, Path) else ["-m", f"harness.hosts.fenicsx.{name}"]
    program = ["-c", code] if code else script
    command = [*mpiexec, PYTHON, *program, *shlex.split(words)]
    settings = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    if ranks > len(os.sched_getaffinity(0)):
        settings["MPIR_CVAR_ENABLE_HEAVY_YIELD"] = "1"
    return command, os.environ | settings


Run = Callable[[str, str, int], subprocess.CompletedProcess[str]]
"""How a program is run, by its options, its name and the number of ranks."""


def start(
    words: str, name: str = "walls", ranks: int = 1, code: str = ""
) -> subprocess.CompletedProcess[str]:
    """Run a program of this host, or a code, with options."""
    command, environment = launch(words, name, ranks, code)
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


def printed_by(words: str, name: str, ranks: int = 1, run: Run = start) -> list[tuple[str, list[float]]]:
    """Names and numbers that a program of this host prints, such as `row: 0.1 2.5`, in their order."""
    done = run(words, name, ranks)
    if done.returncode != 0:
        raise RuntimeError(f"{name}.py {words}: exit {done.returncode}: {done.stderr}")
    lines = [line.partition(": ") for line in done.stdout.splitlines()]
    return [(name, [float(word) for word in text.split()]) for name, _, text in lines]


def execute(name: str, folder: Path) -> None:
    """Run a wall, unless its summary is there."""
    words = name.replace(" ", "-")
    done = folder / f"{words}.json"
    if done.exists():
        return
    out = folder / f"{words}.csv"
    out.unlink(missing_ok=True)  # of a run that was ended
    line = f"{RUNS[name]} --out {out}"
    if name in FIELDS:
        line += f" --pvd {folder / words}.pvd"
    end = start(line)
    if end.returncode not in (0, 3):
        raise RuntimeError(f"{name}: exit {end.returncode}: {end.stderr}")
    done.write_text(end.stdout.splitlines()[-1] + "\n", encoding="utf-8")
    print(f"{name}: {end.stdout.splitlines()[-1]}", flush=True)


def execute_all(folder: Path) -> None:
    """Run all walls whose summary is not in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in RUNS:
        execute(name, folder)
    mesh, field = folder / "window.msh", folder / "window.pvd"
    subprocess.run([PYTHON, EXAMPLES / "window_mesh.py", mesh], check=True)
    start(f"{mesh} --pvd {field}", "window").check_returncode()
    head = "mu,tan_psi,dim,ratio,model,limit,unknowns"
    lines = ["# Made by python -m harness.studies.validation.walls --fit", head]
    for case, line in ARCHES.items():
        done = start(f"{line} --folder {folder}", "arch")
        done.check_returncode()
        lines += [f"{case},{','.join(numbers)}" for numbers in ARCH.findall(done.stdout)]
    (DATA / "arches.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def store(folder: Path) -> None:
    """Write the curves and the summaries of all runs to the folder `data`; runs that are not there stay."""
    paths, sums = [], []
    for name in RUNS:
        file = folder / name.replace(" ", "-")
        done = file.with_name(file.name + ".json")
        if not done.exists():
            paths.append(rows("walls_runs").query("run == @name"))
            sums.append(rows("walls_summaries").query("run == @name"))
            continue
        curve = np.loadtxt(f"{file}.csv", delimiter=",", skiprows=1, ndmin=2)[:, :3]
        curve = np.vstack([[0.0, 0.0, curve[0, 2]], curve])
        parts = dict(zip(("displacement", "horizontal", "vertical"), curve.T, strict=True))
        paths.append(pandas.DataFrame({"run": name, **parts}))
        summary = json.loads(done.read_text(encoding="utf-8"))
        sums.append(pandas.DataFrame([{"run": name, **{column: summary[column] for column in SUMMARY}}]))
    for file, parts, digits in (("walls_runs", paths, "%.5g"), ("walls_summaries", sums, "%.6g")):
        table = pandas.concat(parts).to_csv(index=False, float_format=digits)
        heading = "# Made by python -m harness.studies.validation.walls --fit\n"
        (DATA / f"{file}.csv").write_text(heading + table, encoding="utf-8")


def curves() -> dict[str, Floats]:
    """Stored rows of every run: displacement, horizontal and vertical force."""
    parts = rows("walls_runs").groupby("run", sort=False)
    return {name: part[["displacement", "horizontal", "vertical"]].to_numpy(float) for name, part in parts}


def summaries() -> pandas.DataFrame:
    """Stored summary of every run, by its name."""
    return rows("walls_summaries").set_index("run")
