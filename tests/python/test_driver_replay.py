"""Files of recorded strains and group &replay of the driver; test_decks.py replays the rows of decks."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from support_driver import FLAT, MATERIAL, RP_4, K, read_csv


def test_replay_of_strains(run, tmp_path: Path) -> None:
    """Strains may have no header, or columns in any order, other columns, blank lines and comments."""
    rows = [(0.001 * i, 0.002 * i, -0.0005 * i) for i in range(1, 60)]
    (tmp_path / "plain.csv").write_text("".join(f"{a}, {b},{c}\n" for a, b, c in rows))
    (tmp_path / "named.csv").write_text(
        "# a record\r\ne_3,note,time,e_1,E_2\r\n\r\n"
        + "\r\n".join(f"{c},x,{0.5 * i},{a},{b}" for i, (a, b, c) in enumerate(rows, 1))
    )
    plain = run(MATERIAL + RP_4 + "&replay file = 'plain.csv', h = 2.0, dtime = 0.5 /\n")
    named = run(MATERIAL + RP_4 + "&replay file = 'named.csv', h = 2.0 /\n")
    assert plain.rows == named.rows
    np.testing.assert_allclose(plain.vector("s"), 2 * np.array(rows), rtol=1e-14)
    np.testing.assert_allclose(plain["time"], 0.5 * np.arange(1, 60), rtol=1e-14)
    direct = run(MATERIAL + RP_4 + "&step s_N = 0.118, s_Tx = 0.236, s_Ty = -0.059, increments = 59 /\n")
    np.testing.assert_allclose(plain.vector("t"), direct.vector("t"), rtol=0, atol=1e-12 * K)


def test_replay_file_is_beside_the_case(driver: Path, tmp_path: Path) -> None:
    """The name of the file of recorded strains is relative to the folder of the case."""
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "record.csv").write_text("0.01,0,0\n")
    (tmp_path / "a" / "r.nml").write_text(MATERIAL + FLAT + "&replay file = 'record.csv' /\n")
    subprocess.run([driver, "a/r.nml"], cwd=tmp_path, check=True, capture_output=True)
    _, rows = read_csv((tmp_path / "r.csv").read_text())
    assert float(rows[0][6]) == pytest.approx(0.01 * K, rel=1e-14)


@pytest.mark.parametrize(
    ("options", "record", "fragments"),
    [
        ("", None, ["record.csv", "cannot be opened"]),
        ("ntens = 4,", "0,0,0\n", ["ntens = 4: expected 2, 3 or 6"]),
        ("dtime = -1,", "0,0,0\n", ["dtime = -1: expected >= 0"]),
        ("", "0,0,0\n0,0\n", ["record.csv:2: column 3", "expected a number"]),
        ("", "0,0,0\n0,nan,0\n", ['record.csv:2: column 2 = "nan": expected a number']),
        ("", "0,0,0\n0,1e60,0\n", ["record.csv:2: expected strains of a magnitude up to"]),
        ("ntens = 2,", "0,0,0\n", ["record.csv:1: 3 columns: expected 2 (ntens)"]),
        ("", "time,e_1,e_2,e_3\n1,0,0,0\n0.5,0,0,0\n", ["record.csv:3: time = 0.5: expected at least 1"]),
        (
            "",
            "0,0,0\nx,0,0\n0,1e60,0\n0,0\n",
            ['record.csv:2: column 1 = "x"', "record.csv:3: expected strains", "record.csv:4: column 3"],
        ),
        ("", "x,0,0\n1,0,y\n" + 49 * "0,0,y\n", ["record.csv:1: no column e_1"]),
        ("", "0,0,0\n" + 50 * "0,0,y\n", ["record.csv:21: column 3", "... and 30 more bad lines"]),
        ("", "s_N,s_Tx\n0,0\n", ["record.csv:1: no column s_Ty"]),
        ("ntens = 2,", "s_N,s_Tx,s_Ty\n0,0,1\n", ["record.csv:2: s_Ty = 1: expected 0 with ntens = 2"]),
        ("", "s_N,s_Tx,s_Ty\n", ["no line of numbers"]),
        ("", "", ["record.csv", "expected a"]),
        ("", "0,0,0\n\x00", ["record.csv:2: byte 0: expected a text file"]),
        ("&case tolerance = 1e-3 /\n&replay", "0,0,0\n", ["case.nml:3: &case: tolerance with &replay"]),
        # initial states that the host routine rejects
        (
            "&initial traction = -1, 0, 0.1 /\n&replay ntens = 2,",
            "0,0\n",
            ["case.nml:3: &initial: traction = -1, 0, 0.1: expected t_Ty = 0 with ntens = 2"],
        ),
        (
            "&initial slip = 0.1, 0, damage = 1 /\n&replay",
            "0,0,0\n",
            ["case.nml:3: &initial: slip = 0.1, 0: expected a traction with it"],
        ),
        (
            "&initial traction = 1, 0, 0, damage = 1 /\n&replay",
            "0,0,0\n",
            ["case.nml:3: &initial: traction = 1, 0, 0: initial t_N = 1: tension"],
        ),
    ],
)
def test_bad_replay(run, tmp_path: Path, options: str, record: str | None, fragments: list[str]) -> None:
    """A bad replay gives exit code 1; the message names the line of the recorded file or of the case."""
    if record is not None:
        (tmp_path / "record.csv").write_text(record)
    replay = f"{'' if options.startswith('&') else '&replay '}{options} file = 'record.csv' /\n"
    messages = run(MATERIAL + FLAT + replay, code=1).messages
    for fragment in fragments:
        assert fragment in messages, messages
    assert not (tmp_path / "case.csv").exists()
