"""Files of shear-box tests: what laboratories export is read, and what is wrong is refused by its place."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import asperity
import numpy as np
import pytest
from asperity.tools.fit import ShearTest, read_tests
from asperity.tools.tables import read_table

HEADER, SHORT, ENVELOPE = "slip,tau,dilation,sigma_N\n", "slip,tau,sigma_N\n", "sigma_N,peak,residual,slip\n"
WITH_K = "slip,tau,dilation,k_N,sigma_N\n"
UNITS = "slip [mm],tau [MPa],dilation [mm],sigma_N [MPa]\n"
ROWS = "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1\n" for i in range(1, 8))
LINE = SHORT + "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},-1\n" for i in range(1, 8))
SLIP, TAU, DILATION = np.linspace(0.1, 0.7, 7), 0.2 * np.minimum(np.arange(1, 8), 4), 0.02 * np.arange(1, 8)


def write(folder: Path, text: str, name: str = "record.csv", encoding: str = "utf-8") -> Path:
    """A file."""
    path = folder / name
    path.write_text(text, encoding=encoding)
    return path


def seven(row: Callable[[int], str]) -> str:
    """Seven rows."""
    return "".join(row(i) + "\n" for i in range(1, 8))


def same(test: ShearTest, s_N: bool = True, digits: float = 1e-9) -> None:
    """Check that a test is that of ROWS, in mm and MPa."""
    assert test.slip == pytest.approx(SLIP, abs=digits) and test.tau == pytest.approx(TAU, abs=digits)
    assert test.sigma_N == pytest.approx(-1.0)
    assert (test.s_N == pytest.approx(DILATION, abs=digits)) if s_N else test.s_N is None


def warned(path: Path) -> tuple[list[ShearTest], list[str]]:
    """Tests of a file, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = read_tests(path)
    return found, [str(one.message) for one in caught]


# --- what is read -------------------------------------------------------------------------------------------

LABS = {
    "plain": ("utf-8", HEADER + ROWS),
    "semicolons": ("utf-8", (HEADER + ROWS).replace(",", ";").replace(".", ",")),
    "aliases, brackets, comments": (
        "utf-8",
        "# a box\n% 2024\nSlip (mm),TAU [N/mm^2],s_n [mm],sigma_N [ MPa ],time [s],,\n"
        + ROWS.replace(",-1\n", ",-1,3,, # a row\n\n"),
    ),
    "German, preamble, positive": (
        "utf-8-sig",
        "Labor f\u00fcr Felsmechanik;;;\nDatum;12.03.2024;;\nVersuch;Scher 3;;\n;;;\n"
        "Schubspannung [kPa];Vertikalverschiebung [mm];Horizontalverschiebung [mm];Normalspannung [kPa];\n"
        + seven(lambda i: f"{200 * min(i, 4)},00;{0.02 * i:.3f};{0.1 * i:.2f};1000,00;".replace(".", ",")),
    ),
    "thousands, quoted": (
        "utf-8",
        "Shear disp. (mm),Shear stress (Pa),Normal stress (Pa),Vertical disp. (um)\n"
        + seven(lambda i: f'{0.1 * i:.1f},"{200000 * min(i, 4):,}.0","-1,000,000",{20 * i}.0'),
    ),
    "time of day": (
        "utf-8",
        "Time,Shear disp. (mm),Shear stress (MPa),Normal disp. (mm),Normal stress (MPa)\n"
        + seven(lambda i: f"2024-03-12 09:0{i},{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1"),
    ),
    "tabs, row of units": (
        "utf-16",
        "Test A\n\nShear displ.\tShear stress\tNormal stress\tDilation\nmm\tMPa\tN/mm\u00b2\tmm\n"
        + seven(lambda i: f"{0.1 * i:.1f}\t{min(i, 4) * 0.2:.1f}\t-1\t{0.02 * i:.2f}"),
    ),
    "groups above the names": (
        "utf-8",
        "Shear;;Normal;\nDisplacement;Stress;Displacement;Stress\nmm;MPa;mm;MPa\n" + ROWS.replace(",", ";"),
    ),
    "line breaks in the header": (
        "utf-8",
        '"Shear\ndisplacement [mm]","Shear\nstress [MPa]","Normal\ndisplacement [mm]",sigma_N [MPa]\n' + ROWS,
    ),
    "blanks": ("utf-8", "slip tau dilation sigma_N\n" + ROWS.replace(",", "  ").replace(".", ",")),
    "French, in Windows": (
        "cp1252",
        "D\u00e9placement tangentiel (mm),Contrainte de cisaillement (MPa),D\u00e9placement normal (mm),"
        "Contrainte normale (MPa),Force normale (kN)\n" + ROWS.replace(",-1\n", ",-1.0,7\n"),
    ),
    "in words": (
        "utf-8",
        "Slip;Shear force per area;Uplift;Normal force / area\nmm;N/mm2;mm;N/mm2\n" + ROWS.replace(",", ";"),
    ),
    "symbols": (
        "utf-8",
        "dLs_mm,tau_MPa,dLn_mm,sigma_n_eff_MPa\n" + ROWS,
    ),
    "Greek symbols": ("utf-8", "\u03b4_h [mm],\u03c4 [MPa],\u03b4_v [mm],\u03c3_n [MPa]\n" + ROWS),
    "Italian, errors of a spreadsheet": (
        "utf-8",
        "Spostamento orizzontale [mm];Tensione tangenziale [MPa];Spostamento verticale [mm];"
        "Tensione normale [MPa]\n#DIV/0!;#WERT!;0;-1\n0.15;;0.01;-1\n" + ROWS.replace(",", ";"),
    ),
}  # fmt: skip
"""Encoding and text of files with the test of ROWS."""


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("name", LABS)
def test_files_of_laboratories(name: str, tmp_path: Path) -> None:
    """Languages, decimal commas, thousands, units, preambles and errors of spreadsheets are read."""
    encoding, text = LABS[name]
    path = write(tmp_path, text, encoding=encoding)
    [test] = read_tests(path)
    same(test)
    assert test.units == ({"length": "mm", "stress": "MPa"} if "mm" in text else {})
    # the file has these numbers in these lines
    lines = text.splitlines()
    assert len(test.lines) == 7 and all(re.match(r"[-\d.,: ]+[;,\t ]", lines[i - 1]) for i in test.lines)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("area", ["2500", "50,50"])
def test_forces_over_an_area(area: str, tmp_path: Path) -> None:
    """Forces over the area are the tractions; those of a box that shrinks follow its area."""
    sizes = np.full(7, 2500.0) if area == "2500" else (50.0 - SLIP) * 50.0
    rows = np.column_stack([SLIP, TAU * sizes * 1e-3, DILATION, np.full(7, 2.5)]).tolist()
    lines = [",".join(map(repr, row)) for row in rows]
    text = "\n".join(["Shear disp. (mm),Shear load (kN),Dilation (mm),Normal force (kN)", *lines, ""])
    [test] = read_tests(write(tmp_path, text), area=area)
    assert test.slip == pytest.approx(SLIP) and test.tau == pytest.approx(TAU)
    if area == "2500":
        assert test.sigma_N == pytest.approx(-1.0) and test.path_N is None
    else:
        assert test.path_N == pytest.approx(-2500.0 / sizes)
    # a dead load that is given as a stress is that at the start
    bare = text.replace("Normal force (kN)", "time")
    [test] = read_tests(write(tmp_path, bare), area=area, sigma_N=1.0)
    assert (-test.sigma_N if test.path_N is None else -test.path_N) == pytest.approx(2500.0 / sizes)


def test_forces_without_an_area(tmp_path: Path) -> None:
    """Forces alone ask for the area, a box is longer than its slip, and a table has one area."""
    path = write(tmp_path, "slip (mm),Shear load (kN),sigma_N (MPa)\n" + seven(lambda i: f"{i},{i},1"))
    with pytest.raises(ValueError, match=r"expected tau, too .*--area A for forces"):
        read_tests(path)
    with pytest.raises(ValueError, match="the slip reaches 7: expected less than L = 5"):
        read_tests(path, area="5,5")
    peaks = write(tmp_path, "sigma_N [MPa],Peak shear load [kN]\n1,15\n2,27\n3,38\n")
    found = read_tests(peaks, area="10000")
    assert [one.peak for one in found] == pytest.approx([1.5, 2.7, 3.8])
    with pytest.raises(ValueError, match="strengths of a table: expected one area"):
        read_tests(peaks, area="100,100")


@pytest.mark.parametrize(("pressure", "closure"), [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_closure_tests_of_either_sign(pressure: float, closure: float, tmp_path: Path) -> None:
    """Loading and unloading are told apart; pressure and closure count positive, from the first row."""
    rows = [(0.5, 0.02), (1.0, 0.05), (2.0, 0.08), (4.0, 0.1), (2.0, 0.09), (0.5, 0.06)]
    text = "".join(f"{pressure * p},{closure * c}\n" for p, c in rows)
    [test] = read_tests(write(tmp_path, "Normal stress [MPa],Joint closure [mm]\n" + text))
    assert test.pressure == pytest.approx([p for p, _ in rows])
    assert test.closure == pytest.approx([c - 0.02 for _, c in rows])
    assert test.loading.tolist() == [0, 1, 2, 3] and test.unloading.tolist() == [4, 5]


@pytest.mark.parametrize("change", [-0.01, -0.03])
def test_closure_that_falls(change: float, tmp_path: Path) -> None:
    """A closure that falls with the pressure is refused, also where it ends below 0 and nearer to it."""
    pressure = np.linspace(0.0, 10.0, 11)
    text = "".join(f"{p},{0.2 + change * p}\n" for p in pressure)
    message = f"column closure: falls from 0.2 to {0.2 + 10.0 * change:g} as the pressure grows: expected"
    with pytest.raises(ValueError, match=message):
        read_tests(write(tmp_path, "sigma_N [MPa],closure [mm]\n" + text))


def test_gaps_and_other_names(tmp_path: Path) -> None:
    """Rows with gaps are left out, with a warning; a name of the user comes before those of this program."""
    lines = (HEADER + ROWS).splitlines()
    lines[2:2] = ["0.15,,0.01,-1", "0.16,1,,-1"]
    with pytest.warns(asperity.ModelWarning, match=r"a cell is empty: 2 \(line 3, 4\)"):
        [test] = read_tests(write(tmp_path, "\n".join(lines)))
    same(test)
    path = write(tmp_path, (UNITS + ROWS).replace("slip", "Weg oben").replace("tau", "S1"))
    with pytest.raises(ValueError, match=r"expected slip, tau, too .*slip=HEADER, in Python columns="):
        read_tests(path)
    same(read_tests(path, columns={"slip": "weg Oben", "tau": "S1"})[0])
    with pytest.raises(ValueError, match=r"line 1: columns Weg oben.*: expected Weg, too"):
        read_tests(path, columns={"slip": "Weg"})


def test_several_tests_and_files(tmp_path: Path) -> None:
    """Tests of one file, unused columns, k_N of the file or the argument, and several files are read."""
    text = "Test,slip [mm],tau [MPa],s_n [mm],sigma_N [MPa],k_N [N/mm3],time [s]\n"
    for i in range(1, 7):
        text += f"a,{i},{i},{0.1 * i},2,,{i}\nb,{-i},{-i},{0.2 * i},3,4,{i}\n"
    plain = write(tmp_path, SHORT.replace(",", " [mm],", 1).replace("tau,sigma_N", "tau [MPa],sigma_N [MPa]")
                  + "".join(f"{i},{i},1\n" for i in range(6)), "plain.csv")  # fmt: skip
    with pytest.warns(asperity.ModelWarning, match=r"record.csv: columns not used: time"):
        a, b, c = read_tests([write(tmp_path, text), plain], k_N=7.0)
    assert (a.sigma_N, a.k_N, b.sigma_N, b.k_N) == pytest.approx((-2.0, 7.0, -3.0, 4.0)) and c.k_N == 7.0
    assert a.name.endswith("test a") and c.s_N is None and b.slip.tolist() == [-1, -2, -3, -4, -5, -6]
    cycle = ShearTest("", np.array([0, 1, 2, 1, -1, 0.5]), a.tau, None, -1.0)
    assert cycle.turns == [2.0, -1.0, 0.5] and not cycle.ends_far and a.ends_far


@pytest.mark.parametrize(
    ("rows", "tests"),
    [
        ([(1.0, ROWS), (1.0, ROWS)], 2),
        ([(1.0, ROWS), (2.0, ROWS), (1.0, ROWS)], 3),
        # tests whose first rows lie far apart
        ([(1.0, ROWS), (2.0, ROWS[ROWS.index("0.3,") :] + "0.8,0.8,0.16,-1\n0.9,0.8,0.18,-1\n")], 2),
        # a cycle, whose return stroke reverses tau, in a few rows or in one
        ([(1.0, ROWS), (1.0, "0.4,-0.8,0.08,-1\n0,-0.8,0,-1\n"), (1.0, ROWS)], 1),
        ([(1.0, ROWS), (1.0, "0,-0.8,0,-1\n"), (1.0, ROWS)], 1),
        # noise at the start, and a slip that is misread
        ([(1.0, "0,0,0,-1\n0.001,0,0,-1\n0,0,0,-1\n" + ROWS)], 1),
        ([(1.0, ROWS.replace("0.5,", "0.0,"))], 1),
    ],
)
def test_tests_below_each_other(rows: list[tuple[float, str]], tests: int, tmp_path: Path) -> None:
    """Where the slip jumps back to its start the next test begins, with a warning; a cycle is one test."""
    text = "".join(part.replace(",-1\n", f",{-sigma_N:g}\n") for sigma_N, part in rows)
    path = write(tmp_path, HEADER + text)
    found, caught = warned(path)
    assert [test.sigma_N for test in found] == [-sigma_N for sigma_N, _ in rows[:tests]]
    lines = ", ".join(str(2 + 7 * i) for i in range(1, tests))
    told = f"the slip jumps back in line {lines}: read as the next test" if tests > 1 else ""
    assert [told in one for one in caught] == [True] * (tests > 1)
    # a specimen may have several tests; the rows of a test are one
    for name, count in (("Specimen No.", tests), ("test", 1)):
        labelled = f"{name},{HEADER}" + "".join(f"7,{line}\n" for line in text.splitlines())
        path = write(tmp_path, labelled)
        if len({sigma_N for sigma_N, _ in rows}) > count:
            with pytest.raises(ValueError, match="a column test for several tests"):
                read_tests(path)
            continue
        assert len(warned(path)[0]) == count


def test_normal_tractions_of_the_command(tmp_path: Path) -> None:
    """Files without sigma_N have that of the argument, one for each or one for all."""
    paths = [write(tmp_path, "slip,tau\n" + seven(lambda i, k=k: f"{i},{i * k}"), f"{k}.csv") for k in (1, 2)]
    assert [one.sigma_N for one in read_tests(paths, sigma_N=[0.5, 1.0])] == [-0.5, -1.0]
    assert [one.sigma_N for one in read_tests(paths, sigma_N=-2.0)] == [-2.0, -2.0]
    for given, message in (([1.0, 2.0, 3.0], "3 values for 2 tests"), (None, "expected sigma_N, too")):
        with pytest.raises(ValueError, match=message):
            read_tests(paths, sigma_N=given)


def test_normal_traction_under_a_stiffness(tmp_path: Path) -> None:
    """sigma_N at the start is extrapolated by the dilation, or without dilation taken from the first row."""
    rng = np.random.default_rng(3)
    text = "test,slip,tau,dilation,k_N,sigma_N\n"
    for i in range(1, 101):
        measured = -2.0 - 5.0 * 0.002 * i + rng.normal(0.0, 0.02)
        text += f"a,{0.01 * i},{i},{0.002 * i},5,{measured}\nb,{0.01 * i},{i},,5,{measured}\n"
    a, b = read_tests(write(tmp_path, text))
    first = float(text.splitlines()[1].rsplit(",", 1)[1])
    # standard error of the mean 0.002
    assert a.sigma_N == pytest.approx(-2.0, abs=0.008) and abs(first + 2.0) > 0.01 and b.sigma_N == first


PSI = 0.006894757293168  # in MPa


@pytest.mark.parametrize(
    ("units", "factors"),
    [
        (("mm", "MPa", "mm", "N/mm^2", "N/mm3"), (1.0, 1.0, 1.0, 1.0, 1.0)),
        (("m", "Pa", "cm", "kPa", "MPa/m"), (1e-3, 1e6, 0.1, 1e3, 1e3)),
        (("in", "psi", "\N{MICRO SIGN}m", "ksi", "kN/m3"), (1 / 25.4, 1 / PSI, 1e3, 1e-3 / PSI, 1e6)),
    ],
)
def test_units_are_converted(units: tuple[str, ...], factors: tuple[float, ...], tmp_path: Path) -> None:
    """Numbers are converted from the units of their column to mm and MPa, or to those that are asked for."""
    k_N = 5.0
    text = "slip [{}],tau [{}],dilation [{}],sigma_N [{}],k_N [{}]\n".format(*units)
    for row in zip(SLIP, TAU, DILATION, -1.0 - k_N * DILATION, np.full(7, k_N), strict=True):
        text += ",".join(f"{one * factor:.9g}" for one, factor in zip(row, factors, strict=True)) + "\n"
    path = write(tmp_path, text)
    [test] = read_tests(path)
    same(test, digits=1e-6)
    assert test.k_N == pytest.approx(k_N, rel=1e-6) and test.lines == tuple(range(2, 9))
    [test] = read_tests(path, target=("m", "kPa"))
    assert test.units == {"length": "m", "stress": "kPa"} and test.k_N == pytest.approx(1e6 * k_N, rel=1e-6)
    assert test.slip == pytest.approx(1e-3 * SLIP, rel=1e-6)
    assert test.tau == pytest.approx(1e3 * TAU, rel=1e-6)
    # numbers without units have those of the target
    [test] = read_tests(write(tmp_path, HEADER + ROWS), target=("in", "psi"))
    same(test)
    assert test.units == {"length": "in", "stress": "psi"}


def test_headers(tmp_path: Path) -> None:
    """A unit follows a name in brackets, after a blank, `in` or a slash; # is a comment or part of a name."""
    for text in ("tau [N/mm2]", "tau in N/mm2", "tau / N/mm2", "tau N/mm2"):
        table = read_table(write(tmp_path, f"# box\nTest #;{text};x\n1;2;3 # row\n"), "numbers")
        assert (table.names, table.units) == (["Test #", "tau", "x"], ["", "N/mm2", ""]), text
        assert table.cells.values.tolist() == [["1", "2", "3"]]


# --- what is doubted ----------------------------------------------------------------------------------------


def test_unusual_sizes(tmp_path: Path) -> None:
    """Stresses of a gigapascal give a warning."""
    with pytest.warns(asperity.ModelWarning, match="the largest stress is 500 MPa, which is unusual"):
        read_tests(write(tmp_path, UNITS + ROWS.replace(",-1\n", ",-500\n")))


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
    ],
)
def test_decimal_marks(text: str, decimal: str | None, slip: float, tau: float, tmp_path: Path) -> None:
    """1,234 is read by what its column or all others show; otherwise the file is refused."""
    mark = next(one for one in ";\t," if one in text)
    path = write(tmp_path, f"slip{mark}tau{mark}sigma_N\n" + text + text.splitlines()[-1])
    table = read_table(path, "numbers")
    if slip > 0.0:
        assert table.numbers([0, 1], ["slip", "tau"], (), decimal)[1].tolist() == [slip, tau]
        return
    with pytest.raises(ValueError, match=r"line 2, column slip: 1.000 may be .* or --decimal comma or point"):
        table.numbers([0, 1], ["slip", "tau"])


# --- what is refused ----------------------------------------------------------------------------------------

BAD: list[tuple[str, dict[str, Any], str]] = [
    # columns
    ("slip,shear,sigma_N\n1,2,-1\n", {}, "record.csv: line 1: columns slip, shear, sigma_N: expected tau, t"),
    ("slip,slip,tau,sigma_N\n", {}, "line 1: column slip is there twice"),
    (LINE, {"columns": {"foo": "bar"}}, "columns: foo: expected one of slip, tau"),
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
    # signs and sizes
    (HEADER + ROWS + "0.9,1,0.1,1\n", {}, "line 9, column sigma_N: 1: expected compression in all rows"),
    (HEADER + seven(lambda i: f"{i},{-i},{0.1 * i},-9"), {}, "the work of tau along the slip is -24.5 < 0: "),
    (HEADER + seven(lambda i: f"0.{i},{500 + i},0.0{i},-1"), {}, "tau: 507 at the end where |sigma_N| is 1:"),
    (HEADER + seven(lambda i: f"{i},1,0,-1"), {}, "column tau is 1 in all rows: expected values that change"),
    (HEADER + seven(lambda i: f"0.{i},{i},{5 + 0.01 * i},-1"), {}, "line 2, column dilation: 5.01 at slip 0"),
    (SHORT + seven(lambda i: f"{7.2 + 0.1 * i},{i},-1"), {}, "line 2, column slip: 7.3 in the first row: ex"),
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
    other = write(tmp_path, UNITS + ROWS, "other.csv")
    empty = tmp_path / "empty"
    empty.mkdir()
    old = tmp_path / "old.xls"
    old.write_bytes(b"\xd0\xcf\x11\xe0\0\0\0")
    for files, error, message in (
        ([tmp_path / "none.csv"], FileNotFoundError, "none.csv"),
        ([empty], ValueError, r"empty: expected files that end in \.csv"),
        ([old], ValueError, "old.xls is no text: expected a CSV file with slip, tau, sigma_N"),
        ([path, tmp_path / "." / "record.csv"], ValueError, "record.csv: given twice: expected each file on"),
        ([other, path], ValueError, r"record.csv: no units in the header: expected units in .*other"),
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
