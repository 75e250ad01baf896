"""UMATs in shared libraries: as the law of a case, in Python, and their checks.

The law of planted_umat.f has faults on request.
"""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import asperity
import numpy as np
import pytest
from asperity import ForeignUmat, Interface, Material, Pattern, Step
from asperity.cli import main
from support_driver import FLAT, MATERIAL, RP_4, S_0, K, call

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran"),
]

STIFFNESS, ONSET, BROKEN, SHARE = 100.0, 0.01, 0.2, 0.5
"""Constants of the planted law: stiffness, separations of onset and rupture, weight of the shears."""

MIXED = """&step s_N = 0.05, s_Tx = 0.04, increments = 20 /
&step s_N = -0.01, s_Tx = 0.01, increments = 20 /
&step s_N = 0.02, s_Tx = -0.2, s_Ty = 0.02, increments = 40 /
"""
"""Path with mixed modes, unloading, closing and reloading."""

ATTACKER = """
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
void wait_for_ever() { for (;;) pause(); }
void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, double *stran, double *dstran) {
  for (int i = 0; i < 9; i++) ddsdde[i] = i % 4 == 0 ? 100 : 0;
  for (int i = 0; i < 3; i++) stress[i] = 100 * (stran[i] + dstran[i]);
  if (stran[0] + dstran[0] > 0.0035) { ATTACK }
}
"""
"""Elastic UMAT that does something at larger openings."""

HIDDEN = {"repeated", "cut", "alternating", "threads", "restart"}
"""Checks that hidden state fails."""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of the library of the planted UMAT."""
    path = tmp_path_factory.mktemp("umat") / "libplanted.so"
    source = Path(__file__).parents[2] / "harness/examples/planted_umat.f"
    command = ["gfortran", "-ffree-form", "-shared", "-fPIC", "-O1", source, "-o", path]
    subprocess.run(command, check=True, capture_output=True)
    return path


def planted(library: Path, fault: int = 0, nstatv: int = 7, more: str = "") -> str:
    """Group &umat of the planted law."""
    props = f"{STIFFNESS}, {ONSET}, {BROKEN}, {SHARE}, {fault}"
    return (
        f"&umat library = '{library}', props = {props}, nstatv = {nstatv}, damage = 1,\n"
        f"  length = {ONSET}, stiffness = {STIFFNESS} {more} /\n"
    )


def of_python(library: Path, fault: int = 0) -> ForeignUmat:
    """Return the planted law in Python."""
    return ForeignUmat(library, ONSET, STIFFNESS, (STIFFNESS, ONSET, BROKEN, SHARE, fault), 7, damage=1)


@pytest.fixture
def attacker(tmp_path: Path):
    """Return a function that makes a case of an elastic UMAT with a statement for increments from 4 on."""

    def case(statement: str, limit: float = 0.5) -> str:
        source, path = tmp_path / "attacker.c", tmp_path / "attacker.so"
        source.write_text(ATTACKER.replace("ATTACK", statement), encoding="utf-8")
        subprocess.run(["gcc", "-shared", "-fPIC", "-w", source, "-o", path, "-lm"], check=True)
        return (
            f"&umat library = '{path}', length = 0.01, stiffness = 100, nstatv = 1, limit = {limit} /\n"
            "&step s_N = 0.008, increments = 8 /\n"
        )

    return case


def wait_for(condition) -> None:
    """Wait until a condition holds, at most 20 s."""
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def children(pid: int) -> list[str]:
    """Return the processes that a process has started."""
    return Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()


def outcomes(text: str) -> dict[str, str]:
    """Return the outcome of each check in a table."""
    return dict(
        (name, outcome)
        for outcome, name in re.findall(r"^(passed|FAILED|stated|not \w+) +(\w+)", text, re.MULTILINE)
    )


# --- load paths ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "steps"),
    [
        (MATERIAL + FLAT, "&step t_N = -2, increments = 20 /\n&step slip = 0.3, increments = 30 /\n"),
        (MATERIAL + RP_4, "&step t_N = -1, k_N = 5 /\n&step slip = 0.2, -0.2, cycles = 2 /\n"),
        (MATERIAL + FLAT, "&step t_N = 2.9, 6, k_N = 40, increments = 30 /\n"),
        (MATERIAL + FLAT, "&step t_N = 6, k_N = 40, follow = 'branch' /\n"),
        (
            MATERIAL.replace(" /", ", tau_v = 0.5 /") + FLAT,
            "&step t_N = 3.2 /\n&step t_N = 3.2, time = 8.6 /\n",
        ),
    ],
    ids=["CNL", "CNS", "snap", "branch", "viscous"],
)
def test_own_umat_is_the_own_law(run, law: str, steps: str) -> None:
    """The UMAT of this project through its library gives what the law gives: rows, energies and snaps."""
    pattern = Pattern.regular(4, 30.0) if law.endswith(RP_4) else Pattern.regular(0, 0.0)
    joint = Interface(Material(3.0, 0.3, 0.9, 0.5, tau_v=0.5 * ("tau_v" in law)), pattern)
    own = run(law + steps)
    props = ", ".join(f"{value:.17g}" for value in joint.props())
    umat = f"&umat library = '{asperity.library()}', props = {props}, nstatv = {joint.nstatv},\n"
    foreign = run(f"{umat}  damage = 1, length = {S_0:.17g}, stiffness = {K:.17g} /\n{steps}")
    for name in ("s_N", "s_Tx", "t_N", "t_Tx", "damage", "stored", "rupture", "friction", "work"):
        np.testing.assert_allclose(foreign[name][-1], own[name][-1], atol=1e-9)
    assert [sum("snap" in events for events in rows.events) for rows in (own, foreign)] in ([0, 0], [1, 1])


def test_sweep_springs_and_expected_values(run, library: Path) -> None:
    """Mode I has peak and energy of the bilinear law; &expect, &sweep and springs are those of every case."""
    energy = 0.5 * STIFFNESS * ONSET * BROKEN
    steps = "&step s_N = x, increments = 200 /\n&step t_N = 0.1, k_N = 2.0 /\n"
    expected = f"&expect rupture = {energy}, stored = 0, work = {energy}, tolerance = 2e-4, when = 0.25 /\n"
    expected += "&expect end = 'complete', when = 0.1 /\n&sweep name = 'x', values = 0.1, 0.25 /\n"
    run(planted(library) + steps.splitlines()[0] + "\n" + expected)
    held = run(planted(library) + "&step t_N = 0.3, k_N = 40.0, increments = 5 /\n")
    np.testing.assert_allclose(held["t_N"] + 40.0 * held["s_N"], [0.06, 0.12, 0.18, 0.24, 0.3], rtol=1e-12)
    refined = run("&case tolerance = 1e-3 /\n" + planted(library) + "&step s_N = 0.25, increments = 10 /\n")
    np.testing.assert_allclose([refined["work"][-1], refined["t_N"].max()], [energy, 1.0], rtol=2e-3)


def test_requested_increments(run, library: Path) -> None:
    """A smaller increment is taken where the UMAT asks for one; the result is that of small increments."""
    path = "&step s_N = 0.02, s_Tx = 0.03, increments = 4 /\n"
    cut, fine = run(planted(library, 7) + path), run(planted(library) + path.replace("= 4", "= 40"))
    assert all("cut" in events for events in cut.events)
    np.testing.assert_allclose(cut["t_N"][-1], fine["t_N"][-1], rtol=1e-9)
    np.testing.assert_allclose(cut["rupture"][-1], fine["rupture"][-1], rtol=1e-2)
    endless = run(planted(library, 14) + path, code=2)
    assert "the law asks for less than 1e-6 of the increment" in endless.messages and len(endless.rows) == 2


def test_numbers_and_times_of_increments(run, library: Path) -> None:
    """KSTEP, KINC, TIME and DTIME are those of Abaqus: times at the start of the increment."""
    steps = "&step s_N = 0.001, increments = 2, time = 4 /\n&step s_N = 0.002, increments = 2 /\n"
    rows = run(planted(library) + steps, "--planes")
    found = np.stack([rows[f"statev_{i}"] for i in range(3, 8)], axis=1)
    expected = [[1, 1, 0, 0, 2], [1, 2, 2, 2, 2], [2, 1, 0, 4, 0.5], [2, 2, 0.5, 4.5, 0.5]]
    np.testing.assert_allclose(found, expected)


def test_order_thickness_and_state(run, library: Path) -> None:
    """Components in another order, strains instead of separations, and a damaged start."""
    path = "&step s_N = 0.03, s_Tx = 0.02, increments = 7 /\n"
    plain = run(planted(library) + path)
    six = run(planted(library, more=", order = '-,-,N,-,Tx,Ty'") + path)
    np.testing.assert_array_equal(six.vector("t"), plain.vector("t"))
    other = "&step s_Tx = 0.03, s_N = 0.02, increments = 7 /\n"
    turned = run(planted(library, more=", order = 'Tx,N,Ty'") + other)
    np.testing.assert_array_equal(turned["t_Tx"], plain["t_N"])
    case = planted(library, more=", thickness = 0.5").replace(
        f"{STIFFNESS}, {ONSET}, {BROKEN}", "50, 0.02, 0.4"
    )
    np.testing.assert_allclose(run(case + path)["t_N"], plain["t_N"], rtol=1e-12)
    damaged = run(planted(library, more=f", state = 0, {BROKEN}, 5*0") + path)
    assert damaged["damage"].tolist() == [1.0] * 7 and not damaged["t_N"].any()


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
    plain, found = run(attacker("")), run(attacker(attack))
    assert found.rows == plain.rows and len(found.rows) == 8


@pytest.mark.parametrize("attack", ["atexit(wait_for_ever);", "on_exit(wait_for_ever, 0);"])
@pytest.mark.parametrize("tolerance", ["", "&case tolerance = 1e-3 /\n"])
def test_an_endless_exit(run, attacker, attack: str, tolerance: str) -> None:
    """A process that does not end after the path is ended and reported; the path has each row once."""
    found = run(tolerance + attacker(attack), code=1)
    assert "its process did not end within 2 s after the path was complete" in found.messages
    assert found.rows == run(tolerance + attacker("")).rows


@pytest.mark.parametrize(
    "attack", ['unlink("case.csv");', 'rename("case.csv", "b.csv");', 'fclose(fopen("case.csv", "w"));']
)
def test_a_result_that_the_umat_removes(run, attacker, attack: str) -> None:
    """Rows that are not in the file at the end are no success."""
    assert "case.csv: another program, or the UMAT, has changed" in run(attacker(attack), code=1).messages


NO_LAW = """
void umat_({type} *stress, {type} *statev, {type} *ddsdde, double *a, double *b, double *c, double *d,
           double *e, double *f, double *g, {type} *stran, {type} *dstran) {{ {body} }}
"""
"""UMAT without a law; the type is that of its real numbers."""

ELASTIC = "for (int i = 0; i < 9; i++) ddsdde[i] = i % 4 ? 0 : {0}; for (int i = 0; i < 3; i++) "
ELASTIC += "stress[i] = {1} * (stran[i] + dstran[i]);"
DIAGONAL = ELASTIC.replace("i++", "i += 4", 1)


@pytest.mark.parametrize(
    ("real", "body", "code", "said", "failed"),
    [
        ("double", "", 1, "at the start of the path it does not write DDSDDE", {"path", "stiffness"}),
        ("float", ELASTIC.format(100, 100), 1, "in double precision", {"path", "stiffness"}),
        ("double", ELASTIC.format(-100, -100), 1, "= -100 of its DDSDDE: expected", {"path", "stiffness"}),
        ("double", ELASTIC.format(5, 5), 0, "", {"stiffness"}),
        ("double", ELASTIC.format(100, 0), 0, "", {"stiffness", "tangent"}),
        ("double", ELASTIC.format(100, -100), 0, "", {"stiffness", "tangent"}),
        ("double", DIAGONAL.format(100, 100), 0, "", {"written"}),
        ("double", "double old = ddsdde[0]; " + ELASTIC.format("100 + old", 100), 0, "", {"written"}),
        ("double", ELASTIC.format(100, 100).replace("stran[i] + ", ""), 0, "", {"unmoved"}),
        ("double", ELASTIC.format(100, "1 + 100"), 0, "", {"stiffness"}),
        ("double", ELASTIC.format(100, "i < 2 ? 0 : 100"), 0, "", {"stiffness", "tangent"}),
        ("double", ELASTIC.format(100, 100), 0, "", set()),
    ],
    ids="empty single negative soft zero signs diagonal reads increments prestress one elastic".split(),
)
def test_no_law(run, driver, tmp_path: Path, real: str, body: str, code: int, said: str, failed) -> None:
    """A routine that is no law, or not the declared one, ends without rows or fails its check."""
    source, path = tmp_path / "no_law.c", tmp_path / "no_law.so"
    source.write_text(NO_LAW.format(type=real, body=body), encoding="utf-8")
    subprocess.run(["gcc", "-shared", "-fPIC", source, "-o", path], check=True)
    case = "&umat library = 'no_law.so', length = 0.01, stiffness = 100, ntens = 3, energies = .false. /\n"
    found = run(case + "&step s_N = 0.01, 0, increments = 4 /\n&step slip = 0.02, -0.02 /\n", code=code)
    assert said in found.messages and bool(found.rows) == (code == 0)
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    assert {name for name, outcome in outcomes(done.stdout).items() if outcome == "FAILED"} == failed
    assert done.returncode == bool(failed)


UTILITIES = """
void sinv_(), sprinc_(), sprind_(), rotsig_(), getoutdir_(), getjobname_();
void mutexinit_(), mutexlock_(), mutexunlock_();
void umat_(double *stress, double *statev, double *ddsdde, double *a, double *b, double *c, double *d,
           double *e, double *f, double *g, double *stran, double *dstran, double *h, double *k, double *l,
           double *m, double *n, double *o, char *p, int *q, int *r, int *s, int *nstatv, double *props) {
  static const int ndi = 3, nshr = 3, one = 1;
  const int kind = props[6];
  int length;
  char name[256];
  mutexinit_(&one), mutexlock_(&one), mutexunlock_(&one);
  for (int i = 0; i < 9; i++) ddsdde[i] = i % 4 ? 0 : 100;
  for (int i = 0; i < 3; i++) stress[i] = 100 * (stran[i] + dstran[i]);
  sinv_(props, statev, statev + 1, &ndi, &nshr);
  sprinc_(props, statev + 2, &kind, &ndi, &nshr);
  sprind_(props, statev + 5, statev + 8, &kind, &ndi, &nshr);
  rotsig_(props, props + 7, statev + 17, &kind, &ndi, &nshr);
  getjobname_(name, &length, (long)256);
  statev[23] = length + (name[0] == 'c' && name[4] == ' ' ? 0 : 1000);
  getoutdir_(name, &length, (long)256);
  statev[24] = length;
}
"""
"""Elastic UMAT whose state variables are what Abaqus' utility routines return."""


@pytest.mark.parametrize("kind", [1, 2], ids=["stress", "strain"])
@pytest.mark.parametrize("equal", [False, True], ids=["distinct", "equal"])
def test_utility_routines(run, tmp_path: Path, kind: int, equal: bool) -> None:
    """SINV, SPRINC, SPRIND and ROTSIG agree with NumPy; folder and job are those of the case."""
    source = tmp_path / "utilities.c"
    source.write_text(UTILITIES, encoding="utf-8")
    subprocess.run(["gcc", "-w", "-shared", "-fPIC", source, "-o", tmp_path / "utilities.so"], check=True)
    draw = np.random.default_rng(2015)
    rotation, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    tensor = rotation @ np.diag([2.0, 2.0, -1.0] if equal else [3.0, 1e-3, -7.0]) @ rotation.T
    turn, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    rows, columns = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
    factor = np.repeat([1.0, kind], 3)
    props = [*(tensor[rows, columns] * factor), kind, *turn.T.ravel()]
    text = ", ".join(f"{value:.17g}" for value in props)
    case = f"&umat library = 'utilities.so', props = {text}, nstatv = 25,\n  length = 0.01, "
    found = run(case + "stiffness = 100 /\n&step s_N = 0.001 /\n", "--planes")
    statev = np.array([found[f"statev_{i + 1}"][-1] for i in range(25)])
    close = partial(np.testing.assert_allclose, rtol=1e-12, atol=1e-13)
    expected = np.linalg.eigvalsh(tensor)
    close(np.sort(statev[2:5]), expected)
    directions = statev[8:17].reshape(3, 3).T
    close(directions @ directions.T, np.eye(3))
    close(directions.T @ np.diag(statev[5:8]) @ directions, tensor)
    close(statev[17:23], (turn @ tensor @ turn.T)[rows, columns] * factor)
    if kind == 1:
        deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
        close(statev[:2], [np.trace(tensor) / 3, np.sqrt(1.5 * np.sum(deviator**2))])
    assert statev[23:].tolist() == [len("case"), len(str(tmp_path))]


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
    # a shell in the background starts its programs without SIGINT
    obeys = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(
        [driver, "case.nml"], cwd=tmp_path, stderr=subprocess.DEVNULL, preexec_fn=obeys
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


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("libplanted", "libmissing", "libmissing.so: cannot open shared object file"),
        ("damage = 1", "symbol = 'cohesive_'", "undefined symbol: cohesive_"),
        ("damage = 1", "order = 'N,S'", "order = 'N,S': expected the names N, Tx, Ty"),
        ("damage = 1", "order = 'N,Tx'", "&step: Ty is not zero: expected an order with Ty"),
        ("damage = 1", "state = 1, 2", "2 values of state: expected nstatv = 7"),
        ("damage = 1", "damage = 8", "damage = 8: expected at most nstatv = 7"),
        ("damage = 1", "ntens = 2", "ntens without 3, the number of components of order = 'N,Tx,Ty'"),
        ("stiffness = 100.0", "", "expected library, length"),
        ("stiffness = 100.0", "stiffness = 1e99", "stiffness are out of range: expected other units"),
        ("&umat", "&pattern sides = 0 /\n&umat", "does not go with &umat"),
    ],
)
def test_wrong_input(run, library: Path, old: str, new: str, said: str) -> None:
    """Wrong entries are errors with exit code 1."""
    assert said in run(planted(library).replace(old, new) + MIXED, code=1).messages


# --- Python -------------------------------------------------------------------------------------------------


def test_python_is_the_driver(run, library: Path) -> None:
    """`ForeignUmat.run` gives the rows of the driver, also from a point on, and its reports."""
    law = of_python(library)
    steps = "&step t_N = -0.5, increments = 10 /\n&step s_Tx = 0.1, -0.1, k_N = 3, increments = 20 /\n"
    rows = run(planted(library) + steps)
    whole = law.run([Step(t_N=-0.5, increments=10), Step(s_Tx=[0.1, -0.1], k_N=3.0, increments=20)])
    np.testing.assert_array_equal(whole.traction, rows.vector("t"))
    np.testing.assert_array_equal(whole.rupture, rows["rupture"])
    first, second = Step(s_N=0.03, increments=6), Step(s_N=0.06, increments=6)
    one, two = law.run([first, second]).end, law.run(second, law.run(first).end).end
    # the number of the step begins anew
    np.testing.assert_allclose(one.state - two.state, np.eye(16)[11], atol=1e-15)
    [snap] = law.run(Step(t_N=3.0, k_N=4.0)).snaps
    np.testing.assert_allclose([snap.before[0], snap.after[0]], [ONSET, 0.26], rtol=1e-4)
    with pytest.raises(
        asperity.EquilibriumLost, match=r"beyond step 1 increment 9, .*tension is positive"
    ) as lost:
        law.run(Step(t_N=1.2, increments=10))
    assert len(lost.value.history) == 8
    with pytest.raises(asperity.EquilibriumLost, match="called XIT"):
        of_python(library, 5).run(Step(s_N=0.1))
    with pytest.raises(asperity.EquilibriumLost, match="exit code 0, as STOP or exit do") as stopped:
        of_python(library, 12).run(Step(s_N=0.025, increments=8))
    assert len(stopped.value.history) == 3
    with pytest.raises(asperity.EquilibriumLost, match=r"within the limit of 0.5 s"):
        replace(of_python(library, 18), limit=0.5).run(Step(s_N=0.1))
    with pytest.raises(ValueError, match=r"^&umat: thickness = 0: expected > 0$"):
        replace(of_python(library), thickness=0.0).run(Step(s_N=0.1))
    with pytest.raises(ValueError, match=r"^props has shape \(2, 1\): expected \(n,\)$"):
        replace(of_python(library), props=[[1.0], [2.0]]).run(Step(s_N=0.1))
    own = asperity.ForeignUmat(asperity.library(), 0.02, 150.0, props=(-3.0, 0.3, 0.9, 0.5), nstatv=23)
    with pytest.raises(asperity.EquilibriumLost, match=r"it printed last: .*sigma0 = -3: expected > 0"):
        own.run(Step(s_N=0.01))
    with pytest.raises(FileNotFoundError, match=r"nothing\.so: expected the path of a shared library"):
        of_python(library.with_name("nothing.so"))


def test_commands(library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """`asperity run --plot` draws a case with a UMAT, `check-umat` checks it."""
    monkeypatch.chdir(tmp_path)
    Path("case.nml").write_text(planted(library) + "&step slip = 0.1 /\n", encoding="utf-8")
    assert main(["run", "case.nml", "--plot", "--quiet"]) == 0 and Path("case.png").is_file()
    assert main(["check-umat", "case.nml"]) == 0
    assert set(outcomes(capfd.readouterr().out).values()) == {"passed", "stated"}
    with pytest.raises(ValueError, match="&umat: expected &material and &pattern"):
        asperity.read_case("case.nml")


# --- checks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "case",
    ["figure05b", "figure12", "bed_joint", "rough_joint", "stability/snap", "stability/snap_branch"],
)
def test_own_umat_passes(driver: Path, case: str) -> None:
    """The UMAT of this project passes every check, along cases of the paper and from an initial state."""
    path = Path(__file__).parents[2] / "harness/cases" / f"{case}.nml"
    done = call(driver, path, "--check", "--only", "1", folder=path.parent)
    found = outcomes(done.stdout)
    assert done.returncode == 0 and len(found) == 16
    assert {name for name, outcome in found.items() if outcome != "passed"} == {"symmetry"}


@pytest.mark.parametrize(
    ("fault", "failed"),
    [
        (0, set()),
        (1, {"tangent"}),
        (2, {"cut", "alternating", "threads"}),
        (3, {"dissipation"}),
        (4, {"path", "stiffness"}),
        (5, {"path"}),
        (7, set()),
        (10, {"arguments", "absent"}),
        (11, {"absent"}),
        (13, {"components"}),
    ],
    ids=["none", "symmetrised", "saved", "heals", "overruns", "XIT", "cuts", "writes", "reads", "NTENS"],
)
def test_planted_faults(driver: Path, library: Path, tmp_path: Path, fault: int, failed: set[str]) -> None:
    """A fault fails in its row; hidden state leaves the later rows not judged."""
    (tmp_path / "case.nml").write_text(planted(library, fault, 2) + MIXED, encoding="utf-8")
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    found = outcomes(done.stdout)
    assert {name for name, outcome in found.items() if outcome == "FAILED"} == failed
    assert done.returncode == (1 if failed else 0)
    if failed & HIDDEN:
        assert found["tangent"] == found["energies"] == "not judged"
    if fault == 1:
        assert "DDSDDE is symmetric" in done.stdout
    if fault == 11:
        assert "it uses COORDS" in done.stdout


@pytest.mark.parametrize(("fault", "failed"), [(14, {"path"}), (19, {"restart"}), (20, {"restart"})])
def test_requests_and_initial_states(driver, library: Path, tmp_path: Path, fault: int, failed: set) -> None:
    """Endless requests end a path; a state that is set to 0 in a new process, or in each step, is lost."""
    (tmp_path / "case.nml").write_text(planted(library, fault) + MIXED, encoding="utf-8")
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    assert {name for name, outcome in outcomes(done.stdout).items() if outcome == "FAILED"} == failed
    assert done.returncode == 1


def test_what_a_umat_does_not_declare(driver: Path, attacker, tmp_path: Path) -> None:
    """Components and energies that a UMAT does not have are no failures; without a word they are."""
    case = attacker("")
    for more, expected in (("", "FAILED"), (", ntens = 3, energies = .false.", "not declared")):
        (tmp_path / "case.nml").write_text(case.replace(" /", more + " /", 1), encoding="utf-8")
        done = call(driver, "case.nml", "--check", folder=tmp_path)
        found = outcomes(done.stdout)
        assert found["components"] == found["energies"] == expected
        assert done.returncode == (expected == "FAILED")


@pytest.mark.parametrize(
    ("attack", "said"),
    [("abort();", "Aborted"), ("for (;;);", "limit of 0.5 s"), ("exit(0);", "exit code 0")],
)
def test_the_table_is_whole(driver: Path, attacker, tmp_path: Path, attack: str, said: str) -> None:
    """A UMAT that fails in a check leaves the table whole."""
    case = attacker(f"if (statev[0]++ > 0) {{ {attack} }}")
    (tmp_path / "case.nml").write_text(case, encoding="utf-8")
    done = call(driver, "case.nml", "--check", folder=tmp_path)
    assert done.returncode == 1 and len(outcomes(done.stdout)) == 16
    assert outcomes(done.stdout)["path"] == "FAILED" and said in done.stdout
