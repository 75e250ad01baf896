"""Executors: the same answers in the same order on threads, processes and a cluster, and lost workers."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
import support_parallel as work
from asperity import Interface, LoadCase, Material, Pattern, select
from asperity.cli import main
from asperity.fit.fitting import fit
from asperity.parallel import MOST_LOSSES, Processes, Serial, cluster, map_in_order
from asperity.slip_curves import slip_curves

from harness.studies import fits as study

LAW = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0)


def spawned(count: int) -> ProcessPoolExecutor:
    """Processes of the standard library."""
    return ProcessPoolExecutor(count, mp_context=get_context("spawn"))


EXECUTORS: dict[str, Callable[[], Executor]] = {
    "serial": Serial,
    "threads": lambda: ThreadPoolExecutor(3),
    "pool": lambda: spawned(2),
    "processes": lambda: Processes(2),
}


@pytest.fixture(scope="module", params=EXECUTORS)
def executor(request: pytest.FixtureRequest):
    """Every kind of executor of this machine."""
    with EXECUTORS[request.param]() as found:
        yield found


def test_values_are_in_the_order_of_the_items(executor: Executor) -> None:
    """The order is that of the items, and progress is called once for each of them."""
    done: list[int] = []
    found = map_in_order(work.slowly_squared, range(7), executor, lambda: done.append(1))
    assert found == [i**2 for i in range(7)]
    assert len(done) == 7
    assert map_in_order(work.slowly_squared, [], executor) == []
    assert map_in_order(work.nested, [2.0, 3.0], executor) == [[1.0, 2.0, 4.0], [1.0, 3.0, 9.0]]


def test_first_error_is_raised(executor: Executor) -> None:
    """Several items fail, the later ones sooner: the error is that of the first one."""
    with pytest.raises(ValueError, match=r"^value 2: expected less than 2$"):
        map_in_order(work.refused, range(4), executor)


def test_threads_without_an_executor() -> None:
    """Without an executor threads do the work; loops within a task are not divided further."""
    assert map_in_order(work.slowly_squared, range(5)) == [i**2 for i in range(5)]
    assert map_in_order(work.nested, [2.0]) == [[1.0, 2.0, 4.0]]


@pytest.mark.slow
def test_results_have_the_same_bits(executor: Executor) -> None:
    """Curves, a fit from several starts and a selection do not depend on the executor."""
    joint = Interface(LAW, Pattern.regular(4, 30.0))
    arguments = joint, np.arange(0.0, 90.0, 2.0), np.linspace(0.0, 0.4, 21), -1.0
    mine, other = slip_curves(*arguments), slip_curves(*arguments, executor=executor)
    for name in ("tau_L", "tau_across", "s_N", "damage", "work", "rows", "iterations"):
        np.testing.assert_array_equal(getattr(mine, name), getattr(other, name))
    tests = study.synthetic(0.03, 0, rows=20, increments=400)
    fits = [fit(tests, fixed=study.SET, increments=20, starts=2, executor=one) for one in (None, executor)]
    np.testing.assert_array_equal(fits[0].x, fits[1].x)
    np.testing.assert_array_equal(fits[0].covariance, fits[1].covariance)
    assert fits[0].costs == fits[1].costs
    assert fits[0].evaluations == fits[1].evaluations
    case = LoadCase(LAW, theta=30.0, sigma_N=(-1.0,), turns=(0.3,))
    answers = [select(case, 0.1, executor=one) for one in (None, executor)]
    assert answers[0].errors == answers[1].errors
    assert answers[0].tried == answers[1].tried


def test_lost_process_is_no_loss(tmp_path: Path) -> None:
    """A process is killed at work: others take what it has not done, and each item counts once."""
    done: list[int] = []
    with Processes(2) as executor:
        lost_once = partial(work.end_once, tmp_path / "lost")
        assert map_in_order(lost_once, range(8), executor, lambda: done.append(1)) == [i**2 for i in range(8)]
    assert (tmp_path / "lost").exists()
    assert len(done) == 8


def test_losses_have_an_end(tmp_path: Path) -> None:
    """A task that always kills its process is given up; a pool that cannot be replaced, too."""
    with Processes(1) as executor, pytest.raises(OSError, match=f"lost {MOST_LOSSES + 1} times, 0 of 1"):
        map_in_order(work.end_always, [1.0], executor)
    with spawned(1) as pool, pytest.raises(OSError, match="processes were lost"):
        map_in_order(partial(work.end_once, tmp_path / "lost"), [3.0], pool)


# --- cluster ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def local_cluster():
    """Dask cluster of two workers on this machine."""
    distributed = pytest.importorskip("distributed", reason="needs dask.distributed: asperity[dask]")
    import dask

    # processes find the modules of the tests as this one does
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    with (
        dask.config.set({"distributed.nanny.environ.PYTHONPATH": path}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as found,
    ):
        yield found


def test_cluster_gives_the_same_bits(local_cluster) -> None:
    """The workers of a cluster give the values of this process, in order."""
    frictions = np.linspace(0.3, 0.8, 6).tolist()
    with cluster(local_cluster.scheduler_address) as executor:
        found = map_in_order(work.residual, frictions, executor)
    assert found == map_in_order(work.residual, frictions)


def test_worker_of_another_version(local_cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers with another version of the library are refused."""
    monkeypatch.setattr("asperity.contract.library_version", lambda: "0.0.1")
    with (
        pytest.raises(ValueError, match=r"worker tcp://.*expected asperity 0\.0\.1 there"),
        cluster(local_cluster.scheduler_address),
    ):
        pass


def test_lost_worker_of_a_cluster_is_no_loss(local_cluster) -> None:
    """One of two workers is killed while tasks are done: the values are all there, in order."""
    frictions = np.linspace(0.3, 0.8, 60).tolist()
    killed: list[int] = []
    first = next(iter(local_cluster.workers.values()))

    def kill() -> None:
        if not killed:
            killed.append(first.process.pid)
            os.kill(first.process.pid, 9)

    with cluster(local_cluster.scheduler_address) as executor:
        found = map_in_order(work.residual, frictions, executor, kill)
    assert killed
    assert found == map_in_order(work.residual, frictions)


def test_worker_that_is_lost_again_and_again(local_cluster) -> None:
    """A task that kills every worker ends with an error, not with a wait."""
    with (
        pytest.raises(OSError, match="died while running it"),
        cluster(local_cluster.scheduler_address) as executor,
    ):
        map_in_order(work.end_always, [1.0], executor)


@pytest.mark.slow
def test_fit_on_a_cluster(local_cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--jobs and --scheduler print what the command prints without them."""
    study.write_record(tmp_path / "record.csv", study.synthetic(0.03, 0, rows=20, increments=400))
    values = " ".join(f"{name}={value}" for name, value in study.TRUTH.items() if name not in ("mu", "theta"))
    command = ["fit", str(tmp_path / "record.csv"), "--starts", "3", "--set", values]
    printed = []
    for where in ([], ["--jobs", "2"], ["--scheduler", local_cluster.scheduler_address]):
        assert main([*command, *where]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1] == printed[2]


def test_sweep_by_several_drivers(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The runs of a sweep write the same files and messages, one of them without equilibrium."""
    (tmp_path / "case.nml").write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 100.0 /\n&pattern sides = 0 /\n"
        "&sweep name = 'p', values = 2.0, -1.0, -2.0 /\n&step t_N = p, increments = 10 /\n"
        "&step slip = 0.1, increments = 20 /\n"
    )
    found = []
    for folder, jobs in (("one", []), ("two", ["--jobs", "2"])):
        output = tmp_path / folder / "out.csv"
        output.parent.mkdir()
        code = main(["run", str(tmp_path / "case.nml"), "-o", str(output), "--planes", *jobs])
        messages = capfd.readouterr().err.replace(str(tmp_path / folder), "").replace(f"{tmp_path}/", "")
        files = {path.name: path.read_bytes() for path in output.parent.iterdir()}
        # the case of the failed increment names its own folder
        files = {name: content.replace(f"{tmp_path}/".encode(), b"") for name, content in files.items()}
        found.append((code, messages, files))
    assert found[0] == found[1]
    assert found[0][0] == 2 and len(found[0][2]) == 4
    assert main(["run", str(tmp_path / "case.nml"), "-o", str(tmp_path / "none/out.csv"), "--jobs", "2"]) == 1
    assert "none/out.csv: expected a file in a folder that exists" in capfd.readouterr().err
    (tmp_path / "replay.nml").write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /\n&pattern sides = 0 /\n"
        "&replay file = 's.csv' /\n"
    )
    (tmp_path / "s.csv").write_text("s_N,s_Tx,s_Ty\n0.0,0.1,0.0\n")
    assert main(["run", str(tmp_path / "replay.nml"), "-o", str(tmp_path / "r.csv"), "--jobs", "2"]) == 1
    assert "&replay: expected without --jobs" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--jobs", "0"], "--jobs 0: expected at least 1"),
        (["--scheduler", "tcp://127.0.0.1:1"], "expected the address of a Dask scheduler"),
        (["--scheduler", "nonsense"], "expected the address of a Dask scheduler, tcp://HOST:PORT"),
        (["--scheduler", "http://127.0.0.1:8786"], "expected the address of a Dask scheduler, tcp://"),
        (["--scheduler", "tcp://127.0.0.1:99999"], "expected the address of a Dask scheduler, tcp://"),
    ],
)
def test_wrong_workers(
    options: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Wrong values of the options are named, with exit code 1, in a short time."""
    if options[0] == "--scheduler":
        pytest.importorskip("distributed", reason="needs dask.distributed: asperity[dask]")
    monkeypatch.setattr("asperity.parallel.CONNECTING", 0.5)
    study.write_record(tmp_path / "record.csv", study.synthetic(0.03, 0, rows=20, increments=400))
    before = time.monotonic()
    assert main(["fit", str(tmp_path / "record.csv"), *options]) == 1
    assert message in capsys.readouterr().err
    assert time.monotonic() - before < 20.0


def test_cluster_needs_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without dask.distributed the message says what to install."""
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(ValueError, match=r"asperity\[dask\]"), cluster("tcp://127.0.0.1:1"):
        pass
