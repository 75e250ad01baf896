"""Signals that end a command or a script end the driver that it has started, whenever they come."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from support_signals import Starter

CASE = """&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 0 /
&sweep name = 'p', values = -1 /
&step t_N = p /
&step slip = 5, increments = 9000000 /
"""
MARK = """import os, signal, subprocess, sys
start = subprocess.Popen._execute_child
def mark(self, *arguments):
    start(self, *arguments)
    {now}
    open("pid", "w").write(str(self.pid))
subprocess.Popen._execute_child = mark
"""
"""Write the number of each process that is started; now: what happens before Python knows of it."""
COMMAND = "from asperity.cli import main; sys.exit(main({0}))"
FOREIGN = """import asperity
umat = asperity.ForeignUmat("{0}", 0.01, 100.0, (100.0, 0.01, 0.02, 0.5, 0.0), 7, damage=1)
umat.run(asperity.Step(s_N=0.02, increments=9000000))
"""
JOBS = {
    "run": COMMAND.format(["run", "case.nml", "-o", "out.csv", "--quiet"]),
    "jobs": COMMAND.format(["run", "case.nml", "-o", "out.csv", "--jobs", "1"]),
    "check": COMMAND.format(["check-umat", "case.nml"]),
    "foreign": FOREIGN,
}


def is_running(number: int) -> bool:
    """Whether a process is there; one that nobody has waited for yet (Z) is not."""
    listed = subprocess.run(["ps", "-o", "stat=", "-p", str(number)], capture_output=True, text=True)
    return not (listed.stdout.strip() or "Z").startswith("Z")


@pytest.fixture(scope="module")
def starter() -> Iterator[Starter]:
    """Start of scripts without their imports."""
    starter = Starter()
    yield starter
    starter.end()


def wait_for_mark(pid: Path, number: int) -> None:
    """Wait until a script has started a process, or has ended."""
    while not (pid.is_file() and pid.read_text()) and is_running(number):
        time.sleep(0.01)


@pytest.mark.parametrize("early", [True, False])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
@pytest.mark.parametrize("job", JOBS)
def test_the_driver_ends(
    job: str, number: int, early: bool, library: Path, starter: Starter, tmp_path: Path
) -> None:
    """The signal comes while the driver starts, or later; both processes end, with the code of the signal."""
    (tmp_path / "case.nml").write_text(CASE, encoding="utf-8")
    mark = MARK.format(now=f"os.kill(os.getpid(), {int(number)})" if early else "pass")
    script = mark + JOBS[job].format(library)
    pid = tmp_path / "pid"
    process = starter.start(script, tmp_path)
    wait_for_mark(pid, process)
    if not early:
        os.kill(process, number)
    code = starter.code()
    # a script ends by the signal itself, a command with its code
    assert code == (-number if job == "foreign" else 128 + number)
    assert not is_running(int(pid.read_text()))


@pytest.mark.parametrize("job", JOBS)
def test_the_driver_ends_with_what_is_killed(
    job: str, library: Path, starter: Starter, tmp_path: Path
) -> None:
    """SIGKILL, which no program can heed, ends the driver and the child of a UMAT, too."""
    (tmp_path / "case.nml").write_text(CASE, encoding="utf-8")
    script = MARK.format(now="pass") + JOBS[job].format(library)
    pid = tmp_path / "pid"
    process = starter.start(script, tmp_path)
    wait_for_mark(pid, process)
    os.kill(process, signal.SIGKILL)
    code = starter.code()
    number = int(pid.read_text())
    ended = time.monotonic() + 60.0
    while is_running(number) and time.monotonic() < ended:
        time.sleep(0.05)
    assert code == -signal.SIGKILL and not is_running(number)


def test_an_ignored_signal_ends_nothing(tmp_path: Path) -> None:
    """A command under nohup goes on after the terminal is closed, as its driver does."""
    (tmp_path / "case.nml").write_text(CASE.replace("9000000", "9"), encoding="utf-8")
    strikes = f"os.kill(os.getpid(), {int(signal.SIGHUP)}); os.kill(self.pid, {int(signal.SIGHUP)})"
    ignore = "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
    script = ignore + MARK.format(now=strikes) + JOBS["run"]
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "out_-1.csv").is_file()


def test_a_driver_that_crashes(tmp_path: Path) -> None:
    """A driver that another process kills is an error, also in a sweep."""
    (tmp_path / "case.nml").write_text(CASE, encoding="utf-8")
    for job in ("run", "jobs", "check"):
        script = MARK.format(now=f"os.kill(self.pid, {int(signal.SIGKILL)})") + JOBS[job]
        done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 1 and "rie_driver was ended by signal 9 (Killed)" in done.stderr


def test_a_closed_pipe(tmp_path: Path) -> None:
    """A reader that has all it wants, as head, ends driver and command without an error."""
    (tmp_path / "case.nml").write_text(
        CASE.replace("&sweep name = 'p', values = -1 /", "").replace("p /", "-1 /")
    )
    command = [sys.executable, "-c", MARK.format(now="pass") + COMMAND.format(["run", "case.nml", "-o", "-"])]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline()
        process.stdout.close()
        process.wait(timeout=60.0)
    assert process.returncode == 0
    assert not is_running(int((tmp_path / "pid").read_text()))
