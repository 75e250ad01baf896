"""UMATs in shared libraries as the law of a case: load paths, utility routines, input and Python.

The law of planted_umat.f has faults on request.
"""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from functools import partial
from pathlib import Path

import asperity
import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Step
from asperity.cli import main
from support_driver import FLAT, MATERIAL, RP_4, S_0, K
from support_umat import BROKEN, MIXED, ONSET, STIFFNESS, of_python, outcomes, planted

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("gfortran"), reason="no gfortran"),
]


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
    numbers = np.stack([rows[f"statev_{i}"] for i in range(3, 8)], axis=1)
    expected = [[1, 1, 0, 0, 2], [1, 2, 2, 2, 2], [2, 1, 0, 4, 0.5], [2, 2, 0.5, 4.5, 0.5]]
    np.testing.assert_allclose(numbers, expected)


def test_order_thickness_and_state(run, library: Path) -> None:
    """Components in another order, strains instead of separations, and a damaged start."""
    path = "&step s_N = 0.03, s_Tx = 0.02, increments = 7 /\n"
    plain = run(planted(library) + path)
    six = run(planted(library, more=", order = '-,-,N,-,Tx,Ty'") + path)
    np.testing.assert_array_equal(six.vector("t"), plain.vector("t"))
    steps = "&step s_Tx = 0.03, s_N = 0.02, increments = 7 /\n"
    turned = run(planted(library, more=", order = 'Tx,N,Ty'") + steps)
    np.testing.assert_array_equal(turned["t_Tx"], plain["t_N"])
    case = planted(library, more=", thickness = 0.5").replace(
        f"{STIFFNESS}, {ONSET}, {BROKEN}", "50, 0.02, 0.4"
    )
    np.testing.assert_allclose(run(case + path)["t_N"], plain["t_N"], rtol=1e-12)
    damaged = run(planted(library, more=f", state = 0, {BROKEN}, 5*0") + path)
    assert damaged["damage"].tolist() == [1.0] * 7 and not damaged["t_N"].any()


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
    results = run(case + "stiffness = 100 /\n&step s_N = 0.001 /\n", "--planes")
    statev = np.array([results[f"statev_{i + 1}"][-1] for i in range(25)])
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
    at_once, in_two = law.run([first, second]).end, law.run(second, law.run(first).end).end
    # the number of the step begins anew
    np.testing.assert_allclose(at_once.state - in_two.state, np.eye(16)[11], atol=1e-15)
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
