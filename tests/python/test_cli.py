"""The command `asperity`: usage, start, run, results, pictures, cases, doctor."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import asperity
import matplotlib.image
import numpy as np
import pytest
from asperity import (
    History,
    Interface,
    Material,
    Pattern,
    case_files,
    doctor,
    installed,
)
from asperity.cli import main
from asperity.installed import all_cases
from asperity.options import results_of
from asperity.tools import plots, style

RT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(2, 30.0))
LAW = "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /\n"
CASE = f"""&case title = 'Slip and back' /
{LAW}&pattern sides = 2, theta = 30.0 /
&step t_N = -1.0, increments = 100 /
&step slip = 0.1, -0.1, increments = 20, 40 /
"""
LOST = f"{LAW}&pattern sides = 0 /\n&step t_N = 2.0 /\n&step slip = 0.1, increments = 100 /\n"
SWEEP = f"""{LAW}&pattern sides = 2, theta = theta_m /
&sweep name = 'theta_m', values = 0.0, 45.0, 30.0 /
&step s_Tx = 0.1, increments = 10 /
"""
SCRIPTS = sysconfig.get_path("scripts")

pytestmark = pytest.mark.usefixtures("folder")


def write(name: str, text: str) -> Path:
    """Write a file into the current folder."""
    Path(name).write_text(text, encoding="utf-8")
    return Path(name)


def python(script: str, check: bool = True) -> subprocess.CompletedProcess[str]:
    """Run a script."""
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=check)


# --- the command ----------------------------------------------------------


@pytest.mark.parametrize("command", [["asperity"], [sys.executable, "-m", "asperity"], ["rie_driver"]])
def test_version(command: list[str]) -> None:
    """All ways to call command and driver print the version."""
    program = shutil.which(command[0], path=SCRIPTS) or command[0]
    done = subprocess.run([program, *command[1:], "--version"], capture_output=True, text=True, check=True)
    name = "rie_driver" if "driver" in program else "asperity"
    assert done.stdout == f"{name} {asperity.__version__}\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "usage: asperity"),
        ("run", "usage: asperity"),
        ("run a.nml --colour", "usage: asperity"),
        ("fti record.csv", "fti: did you mean fit?"),
        ("xyz record.csv", "xyz: expected one of new, cases,"),
        # Python alone reads these numbers
        ("card abaqus case.nml --h=1_0", "argument --h: invalid float value: '1_0'"),
        ("card abaqus case.nml --map=\u0661", "argument --map: invalid int value"),
        ("surface scan.csv --spacing 1_0", "argument --spacing: 1_0: expected DX or DX,DY"),
    ],
)
def test_wrong_usage(words: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Wrong arguments give exit code 2, and the usage or the command that is meant."""
    with pytest.raises(SystemExit) as end:
        main(words.split())
    assert end.value.code == 2 and message in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--help"], ["run", "case.nml", "-o", "out.csv"]])
def test_what_needs_no_tools_imports_none(arguments: list[str]) -> None:
    """Help and a run without a picture start at once: no package of the toolbox is imported."""
    write("case.nml", CASE)
    done = python(
        "import atexit, sys\nfrom asperity.cli import main\n"
        "atexit.register(lambda: print({'matplotlib', 'pandas', 'scipy', 'tqdm'} & {*sys.modules}))\n"
        f"sys.exit(main({arguments!r}))"
    )
    assert done.stdout.splitlines()[-1] == "set()"


BARE = """
import asperity, numpy, sys
from asperity import Interface, Material, Pattern, Step, read_case
joint = Interface(Material(3.0, 0.3, 0.9, 0.5), Pattern.regular(2, 30.0))
assert joint.update([[0.01, 0.0, 0.0]]).traction[0, 0] > 0.0
rows = joint.run([Step(t_N=-1.0, increments=10), Step(slip=0.1, increments=20)])
rows.to_csv("rows.csv")
assert numpy.array_equal(asperity.History.from_csv("rows.csv").separation, rows.separation)
assert len(read_case("case.nml").runs) == 1
"""
"""What the core does: law, load path, case file, result."""


@pytest.fixture
def bare(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Function that runs Python with asperity and NumPy alone, as in an environment without the extras."""
    lone = tmp_path / "lone"
    lone.mkdir()
    for package in (asperity, np):
        folder = Path(package.__path__[0])
        for path in (folder, folder.with_name(f"{folder.name}.libs")):
            if path.exists():
                (lone / path.name).symlink_to(path)

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-S", *arguments]
        environment = {"PYTHONPATH": str(lone), "PATH": os.environ["PATH"]}
        return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)

    return run


@pytest.mark.slow
def test_the_core_needs_numpy_alone(bare: Callable) -> None:
    """Law, load paths, case files, results and their commands work without the toolbox's packages."""
    write("case.nml", CASE)
    done = bare("-c", BARE)
    assert done.returncode == 0, done.stderr
    commands = "new -o joint.nml", "run joint.nml", "card abaqus joint.nml", "export abaqus folder", "doctor"
    for words in commands:
        done = bare("-m", "asperity", *words.split())
        assert done.returncode == 0 and "WRONG" not in done.stdout, f"{words}: {done.stdout}{done.stderr}"
    assert Path("joint.csv").is_file() and list(Path("folder").iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "extra"),
    [
        ("fit test.csv", "tools"),
        ("select case.nml", "tools"),
        ("explore", "tools"),
        ("run case.nml --plot", "tools"),
        ("mesh walls.msh -o walls.inp", "mesh"),
    ],
)
def test_a_missing_extra_is_named(words: str, extra: str, bare: Callable) -> None:
    """A command that needs more than NumPy names the extra that brings it."""
    write("case.nml", CASE)
    write("walls.msh", "")
    done = bare("-m", "asperity", *words.split())
    assert done.returncode == 1 and f"pip install 'asperity[{extra}]'" in done.stderr, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("command", [["cases"], ["run", "figure05b", "-o", "-", "--quiet"]])
def test_a_pipe_that_closes(command: list[str]) -> None:
    """A reader that ends early, such as head, is no error."""
    program = [sys.executable, "-m", "asperity"]
    with subprocess.Popen([*program, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None and running.stderr is not None
        running.stdout.close()
        told = running.stderr.read().decode()
        assert running.wait() == 0, told
    assert "asperity:" not in told and "Traceback" not in told and "Exception" not in told


def test_doctor(said: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """The report of a sound installation has no error; another driver is one, a missing tool is named."""
    out, _ = said("doctor")
    assert "WRONG" not in out and "differs from closed forms by" in out
    monkeypatch.setenv("ASPERITY_DRIVER", shutil.which("true") or "/bin/true")
    monkeypatch.setattr(doctor, "TOOLS", ("no-package",))
    out = said("doctor", 1)[0]
    assert [line.split()[0] for line in out.splitlines() if "WRONG" in line] == ["driver"]
    assert re.search(r"^no-package +not installed: .* 'asperity\[tools\]'", out, re.MULTILINE)
    monkeypatch.setenv("ASPERITY_DRIVER", "nothing")
    message = "ASPERITY_DRIVER = nothing: expected the path of rie_driver"
    assert message in said("doctor", 1)[0] and message in said("run figure02", 1)[1]


def test_package_has_what_hosts_need() -> None:
    """The package has sources for Abaqus, the header, and the mark of types."""
    assert (files(asperity) / "py.typed").is_file()
    for name in ("asperity_abaqus.f90", "asperity_abaqus_standard.f90"):
        assert (installed.abaqus() / name).is_file(), name
    assert installed.library().with_name("asperity.h").is_file()


# --- new, cases, run ------------------------------------------------------


def test_new_case(said: Callable) -> None:
    """A new case runs; its values are those of the command, those of a joint without bond, too."""
    said("new")
    said("run case.nml --quiet")
    said("new -o mine.nml sigma0=0.5 Gc=0.05 kc=7 sides=2 theta=15 turn=90 sigma_N=-2 slip=0.3 increments=30")
    [test] = case_files.slip_tests(case_files.read_case(Path("mine.nml")))
    assert (test.material.sigma0, test.material.Gc, test.material.kc) == (0.5, 0.05, 7.0)
    assert test.pattern == Pattern.regular(2, 15.0, turn=90.0)
    assert (test.sigma_N, test.slips[-1], len(test.slips)) == (-2.0, 0.3, 30)
    said("new -o flat.nml sides=0 kn=20 ks=5 closure=.1")
    run = case_files.read_case(Path("flat.nml")).runs[0]
    assert run.pattern.m == 0
    assert run.material == Material.from_joint(kn=20.0, ks=5.0, mu=0.5, closure=0.1)


def test_cases(said: Callable) -> None:
    """Every case of the package is listed with its title, can be copied, and runs by its name."""
    lines = said("cases")[0].splitlines()
    assert len(lines) == len(all_cases()) > 20 and all(line[34:] for line in lines)
    title = "Figure 5(b): cyclic slip, with kc = 1 as in the paper"
    assert any(line.split(None, 1) == ["figure05b", title] for line in lines)
    said("cases figure05b")
    said("cases stability/unloading -o x.nml")
    assert Path("figure05b.nml").read_bytes() == all_cases()["figure05b"].read_bytes()
    assert Path("x.nml").read_bytes() == all_cases()["stability/unloading"].read_bytes()
    assert "expected" in said("cases figure05b", 1)[1]


@pytest.mark.parametrize("output", ["", "x.txt", "[x].csv", "x"])
def test_run_of_a_sweep(output: str, folder: Path, said: Callable) -> None:
    """A sweep gives one result per value, whatever the name, and one picture without earlier results."""
    write("sweep.nml", SWEEP)
    write("sweep_20.csv", "old")
    picture = Path(output or "sweep.csv").with_suffix(".png")
    out, _ = said(f"run sweep.nml --plot {output and '-o ' + output}")
    assert out == f"{picture}\n" and matplotlib.image.imread(picture).shape[1] == round(style.TWO * style.DPI)
    results = results_of(folder / (output or "sweep.csv"))
    assert list(results) == [0.0, *([] if output else [20.0]), 30.0, 45.0]
    assert np.all(History.from_csv(results[45.0]).separation[-1] == [0.0, 0.1, 0.0])


def test_run_passes_the_exit_codes(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Bad input gives exit code 1 and no picture, a lost equilibrium exit code 2 and a picture."""
    write("bad.nml", CASE.replace("mu = 0.5", "mu = -0.5"))
    for name, part in (("bad", "mu = -0.5"), ("missing", "missing.nml")):
        assert main(["run", f"{name}.nml", "--plot"]) == 1
        message = capfd.readouterr().err
        assert part in message and "Traceback" not in message
    assert not list(folder.glob("*.png"))
    write("lost.nml", LOST)
    assert main(["run", "lost.nml", "--plot", "other.png"]) == 2 and Path("other.png").is_file()
    assert History.from_csv(folder / "lost.csv").separation[-1, 1] == pytest.approx(0.031, abs=1e-3)


# --- pictures -------------------------------------------------------------


def rows(s: np.ndarray, t: np.ndarray, event: str = "") -> History:
    """Rows of a result with damage 0.5."""
    events = ((len(s) - 1, event),) if event else ()
    return History(s.copy(), t.copy(), np.full(len(s), 0.5), np.zeros((len(s), 1)), np.zeros(len(s)), events)


@pytest.mark.parametrize("angle", [0.0, 45.0, 180.0, 300.0])
def test_slip_direction(angle: float) -> None:
    """The direction of a path is that of the first long slip, for either sign of the slip."""
    e = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    slip = np.array([0.0, 1e-3, 0.4, -0.41, 0.4])
    separation = np.column_stack([np.ones(5), slip[:, None] * e])
    line = rows(separation, separation)
    assert np.allclose([line.slip_along(), line.tau], slip, rtol=0, atol=1e-15)
    assert np.allclose(line.slip_along(angle + 90.0), 0.0, rtol=0, atol=1e-15)
    assert rows(np.zeros((3, 3)), np.eye(3)).tau.tolist() == [0.0, 1.0, 0.0]


def test_picture_shows_the_rows() -> None:
    """Curves show columns over the slip, with units, labels of a sweep, a cross at a lost equilibrium.

    The normal traction is one of them where it changes during the slip.
    """
    s = np.array([[0.0, 0, 0], [0.1, 0, -1.0], [0.3, 0, -2.0]])
    t = np.array([[0.0, 0, 0], [5.0, 3.0, -4.0], [6.0, 0, -7.0]])
    figure = plots.figure_of({1.0: rows(s, t), 2.5: rows(s, 2 * t, "slip+lost")}, "Title", "theta", "m", "Pa")
    shown = [[line.get_xydata().tolist() for line in ax.lines] for ax in figure.axes]
    assert shown[0] == [[[0, 0], [1, 4], [2, 7]], [[0, 0], [1, 8], [2, 14]], [[2, 14]]]
    columns = [0, 0.1, 0.3], [0, 5, 6], [0.5, 0.5, 0.5]
    assert [lines[0] for lines in shown[1:]] == [[[i, y] for i, y in enumerate(column)] for column in columns]
    assert [ax.get_xlabel()[-3:] for ax in figure.axes] == ["[m]"] * 4
    assert [ax.get_ylabel().split("[")[1] for ax in figure.axes] == ["Pa]", "m]", "Pa]", "-]"]
    assert len(plots.figure_of({None: rows(s, t * [0, 1, 1])}, "", "", "m", "Pa").axes) == 3
    assert [text.get_text() for text in figure.axes[0].texts] == ["1", "2.5", "theta"]
    line, mark = figure.axes[0].lines[:2]
    assert line.get_color() != mark.get_color() and line.get_linestyle() != mark.get_linestyle()


def test_picture_of_an_opening() -> None:
    """Without slip, normal traction and damage are drawn over the opening; many curves have many colours."""
    s, t = np.array([[0.0, 0, 0], [0.1, 0, 0]]), np.array([[0.0, 0, 0], [2.0, 0, 0]])
    figure = plots.figure_of({float(i): rows(s, i * t) for i in range(1, 9)}, "Title", "x", "mm", "MPa")
    assert len(figure.axes) == 2
    assert figure.axes[0].lines[0].get_xydata().tolist() == [[0, 0], [0.1, 2]]
    assert len({line.get_color() for line in figure.axes[0].lines}) == 8


# --- cases and comparison -------------------------------------------------


def test_case_file_strings() -> None:
    """A string may contain !, /, =, & and commas, a doubled quote is one quote; other encodings are read."""
    text = CASE.replace("'Slip and back'", "'Don''t stop! a=1, &b /c' ! isn't \"read\" &x /\n")
    case = case_files.read_case(write("case.nml", text.replace("= 2,", "= 2 ! sides = 4\n ,")))
    assert (case.title, case.sweep) == ("Don't stop! a=1, &b /c", "")
    (test,) = case_files.slip_tests(case)
    assert (test.material, test.pattern, test.preload) == (RT.material, RT.pattern, 100)
    write("double.nml", CASE.replace("'Slip and back'", '"say ""go"" !"'))
    assert case_files.read_case(Path("double.nml")).title == 'say "go" !'
    assert main(["run", "case.nml"]) == main(["run", "double.nml"]) == 0  # the driver reads the same files
    Path("latin.nml").write_bytes(CASE.replace("Slip", "Schlupf in Düsen").encode("latin-1"))
    case = case_files.read_case(Path("latin.nml"))
    assert case.title == "Schlupf in D\N{REPLACEMENT CHARACTER}sen and back"
    assert case.before.endswith(b"mu = 0.5 /\n") and case.after.startswith(b"\n&step t_N")
