"""The command `asperity`: exit codes, one-line errors, results, pictures and tables."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import asperity
import matplotlib.image
import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern, Step, case_files, plots, results, style
from asperity.cli import main
from asperity.history import COLUMNS
from asperity.installed import driver, named_case

from harness.studies import compare

RT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(2, 30.0))
CASE = """&case title = 'Slip and back' /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 2, theta = 30.0 /
&step t_N = -1.0, increments = 100 /
&step slip = 0.1, -0.1, increments = 20, 40 /
"""
SLIPS = np.concatenate([0.1 * np.arange(1, 21) / 20, 0.1 - 0.2 * np.arange(1, 41) / 40])
LOST = """&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 0 /
&step t_N = 2.0, increments = 10 /
&step slip = 0.1, increments = 100 /
"""
SWEEP = """&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 2, theta = theta_m /
&sweep name = 'theta_m', values = 0.0, 45.0, 30.0 /
&step s_Tx = 0.1, increments = 10 /
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ASPERITY_DRIVER", raising=False)
    return tmp_path


def write(name: str, text: str) -> str:
    """Write a file into the current folder."""
    Path(name).write_text(text, encoding="utf-8")
    return name


def assert_one_line(text: str, *parts: str) -> None:
    """Check that the command prints an error of one line that contains these fragments."""
    assert text.startswith("asperity: ") and text.count("\n") == 1
    assert all(part in text for part in parts), text


# --- the command ----------------------------------------------------------


@pytest.mark.parametrize("command", [["asperity"], [sys.executable, "-m", "asperity"]])
def test_version(command: list[str]) -> None:
    """Both ways to call the command print the version."""
    path = Path(sysconfig.get_path("scripts"))
    program = shutil.which(command[0], path=str(path)) or command[0]
    done = subprocess.run([program, *command[1:], "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"asperity {asperity.__version__}\n"


@pytest.mark.parametrize("arguments", [[], ["walk"], ["run"], ["run", "a.nml", "--colour"]])
def test_wrong_usage(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Wrong arguments give exit code 2 and the usage."""
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("usage: asperity")


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["run", "case.nml", "-o", "out.csv"]])
def test_what_needs_no_numbers_imports_none(arguments: list[str], folder: Path) -> None:
    """Help and a run without a picture start at once: neither numpy nor matplotlib is imported."""
    write("case.nml", CASE)
    script = (
        "import atexit, sys\nfrom asperity.cli import main\n"
        "atexit.register(lambda: print({'numpy', 'matplotlib', 'scipy', 'tqdm'} & {*sys.modules}))\n"
        f"sys.exit(main({arguments!r}))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "set()"


def test_names_of_the_package() -> None:
    """Each public name is imported at its first use, whichever comes first; an unknown name is an error."""
    script = (
        "import sys\nimport asperity\n"
        "for name in asperity.__all__:\n"
        "    for module in list(sys.modules):\n"
        "        if module.startswith('asperity') and module != 'asperity._core':\n"
        "            del sys.modules[module]\n"
        "    import asperity\n"
        "    print(getattr(asperity, name))\n"
        "asperity.nothing"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    for name, line in zip(asperity.__all__, done.stdout.splitlines(), strict=True):
        assert name.lower() in line.lower()
    assert "AttributeError: module 'asperity' has no attribute 'nothing'" in done.stderr


# --- run -------------------------------------------------------------------


def test_run_gives_the_confined_slip(folder: Path) -> None:
    """The rows of the driver are those of Interface.confined_slip in all digits."""
    assert main(["run", write("case.nml", CASE)]) == 0
    rows = History.from_csv(folder / "case.csv")
    history = RT.confined_slip(0.0, SLIPS, -1.0, preload=100)
    assert len(rows) == 160
    # slips are interpolated here and in the driver: a rounding error each, K = sigma0/s0 = 150 MPa/mm
    assert np.allclose(rows.separation[100:], history.separation, rtol=0, atol=1e-14)
    assert np.allclose(rows.traction[100:], history.traction, rtol=0, atol=150 * 1e-14)
    assert np.allclose(rows.damage[100:], history.damage, rtol=0, atol=1e-12)


def test_run_into_a_file_with_a_picture(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """-o names the result, --plot the picture; without a name the picture is written beside the result."""
    write("case.nml", CASE)
    assert main(["run", "case.nml", "-o", "out.csv", "--plot"]) == 0
    assert capsys.readouterr().out == "out.png\n"
    assert main(["run", "case.nml", "-o", "out.csv", "--plot", "other.png"]) == 0
    assert sorted(path.name for path in folder.iterdir()) == ["case.nml", "other.png", "out.csv", "out.png"]
    picture = matplotlib.image.imread(folder / "out.png")
    assert picture.shape[1] == round(style.TWO * style.DPI)
    assert np.array_equal(picture, matplotlib.image.imread(folder / "other.png"))


def test_run_of_a_sweep(folder: Path) -> None:
    """A sweep gives one result per value and one picture; results of earlier runs are not drawn."""
    write("sweep_20.csv", "old")
    assert main(["run", write("sweep.nml", SWEEP), "--plot"]) == 0
    found = results.results_of(folder / "sweep.csv")
    assert list(found) == [0.0, 20.0, 30.0, 45.0]
    assert (folder / "sweep.png").is_file()
    assert np.all(History.from_csv(found[45.0]).separation[-1] == [0.0, 0.1, 0.0])


@pytest.mark.parametrize("output", ["x.txt", "[x].csv", "x"])
def test_run_of_a_sweep_into_files_of_any_name(
    output: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A result with another ending or none is drawn as well, as is a name with wildcard characters."""
    assert main(["run", write("sweep.nml", SWEEP), "-o", output, "--plot"]) == 0
    picture = Path(output).with_suffix(".png").name
    assert capsys.readouterr().out == f"{picture}\n" and (folder / picture).is_file()
    assert list(results.results_of(Path(output))) == [0.0, 30.0, 45.0]


def test_run_passes_the_exit_codes(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Bad input gives exit code 1 and no picture, a lost equilibrium exit code 2 and a picture."""
    assert main(["run", write("bad.nml", CASE.replace("mu = 0.5", "mu = -0.5")), "--plot"]) == 1
    message = capfd.readouterr().err
    assert "mu" in message and "-0.5" in message and "Traceback" not in message
    assert main(["run", "missing.nml", "--plot"]) == 1
    assert "missing.nml" in capfd.readouterr().err
    assert not list(folder.glob("*.png"))
    assert main(["run", write("lost.nml", LOST), "--plot"]) == 2
    assert (folder / "lost.png").is_file()
    assert History.from_csv(folder / "lost.csv").separation[-1, 1] == pytest.approx(0.031, abs=1e-3)


@pytest.mark.parametrize("code", [0, 1, 2, 77])
def test_run_takes_another_driver(code: int, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """ASPERITY_DRIVER names the driver, which gets the arguments and determines the exit code."""
    other = folder / "other"
    other.write_text(f'#!/bin/sh\necho "$@" >arguments\nexit {code}\n')
    other.chmod(0o755)
    monkeypatch.setenv("ASPERITY_DRIVER", str(other))
    assert main(["run", "case.nml", "-o", "here.csv", "--plot"]) == code
    assert (folder / "arguments").read_text() == "case.nml -o here.csv\n"
    assert not list(folder.glob("*.png"))


def test_run_errors(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Errors of the command itself: exit code 1, one line."""
    assert main(["run", write("case.nml", CASE), "--plot", "--label-units", "mm"]) == 1
    assert_one_line(capsys.readouterr().err, "--label-units mm", "expected LENGTH,STRESS")
    assert main(["run", "case.nml", "--plot", "no/such/folder.png"]) == 1
    assert_one_line(capsys.readouterr().err, "no/such/folder.png")
    monkeypatch.setenv("ASPERITY_DRIVER", "nowhere")
    assert main(["run", "case.nml"]) == 1
    assert_one_line(capsys.readouterr().err, "ASPERITY_DRIVER = nowhere", "expected the path of rie_driver")


def test_driver_has_the_version() -> None:
    """The installed driver is of this version."""
    done = subprocess.run([driver(), "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"rie_driver {asperity.__version__}\n"


# --- results and pictures -------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected columns s_N"),
        ("s_N,s_Tx,s_Ty,t_N,t_Tx,t_Ty,event\n", "expected columns damage"),
        (",".join(COLUMNS) + "\n", "expected rows after the header"),
        (",".join(COLUMNS) + "\n0,0,0,0,0,0,x,0,0,0,0,\n", "line 2"),
    ],
)
def test_results_that_are_none(text: str, message: str, folder: Path) -> None:
    """A file that is no result of the driver is rejected."""
    with pytest.raises(ValueError, match=message):
        History.from_csv(Path(write("out.csv", text)))


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
    found = rows(separation, separation)
    assert np.allclose(found.slip_along(), slip, rtol=0, atol=1e-15)
    assert np.allclose(found.tau, slip, rtol=0, atol=1e-15)
    assert np.allclose(found.slip_along(angle + 90.0), 0.0, rtol=0, atol=1e-15)
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
    assert shown[1][0] == [[0, 0], [1, 0.1], [2, 0.3]]
    assert shown[2][0] == [[0, 0], [1, 5], [2, 6]]
    assert shown[3][0] == [[0, 0.5], [1, 0.5], [2, 0.5]]
    assert [ax.get_xlabel()[-3:] for ax in figure.axes] == ["[m]"] * 4
    assert [ax.get_ylabel().split("[")[1] for ax in figure.axes] == ["Pa]", "m]", "Pa]", "-]"]
    assert len(plots.figure_of({None: rows(s, t * [0, 1, 1])}, "", "", "m", "Pa").axes) == 3
    assert [text.get_text() for text in figure.axes[0].texts] == ["1", "2.5", "theta"]
    colours = [line.get_color() for line in figure.axes[0].lines[:2]]
    assert len(set(colours)) == 2
    assert figure.axes[0].lines[0].get_linestyle() != figure.axes[0].lines[1].get_linestyle()


def test_picture_of_a_loop_has_arrows() -> None:
    """Each branch of a cycle has an arrow in its direction; a monotonic path and a long cycle have none."""

    def arrows(slips: list[float]) -> list[float]:
        x = np.array(slips)
        s = np.column_stack([np.zeros_like(x), x, np.zeros_like(x)])
        figure = plots.figure_of({None: rows(s, s)}, "Title", "", "mm", "MPa")
        return [float(note.xy[0] - note.xyann[0]) for note in figure.axes[0].texts]

    there, back = [0.1 * i for i in range(5)], [0.4 - 0.1 * i for i in range(1, 9)]
    again = [-0.4 + 0.1 * i for i in range(1, 9)]
    assert np.allclose(arrows([0.0, 0.0, *there, *back, *again]), [0.1, -0.1, 0.1], rtol=0, atol=1e-12)
    assert arrows(there) == [] and arrows([0.0, 1.0] * 20) == []


def test_picture_of_an_opening() -> None:
    """Without slip, normal traction and damage are drawn over the opening; many curves have many colours."""
    s, t = np.array([[0.0, 0, 0], [0.1, 0, 0]]), np.array([[0.0, 0, 0], [2.0, 0, 0]])
    figure = plots.figure_of({float(i): rows(s, i * t) for i in range(1, 9)}, "Title", "x", "mm", "MPa")
    assert len(figure.axes) == 2
    assert figure.axes[0].lines[0].get_xydata().tolist() == [[0, 0], [0.1, 2]]
    assert len({line.get_color() for line in figure.axes[0].lines}) == 8


# --- cases and comparison -------------------------------------------------


def test_case_is_read() -> None:
    """Material, pattern, slips and preload of the shipped Figure 5(b)."""
    case = case_files.read_case(named_case("figure05b"))
    (test,) = case_files.slip_tests(case)
    assert (test.material, test.pattern) == (RT.material, RT.pattern)
    assert (test.value, test.preload, test.sigma_N, test.direction) == (None, 100, -10.0, 0.0)
    assert len(test.slips) == 800
    assert test.slips[[159, 479, 799]].tolist() == [0.4, -0.4, 0.4]
    assert np.allclose(np.abs(np.diff(test.slips)), 0.0025, rtol=0, atol=1e-15)
    assert case.sweep == "" and case.title == "Figure 5(b): cyclic slip, with kc = 1 as in the paper"
    assert case.before + b"&pattern sides = 2, theta = 30.0 /" + case.after == case.path.read_bytes()


def test_sweep_is_read(folder: Path) -> None:
    """Values of the sweep replace its name; comments and line breaks have no effect."""
    text = SWEEP.replace("s_Tx", "! slip = 7\n  t_N = 0.0, slip").replace("0.0, 45.0,", "0.0,\n 45.0,")
    case = case_files.read_case(Path(write("sweep.nml", text)))
    found = list(case_files.slip_tests(case))
    assert [test.value for test in found] == [test.pattern.theta for test in found] == [0.0, 45.0, 30.0]
    assert [test.slips[-1] for test in found] == [0.1] * 3
    assert (case.title, case.sweep) == ("sweep", "theta_m")


def test_case_file_strings(folder: Path) -> None:
    """A string may contain !, /, =, & and commas, and a doubled quote is one quote; comments are ignored."""
    text = CASE.replace("'Slip and back'", "'Don''t stop! a=1, &b /c' ! isn't \"read\" &x /\n")
    path = Path(write("case.nml", text.replace("= 2,", "= 2 ! sides = 4\n ,")))
    case = case_files.read_case(path)
    assert (case.title, case.sweep) == ("Don't stop! a=1, &b /c", "")
    (test,) = case_files.slip_tests(case)
    assert (test.material, test.pattern, test.preload) == (RT.material, RT.pattern, 100)
    write("double.nml", CASE.replace("'Slip and back'", '"say ""go"" !"'))
    assert case_files.read_case(Path("double.nml")).title == 'say "go" !'
    assert main(["run", str(path)]) == main(["run", "double.nml"]) == 0  # the driver reads the same files


def test_steps_are_explicit(folder: Path) -> None:
    """Lists repeat in cycles and a shorter list repeats its last value; steps have control and springs."""
    steps = """&step t_N = -1.0, t_Ty = 0.0, increments = 7 /
&step s_Tx = 0.1, -0.1, k_N = 5.0, t_N = -2.0, increments = 3, cycles = 2, time = 4.0 /
&step slip = 0.2, direction = 30.0 /
&step s_Ty = 0.0, follow = 'branch' /
"""
    start = CASE.split("&step")[0] + "&state separation = 3*0.0, statev = 17*0.0 /\n"
    (run,) = case_files.read_case(Path(write("case.nml", start + steps))).runs
    assert run.start == "state" and list(run.props) == RT.props().tolist()
    assert run.state is not None and run.state.separation == (0.0, 0.0, 0.0) and not run.state.state.any()
    assert run.tolerance is None
    kept = {"k_N": 5.0, "time": [1.0]}
    assert run.steps == (
        Step(t_N=[-1], t_Ty=[0], k_N=0, k_Ty=0, increments=[7], time=[1.0]),
        Step(
            t_N=[-2, -2, -2, -2], s_Tx=[0.1, -0.1, 0.1, -0.1], k_N=5.0, k_Ty=0.0,
            increments=[3, 3, 3, 3], time=[1.0, 1.0, 1.0, 1.0],
        ),
        Step(slip=[0.2], direction=30, increments=[100], **kept),
        Step(s_Ty=[0], follow="branch", arc=0.05, **kept),
    )  # fmt: skip
    assert [path.name for path in folder.iterdir()] == ["case.nml"]  # the case is read without a run


def test_case_that_cannot_be_compared(folder: Path) -> None:
    """Another kind of load path is rejected, as is a case that the driver rejects."""
    with pytest.raises(ValueError, match=r"case.nml: expected &step with t_N, then slip under it"):
        list(case_files.slip_tests(case_files.read_case(Path(write("case.nml", SWEEP)))))
    branch = CASE.split("&step")[0] + "&step t_N = 0.0, slip = 0.1, follow = 'branch' /\n"
    with pytest.raises(ValueError, match=r"case.nml: expected &step with t_N, then slip under it"):
        list(case_files.slip_tests(case_files.read_case(Path(write("case.nml", branch)))))
    cracked = CASE + "&initial damage = 0.5 /\n"
    with pytest.raises(ValueError, match=r"case.nml: &initial: expected a case that starts virgin"):
        list(case_files.slip_tests(case_files.read_case(Path(write("case.nml", cracked)))))
    assert main(["run", "case.nml"]) == 0
    with pytest.raises(ValueError, match=r"^case.nml:\d+: &material: mu = -0.5: expected"):
        compare.compare(Path(write("case.nml", CASE.replace("mu = 0.5", "mu = -0.5"))))


@pytest.mark.parametrize("text", [CASE, LOST + "&expect end = 'lost' /\n"])
def test_compare(text: str, folder: Path) -> None:
    """Driver and reference agree, also on a lost equilibrium."""
    result = compare.compare(Path(write("case.nml", text)))
    assert result.agrees, result
    assert result.curves == 1 and result.rows > 20
    assert list(result.differences) == ["law/NumPy", "test/NumPy"]


def test_compare_command(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The command prints one line per case, with exit code 1 for a difference or an unknown figure."""
    assert compare.main(["--figure", "2"]) == 0
    line = capsys.readouterr().out.splitlines()[-1].split()
    assert line[:4] == ["figure02", "1", "100", "law/NumPy"] and line[-1] == "agrees"
    monkeypatch.setattr(compare, "LAW_TOLERANCE", 0.0)
    assert compare.main(["--figure", "2"]) == 1
    assert capsys.readouterr().out.splitlines()[-1].endswith("DIFFERS")
    assert compare.main(["--figure", "3"]) == 1
    assert_one_line(capsys.readouterr().err, "figure 3", "expected one of 2, 4a")


# --- tables ----------------------------------------------------------------


def test_case_in_another_encoding(folder: Path) -> None:
    """A title that is not UTF-8 does not prevent the run."""
    Path("latin.nml").write_bytes(CASE.replace("Slip", "Schlupf in Düsen").encode("latin-1"))
    case = case_files.read_case(Path("latin.nml"))
    assert case.title == "Schlupf in D\N{REPLACEMENT CHARACTER}sen and back"
    assert case.before.endswith(b"mu = 0.5 /\n") and case.after.startswith(b"\n&step t_N")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("asperity sel", {"select"}),
        ("asperity paper --fo", {"--force"}),
        ("asperity card aba", {"abaqus"}),
    ],
)
def test_completion(line: str, expected: set[str], tmp_path: Path) -> None:
    """The shell gets commands, options of the command on its line, and values of an option."""
    pytest.importorskip("argcomplete")
    answer = tmp_path / "answer"
    asked = {"_ARGCOMPLETE": "1", "_ARGCOMPLETE_STDOUT_FILENAME": str(answer), "_ARGCOMPLETE_IFS": "\n"}
    asked |= {"COMP_LINE": line, "COMP_POINT": str(len(line))}
    subprocess.run([sys.executable, "-m", "asperity"], env=os.environ | asked, check=True)
    assert set(answer.read_text(encoding="utf-8").split()) == expected
