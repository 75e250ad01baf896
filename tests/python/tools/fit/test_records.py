"""Files of shear-box tests: what laboratories export is read."""

from __future__ import annotations

import re
from pathlib import Path

import asperity
import numpy as np
import pytest
from asperity.tools.fit import ShearTest, read_tests
from asperity.tools.fit.closure_test import ClosureTest
from asperity.tools.fit.shear_test import cycles
from asperity.tools.tables import read_table
from support_records import DILATION, HEADER, ROWS, SHORT, SLIP, TAU, UNITS, same, seven, warned, write

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
    "blanks, powers": (
        "utf-8",
        "slip tau dilation sigma_N\n"
        + seven(lambda i: f"{0.1 * i:e} {min(i, 4) * 0.2:e} {0.02 * i:e} -1e0".replace(".", ",")),
    ),
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
    "abbreviations": (
        "utf-8",
        "Horiz. disp. [mm],Horiz. stress [MPa],Vert. disp. [mm],Vert. stress [MPa]\n" + ROWS,
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


@pytest.mark.parametrize(
    ("heading", "column"), [("Shear stress (kPa)", "peak"), ("Shear load (N)", "peak_force")]
)
def test_strengths_named_as_curves(heading: str, column: str, tmp_path: Path) -> None:
    """Shear stresses or forces without slips ask for one, and for the option by which they are strengths."""
    path = write(tmp_path, f"Normal stress (kPa),{heading}\n50,45\n100,75\n200,140\n")
    area = "1000" if column == "peak_force" else None
    with pytest.raises(ValueError, match="expected slip, too") as caught:
        read_tests(path, area=area)
    assert f'--columns {column}="{heading}" for a row per test' in str(caught.value)
    found = read_tests(path, area=area, columns={column: heading})
    assert [one.peak for one in found] == pytest.approx([0.045, 0.075, 0.14])


@pytest.mark.parametrize(("pressure", "closure"), [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_closure_tests_of_either_sign(pressure: float, closure: float, tmp_path: Path) -> None:
    """Loading and unloading are told apart; pressure and closure count positive, from the first row."""
    rows = [(0.5, 0.02), (1.0, 0.05), (2.0, 0.08), (4.0, 0.1), (2.0, 0.09), (0.5, 0.06)]
    text = "".join(f"{pressure * p},{closure * c}\n" for p, c in rows)
    found, caught = warned(write(tmp_path, "Normal stress [MPa],Joint closure [mm]\n" + text))
    [test] = found
    assert ["read as opening positive" in warning for warning in caught] == [True] * (closure < 0.0)
    assert test.pressure == pytest.approx([p for p, _ in rows])
    assert test.closure == pytest.approx([c - 0.02 for _, c in rows])
    assert test.loading.tolist() == [0, 1, 2, 3] and test.unloading.tolist() == [4, 5]


@pytest.mark.parametrize(
    ("column", "headings"),
    [
        (
            "peak",
            "tau_p; \u03c4_max; Max. shear stress; R\u00e9sistance_au_pic; Scherfestigkeit"
            "; Max. Scherspannung / Peak shear stress",
        ),
        (
            "residual",
            "\u03c4r; tau_res; Restscherfestigkeit; Contrainte r\u00e9siduelle; Residual \u03c4",
        ),
        ("sigma_N", "Normal stress at peak; Residual normal stress; \u03c3n; Confining pressure"),
        (
            "",
            "Peak friction angle; Dilation angle; Normalized shear stress; Friction ratio; sigma_ci"
            "; \u03c4/\u03c3n; tau_p/sigma_n [-]; Shear / normal stress; Peak shear stress / JCS"
            "; \u526a\u5e94\u529b/\u6b63\u5e94\u529b",
        ),
    ],
)
def test_headings_of_strengths(column: str, headings: str, tmp_path: Path) -> None:
    """Columns of a table are known by their names; other quantities with like names are not used."""
    numbers = {"sigma_N": [1, 2, 3], "peak": [1.2, 2.2, 3.1], "residual": [0.6, 1.1, 1.7], "": [7, 8, 9]}
    for heading in headings.split("; "):
        names = {name: heading if name == column else name or "depth" for name in numbers}
        rows = [";".join(map(str, row)) for row in zip(*numbers.values(), strict=True)]
        path = write(tmp_path, "\n".join([";".join(names.values()), *rows, ""]))
        with pytest.warns(asperity.ModelWarning, match=f"columns not used: {re.escape(names[''])}$"):
            tests = read_tests(path)
        for name in ("peak", "residual"):
            assert [getattr(test, name) for test in tests] == numbers[name], heading
        assert [-test.sigma_N for test in tests] == numbers["sigma_N"], heading


@pytest.mark.parametrize(
    ("heading", "column"),
    [
        ("Displacement at peak stress", "peak_slip"),
        ("Verschiebung bei max. Scherspannung", "peak_slip"),
        ("Shear displacement at residual shear stress", "slip"),
        ("Dilation at peak shear stress", ""),
        ("Barton peak strength", ""),
        ("Predicted residual strength", ""),
    ],
)
def test_quantities_at_a_strength(heading: str, column: str, tmp_path: Path) -> None:
    """A displacement at the peak is no peak, nor is the strength of a model."""
    path = write(tmp_path, f"sigma_N;Peak strength;{heading}\n1;1.2;0.5\n2;2.2;0.6\n3;3.1;0.7\n")
    found, caught = warned(path)
    assert [one.peak for one in found] == [1.2, 2.2, 3.1]
    assert [getattr(one, column or "slip") for one in found] == pytest.approx(
        [0.5, 0.6, 0.7] if column else [np.nan] * 3, nan_ok=True
    )
    assert [one.endswith(f"not used: {heading}") for one in caught] == [True] * (not column)


STATISTICS = (
    "Mean; AVERAGE; avg.; Median; Std. dev.; St.Dev; Standard deviation (n = 3); s.d.; CoV [%]; c.o.v.; min"
    "; Max.; Mittelwert; Std.-Abw.; Moyenne; \u00c9cart-type; Media; Desviaci\u00f3n est\u00e1ndar; mean of 3"
    "; Mean 0.2 MPa; Coefficient of variation; Sum; \u5e73\u5747\u503c"
    "; Std. deviation; Standardabw.; Dev. std.; Standard dev.; Mean \u00b1 SD; Arithmetic mean; Means"
    "; Durchschnitt; Mittelwerte; MW; Var.-Koeff.; Moy.; Valeur moyenne; Valore medio; Desv. est."
    "; Coeff. of variation; SEM; Char. value"
)


@pytest.mark.parametrize("word", STATISTICS.split("; "))
def test_rows_of_statistics(word: str, tmp_path: Path) -> None:
    """A mean or deviation below the specimens of a table is left out, and named."""
    rows = "T1;1;1.2\nSD 1;2;2.2\nMean joint;3;3.1\n"
    found, caught = warned(write(tmp_path, f"Specimen;sigma_N;peak\n{rows}{word};2;2.2\n"))
    assert [one.peak for one in found] == [1.2, 2.2, 3.1]
    assert f"record.csv: rows of statistics left out, which are no specimens: line 5: {word}" in "".join(
        caught
    )


def test_words_of_statistics_beside_a_specimen(tmp_path: Path) -> None:
    """A word in another column than the first one describes a specimen, as a roughness does in Spanish."""
    rows = "1;1.2;baja\n2;2.2;media\n3;3.1;max\n"
    found, caught = warned(write(tmp_path, f"sigma_N;peak;Rugosidad\n{rows}"))
    assert [one.peak for one in found] == [1.2, 2.2, 3.1]
    assert not any("left out" in one for one in caught)


def test_words_of_statistics_where_specimens_have_their_names(tmp_path: Path) -> None:
    """A word of statistics in place of a name counts behind a rock, too; beside a name it is a class."""
    rows = "mittel;T1;1;1.2\nmin;T2;2;2.2\nmittel;T3;3;3.1\nGranite;Mean;2;2.2\nMean;;2;2.2\n"
    found, caught = warned(write(tmp_path, f"Class;Specimen;sigma_N;peak\n{rows}"))
    assert [one.peak for one in found] == [1.2, 2.2, 3.1]
    assert any(one.endswith("no specimens: line 5: Mean, line 6: Mean") for one in caught)


def test_headings_of_curves(tmp_path: Path) -> None:
    """A dilation angle is no dilation, an opening is one, and a closure has its names in other languages."""
    text = (HEADER + ROWS).replace("dilation", "Opening").replace(",-1\n", ",-1,30\n")
    path = write(tmp_path, text.replace("sigma_N\n", "sigma_N,Dilation angle\n"))
    same(warned(path)[0][0])
    for name in ("Normal closure", "Joint_closure_dn", "Kluftschlie\u00dfung", "Fermeture du joint"):
        rows = "".join(f"{i},{0.1 * i:g}\n" for i in range(1, 8))
        [test] = read_tests(write(tmp_path, f"sigma_N,{name}\n{rows}"))
        assert isinstance(test, ClosureTest) and test.size == pytest.approx(0.6), name


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


@pytest.mark.parametrize("name", ["test", "Specimen"])
def test_names_in_first_rows_and_counters(name: str, tmp_path: Path) -> None:
    """A name stands for the empty cells below it; a column with another entry in each row names no tests."""
    lines = (ROWS + ROWS.replace(",-1\n", ",-2\n")).splitlines()
    entries = {0: "a", 7: "b"}
    text = "".join(f"{entries.get(i, '')},{line}\n" for i, line in enumerate(lines))
    found, caught = warned(write(tmp_path, f"{name},{HEADER}{text}"))
    assert [(one.name[-6:], one.sigma_N) for one in found] == [("test a", -1.0), ("test b", -2.0)]
    assert not caught
    for start in (0, 7):  # counted through the file, or from 1 on in each test
        text = "".join(f"{i % (start or 99) + 1},{line}\n" for i, line in enumerate(lines))
        found, caught = warned(write(tmp_path, f"{name},{HEADER}{text}"))
        assert [one.sigma_N for one in found] == [-1.0, -2.0]
        assert f"column {name}: another entry in each row: read as a counter of the rows" in caught[0]


@pytest.mark.parametrize(
    ("rows", "kept"),
    [
        # the box is unloaded: the slip returns by that of a spring, or stands still
        ("0.69,0.5,0.14,-1\n0.67,0.1,0.14,-1\n0.66,0,0.14,-1\n", 7),
        ("0.7,0.4,0.14,-1\n0.7,0,0.14,-1\n", 7),
        # a dwell in which the traction relaxes, and strokes back, whose traction is reversed
        ("0.7,0.75,0.14,-1\n0.7,0.7,0.14,-1\n", 9),
        ("0.68,0.2,0.14,-1\n0.66,-0.6,0.14,-1\n", 9),
        ("0.6,0.1,0.14,-1\n0.3,-0.1,0.08,-1\n0,-0.8,0,-1\n", 10),
        ("0.75,0.06,0.14,-1\n0.74,-0.02,0.14,-1\n", 9),
    ],
)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_unloading_at_the_end(rows: str, kept: int, side: float, tmp_path: Path) -> None:
    """Rows of the unloading after the largest slip are left out, with a warning."""
    lines = [[float(cell) for cell in line.split(",")] for line in (ROWS + rows).splitlines()]
    text = "".join(f"{side * u},{side * t},{d},{p}\n" for u, t, d, p in lines)
    [test], caught = warned(write(tmp_path, HEADER + text))
    assert test.slip.size == kept
    told = f"unloading at the end left out: {len(lines) - kept} (from line 9 on)"
    assert [told in one for one in caught] == [True] * (kept == 7)


@pytest.mark.parametrize(
    ("place", "loop", "left_out"),
    [
        # loops that show a stiffness, before and after the peak, down to no traction or to a part of it
        (2, "0.18,0.2,0.02,-1\n0.17,0,0.02,-1\n0.19,0.3,0.02,-1\n0.2,0.4,0.02,-1\n", "line 4 to 7"),
        (6, "0.55,0.3,0.1,-1\n0.5,0,0.1,-1\n0.55,0.3,0.1,-1\n0.6,0.8,0.1,-1\n", "line 8 to 11"),
        (6, "0.57,0.6,0.1,-1\n0.6,0.8,0.1,-1\n", "line 8 to 9"),
        # a gauge that falls by its noise or is misread, a traction that falls alone, and a cycle
        (6, "0.595,0.79,0.1,-1\n", ""),
        (6, "0.1,0.79,0.1,-1\n", ""),
        (6, "0.65,0.2,0.1,-1\n", ""),
        (6, "0.5,0.1,0.1,-1\n0.3,-0.8,0.1,-1\n0.5,0.7,0.1,-1\n", ""),
    ],
)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_unloading_and_reloading(place: int, loop: str, left_out: str, side: float, tmp_path: Path) -> None:
    """A loop of unloading and reloading belongs to the stroke, which only a reversed traction ends."""
    rows = ROWS.splitlines()
    lines = [*rows[:place], *loop.splitlines(), *rows[place:]]
    cells = [[float(cell) for cell in line.split(",")] for line in lines]
    [test], caught = warned(
        write(tmp_path, HEADER + "".join(f"{side * u},{side * t},{d},{p}\n" for u, t, d, p in cells))
    )
    assert test.slip.size == len(rows if left_out else lines)
    assert [f"({left_out})" in one for one in caught] == [True] * bool(left_out)
    assert not (left_out and cycles([test]))


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
