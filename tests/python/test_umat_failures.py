"""UMATs that fail: crashes, exits, endless loops, processes and files, with the rows before them kept."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from support_driver import call
from support_signals import heeds_signals
from support_umat import planted

pytestmark = [
    pytest.mark.slow,
    pytest.mark.waits,
    pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran"),
]


def wait_for(condition) -> None:
    """Wait until a condition holds, at most 20 s."""
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def children(pid: int) -> list[str]:
    """Return the processes that a process has started."""
    return Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()


@pytest.mark.parametrize(
    ("fault", "nstatv", "said", "rows"),
    [
        (4, 2, r"at the start of the path it wrote to STATEV\(3\), of 2: expected a larger nstatv", 0),
        (5, 7, "in step 1 increment 4 it called XIT", 3),
        (6, 7, r"no finite number in STRESS\(1\)", 3),
        (8, 7, "read more than the 5 values of PROPS", 0),
        (9, 7, "called STDB_ABQERR: no more of this", 3),
        (15, 7, "no number in PNEWDT", 3),
        (17, 7, "exit code 1, as STOP or exit do; it printed last: ERROR STOP", 3),
    ],
)
def test_a_umat_that_fails(run, library: Path, fault: int, nstatv: int, said: str, rows: int) -> None:
    """A failure is an error that names UMAT, increment and reason; the rows before it are kept."""
    result = run(planted(library, fault, nstatv) + "&step s_N = 0.025, increments = 8 /\n", code=1)
    assert re.search(rf"umat_ of {library}: .*{said}", result.messages)
    assert len(result.rows) == rows


def test_a_tolerance_keeps_the_rows_before_a_failure(run, library: Path) -> None:
    """A path with a tolerance whose UMAT fails has the rows of the path without it, up to the failure."""
    path = planted(library, 5) + "&step s_N = 0.025, increments = 8 /\n"
    result = run("&case tolerance = 1e-3 /\n" + path, code=1)
    assert "called XIT" in result.messages and result.rows == run(path, code=1).rows
    assert "stopped at step 1 increment 3" in result.messages and "ended at" not in result.messages


SIGNAL = r"ended by signal {} \({}\)"


@pytest.mark.parametrize(
    ("attack", "said"),
    {
        "*(volatile int *)8 = 1;": SIGNAL.format(11, "Segmentation fault"),
        "for (int i = 0; i < 1000; i++) statev[i] = 1;": r"STATEV\(2\), of 1: expected a larger nstatv",
        "statev[1000000] = 1;": SIGNAL.format(11, "Segmentation fault"),
        "exit(0);": "ended the program with exit code 0",
        "quick_exit(3);": "ended the program with exit code 3",
        "abort();": SIGNAL.format(6, "Aborted"),
        "raise(SIGFPE);": SIGNAL.format(8, "Floating point exception"),
        "for (;;);": r"did not complete the increment within the limit of 0\.5 s",
        "signal(SIGTERM, SIG_IGN); raise(SIGSTOP);": r"limit of 0\.5 s",
        'for (;;) puts("still");': r"limit of 0\.5 s; it printed last: ",
        "if (fork() == 0) for (;;) pause(); abort();": SIGNAL.format(6, "Aborted"),
        "for (int i = 3; i < 1000; i++) close(i);": "closed a file of this program",
        "signal(SIGSEGV, wait_for_ever); *(volatile int *)8 = 1;": r"limit of 0\.5 s",
        'exit(puts("negative damage"));': "it printed last: negative damage",
    }.items(),
)
def test_attacks(run, attacker, attack: str, said: str) -> None:
    """A UMAT that crashes, ends the program, loops, or closes files is reported; the rows are kept."""
    result = run(attacker(attack), code=1)
    assert re.search(rf"umat_ of .*attacker\.so: in step 1 increment 4 .*{said}", result.messages)
    assert len(result.rows) == 3
    failed = result.messages.split("the failed increment was written to ")[1].split()[0]
    assert failed == "case.failed.nml"


@pytest.mark.parametrize(
    "attack",
    [
        "close(1); close(2);",
        'for (int i = 0; i < 100000; i++) puts("text");',
        "if (fork() == 0) for (;;) pause();",
        "signal(SIGCHLD, SIG_IGN); if (fork() == 0) _exit(0);",
        'chdir("/");',
        "feenableexcept(FE_ALL_EXCEPT);",
        "fesetround(FE_UPWARD);",
        "signal(SIGALRM, SIG_IGN); alarm(1);",
        "char c; read(0, &c, 1);",
    ],
)
def test_harmless(run, attacker, attack: str) -> None:
    """Closed output, much of it, processes, folders, exceptions, alarms and input of a UMAT change no row."""
    plain, rows = run(attacker("")), run(attacker(attack))
    assert rows.rows == plain.rows and len(rows.rows) == 8


@pytest.mark.parametrize("attack", ["atexit(wait_for_ever);", "on_exit(wait_for_ever, 0);"])
@pytest.mark.parametrize("tolerance", ["", "&case tolerance = 1e-3 /\n"])
def test_an_endless_exit(run, attacker, attack: str, tolerance: str) -> None:
    """A process that does not end after the path is ended and reported; the path has each row once."""
    rows = run(tolerance + attacker(attack), code=1)
    assert "its process did not end within 2 s after the path was complete" in rows.messages
    assert rows.rows == run(tolerance + attacker("")).rows


@pytest.mark.parametrize(
    "attack", ['unlink("case.csv");', 'rename("case.csv", "b.csv");', 'fclose(fopen("case.csv", "w"));']
)
def test_a_result_that_the_umat_removes(run, attacker, attack: str) -> None:
    """Rows that are not in the file at the end are no success."""
    assert "case.csv: another program, or the UMAT, has changed" in run(attacker(attack), code=1).messages


def test_no_process_is_left(run, attacker) -> None:
    """Processes that a UMAT started end with it."""
    run(attacker('if (fork() == 0) execlp("sleep", "sleep", "98765", NULL);'))
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    assert "98765" not in listed.stdout


def test_copies_of_a_process_do_not_go_on(run, attacker, tmp_path: Path) -> None:
    """Where a UMAT forks in each call, only the process that was there before calls it again."""
    log = tmp_path / "pids"
    note = f'FILE *log = fopen("{log}", "a"); fprintf(log, "%d\\n", getpid()); fclose(log); fork();'
    assert len(run(attacker(note).replace("s_N = 0.008", "t_N = 0.8")).rows) == 8
    assert len(set(log.read_text().split())) == 1 < len(log.read_text().split())


def test_inputs_are_not_replaced(run, attacker, tmp_path: Path) -> None:
    """The library of a UMAT and the case file are neither results nor reports, even with --force."""
    case = attacker("")
    library = (tmp_path / "attacker.so").read_bytes()
    for option, name in (("-o", "attacker.so"), ("--report", "case.nml")):
        assert "would replace" in run(case, option, name, "--force", code=1).messages
    assert (tmp_path / "attacker.so").read_bytes() == library
    assert (tmp_path / "case.nml").read_text(encoding="utf-8") == case


def test_two_runs_do_not_share_a_file(driver: Path, attacker, tmp_path: Path) -> None:
    """A second run into a file to which one writes is refused, and changes none of its rows."""
    (tmp_path / "case.nml").write_text(attacker("for (;;);", 60), encoding="utf-8")
    with subprocess.Popen([driver, "case.nml"], cwd=tmp_path, stderr=subprocess.DEVNULL) as process:
        wait_for(lambda: (tmp_path / "case.csv").is_file())
        wait_for(lambda: (tmp_path / "case.csv").read_text().count("\n") == 4)
        second = call(driver, "case.nml", folder=tmp_path)
        assert second.returncode == 1
        assert "case.csv: another run writes to it: expected another -o" in second.stderr
        assert (tmp_path / "case.csv").read_text().count("\n") == 4
        process.kill()


def test_an_interrupt_ends_the_child(driver: Path, attacker, tmp_path: Path) -> None:
    """SIGINT to the driver ends the UMAT, too, and keeps the rows."""
    (tmp_path / "case.nml").write_text(attacker("for (;;);", 60), encoding="utf-8")
    with subprocess.Popen(
        [driver, "case.nml"], cwd=tmp_path, stderr=subprocess.DEVNULL, preexec_fn=heeds_signals
    ) as process:
        wait_for(lambda: (tmp_path / "case.csv").is_file())
        wait_for(lambda: (tmp_path / "case.csv").read_text().count("\n") == 4)
        [child] = children(process.pid)
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == -signal.SIGINT
    wait_for(lambda: not Path(f"/proc/{child}").exists())


def test_failed_increment_runs_again(driver: Path, library: Path, tmp_path: Path) -> None:
    """The file of the failed increment fails in the same way, with a quote in the path of the library."""
    folder = tmp_path / "it's"
    folder.mkdir()
    shutil.copy(library, folder)
    group = planted(library, 5).replace(str(library), str(folder / library.name).replace("'", "''"))
    (tmp_path / "a.nml").write_text(group + "&step s_N = 0.025, increments = 8 /\n", encoding="utf-8")
    said = [call(driver, name, folder=tmp_path).stderr for name in ("a.nml", "a.failed.nml")]
    assert all("called XIT" in text for text in said)
