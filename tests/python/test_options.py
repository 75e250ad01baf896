"""What commands have in common: rows of arguments, lists of numbers, NAME=VALUE, processes, outputs."""

from __future__ import annotations

import argparse
import os
from multiprocessing import Process, active_children
from pathlib import Path
from time import sleep

import pytest
from asperity.options import (
    Parser,
    add_options,
    add_workers,
    assigned,
    check_outputs,
    check_picture,
    numbers,
    results_of,
    units_of,
    workers,
)


def parsed(*rows: tuple[object, ...], words: str) -> argparse.Namespace:
    """Options of words, by a command with these arguments."""
    parser = Parser(prog="asperity")
    command = parser.add_subparsers().add_parser("do")
    add_options(command, *rows)
    options: argparse.Namespace = parser.parse_args(["do", *words.split()])
    return options


def test_kinds_of_arguments() -> None:
    """A row without a kind is a flag; a default gives the type; list: repeated."""
    rows = (
        ("case CASE", "a file", Path),
        ("--flag", "a flag"),
        ("-n --count N", "how many", 3),
        ("--set X", "", list),
    )
    options = parsed(*rows, words="a.nml --flag -n 5 --set a --set b")
    assert (options.case, options.flag, options.count, options.set) == (Path("a.nml"), True, 5, ["a", "b"])
    options = parsed(*rows, words="a.nml")
    assert (options.flag, options.count, options.set) == (False, 3, [])


@pytest.mark.parametrize(
    "text", ["-0.3,-1", "-.5,2", "-1e-3,-2e+1,3", "0.3,-1", "-2", "-2.", "-1e-3", "-.5E+2"]
)
@pytest.mark.parametrize("many", [{}, {"nargs": "+"}])
def test_lists_that_begin_with_a_minus_sign(text: str, many: dict[str, str]) -> None:
    """They are values, alone and among others; options remain options."""
    rows = ("--sigma-N VALUE,...", "pressures", str, many), ("-o --output FILE", "", Path)
    options = parsed(*rows, words=f"--sigma-N {text} -o out")
    assert options.sigma_N == ([text] if many else text) and options.output == Path("out")
    with pytest.raises(SystemExit):
        parsed(*rows, words=f"--sigma-N -x,{text} -o out")


@pytest.mark.parametrize("text", ["-2", "-2.", "-1e-3", "-1.5E3"])
def test_numbers_that_begin_with_a_minus_sign(text: str) -> None:
    """They are values in any form of a number."""
    options = parsed(("--direction X", "", float, {"nargs": "+"}), words=f"--direction 1 {text} {text}")
    assert options.direction == [1.0, float(text), float(text)]


@pytest.mark.parametrize(
    "words", ["--sigma-N -0.1 --sigma-N -1", "-n 1 --count 2", "--plot --plot b.png", "--sigma-N=1 --sigma 2"]
)
def test_a_value_is_given_once(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A second value would hide the first one; flags and lists may be repeated."""
    rows: list[tuple[object, ...]] = [("--sigma-N VALUE,...", "pressures", str), ("-n --count N", "", 3)]
    rows += [("--plot FILE", "", Path, {"nargs": "?"}), ("--set X", "", list), ("--flag", "")]
    options = parsed(*rows, words="--set a --set b --flag --flag -n 1 --sigma-N -1")
    assert options.set == ["a", "b"] and options.flag and options.count == 1
    with pytest.raises(SystemExit) as stopped:
        parsed(*rows, words=words)
    assert stopped.value.code == 2
    assert "given twice: expected it once" in capsys.readouterr().err


@pytest.mark.parametrize("words", ["-0.1 -1", "0.1 1", "-1e-3,-2. -3"])
@pytest.mark.parametrize("between", [" ", "="])
def test_values_of_a_list_are_separated_by_commas(
    words: str, between: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A blank in place of a comma is named, as the second number would be a file or an unknown word."""
    rows = ("records FILE", "", Path, {"nargs": "+"}), ("--sigma-N VALUE,...", "pressures", str)
    with pytest.raises(SystemExit):
        parsed(*rows, words=f"a.csv --sigma-N{between}{words}")
    assert f"expected {words.replace(' ', ',')}, with a comma" in capsys.readouterr().err
    assert parsed(*rows, words="a.csv --sigma-N -0.1,-1").sigma_N == "-0.1,-1"


def test_name_value() -> None:
    """Values by name; a wrong form and a name that is given twice are named."""
    assert assigned(["sigma0=3.0", " mu = .5"]) == {"sigma0": "3.0", "mu": ".5"}
    assert numbers("--range", ["mu=0.3,0.5 eta=0.1,0.2"], 2) == {"mu": [0.3, 0.5], "eta": [0.1, 0.2]}
    for texts, message in (
        (["mu"], "--set mu: expected NAME=VALUE"),
        (["mu=1", "mu=2"], "--set mu=2: mu is given twice"),
    ):
        with pytest.raises(ValueError, match=message):
            assigned(texts, "--set")
    for text, message in (("mu=a", "a number"), ("mu=1,2", "--set mu=1,2: expected NAME=VALUE")):
        with pytest.raises(ValueError, match=message):
            numbers("--set", [text], 1)


def test_units_of_a_picture() -> None:
    """Two units, separated by a comma; a picture ends in .png or .pdf."""
    assert units_of("m,kPa") == ("m", "kPa")
    for text in ("m", "m,kPa,s"):
        with pytest.raises(ValueError, match=f"--label-units {text}: expected LENGTH,STRESS"):
            units_of(text)
    with pytest.raises(ValueError, match=r"a\.svg: expected a name that ends in"):
        check_picture(Path("a.svg"))


def test_results_of_a_sweep(tmp_path: Path) -> None:
    """Files of a run by the value of the sweep, which ascends; other files are none of them."""
    for name in ("a_2.csv", "a_-1.csv", "a_b.csv", "b_1.csv"):
        (tmp_path / name).touch()
    assert list(results_of(tmp_path / "a.csv")) == [-1.0, 2.0]
    (tmp_path / "a.csv").touch()
    assert list(results_of(tmp_path / "a.csv")) == [None, -1.0, 2.0]


def test_outputs_that_are_refused(tmp_path: Path) -> None:
    """A file of somebody else, one that is read, and a folder that is not there."""
    mine, foreign = tmp_path / "mine.nml", tmp_path / "other.nml"
    mine.write_text("! by asperity")
    foreign.write_text("! by hand")
    check_outputs(False, [None], ("-o", mine, "! by asp"), ("-o", None))
    check_outputs(True, [], ("-o", foreign, "! by asp"))
    for path, message in (
        (foreign, "is not replaced"),
        (tmp_path / "none" / "a", "no folder"),
        (tmp_path, "a file"),
    ):
        with pytest.raises(ValueError, match=message):
            check_outputs(False, [], ("-o", path, "! by asp"))
    with pytest.raises(ValueError, match="read or written by the same command"):
        check_outputs(True, [mine], ("-o", mine, "! by asp"))


def test_processes_end_with_what_they_compute(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception ends the processes of the pool, and no others."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    parser = argparse.ArgumentParser()
    add_workers(parser)
    sleeper = Process(target=sleep, args=(60.0,))
    sleeper.start()
    try:
        with (
            pytest.raises(RuntimeError, match="stop"),
            workers(parser.parse_args(["--jobs", "1"]), None) as single,
        ):
            assert single is not None and single.submit(len, "abc").result() == 3
            raise RuntimeError("stop")
        with pytest.raises(RuntimeError, match="stop"), workers(parser.parse_args([]), 2) as two:
            assert two is not None
            two.submit(sleep, 60.0)
            raise RuntimeError("stop")
        assert active_children() == [sleeper] and sleeper.is_alive()
    finally:
        sleeper.terminate()
        sleeper.join()
    with pytest.raises(ValueError, match="--jobs 0: expected 1 to"):
        workers(parser.parse_args(["--jobs", "0"]))
