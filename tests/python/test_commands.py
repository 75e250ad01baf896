"""Commands for a start: new, cases, doctor, options that are passed on, pipes, and fit -> select -> card."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import sysconfig
from importlib import metadata
from pathlib import Path

import asperity
import pytest
from asperity import History, doctor, installed
from asperity.case_files import read_case, slip_tests
from asperity.cli import COMMANDS, main
from asperity.installed import all_cases

from harness.studies import synthetic as study


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ASPERITY_DRIVER", raising=False)
    return tmp_path


def test_new_case() -> None:
    """A new case runs; its values are those of the command; a file that is there is not overwritten."""
    assert main(["new"]) == 0
    assert main(["run", "case.nml", "--quiet"]) == 0
    given = ["sigma0=0.5", "Gc=0.05", "kc=7", "sides=2", "theta=15", "turn=90"]
    assert main(["new", "-o", "mine.nml", *given, "sigma_N=-2", "slip=0.3", "increments=30"]) == 0
    [test] = slip_tests(read_case(Path("mine.nml")))
    assert (test.material.sigma0, test.material.Gc, test.material.kc) == (0.5, 0.05, 7.0)
    assert (test.pattern.m, test.pattern.theta, test.pattern.turn) == (2, 15.0, 90.0)
    assert (test.sigma_N, test.slips[-1], len(test.slips)) == (-2.0, 0.3, 30)
    assert main(["new", "-o", "flat.nml", "sides=0"]) == 0
    assert read_case(Path("flat.nml")).runs[0].pattern.m == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["mu"], "mu: expected NAME=VALUE, as sigma0=3.0"),
        (["mu=0.5 /"], "mu=0.5 /: expected NAME=VALUE"),
        (["mu=1", "mu=2"], "mu=2: mu is given twice"),
        (["mu=-1"], "&material: mu = -1: expected >= 0"),
        (["friction=1"], "&material: friction = 1: unknown name, expected one of sigma0"),
        (["slip=far"], 'slip = "far": expected a number'),
        (["-o", "taken.nml"], "taken.nml: this file is there and is not replaced"),
        (["-o", "none/case.nml"], "-o none/case.nml: no folder none: expected one"),
    ],
)
def test_new_refused(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Wrong values are refused by name and leave no file."""
    Path("taken.nml").write_text("kept", encoding="utf-8")
    assert main(["new", *arguments]) == 1
    assert message in capsys.readouterr().err
    assert [path.name for path in Path().iterdir()] == ["taken.nml"]
    assert Path("taken.nml").read_text(encoding="utf-8") == "kept"


def test_cases(capsys: pytest.CaptureFixture[str]) -> None:
    """Every case of the package is listed with its title, can be copied, and runs by its name."""
    assert main(["cases"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(all_cases()) > 20
    title = "Figure 5(b): cyclic slip, with kc = 1 as in the paper"
    assert any(line.split(None, 1) == ["figure05b", title] for line in lines)
    assert all(line[34:] for line in lines)
    assert main(["cases", "figure05b"]) == main(["cases", "stability/unloading", "-o", "x.nml"]) == 0
    assert Path("figure05b.nml").read_bytes() == all_cases()["figure05b"].read_bytes()
    assert Path("x.nml").read_bytes() == all_cases()["stability/unloading"].read_bytes()
    assert main(["run", "unloading", "--quiet"]) == 0 and Path("unloading.csv").exists()
    capsys.readouterr()
    for wrong in (
        ["cases", "figure99"],
        ["cases", "figure05b"],
        ["cases", "-o", "y.nml"],
        ["run", "nothing"],
    ):
        assert main(wrong) == 1
        assert "expected" in capsys.readouterr().err


def test_options_are_passed_on(capfd: pytest.CaptureFixture[str]) -> None:
    """`run` passes --planes and --quiet on to the driver."""
    assert main(["run", "unloading", "--planes", "--quiet"]) == 0
    assert "updates of the law" not in capfd.readouterr().err
    header = Path("unloading.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "alpha_1" in header and "s_dih_5" in header
    assert main(["run", "unloading"]) == 0
    assert "updates of the law" in capfd.readouterr().err
    assert "alpha_1" not in Path("unloading.csv").read_text(encoding="utf-8").splitlines()[0]
    assert len(History.from_csv(Path("unloading.csv"))) > 100


def test_help_has_a_line_for_each_command(capsys: pytest.CaptureFixture[str]) -> None:
    """The help lists every command."""
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    assert end.value.code == 0
    listed = capsys.readouterr().out
    for name in COMMANDS:
        assert f"\n    {name} " in listed, name


@pytest.mark.parametrize("command", [["cases"], ["run", "figure05b", "-o", "-", "--quiet"]])
def test_a_pipe_that_closes(command: list[str]) -> None:
    """A reader that ends early, such as head, is no error."""
    program = shutil.which("asperity", path=sysconfig.get_path("scripts"))
    arguments = [program] if program else [sys.executable, "-m", "asperity"]
    with subprocess.Popen([*arguments, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None and running.stderr is not None
        running.stdout.close()
        told = running.stderr.read().decode()
        assert running.wait() == 0, told
    assert "asperity:" not in told and "Traceback" not in told and "Exception" not in told


def test_doctor(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The report of a sound installation has no error; another driver, or a missing package, is one."""
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert "WRONG" not in out and "differs from closed forms by" in out
    monkeypatch.setenv("ASPERITY_DRIVER", shutil.which("true") or "/bin/true")
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-package"))
    assert main(["doctor"]) == 1
    lines = [line for line in capsys.readouterr().out.splitlines() if "WRONG" in line]
    assert [line.split()[0] for line in lines] == ["driver", "no-package"]
    monkeypatch.setenv("ASPERITY_DRIVER", "nothing")
    assert main(["doctor"]) == 1
    assert "ASPERITY_DRIVER = nothing: expected the path of rie_driver" in capsys.readouterr().out


@pytest.mark.slow
def test_fit_then_select_then_card(capsys: pytest.CaptureFixture[str]) -> None:
    """The case that fit writes is read by select, whose case is read by run and card."""
    study.write_record(Path("record.csv"), study.synthetic(0.02, 31, sigma_N=(-0.2, -0.5)))
    known = ["--set", "kc=20 eta=0.9 flat=0.3333333", "--starts", "2"]
    assert main(["fit", "record.csv", *known, "--plot", "-o", "joint.nml"]) == 0
    assert Path("fit.png").exists()
    assert main(["select", "joint.nml", "--tolerance", "0.2", "-o", "joint.nml"]) == 1
    assert "expected another name" in capsys.readouterr().err
    assert main(["select", "joint.nml", "--tolerance", "0.2", "-o", "chosen.nml"]) == 0
    line = capsys.readouterr().out.split("PROPS(")[1].split(")   ")[1].splitlines()[0]
    joint, chosen = (read_case(Path(name)).runs[0] for name in ("joint.nml", "chosen.nml"))
    assert chosen.material == joint.material
    listed = [float(text) for text in line.split(",")]
    assert chosen.props[: len(listed)] == pytest.approx(listed, rel=1e-8)
    assert main(["run", "chosen.nml", "--quiet"]) == 0
    assert main(["card", "abaqus", "chosen.nml", "--sigma-N", "-0.5", "-o", "card.inp"]) == 0
    assert "*User Material" in Path("card.inp").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "figure05b", "--label-units", "m,Pa"], "--label-units m,Pa: expected with --plot"),
    ],
)
def test_options_that_would_do_nothing(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """An option that has no effect is refused, before any work."""
    assert main(arguments) == 1
    assert message in capsys.readouterr().err
    assert not list(Path().iterdir())


def test_driver_is_on_the_search_path() -> None:
    """The program rie_driver beside the command is the driver of the package, with its exit codes."""
    program = Path(sysconfig.get_path("scripts")) / "rie_driver"
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"rie_driver {asperity.__version__}\n"
    assert subprocess.run([program, "none.nml"], capture_output=True, check=False).returncode == 1


def test_package_has_what_hosts_need() -> None:
    """The sources for Abaqus and the header are in the package; these packages are required."""
    for name in ("asperity_abaqus.f90", "asperity_abaqus_standard.f90"):
        assert (installed.abaqus() / name).is_file(), name
    assert installed.library().with_name("asperity.h").is_file()
    required = [line for line in metadata.requires("asperity") or [] if "extra ==" not in line]
    expected = ["lmfit", "matplotlib", "numpy", "pandas", "pint", "scipy", "tqdm"]
    assert sorted(re.split(r"\W", line)[0] for line in required) == expected


def test_misspelt_command(capsys: pytest.CaptureFixture[str]) -> None:
    """The message names the command that is meant, or all of them."""
    for word, message in (("fti", "fti: did you mean fit?"), ("xyz", "xyz: expected one of new, cases,")):
        with pytest.raises(SystemExit) as caught:
            main([word, "record.csv"])
        assert caught.value.code == 2 and message in capsys.readouterr().err
