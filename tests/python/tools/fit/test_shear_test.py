"""Files of shear-box tests that are doubted, with a warning, or refused, with the place of what is wrong."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import asperity
import numpy as np
import pytest
from asperity.tools.fit import ShearTest, read_tests
from asperity.tools.tables import read_table
from support_records import ENVELOPE, HEADER, LINE, ROWS, SHORT, UNITS, WITH_K, seven, write

# --- what is doubted ----------------------------------------------------------------------------------------


def test_unusual_sizes(tmp_path: Path) -> None:
    """Stresses of a gigapascal give a warning."""
    with pytest.warns(asperity.ModelWarning, match="the largest stress is 500 MPa, which is unusual"):
        read_tests(write(tmp_path, UNITS + ROWS.replace(",-1\n", ",-500\n")))


def test_numbers_like_marks(tmp_path: Path) -> None:
    """A pressure of 999 kPa beside others of its size is one; stresses of a gigapascal give a warning."""
    text = "sigma_N [kPa],peak [kPa]\n250,210\n500,405\n999,810\n"
    assert len(read_tests(write(tmp_path, text))) == 3
    with pytest.warns(asperity.ModelWarning, match="line 4: the largest stress, 999, is unusual for a shear"):
        read_tests(write(tmp_path, text.replace("kPa", "MPa")))
    beside_none = write(tmp_path, "sigma_N [kPa],peak [kPa]\n0,20\n0,22\n999,810\n", "none.csv")
    assert [one.sigma_N for one in read_tests(beside_none)][-1] == pytest.approx(-0.999)
    plain = write(tmp_path, "sigma_N,peak\n1,2\n", "plain.csv")
    with pytest.raises(ValueError, match=r"plain.csv: line 2: no units in the header: expected units in e"):
        read_tests([write(tmp_path, text), plain])


@pytest.mark.parametrize(("scale", "told"), [(0.02, True), (0.05, False), (20.0, False), (400.0, True)])
def test_peaks_beside_pressures(scale: float, told: bool, tmp_path: Path) -> None:
    """Peaks that are small or large beside the pressures are told, as forces beside stresses are."""
    text = "".join(f"{p},{scale * (4.0 * p + 1.0):g}\n" for p in (0, 5, 10, 15))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert len(read_tests(write(tmp_path, "sigma_N,peak\n" + text))) == 4
    assert ["the median ratio of peak to pressure is" in str(one.message) for one in caught] == [True] * told


def test_flat_dilation_with_flicker(tmp_path: Path) -> None:
    """A dilation of 0 with the last digit of its gauge in some rows has no outliers."""
    rows = "".join(f"{i},{1.0 + 0.01 * i},{0.001 if i in (3, 9) else 0:g},-1\n" for i in range(1, 21))
    [test] = read_tests(write(tmp_path, HEADER + rows))
    assert test.slip.size == 20


def test_closing_joint(tmp_path: Path) -> None:
    """A joint that closes as far as it should open gives a warning."""
    rows = "".join(f"{i},{min(i, 4)},{-0.2 * i:g},-5\n" for i in range(1, 9))
    with pytest.warns(asperity.ModelWarning, match="dilation: -1.6 at the end: .* check the sign"):
        read_tests(write(tmp_path, "slip,tau,dilation,sigma_N\n" + rows))


@pytest.mark.parametrize(
    ("text", "decimal", "slip", "tau"),
    [
        # the column itself, or all others, show what the mark is
        ("0,1;1,150;-5\n0,2;1,234;-5\n", None, 0.2, 1.234),
        ("0.1;1,150.5;-5\n0.2;1,234;-5\n", None, 0.2, 1234.0),
        ("0.1;950;-5\n0.2;1,234,000;-5\n", None, 0.2, 1234000.0),
        ("40.000;1,5;-5\n50.000;2,5;-5\n", ".", 50.0, 2.5),
        ("40.000;1,5;-5\n50.000;2,5;-5\n", ",", 50000.0, 2.5),
        ("1,000;1,150;-5\n2,000;1,234;-5\n", ",", 2.0, 1.234),
        ("1,000;1,150;-5\n2,000;1,234;-5\n", ".", 2000.0, 1234.0),
        ("1.000,1.150,-5\n2.000,1.234,-5\n", None, 2.0, 1.234),
        ("1,000;1,150;-5\n2,000;1,234;-5\n", None, 0.0, 0.0),
        ("1.000;1.150;-5\n2.000;1.234;-5\n", None, 0.0, 0.0),
        ("1.000;1,5;-5\n2.000;2,5;-5\n", None, 0.0, 0.0),
        ("1.000;1.200,9;-5\n2.000;300,5;-5\n", None, 0.0, 0.0),
        ("1,000;0.5;-5\n2,000;0.75;-5\n", None, 0.0, 0.0),
        ("1.000\t1,5\t-5\n2.000\t2,5\t-5\n", None, 0.0, 0.0),
        ("1.000\t1.150\t-5\n2.000\t1.234\t-5\n", None, 0.0, 0.0),
    ],
)
def test_decimal_marks(text: str, decimal: str | None, slip: float, tau: float, tmp_path: Path) -> None:
    """1,234 is read by what its column or all others show; otherwise the file is refused."""
    mark = next(mark for mark in ";\t," if mark in text)
    path = write(tmp_path, f"slip{mark}tau{mark}sigma_N\n" + text + text.splitlines()[-1])
    table = read_table(path, "numbers")
    if slip > 0.0:
        assert table.numbers([0, 1], ["slip", "tau"], (), decimal)[1].tolist() == [slip, tau]
        return
    with pytest.raises(ValueError, match=r"line 2, column slip: 1.000 may be .* or --decimal comma or point"):
        table.numbers([0, 1], ["slip", "tau"])


@pytest.mark.parametrize("offset", [1.3, -12.3])
def test_slip_of_a_gauge_that_was_not_set_to_zero(offset: float, tmp_path: Path) -> None:
    """Where the joint rests in the first row the slip counts from the start of the traction; it is said."""
    rows = [(0.0, 0.0, 0.0), (0.1, 0.4, 0.0), *((0.1 * i, 0.8, 0.02 * i) for i in range(2, 12))]
    path = write(tmp_path, HEADER + "".join(f"{s + offset:g},{t},{d:g},-1\n" for s, t, d in rows))
    with pytest.warns(
        asperity.ModelWarning, match=rf"line 2, column slip: {offset:g} where 0% of .* from {offset:g}"
    ):
        [test] = read_tests(path)
    assert test.slip == pytest.approx([s for s, *_ in rows], abs=1e-9)


def test_dilation_of_a_gauge_that_was_not_set_to_zero(tmp_path: Path) -> None:
    """The same of the dilation; where the joint slides in the first row the start is not known."""
    slip = np.linspace(0.0, 6.0, 61)
    tau, dilation = np.minimum(1.0, 10.0 * slip), 0.6 * (1.0 - np.exp(-slip / 2.0))
    for start in (0, 1):
        rows = zip(slip[start:], tau[start:], 0.2 + dilation[start:], strict=True)
        path = write(tmp_path, HEADER + "".join(f"{s:.6g},{t:.6g},{d:.6g},-1\n" for s, t, d in rows))
        if start:
            message = "line 2, column dilation: 0.229262 in the first row, where the rows lead to 0.2"
            with pytest.raises(ValueError, match=message):
                read_tests(path)
        else:
            with pytest.warns(asperity.ModelWarning, match="line 2, column dilation: 0.2 where 0% of the"):
                [test] = read_tests(path)
            assert test.s_N == pytest.approx(dilation, abs=1e-5)


@pytest.mark.parametrize("given", [None, 30.0])
def test_stiffness_that_the_rows_show(given: float | None, tmp_path: Path) -> None:
    """A pressure that grows with the dilation names the stiffness to give; another one is refused."""
    slip = np.linspace(0.1, 6.0, 60)
    dilation = 0.6 * (1.0 - np.exp(-slip / 2.0))
    pressure = 1.5 + 3.0 * dilation + 0.01 * np.sin(40.0 * slip)
    rows = zip(slip, 0.8 * pressure, dilation, pressure, strict=True)
    path = write(tmp_path, HEADER + "".join(f"{s:.6g},{t:.6g},{d:.6g},{p:.6g}\n" for s, t, d, p in rows))
    message = "k_N = 30, but .* stiffness of 3: expected this one" if given else "expected --k-N 3$"
    with pytest.raises(ValueError, match=message):
        read_tests(path, k_N=given)
    [test] = read_tests(path, k_N=3.0)
    assert -test.sigma_N == pytest.approx(1.5, rel=0.01)


# --- what is refused ----------------------------------------------------------------------------------------

CURVE = "".join(f"-1,{2 - 0.1 * i:g},0.5,{i}\n" for i in range(1, 11))
"""Rows of a table with a peak, a residual strength and a slip."""

MARKS: list[tuple[str, dict[str, Any], str]] = [
    (
        HEADER + ROWS + "0.8,0.8,-99,-1\n",
        {},
        "line 9, column dilation: -99 marks a missing value: exp",
    ),
    (HEADER + ROWS + "0.8,9999,0.1,-1\n", {}, "line 9, column tau: 9999 marks a missing value: exp"),
    (
        HEADER + ROWS.replace("0.6,", "-99.99,"),
        {},
        "line 7, column slip: -99.99 marks a missing value: exp",
    ),
    (
        ENVELOPE + "1,2,1,5\n9999,999,2,5\n",
        {},
        "line 3, column sigma_N: 9999 marks a missing value: exp",
    ),
    (
        ENVELOPE + "50,60,-99,5\n100,110,70,5\n",
        {},
        "line 2, column residual: -99 marks a missing value: exp",
    ),
]
"""Marks of missing values."""

BAD: list[tuple[str, dict[str, Any], str]] = [
    # columns
    ("slip,shear,sigma_N\n1,2,-1\n", {}, "record.csv: line 1: columns slip, shear, sigma_N: expected tau, t"),
    ("slip,slip,tau,sigma_N\n", {}, "line 1: column slip is there twice"),
    ("slip,tau\n1,2\n", {}, "--sigma-N VALUE for files without sigma_N, 0 without a pressure;"),
    (LINE, {"columns": {"foo": "bar"}}, "columns: foo: expected one of slip, tau"),
    (
        SHORT.replace("tau", "\u03c4/\u03c3n"),
        {},
        "expected tau, too (--columns tau=HEADER, in Python columns=, for "
        "a column with another name; \u03c4/\u03c3n is a ratio, and no stress)",
    ),
    (
        "sigma_N,Shear strength,Peak strength\n1,2,3\n",
        {},
        "expected one strength, not Shear strength and Peak strength (--columns peak=HEADER for that of the",
    ),
    ("Confining pressure;Peak deviator stress\n1;8.8\n2;11.7\n", {}, "Peak deviator stress: expected slip,"),
    # rows
    ("", {}, "no rows: expected a header"),
    (HEADER + "0.1,1,0.1,-1\n", {}, "record.csv: 1 rows: expected at least 5"),
    (HEADER + ROWS + "0.9,1,0.1\n", {}, "line 9: 3 values: expected 4"),
    # cells
    (HEADER + ROWS + "0.9,high,0.1,-1\n1,1,low,-1\n", {}, "line 9, column tau: high: expected a finite numb"),
    (SHORT + "0.1,0.2,-1\n0.2,MPa,-1\n0.3,0.3,-1\n", {}, "line 3, column tau: MPa: expected a finite"),
    (LINE + SHORT + LINE[17:], {}, "line 9, column slip: slip: expected a finite number"),
    # decimal marks
    (HEADER + ROWS + '"0,9",1,0.1,-1\n', {}, "line 9, column slip: 0,9: expected a finite number"),
    (SHORT.replace(",", ";") + "0.5;1,5;-1\n2;2.5;-1\n1;1,7;-1\n", {}, "line 3, column tau: 2.5: expected a"),
    # units
    ("slip [mm],tau [kPa],sigma_N\n", {}, "sigma_N has no unit: expected one for every column, as slip [mm]"),
    ("slip [mm],tau [kN],sigma_N [MPa]\n", {}, "line 1: tau [kN]: expected Pa, kPa, MPa, N/mm2, kN/m2, kg/"),
    (UNITS.replace("dilation [mm]", "k_N [kN/mm]"), {}, "k_N [kN/mm]: expected a unit of stress/length, suc"),
    # outliers, and marks of a missing value
    (
        HEADER + "".join(f"{i},{i},{-77 if i in (6, 9) else 0.02 * i},-9\n" for i in range(1, 21)),
        {},
        "line 7, column dilation: -77 (as in 2 rows) lies apart from all others: expected no outlier",
    ),
    # signs and sizes
    (HEADER + ROWS + "0.9,1,0.1,1\n", {}, "line 9, column sigma_N: 1: expected compression in all rows"),
    (HEADER + seven(lambda i: f"{i},{-i},{0.1 * i},-9"), {}, "the work of tau along the slip is -24.5 < 0: "),
    (HEADER + seven(lambda i: f"0.{i},{500 + i},0.0{i},-1"), {}, "tau: 507 at the end where |sigma_N| is 1:"),
    (HEADER + seven(lambda i: f"{i},1,0,-1"), {}, "column tau is 1 in all rows: expected values that change"),
    (HEADER + seven(lambda i: f"0.{i},1.{i},{5 + 0.01 * i},-1"), {}, "line 2, column dilation: 5.01 at sli"),
    (
        HEADER + ROWS + "0.8,0.8,-998,-1\n",
        {},
        "line 9, column dilation: -998 is more than 20 times the largest",
    ),
    *MARKS,
    (SHORT + seven(lambda i: f"{7.2 + 0.1 * i},1.{i},-1"), {}, "line 2, column slip: 7.3 in the first row, "),
    (HEADER + ROWS + "0.9,1,0.1,-2\n", {}, "line 9, column sigma_N: -2 is more than 5% off the mean -1.125"),
    # stiffnesses and other kinds of test
    (WITH_K + seven(lambda i: f"{i},{i},0,{-i},-1"), {}, "column k_N: 7 values: expected one a test"),
    (WITH_K + seven(lambda i: f"{i},{i},0,-2,-1"), {}, "line 2, column k_N: -2: expected a stiffness >= 0"),
    (LINE, {"sigma_N": 2.0}, "sigma_N: 1 values for 0 tests without that column: expected"),
    (LINE, {"k_N": -1.0}, "k_N = -1: expected a finite stiffness > 0"),
    (LINE, {"k_T": 2.0}, "line 5: k_T = 2 takes 0.4 off the slip 0.4: expected more than tau/slip = 2"),
    (LINE, {"k_N": 5.0, "sigma_N_path": True}, "k_N = 5: expected no stiffness beside a prescribed"),
    (ENVELOPE + "-1,2,1,5\n-2,1,2,5\n", {}, "line 3: residual = 2: expected at most the peak, 1"),
    (ENVELOPE + "-1,2,1,5\n", {"k_T": 5.0}, "k_T, sigma_N_path: expected curves, not strengths alone"),
    (ENVELOPE + "-1,2,1,5\n", {"k_N": 5.0}, "k_N, k_T, sigma_N_path: expected curves, not strengths"),
    (
        ENVELOPE + CURVE,
        {},
        "column peak: 10 rows at one pressure with growing slips are a curve: expected tau",
    ),
    (
        "sigma_N,residual\n-1,0.6\n-2,1.2\n",
        {},
        "expected peak, too (--columns peak=HEADER, in Python columns=",
    ),
    (
        "name,sigma_N,peak\nmean,1,2\nsd,0,1\n",
        {},
        "record.csv: line 2: mean, line 3: sd: expected rows of spe",
    ),
    ("sigma_N,normal displacement\n1,0.1\n2,0.2\n", {}, "a closure test has no slip: --columns closure=HEA"),
]


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize(("text", "options", "message"), BAD, ids=[message for *_, message in BAD])
def test_bad_records(text: str, options: dict[str, Any], message: str, tmp_path: Path) -> None:
    """Errors have file, line, column, value and expectation."""
    with pytest.raises(ValueError, match=re.escape(message)):
        read_tests(write(tmp_path, text), **options)


def test_all_errors_at_once(tmp_path: Path) -> None:
    """The errors of all rows and files are listed together."""
    first = write(tmp_path, HEADER + ROWS + "0.9,high,0.1,-1\n1,1,low,-1\n")
    second = write(tmp_path, HEADER + "0.9,1,0.1\n", "second.csv")
    with pytest.raises(ValueError, match="line 9") as caught:
        read_tests([first, second])
    told = str(caught.value).splitlines()
    assert len(told) == 3 and "line 10, column dilation: low" in told[1]
    assert "second.csv: line 2: 3" in told[2]


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    """Errors have the file and the expectation."""
    path = write(tmp_path, HEADER + ROWS)
    csv = write(tmp_path, UNITS + ROWS, "other.csv")
    empty = tmp_path / "empty"
    empty.mkdir()
    old = tmp_path / "old.xls"
    old.write_bytes(b"\xd0\xcf\x11\xe0\0\0\0")
    for files, error, message in (
        ([tmp_path / "none.csv"], FileNotFoundError, "none.csv"),
        ([empty], ValueError, r"empty: expected files that end in \.csv"),
        ([old], ValueError, "old.xls is no text: expected a CSV file with .* Excel 97: save it as .xls"),
        ([path, tmp_path / "." / "record.csv"], ValueError, "record.csv: given twice: expected each file on"),
        ([csv, path], ValueError, r"record.csv: no units in the header: expected units in .*other"),
        ([], ValueError, "no test: expected a file"),
    ):
        with pytest.raises(error, match=message):
            read_tests(files)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tau": np.ones(6)}, "t: column tau is 1 in all rows: expected values that change"),
        ({"slip": [], "tau": []}, r"t: slip has shape \(0,\)"),
    ],
)
def test_tests_that_cannot_be(values: dict[str, Any], message: str) -> None:
    """A test that a script constructs, of arrays or lists, is also checked."""
    good = {"slip": list(range(6)), "tau": np.arange(6.0), "s_N": None, "sigma_N": -1}
    assert ShearTest("t", **good).slip.tolist() == [0, 1, 2, 3, 4, 5]  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        ShearTest("t", **(good | values))
