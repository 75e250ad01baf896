"""Executors: the same answers in the same order in threads and processes, lost processes, and --jobs."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, sweeps
from asperity.cli import main
from asperity.parallel import map_in_order
from asperity.tools.slip_curves import slip_curves
from support_signals import heeds_signals


@pytest.mark.parametrize("processes", [0, 2])
def test_executors(processes: int) -> None:
    """Order, bits, progress, a loop in a loop, the error of the first item, a task that ends its process."""
    executor = ProcessPoolExecutor(processes, get_context("spawn")) if processes else None
    done: list[int] = []
    assert map_in_order(math.sqrt, [9.0, 4.0, 1.0], executor, lambda: done.append(1)) == [3.0, 2.0, 1.0]
    assert len(done) == 3 and map_in_order(math.sqrt, [], executor) == []
    inner = partial(map_in_order, math.sqrt)
    assert map_in_order(inner, [[4.0, 1.0], [9.0]], executor) == [[2.0, 1.0], [3.0]]
    with pytest.raises(ValueError, match="'first'"):
        map_in_order(int, ["1", "first", "second"], executor)
    joint = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0), Pattern.regular(4, 30.0))
    arguments = joint, np.arange(0.0, 90.0, 2.0), np.linspace(0.0, 0.4, 21), -1.0
    mine, parallel = (slip_curves(*arguments, executor=pool) for pool in (ThreadPoolExecutor(1), executor))
    for name in ("tau_L", "tau_across", "s_N", "damage", "work", "rows"):
        np.testing.assert_array_equal(getattr(mine, name), getattr(parallel, name))
    if executor is not None:
        with executor, pytest.raises(OSError, match="--jobs 1 needs least"):
            map_in_order(os._exit, [1, 1], executor)


def update_many(joint: Interface) -> None:
    """Update more points than a single thread does."""
    joint.update(np.full((4000, 3), 1e-3), np.zeros((4000, joint.nstatv)))


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_fork() -> None:
    """A process that is forked after threads have shared points updates points, too."""
    joint = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(4, 30.0))
    update_many(joint)
    child = get_context("fork").Process(target=update_many, args=(joint,))
    child.start()
    child.join(60.0)
    code = child.exitcode
    child.kill()
    assert code == 0


def test_sweep(tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The runs of a sweep write the same files and messages, one of them without equilibrium."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    case, values = tmp_path / "case.nml", []
    case.write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 100.0 /\n&pattern sides = 0 /\n"
        "&sweep name = 'p', values = 2.0, -1.0, -2.0 /\n&step t_N = p, increments = 10 /\n"
        "&step slip = 0.1, increments = 20 /\n"
    )
    for folder, jobs in ((tmp_path / "one", []), (tmp_path / "two", ["--jobs", "2"])):
        folder.mkdir()
        code = main(["run", str(case), "-o", str(folder / "out.csv"), "--planes", *jobs])
        messages = capfd.readouterr().err.replace(str(folder), "")
        values.append((code, messages, {path.name: path.read_bytes() for path in folder.iterdir()}))
    assert values[0] == values[1] and values[0][0] == 2 and len(values[0][2]) == 4
    for jobs, output, message in (
        ("0", "out.csv", "--jobs 0: expected 1 to 2, the number of processors"),
        ("3", "out.csv", "--jobs 3: expected 1 to 2, the number of processors"),
        ("2", "-", "-o -: expected the name of a file"),
        ("2", str(tmp_path / "none/out.csv"), "none/out.csv: expected a file in a folder that exists"),
    ):
        assert main(["run", str(case), "-o", output, "--jobs", jobs]) == 1
        assert message in capfd.readouterr().err
    # what is there is looked at before any run
    (tmp_path / "mine_7.csv").write_text("mine")
    monkeypatch.setattr(sweeps, "map_in_order", lambda *_: pytest.fail("a run began"))
    assert main(["run", str(case), "-o", str(tmp_path / "mine.csv"), "--jobs", "1"]) == 1
    assert "mine_7.csv: this file is there and is not replaced" in capfd.readouterr().err


@pytest.mark.skipif(len(getattr(os, "sched_getaffinity", str)(0)) < 2, reason="needs two processors")
@pytest.mark.parametrize(
    ("number", "code", "jobs"), [(signal.SIGINT, 130, 2), (signal.SIGTERM, 143, 2), (signal.SIGTERM, 143, 1)]
)
def test_a_command_that_is_ended_ends_its_processes(
    number: int, code: int, jobs: int, tmp_path: Path
) -> None:
    """Ctrl-C and `kill` end the runs of a sweep, too, before they are complete."""
    path = tmp_path / "long.nml"
    path.write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /\n&pattern sides = 0 /\n"
        "&sweep name = 'p', values = -1, -2 /\n&step t_N = p /\n&step slip = 5, increments = 9000000 /\n"
    )
    command = [sys.executable, "-m", "asperity", "run", path, "-o", tmp_path / "out.csv", "--jobs", f"{jobs}"]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen(command, preexec_fn=heeds_signals, **streams) as process:
        while len([*tmp_path.glob("out_*.csv")]) < jobs and process.poll() is None:
            time.sleep(0.1)
        process.send_signal(number)
        # no process holds the pipe any more
        process.communicate(timeout=20.0)
    assert process.returncode == code
