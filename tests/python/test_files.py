"""Files of commands: no command replaces one that it did not write itself, unless --force is given."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from asperity.cli import main
from asperity.installed import driver
from asperity.options import PICTURES, may_replace, replace_file
from asperity.tools.style import new_figure, save

CASE = """&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 20.0 /
&pattern sides = 4, theta = 10.0 /
&step t_N = -1.0, increments = 10 /
&step slip = 0.2, increments = 20 /
"""
LOST = "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /\n&pattern sides = 0 /\n&step t_N = 4.0 /\n"
SWEEP = CASE.replace("-1.0", "p") + "&sweep name = 'p', values = -1.0, -2.0 /\n"
FOREIGN = b"slip,tau,sigma_N\n0.0,0.1,-1\n"
SEARCH = ["--sd", "mu=0.05", "--samples", "20", "--jobs", "1"]
JOINT = ["kn=82", "ks=36", "ft=0.25", "GfI=0.018", "c=0.35", "GfII=0.125", "tan_phi=0.75"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Current folder with the input of all commands."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("case.nml", CASE), ("lost.nml", LOST), ("sweep.nml", SWEEP)):
        Path(name).write_text(text, encoding="utf-8")
    x, y = np.meshgrid(np.arange(12), np.arange(12))
    rows = 0.05 * np.sin(x * 0.9) * np.cos(y * 0.7)
    np.savetxt("scan.csv", rows, delimiter=",")
    return tmp_path


COMMANDS = [
    (["run", "case.nml", "-o", "out.csv"], "out.csv"),
    (["run", "case.nml", "--plot", "out.png"], "out.png"),
    (["run", "sweep.nml", "-o", "out.csv"], "out_-2.csv"),
    (["run", "lost.nml", "-o", "out.csv"], "out.failed.nml"),
    (["card", "abaqus", "case.nml", "-o", "out.inp"], "out.inp"),
    (["select", "case.nml", "--tolerance", "0.5", "-o", "out.nml"], "out.nml"),
    (["uncertainty", "case.nml", *SEARCH, "-o", "out.csv"], "out.csv"),
    (["surface", "scan.csv", "--spacing", "1", "-o", "out"], "out.csv"),
    (["surface", "scan.csv", "--spacing", "1", "--case", "case.nml", "-o", "out"], "out.nml"),
]


def sketch(*arguments: object) -> None:
    """Write a picture of empty axes in place of that of a scan, as the package writes it."""
    save(new_figure(1.0, 1.0)[0], next(path for path in arguments if isinstance(path, Path)))


@pytest.mark.slow
@pytest.mark.parametrize(("arguments", "name"), COMMANDS)
def test_own_files_only_are_replaced(
    arguments: list[str], name: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A command may be repeated; what another program wrote under that name is kept without --force."""
    monkeypatch.setattr("asperity.tools.surface.picture.draw", sketch)  # a second each, and looked at by none
    code = 2 if "lost.nml" in arguments else 0
    path = Path(name)
    assert main(arguments) == main(arguments) == code
    own = path.read_bytes()
    path.write_bytes(FOREIGN)
    capfd.readouterr()
    assert main(arguments) == 1
    message = capfd.readouterr().err
    assert name in message and "--force" in message and path.read_bytes() == FOREIGN
    assert main([*arguments, "--force"]) == code
    assert path.read_bytes() == own


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["new"], "case.nml"),
        (["cases", "figure05b"], "figure05b.nml"),
        (["joint", *JOINT, "-o", "joint.nml"], "joint.nml"),
    ],
)
def test_files_to_edit_are_kept(arguments: list[str], name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A file to start from may have been edited, so it is never replaced without --force."""
    assert main([*arguments, "--force"]) == 0
    edited = Path(name).read_bytes() + b"! edited\n"
    Path(name).write_bytes(edited)
    assert main(arguments) == 1
    assert f"{name}: this file is there" in capsys.readouterr().err and Path(name).read_bytes() == edited
    assert main([*arguments, "--force"]) == 0 and Path(name).read_bytes() != edited


@pytest.mark.parametrize("name", ["out.nml", "out.fit.json", "out.png"])
def test_fits_keep_other_files(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A fit refuses before its work to replace a case, a file of a covariance and a picture of others."""
    Path("record.csv").write_bytes(FOREIGN)
    Path(name).write_bytes(FOREIGN)
    assert main(["fit", "record.csv", "-o", "out.nml", "--plot", "out.png"]) == 1
    assert f"{name}: this file is there" in capsys.readouterr().err and Path(name).read_bytes() == FOREIGN


def test_a_case_of_one_command_is_kept_by_another(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Case files have the name of the command that wrote them."""
    monkeypatch.setattr("asperity.tools.surface.picture.draw", sketch)
    assert main(["surface", "scan.csv", "--spacing", "1", "--case", "case.nml", "-o", "out"]) == 0
    assert main(["select", "case.nml", "--tolerance", "0.5", "-o", "out.nml"]) == 1
    assert main(["card", "abaqus", "case.nml", "-o", "out.nml"]) == 1
    assert capsys.readouterr().err.count("out.nml: this file is there") == 2


def test_the_driver_alone() -> None:
    """rie_driver has the same rule; an empty file, standard output and devices are no files to keep."""
    Path("record.csv").write_bytes(FOREIGN)
    Path("empty.csv").touch()
    for output, more, code in (
        ("record.csv", [], 1),
        ("record.csv", ["--force"], 0),
        ("record.csv", [], 0),
        ("empty.csv", [], 0),
        ("-", [], 0),
        ("/dev/null", [], 0),
    ):
        command = [driver(), "case.nml", "-o", output, *more]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == code, (output, more)
        assert code == 0 or "would replace a file that rie_driver did not write" in done.stderr
    with Path("record.csv").open(encoding="utf-8") as file:
        assert "t_Tx" in next(csv.reader(file))


@pytest.mark.slow
def test_pictures_of_other_programs_are_kept() -> None:
    """Pictures say which program drew them."""
    figure, axes = new_figure(3.5, 2.0)
    axes[0].plot([0, 1], [0, 1])
    for ending, start in PICTURES.items():
        own, foreign = Path(f"own{ending}"), Path(f"other{ending}")
        save(figure, own)
        with mpl.rc_context({"savefig.format": ending[1:]}):
            figure.savefig(foreign)
        assert may_replace(own, start) and not may_replace(foreign, start)


@pytest.mark.parametrize(
    "command", [["card", "abaqus", "case.nml", "-o", "old.txt"], ["new", "sigma0=2", "-o", "old.txt"]]
)
def test_a_file_that_cannot_be_written_is_kept(command: list[str]) -> None:
    """Where there is no room, the old file stays whole, nothing else is left, and the command says why."""
    assert main(command) == 0
    before, names = Path("old.txt").read_bytes(), sorted(Path().iterdir())
    # no file of this process may have more than 100 bytes: the same error path as a full disk
    limited = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100));"
        "from asperity.cli import main; sys.dont_write_bytecode = True; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", limited, *command, "--force"], capture_output=True, text=True, check=False
    )
    assert done.returncode != 0 and "File too large" in done.stderr
    assert Path("old.txt").read_bytes() == before and sorted(Path().iterdir()) == names


def test_a_device_that_is_full_is_named() -> None:
    """The error of a full device has its name."""
    with pytest.raises(OSError, match="No space left") as error:
        replace_file(Path("/dev/full"), "text")
    assert error.value.filename == "/dev/full"
