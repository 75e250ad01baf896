"""Output of the driver: sweeps, files, progress, help, warnings."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest
from support_driver import FLAT, MATERIAL, RP_4, call, read_csv


def test_sweep(run, tmp_path: Path) -> None:
    """A sweep writes one CSV for each value, equal to that of a case file with this value."""
    text = (
        MATERIAL + "&pattern sides = 2, theta = THETA /\n&sweep name = 'Theta', values = 0.0, 30.0, 12.5 /\n"
        "&step t_N = -5.0 /\n&step slip = 0.1 /\n"
    )
    run(text)
    names = ["case_0.csv", "case_12.5.csv", "case_30.csv"]
    assert sorted(path.name for path in tmp_path.glob("*.csv")) == names
    run(text, "-o", "other.csv")
    renamed = [name.replace("case", "other") for name in names]
    assert sorted(path.name for path in tmp_path.glob("other*")) == renamed
    run(re.sub("&sweep.*\n", "", text).replace("THETA", "12.5"))
    assert (tmp_path / "case.csv").read_bytes() == (tmp_path / "case_12.5.csv").read_bytes()
    assert (tmp_path / "other_30.csv").read_bytes() == (tmp_path / "case_30.csv").read_bytes()
    assert "standard output" in run(text, "-o", "-", code=1).messages


def test_output(run, driver: Path, tmp_path: Path) -> None:
    """-o names the output, `-` is standard output; the default is a file in the current folder."""
    text = MATERIAL + FLAT + "&step s_N = 0.1, increments = 30 /\n"
    default = run(text)
    assert "written to case.csv" in default.messages and len(default.messages.splitlines()) == 1
    quiet = run(text, "--quiet", "-o", "-")
    assert quiet.messages == "" and quiet.rows == []
    assert read_csv(quiet.stdout) == (default.header, default.rows)
    (tmp_path / "elsewhere").mkdir()
    subprocess.run([driver, "../case.nml"], cwd=tmp_path / "elsewhere", check=True, capture_output=True)
    assert read_csv((tmp_path / "elsewhere" / "case.csv").read_text())[1] == default.rows
    assert "cannot be written" in run(text, "-o", "no/such/folder.csv", code=1).messages
    assert "replace the case file" in run(text, "-o", "case.nml", code=1).messages
    if Path("/dev/full").exists():
        assert "cannot be written" in run(text, "-o", "/dev/full", code=1).messages
        with Path("/dev/full").open("w") as full:
            rows = subprocess.run(
                [driver, "case.nml", "-o", "-"], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE
            )
        assert rows.returncode == 1 and b"-: cannot be written" in rows.stderr


def test_input_is_not_replaced(run, driver: Path, tmp_path: Path) -> None:
    """The output replaces neither the case nor the recorded strains, also if a link or path names them."""
    text = MATERIAL + FLAT + "&step s_N = 0.1, increments = 3 /\n"
    (tmp_path / "link.nml").symlink_to("case.nml")
    (tmp_path / "sub").mkdir()
    (tmp_path / "case.nml").write_text(text)
    (tmp_path / "hard.nml").hardlink_to(tmp_path / "case.nml")
    for name in ("./case.nml", "sub/../case.nml", "link.nml", "hard.nml", str(tmp_path / "case.nml")):
        assert "would replace the case file" in run(text, "-o", name, code=1).messages
        assert (tmp_path / "case.nml").read_text() == text
    record = "0.01,0,0\n"
    (tmp_path / "rec.csv").write_text(record)
    replay = MATERIAL + FLAT + "&replay file = 'rec.csv' /\n"
    (tmp_path / "rec.nml").write_text(replay)
    (tmp_path / "link.csv").symlink_to("rec.csv")
    for arguments in (["rec.nml"], ["rec.nml", "-o", "./rec.csv"], ["rec.nml", "-o", "link.csv"]):
        process = call(driver, *arguments, folder=tmp_path)
        assert process.returncode == 1 and "would replace the recorded strains" in process.stderr
        assert (tmp_path / "rec.csv").read_text() == record
    assert call(driver, "rec.nml", "-o", "out.csv", folder=tmp_path).returncode == 0
    (tmp_path / "out_2.csv").write_text(record)
    sweep = replay.replace("mu = 0.5", "mu = x") + "&sweep name = 'x', values = 0.5, 2 /\n"
    assert "would replace" in run(sweep.replace("rec.csv", "out_2.csv"), "-o", "out.csv", code=1).messages
    assert (tmp_path / "out_2.csv").read_text() == record and not (tmp_path / "out_0.5.csv").exists()


def test_limit_on_the_size_of_a_file(driver: Path, tmp_path: Path) -> None:
    """Beyond `ulimit -f` the run ends with a message, not with a backtrace, and leaves complete rows."""
    (tmp_path / "case.nml").write_text(MATERIAL + FLAT + "&step s_N = 0.1, increments = 1000 /\n")
    # 8 blocks of 512 or of 1024 bytes
    process = subprocess.run(
        ["sh", "-c", f"ulimit -f 8; exec '{driver}' case.nml"], cwd=tmp_path, capture_output=True, text=True
    )
    assert process.returncode == 1
    lines = process.stderr.splitlines()
    assert len(lines) == 1 and "case.csv: cannot be written" in lines[0], process.stderr
    header, rows = read_csv((tmp_path / "case.csv").read_text())
    assert rows and all(len(row) == len(header) for row in rows)


@pytest.mark.slow
def test_progress(driver: Path, tmp_path: Path) -> None:
    """A long run shows its progress on a terminal after two seconds, most of which it is stopped."""
    text = MATERIAL + "&pattern sides = 64, theta = 30.0 /\n&step slip = 0.02, increments = 10000000 /\n"
    (tmp_path / "long.nml").write_text(text)
    screen, terminal = os.openpty()
    with subprocess.Popen([driver, "long.nml", "--planes"], cwd=tmp_path, stderr=terminal) as process:
        os.close(terminal)
        time.sleep(0.4)
        process.send_signal(signal.SIGSTOP)
        time.sleep(2.0)
        process.send_signal(signal.SIGCONT)
        line = os.read(screen, 200).decode()
        process.kill()
    os.close(screen)
    assert re.fullmatch(
        r"\r\x1b\[Krie_driver: long.nml: \d+ of 10000000 increments \(0 %\), \d+ (s|min) left", line
    )


def test_commands(driver: Path, tmp_path: Path) -> None:
    """--help prints its text; a wrong command line gives exit code 1."""
    assert "usage: rie_driver CASE.nml" in call(driver, "--help", folder=tmp_path).stdout
    for arguments in ([], ["a.nml", "b.nml"], ["--no-such"], ["a.nml", "-o"], [""], ["a.nml", "-o", ""]):
        process = call(driver, *arguments, folder=tmp_path)
        assert process.returncode == 1 and "--help" in process.stderr, arguments


@pytest.mark.parametrize(
    ("constants", "path", "text"),
    [
        # known before the run, and after it
        (", sigma02 = 4.0", "&step s_N = 0.1 /", "warning: sigma02 or Gc2 differ"),
        ("", "&step t_N = 1.0, 3.3 /\n&expect end = 'lost' /", "the normal traction reaches 1.1 times"),
        ("", "&step t_N = -10.0 /", "closes by 2 s_f, expected at most 0.1: the contact is soft"),
        (", kc = 1000", "&step t_N = x /\n&sweep name = 'x', values = -1, -9 /", ""),
        (", kc = 1", "&step t_N = x /\n&sweep name = 'x', values = -5, -10 /", "closes by 2 s_f"),
    ],
)
def test_warnings(run, constants: str, path: str, text: str) -> None:
    """A case has one warning of a kind, for the worst run; test_warnings.pf has all kinds."""
    pattern = FLAT if "t_N = 1.0" in path or "s_N = 0.1" in path else RP_4
    messages = run(MATERIAL.replace(" /", f"{constants} /") + pattern + path, "--quiet").messages
    assert (messages.count(text) == messages.count("\n") == 1) if text else messages == ""
