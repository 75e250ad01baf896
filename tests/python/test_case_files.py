"""Case files of the driver: spellings that mean the same, and errors."""

from __future__ import annotations

from pathlib import Path

import pytest
from asperity import read_case
from asperity.case_files import Run
from asperity.case_writer import Group, Word, case_text
from asperity.contract import owned
from asperity.steps import entries, numbers_of
from support_driver import MATERIAL, RP_4, call

PLAIN = (
    MATERIAL + RP_4 + "&step t_N = -5.0, increments = 10 /\n"
    "&step s_Tx = 0.1, 0.0, 0.0, 0.0, increments = 9 /\n"
)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.replace("\n", "\r\n"),
        "! before\n" + PLAIN.replace("&step s_Tx", "! then the slip\n&step s_Tx").replace("\n", "\r"),
        PLAIN.replace(" /\n", " / ! after\r", 2).replace("10 /\n", "10 /\r\n"),
        PLAIN.rstrip("\n"),
        "! before\n\n" + PLAIN.replace(" /\n", " / ! after\n") + "! behind /\n",
        PLAIN.upper(),
        PLAIN.replace(", ", "\n\t"),
        PLAIN.replace(", ", " ! a comment, with 'quotes' and / in it\n"),
        PLAIN.replace("0.0, 0.0, 0.0", "3*0.0").replace(" = ", "="),
        PLAIN.replace("0.1", "1d-1").replace("9.", "+.9D+1"),
        "\ufeff" + PLAIN + "! Umlaute: äöü /\n",
        "&case title = 'it''s / not ! the \"end\"' /" + PLAIN.replace("\n", ""),
    ],
    ids="crlf cr mixed no-newline comments case tabs inner-comments repeats exponents bom one-line".split(),
)
def test_ways_to_write_a_case(run, text: str) -> None:
    """Line ends, comments, blanks, upper case, repeat counts and exponents do not change the meaning."""
    assert run(text).rows == run(PLAIN).rows


END = "increments = 9 /"
PATTERN = "sides = 4, theta = 30.0"
BOND = "sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5"
MU, BRANCH = "mu = 0.5", "&step t_N = -5.0, follow = 'branch'"
ONE_NAN = ['"NaN": expected a number']

STARTS = [
    (True, 3, "initial traction = 1, 0", "traction = 1, 0: 2 values: expected three (t_N, t_Tx, t_Ty)"),
    (True, 3, "initial traction = 1, nan, 0", 'traction = "nan": expected a number'),
    (True, 3, "initial damage = 1.5", "damage = 1.5: expected 0 to 1"),
    (True, 3, "initial damage = 2*0.5", "damage = 2*0.5: 2 values: expected 1 for all planes"),
    (False, 3, "initial damage = 6*0.5", "6 values: expected 1 for all planes or 5 for 5 planes"),
    (True, 3, "initial slip = 0.1", "slip = 0.1: 1 values: expected 2 for all planes, in pairs s_dit, s_dih"),
    (True, 3, "initial slip = 0, 1e99", "slip = 0, 1e99: expected a magnitude up to"),
    (True, 3, "initial", "nothing given: expected traction, damage or slip"),
    (True, 3, "initial traction = 0.1, 0, 0, damage = 1", "initial t_N = 0.1: tension on a crack",
     "it carries t_N = 0"),
    (False, 3, "initial traction = 1e-8, 0, 0, damage = 1", "initial t_N = 1e-8: tension on a crack"),
    (True, 3, "initial traction = -10, 7.5, 0, damage = 1",
     "traction = -10, 7.5, 0: initial t_Tx, t_Ty = 7.5, 0: outside the friction of the pattern"),
    (True, 3, "initial traction = 3.1, 0, 0", "traction = 3.1, 0, 0: initial t_N = 3.1: beyond the strength"),
    (False, 3, "initial traction = 1e299, 0, 0", "&initial: traction = 1e299, 0, 0: initial t_N = 1e299: "),
    (True, 3, "initial damage = 1 /\n&state separation = 3*0, statev = 11*0",
     "a run starts from &initial or from &state, in line 4: expected the one or the other"),
    (True, 3, "state separation = 0, 0, statev = 11*0", "2 values of separation: expected three"),
    (True, 3, "state separation = 0, 0, 0, statev = 10*0", "10 values of statev: expected 11"),
    (True, 3, "state separation = 0, 0, 0, statev = 8*0, 2, 0, 0", "STATEV(9) alpha = 2"),
    (True, 3, "state separation = 0, 1e99, 0, statev = 11*0", "1e99"),
]  # fmt: skip
"""Groups &initial and &state, of a flat joint or of RP-4, with line and fragments of the message."""


@pytest.mark.parametrize(
    ("old", "new", "line", "fragments"),
    [
        ("sigma0 = 3.0", "sigma0 = -3.0", 1, ["&material: sigma0 = -3.0", "expected > 0"]),
        ("sigma0 = 3.0, ", "", 1, ["&material: sigma0 is missing", "expected > 0"]),
        ("eta = 0.9", "eta = 1.0", 1, ["eta = 1.0", "0 < eta < 1"]),
        ("eta = 0.9", "eta = nan", 1, ['eta = "nan": expected a number']),
        ("eta = 0.9", "eta = 1e999", 1, ['eta = "1e999": expected a number']),
        ("eta = 0.9", "eta = 0.9, 0.8", 1, ["eta = 0.9, 0.8: expected one number"]),
        ("eta = 0.9", "eta =", 1, ["&material: eta: empty value before a comma"]),
        ("mu = 0.5", "mu =", 1, ["mu = : no value"]),
        ("eta = 0.9", "eta = 0.9, eta = 0.9", 1, ["eta is given twice, first in line 1"]),
        ("eta = 0.9", "eta(1) = 0.9", 1, ["eta(1): subscripts are not read"]),
        ("mu = 0.5", "mu = 0.5, tau_v = -1.0", 1, ["tau_v = -1.0", ">= 0"]),
        ("sides = 4", "sides = 1", 2, ["sides = 1", "expected 0 (flat) or 2 to 64"]),
        ("sides = 4", "sides = 2.5", 2, ["sides = 2.5", "whole number from 0 to 64"]),
        ("sides = 4, ", "", 2, ["&pattern: expected sides (0: flat), or normals and weights"]),
        ("theta = 30.0", "flat = 1.5", 2, ["flat = 1.5", "0 <= flat <= 1"]),
        ("sides = 4", "normals = 1, 0, 0, weights = 1", 2, ["do not go with normals"]),
        (PATTERN, "normals = 1, 0, 0, 1, weights = 1", 2, ["4 values of normals and 1 weights"]),
        (PATTERN, "normals = 0, 1, 0, weights = 1", 2, ["n_N of listed plane 1 = 0: expected > 0"]),
        (PATTERN, "normals = 1, 0, 0, weights = .5", 2, ["sum to 0.5: expected 1"]),
        ("&pattern", "&patern", 2, ["&patern: unknown group: expected &case, &material, &pattern"]),
        ("&pattern", "pattern", 2, ["outside a group"]),
        ("30.0 /", "30.0", 2, ["&pattern: no closing / before &step in line 3"]),
        ("&step t_N", "&step s_N = 0.1, t_N", 3, ["s_N and t_N: expected the one or the other"]),
        ("&step t_N", "&step k_N = -1, t_N", 3, ["k_N = -1: expected >= 0"]),
        ("&step t_N", "&step k_Tx = 1, t_N", 3, ["k_Tx where the separation is given: expected t_Tx"]),
        ("&step t_N", "&step slip = 0.1, s_Ty = 0, t_N", 3, ["slip sets s_Tx and s_Ty"]),
        ("&step t_N", "&step direction = 45, t_N", 3, ["direction without slip"]),
        ("&step t_N", "&step time = -1, t_N", 3, ["time = -1: expected >= 0"]),
        ("increments = 10", "increments = 0", 3, ["increments = 0: expected a whole number from 1"]),
        ("increments = 10", "increments = 10, 20", 3, ["2 values of increments: expected 1 to 1"]),
        ("increments = 10", "increments = 10000000", None, ["in all steps: expected at most 10000000"]),
        ("increments = 10", "time = 1, 2", 3, ["2 values of time: expected 1, of the step, or 1, as many"]),
        ("&step t_N", "&step slip = 1, direction = 1, 2, t_N", 3, ["direction = 1, 2: expected one number"]),
        (END, "cycles = 1000000 /", 4, ["4 targets in 1000000 cycles: expected at most 1000000 targets"]),
        ("increments = 10", "cycles = 0", 3, ["cycles = 0"]),
        ("s_Tx = 0.1", "s_Tx = 1e60", 4, ["s_Tx = ", "expected a magnitude up to"]),
        ("s_Tx = 0.1", "s_Tx = what", 4, ['s_Tx = "what": expected a number']),
        (END, END + "\n&step /\n&expect end = 'x' /", 6, ["'x': expected 'complete' or 'lost'"]),
        (END, END + "\n&expect t_N = 1 /", 5, ["tolerance"]),
        (END, END + 2 * "\n&expect t_N = 1, tolerance = 1 /", 6, ["given twice for the same run"]),
        (END, END + "\n&expect when = 1 /", 5, ["when = 1: expected a value of &sweep"]),
        (END, END + "\n&sweep name = 'x', values = 1, 2, 1 /", 5, ["1 is given twice"]),
        (END, END + "\n&sweep name = '1', values = 1 /", 5, ["expected a name of letters"]),
        (END, END + "\n&sweep values = 1 /", 5, ["expected name and values"]),
        (END, END + "\n&sweep name = 'y', values = 1, 2 /", 5, ["name = 'y' stands for no number"]),
        (END, END + "\n&case title = 'y' /\n&sweep name = 'y', values = 1 /", 6, ["stands for no number"]),
        (END, END + "\n&material /", 5, ["given twice, first in line 1"]),
        (END, END + "\n&case planes = 3 /", 5, ["planes = 3: expected .true. or .false."]),
        (END, END + "\n&case title = x /", 5, ["expected one string in quotes"]),
        (END, END + "\n&case title = 'x /", 5, ["string without its closing '"]),
        # a value that is no number has one message
        ("increments = 10", "time = NaN", 3, ("time = NaN", "expected >= 0")),
        ("&material", "&case tolerance = NaN /\n&material", 1, ONE_NAN),
        ("mu = 0.5", "mu = NaN", 1, ONE_NAN),
        (END, END + "\n&expect t_N = 1, tolerance = NaN /", 5, ONE_NAN),
        # branches
        ("increments = 10", "follow = 'jump'", 3, ["follow = 'jump': expected 'stable' or 'branch'"]),
        ("increments = 10", "follow = 'branch', increments = 1", 3, ["increments with follow = 'branch'"]),
        ("increments = 10", "follow = 'branch', arc = 2.0", 3, ["arc = 2.0: expected 0.00001 to 1"]),
        ("increments = 10", "arc = 0.1", 3, ["arc without follow = 'branch'"]),
        (f"{MU} /\n{RP_4}&step t_N = -5.0, increments = 10", f"{MU}, W0 = 4.0 /\n{RP_4}{BRANCH}", None,
         ["follow = 'branch' with W0 = 4: expected 0"]),
        (f"{PLAIN[:9]}", f"&case tolerance = 1e-3 /\n&step follow = 'branch' /\n{PLAIN[:9]}", 1,
         ["&case: tolerance with follow = 'branch': expected arc"]),
        (f"{PLAIN[:9]}", f"&case tolerance = 1e-3 /\n&step increments = 25000 /\n{PLAIN[:9]}", 1,
         ["&case: tolerance with 25046 increments: expected at most 25000"]),
        # joints without bond
        (BOND, "kn = 20.0, mu = 0.6", 1, ["kn = 20.0: expected ks beside it"]),
        (BOND, "ks = 20.0, mu = 0.6", 1, ["ks = 20.0: expected kn beside it"]),
        (BOND, "kn = 20.0, ks = 5.0", 1, ["mu is missing"]),
        (BOND, "kn = 1e20, ks = 1.0, mu = 0.6", 1, ["kn = 1e20: expected at most 1e10 ks"]),
        (BOND, "kn = -1.0, ks = 5.0, mu = -2.0, sigma0 = 3.0, Gc = 1.0, kc = 2.0, damage0 = 0.5", 1,
         ["kn = -1.0: expected > 0 (1e-44 to 1e50)", "mu = -2.0: expected",
          "sigma0 = 3.0: expected without kn and ks, which give sigma0, Gc, eta and kc",
          "Gc = 1.0: expected without kn and ks", "kc = 2.0: expected without kn and ks",
          "damage0 = 0.5: expected 1 beside kn and ks"]),
        # starts of a run
        *((f"{PATTERN} /", f"{'sides = 0' if flat else PATTERN} /\n&{start} /", line, fragments)
          for flat, line, start, *fragments in STARTS),
    ],
)  # fmt: skip
def test_bad_case(run, tmp_path: Path, old: str, new: str, line: int | None, fragments: list[str]) -> None:
    """A bad case gives exit code 1 and no output file.

    The message names file, line, group, name, value and what was expected.
    """
    assert old in PLAIN
    messages = run(PLAIN.replace(old, new, 1), code=1).messages
    assert "case.nml:" + (f"{line}: " if line else " ") in messages
    assert fragments is not ONE_NAN or messages.count("\n") == 1
    for fragment in fragments:
        assert fragment in messages, messages
    assert not (tmp_path / "case.csv").exists()


def test_missing_parts(run) -> None:
    """A case needs material, pattern, and steps or a replay."""
    lines = PLAIN.splitlines(keepends=True)
    assert "no group &material" in run("".join(lines[1:]), code=1).messages
    assert "no group &pattern" in run(lines[0] + "".join(lines[2:]), code=1).messages
    assert "0 groups &step and 0 &replay" in run("".join(lines[:2]), code=1).messages
    replay = "&state separation = 3*0, statev = 23*0 /\n&replay file = 'x' /\n"
    assert "expected &state with &step only" in run("".join(lines[:2]) + replay, code=1).messages
    assert "2 groups &step and 1 &replay" in run(PLAIN + "&replay file = 'x' /\n", code=1).messages


@pytest.mark.parametrize(
    "content", [b"", b"\x00\x01\x02", b"\x7fELF" + bytes(range(256)), PLAIN.encode() + b"\x00"]
)
def test_no_text(run, content: bytes) -> None:
    """Empty and binary files are input errors."""
    messages = run(content, code=1).messages
    assert "case.nml" in messages and "expected a" in messages


def test_record_with_old_line_ends(run, tmp_path: Path) -> None:
    """A record whose lines end with CR alone has the same rows."""
    found = []
    for end in ("\n", "\r", "\r\n"):
        record = end.join(["# recorded", "s_N,s_Tx,s_Ty", "0.01,0.02,-0.01", "-0.02,0.1,0.05", ""])
        (tmp_path / "record.csv").write_bytes(record.encode())
        found.append(run(MATERIAL + RP_4 + "&replay file = 'record.csv' /\n").rows)
    assert found[0] == found[1] == found[2] and len(found[0]) == 2


def test_no_file(driver: Path, tmp_path: Path) -> None:
    """A missing file and a directory are input errors."""
    for name in ("none.nml", "."):
        process = call(driver, name, folder=tmp_path)
        assert process.returncode == 1 and name in process.stderr


def test_texts_that_are_written() -> None:
    """A text of any length is written whole; one with a line end or a zero is rejected."""
    assert case_text(("case", {"title": "'" + 9999 * "x"})).count("''" + 9999 * "x") == 1
    for text in ("a\nb", "a\rb", "a\0b"):
        with pytest.raises(ValueError, match=r"title = '.*: expected one line"):
            case_text(("case", {"title": text}))


def test_a_long_title(tmp_path: Path) -> None:
    """A title of a megabyte, with characters that are doubled or escaped, is read at once."""
    title = "it's \"\\\tä" * 100_000
    file = tmp_path / "long.nml"
    file.write_text(case_text(("case", {"title": title})) + PLAIN, encoding="utf-8")
    assert read_case(file).title == title


WRITTEN_STEPS = (
    {
        "t_N": [-1 / 3, -2.5e-7, 0.0],
        "t_Tx": 1e-12,
        "t_Ty": 0.1,
        "k_N": 1 / 7,
        "k_Tx": 3e10,
        "k_Ty": 0.7,
        "p": [0.2, 1e-9],
        "increments": [3, 1, 20],
        "time": [1.5, 1e-5, 2.0],
        "cycles": 2,
    },
    {"s_N": [-0.1, 1 / 3], "s_Tx": 123.456789, "s_Ty": -5e-6, "increments": 7},
    {"slip": [0.1 * i / 3 for i in range(40)], "direction": -31.7, "t_N": -1.0},
    {"slip": 7.0, "follow": "branch", "arc": 0.0123, "fork": -1},
)
"""Steps with every entry."""
WRITTEN_MATERIAL = {
    "sigma0": 1 / 3,
    "Gc": 1e-7 / 3,
    "eta": 0.9,
    "mu": 0.7,
    "sigma02": 0.4,
    "Gc2": 2e-7 / 3,
    "kc": 123456.7,
    "tau_v": 1e-9,
    "guard": True,
    "height": 3e-6,
    "W0": 2e10,
    "crush": 1 / 7,
    "damage0": 0.1,
    "closure": 1e-6,
    "c": 1e-5 / 3,
    "fc": 31 / 3,
    "Gfc": 40 / 7,
    "Css": 8.9,
    "kp": 1e-3 / 3,
    "fcr": 0.11,
}
"""All constants of a joint."""
BONDED = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5}


def test_python_writes_what_the_library_reads(tmp_path: Path) -> None:
    """Every constant, and every entry of a step, of &case and &state, comes back bit by bit."""
    case = {"title": "it's 1/3", "a_0": -1 / 3, "a_min": 2e-9}
    pattern = {"sides": 5, "theta": 100 / 3, "flat": 1 / 3, "turn": -1e-3}
    state = {"separation": [0.1, -2e-7, 1 / 3], "statev": [i / 7e5 for i in range(26)], "work": 1 / 7}
    file = tmp_path / "written.nml"

    def read(*groups: Group) -> Run:
        file.write_text(case_text(("case", case), ("pattern", pattern), *groups), encoding="utf-8")
        assert read_case(file).title == case["title"]
        return read_case(file).runs[0]

    run = read(("material", WRITTEN_MATERIAL), ("step", {"s_N": 0.0}))
    for owner, values in ("law", WRITTEN_MATERIAL), ("pattern", {"m": 5} | pattern):
        constants = {row.name: run.props[row.index - 1] for row in owned(owner)}
        # the case gives m as sides
        assert constants.keys() ^ (values.keys() - {"sides"}) == set(), "WRITTEN_MATERIAL"
        assert constants.items() <= values.items()
    steps = [("step", step) for step in WRITTEN_STEPS]
    run = read(("material", BONDED), ("state", state | {"p": 0.1}), *steps)
    assert run.state is not None and [*run.state.separation] == state["separation"]
    assert (run.state.work, run.state.p, run.a_0, run.a_min) == (1 / 7, 0.1, -1 / 3, 2e-9)
    assert run.state.state.tolist() == state["statev"]
    for given, step in zip(WRITTEN_STEPS, run.steps, strict=True):
        numbers = numbers_of(step) | {"follow": step.follow}
        for name, value in given.items():
            if name == "cycles":  # they are in the lists
                assert numbers["t_N"] == value * tuple(given["t_N"])
                continue
            values = tuple(value) if isinstance(value, list) else value if name == "follow" else (value,)
            assert numbers[name][: len(values)] == values, name
    assert set().union(*WRITTEN_STEPS) == {entry.name for entry in entries()}


def test_a_step_that_holds_repeats(run, tmp_path: Path) -> None:
    """A step without targets holds all values as long as its cycles say, in Python as in the driver."""
    steps = "&step t_N = -1.0, increments = 2 /\n&step increments = 3, cycles = 2, time = 0.4 /\n"
    rows = run(MATERIAL + RP_4 + steps)
    [case] = read_case(tmp_path / "case.nml").runs
    history = case.history()
    assert len(rows.rows) == 2 + 3 * 2 and rows["time"][-1] == 1.0 + 0.4
    assert history.separation.tolist() == rows.vector("s").tolist()
    assert history.time.tolist() == rows["time"].tolist()


def test_python_writes_starts_sweeps_and_planes(tmp_path: Path) -> None:
    """An initial traction with water, the name of a sweep and listed planes are read as they were given."""
    file = tmp_path / "written.nml"
    planes = {"normals": [1.0, 0.0, 0.0, 1.0, 0.3, 0.0], "weights": [1 / 3, 2 / 3]}
    file.write_text(
        case_text(
            ("case", {"tolerance": 1e-3 / 3}),
            ("material", BONDED | {"mu": Word("mu")}),
            ("pattern", planes),
            ("sweep", {"name": "mu", "values": [0.1, 1 / 3]}),
            ("initial", {"traction": [-1 / 3, 0.0, 0.0], "p": 0.1}),
            ("step", {"s_N": 0.1}),
        ),
        encoding="utf-8",
    )
    runs = read_case(file).runs
    assert [(run.value, run.material.mu) for run in runs] == [(0.1, 0.1), (1 / 3, 1 / 3)]
    assert [run.tolerance for run in runs] == [1e-3 / 3] * 2
    assert all(run.pattern.weights.tolist() == planes["weights"] and run.start == "initial" for run in runs)
    for run in runs:
        at_rest = run.interface.update([[0.0, 0.0, 0.0]], run.state.state[None], p=[run.state.p]).traction[0]
        assert run.state.p == 0.1 and at_rest == pytest.approx([-1 / 3, 0.0, 0.0], rel=1e-10, abs=1e-12)
