"""Tables of laboratories: marks, headers, units, workbooks, folders; drawn files lose no value."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.tools.fit import read_tests
from asperity.tools.tables import Table, read_table, read_tables
from asperity.tools.units import area_of, header, size

openpyxl = pytest.importorskip("openpyxl")


def table_of(folder: Path, text: str, name: str = "table.csv", encoding: str = "utf-8") -> Table:
    """Table of a file with a text."""
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return read_table(path, "numbers")


# --- headers and units --------------------------------------------------------------------------------------

LAB = ["slip", "tau", "sigma_N"]
HEADED = "0.1,0.5,-1\n0.2,0.6,-1\n"


@pytest.mark.parametrize(
    ("text", "names", "units"),
    [
        ("# slip [mm],tau [MPa],sigma_N [MPa]\n" + HEADED, LAB, ["mm", "MPa", "MPa"]),
        ("# made in 2024\n#slip, tau, sigma_N\n" + HEADED, LAB, [""] * 3),
        ("# slip,tau,sigma_N\n# mm,kPa,MPa\n" + HEADED, LAB, ["mm", "kPa", "MPa"]),
        ("% slip tau sigma_N\n" + HEADED.replace(",", " "), LAB, [""] * 3),
        # a plain header is one, also above a comment of as many words
        ("slip tau sigma_N\n# of box one\n" + HEADED.replace(",", " "), LAB, [""] * 3),
        ("Lab A,,\n# slip,tau,sigma_N\n" + HEADED, LAB, [""] * 3),
        ("slip_um,vs_MPA,Normal Kpa\n" + HEADED, ["slip", "vs", "Normal"], ["um", "MPA", "Kpa"]),
        ("u_mm,tau_kg_cm2,sn (kg/cm2)\n" + HEADED, ["u", "tau", "sn"], ["mm", "kg/cm2", "kg/cm2"]),
        ("# slip [mm],tau [MPa],sigma_N [MPa]\n# ----\n# made by hand\n" + HEADED, LAB, ["mm", "MPa", "MPa"]),
        ("slip/mm,tau / MPa,sigma_N - MPa\n" + HEADED, LAB, ["mm", "MPa", "MPa"]),
        ("slip (in mm),tau: kPa,sigma_N [N/mm^2]\n" + HEADED, LAB, ["mm", "kPa", "N/mm^2"]),
        ("slip_in,tau tsf,sigma_N (ksf)\n" + HEADED, LAB, ["in", "tsf", "ksf"]),
        ("slip/ft,tau / tons/ft2,sigma_N_kips/ft2\n" + HEADED, LAB, ["ft", "tons/ft2", "kips/ft2"]),
        # names of quantities are no units
        ("s_N,k_n,sigma_N\n" + HEADED, ["s_N", "k_n", "sigma_N"], ["", "", ""]),
        ("| slip [mm] | tau [MPa] | sigma_N [MPa] |\n|---|--:|:-:|\n| 0.1 | 0.5 | -1 |\n| 0.2 | 0.6 | -1 |\n",
         LAB, ["mm", "MPa", "MPa"]),
        (" slip | tau | sigma_N\n------+-----+--------\n 0,1 | 0,5 | -1\n 0,2 | 0,6 | -1\n",
         LAB, [""] * 3),
    ],
)  # fmt: skip
def test_headers(text: str, names: list[str], units: list[str], tmp_path: Path) -> None:
    """The header may be a comment, units suffixes of any case, and bars separate cells."""
    table = table_of(tmp_path, text)
    assert (table.names, table.units) == (names, units)
    assert table.numbers(range(3), names).tolist() == [[0.1, 0.5, -1.0], [0.2, 0.6, -1.0]]


KSF = 1000.0 * 6894.757293168 / 144.0
"""A thousand pounds per square foot, in pascals."""


def test_units() -> None:
    """Case does not matter, masses are weights, tons over feet are short, what is misspelt is refused."""
    known = {
        "stress": {
            "Mpa": 1e6, "KPa": 1e3, "mpa": 1e6, "kg/cm\u00b2": 98066.5, "kgf/cm2": 98066.5, "t/m2": 9806.65,
            "KN/m^2": 1e3, "N mm-2": 1e6, "PSI": 6894.757293168, "kg/sq.cm": 98066.5,
            **dict.fromkeys(("tsf", "t/ft2", "Tons/ft\u00b2", "tonf/sq ft", "tons per sq. ft"), 2.0 * KSF),
            **dict.fromkeys(("ksf", "kip/ft2", "kips/ft^2"), KSF), "ton/in2": 288.0 * KSF,
        },
        "length": {"MM": 1e-3, "\u00b5m": 1e-6},
        "stiffness": {"MPa/mm": 1e9, "N/mm\u00b3": 1e9},
        "force": {"kn": 1e3},
        "area": {"cm2": 1e-4},
    }  # fmt: skip
    every = [(kind, *unit) for kind, units in known.items() for unit in units.items()]
    for kind, text, expected in every:
        assert size(kind, text) == pytest.approx(expected, rel=1e-12), text
    for kind, text in (
        ("stress", "mPa"),
        ("stress", "kN"),
        ("length", "Mm"),
        ("length", "MPa"),
        ("length", "0mm"),
        ("area", "mm"),
    ):
        with pytest.raises(ValueError, match=rf"x \[{text}\]: expected "):
            size(kind, text, "x ")
    assert header("Peak shear stress (MPa)") == ("Peak shear stress", "MPa")


def test_headings_of_the_file(tmp_path: Path) -> None:
    """A column is found by its heading as it stands in the file, and by its name without unit."""
    rows = "".join(f"{i},{40 * i},0.{i},1.0,{0.2 * min(i, 3):.4f}\n" for i in range(1, 8))
    text = "time_s,vdcdt_um,mu,effns_mpa,vstress_mpa\n" + rows
    table = table_of(tmp_path, text)
    assert table.places("VDCDT_um") == table.places("vdcdt") == [1] and table.places("dcdt") == []
    columns = {"slip": "vdcdt_um", "tau": "vstress_mpa", "sigma_N": "effns_mpa"}
    with pytest.warns(ModelWarning, match="columns not used: time_s, mu"):
        [test] = read_tests(tmp_path / "table.csv", columns=columns)
    assert test.slip == pytest.approx(0.04 * np.arange(1, 8)) and test.units == {
        "length": "mm",
        "stress": "MPa",
    }
    assert test.tau.max() == pytest.approx(0.6)


def test_numbers_above_the_header(tmp_path: Path) -> None:
    """Rows of numbers above a header are not lost."""
    rows = "".join(f"{i},{i}.5,-1\n" for i in range(9))
    with pytest.raises(ValueError, match="line 2: numbers above those of the table: expected one table"):
        table_of(tmp_path, "slip,tau,sigma_N\n1,2,-1\n2,2,-1\nslip,tau,sigma_N\n" + rows)


# --- workbooks, folders, areas ------------------------------------------------------------------------------


def test_workbook(tmp_path: Path) -> None:
    """All sheets with numbers are read, or the one that is named; other sheets are named."""
    book = openpyxl.Workbook()
    first = book.active
    first.title = "Test A"
    second, notes = book.create_sheet("B"), book.create_sheet("Notes")
    for sheet, factor in ((first, 1.0), (second, 2.0)):
        sheet.append(["Shear stress tests"])
        sheet.append([None])
        sheet.append(["slip [mm]", "tau [MPa]", "sigma_N [MPa]"])
        for i in range(1, 8):
            sheet.append([30.125 * i, factor * min(i, 4), "-1,5"])
    notes["A1"] = "by hand"
    path = tmp_path / "book.xlsx"
    book.save(path)
    with pytest.warns(ModelWarning, match="sheets without rows of numbers, not read: Notes"):
        tests = read_tests(path)
    assert [test.name for test in tests] == [f"{path}:Test A", f"{path}:B"]
    for test, factor in zip(tests, (1.0, 2.0), strict=True):
        assert test.slip.tolist() == [30.125 * i for i in range(1, 8)] and test.sigma_N == -1.5
        assert test.tau.max() == 4.0 * factor and test.lines == tuple(range(4, 11))
    [only] = read_tests(f"{path}:B")
    assert only.tau.max() == 8.0
    second.sheet_state = "hidden"
    book.save(path)
    with pytest.warns(ModelWarning, match=r"hidden sheets, not read: B; book.xlsx:B reads that one"):
        [only] = read_tests(path)
    assert only.name == f"{path}:Test A" and read_tests(f"{path}:B")[0].tau.max() == 8.0
    second.sheet_state = "visible"
    for line in (1, 5, 7):
        second.row_dimensions[line].hidden = True
    book.save(path)
    with pytest.warns(ModelWarning, match=r"book.xlsx:B: hidden rows are read, too: 2 \(line 5, 7\)"):
        assert read_tests(f"{path}:B")[0].slip.size == 7
    second["B5"] = "=A5*2"
    book.save(path)
    for name, message in ((f"{path}:C", "sheet C: expected one of Test A, B, Notes"),
                          (path, "B: line 5, cell 2: =A5.2: expected the value of the formula")):  # fmt: skip
        with pytest.raises(ValueError, match=message):
            read_tests(name)
    path.write_bytes(b"PK no workbook")
    with pytest.raises(ValueError, match=r"expected a workbook, \.xlsx"):
        read_tests(path)


def test_folder(tmp_path: Path) -> None:
    """A folder stands for its tables in the order of their names; other files are named."""
    for name in ("b.csv", "a.txt"):
        (tmp_path / name).write_text(f"{name[0]},y\n1,2\n2,3\n", encoding="utf-8")
    (tmp_path / "photo.jpg").write_bytes(b"\xff")
    (tmp_path / "older").mkdir()
    (tmp_path / "readme.txt").write_text("Tests of hole 3.\nAt 12 mm the box stops.\n", encoding="utf-8")
    with pytest.warns(ModelWarning, match="not read: older, photo.jpg, readme.txt$"):
        tables = read_tables([tmp_path], "numbers")
    assert [table.names[0] for table in tables] == ["a", "b"]


def test_areas() -> None:
    """An area is constant, or that of a box whose halves overlap less and less."""
    slip = np.array([0.0, 10.0, -10.0])
    assert area_of("3600")(slip).tolist() == [3600.0] * 3
    assert area_of("60,50")(slip).tolist() == [3000.0, 2500.0, 2500.0]
    with pytest.raises(ValueError, match="--area 60,50: the slip reaches 60: expected less than L = 60"):
        area_of("60,50")(np.array([60.0]))
    for text in ("", "0", "nan", "60,50,2", "60x50", "-1,2"):
        with pytest.raises(ValueError, match=f"--area {text}: expected A, an area > 0, or L,B"):
            area_of(text)


# --- drawn files --------------------------------------------------------------------------------------------


def written(values: np.ndarray, rng: np.random.Generator) -> tuple[list[str], int, str]:
    """Lines of a file of numbers in a drawn style, the number of lines above the rows, and the separator."""
    separator = rng.choice([";", "\t", ",", "|", " "])
    lines, columns = [], []
    for column in values.T:
        digits = int(rng.integers(1, 6))
        mark = "," if separator in ";\t|" and rng.random() < 0.5 else "."
        grouping = "," if separator in ";\t" and rng.random() < 0.2 else ""
        texts = [f"{number:{grouping}.{digits}f}" for number in column]
        columns.append([text.translate(str.maketrans(".,", ",.")) if mark == "," else text for text in texts])
    names = [f"c{i}" + rng.choice([" [mm]", "_mm", " (MPa)", ""]) for i in range(values.shape[1])]
    names = [re.sub(" ", "", name) for name in names] if separator == " " else names
    quote = '"' if separator in ",;" and rng.random() < 0.3 else ""
    head = [rng.choice(["", "", "# ", "#"]) + separator.join(names)]
    if rng.random() < 0.3:
        head = ["# " + str(rng.choice(["a box", "made by hand", "2024-03-12"])), *head]
    for row in zip(*columns, strict=True):
        lines.append(separator.join(quote + cell + quote for cell in row))
    return [*head, *lines], len(head), str(separator)


def mutated(lines: list[str], at: int, rng: np.random.Generator) -> list[str]:
    """Lines with one of them damaged."""
    line = lines[at]
    place = int(rng.integers(0, len(line) + 1))
    signs = ";,.|#\"'- x0e\t%/[(\u2013\x00\ufeff\n"
    kinds: list[Callable[[], list[str]]] = [
        lambda: [line[:place] + line[place + 1 :]],
        lambda: [line[:place] + str(rng.choice([*signs])) + line[place:]],
        lambda: [line[:place]],
        lambda: [line, line],
        lambda: [line, "", line],
        lambda: [line.replace(".", ",")],
        lambda: [line.replace(",", ";")],
        lambda: ["c0;c1;c2", line],
        lambda: [line + " # note"],
        lambda: ["nan" + line[1:]],
    ]
    new = kinds[int(rng.integers(len(kinds)))]()
    return [*lines[:at], *new, *lines[at + 1 :]]


@pytest.mark.parametrize(("seed", "count"), [(1, 150), pytest.param(2, 1000, marks=pytest.mark.long)])
def test_drawn_tables(seed: int, count: int, tmp_path: Path) -> None:
    """Of drawn files, whole or damaged in a line, all other rows have their values, or the file is refused.

    Rows are counted by the lines that begin with a number, values are those that were written.
    """
    rng, read = np.random.default_rng(seed), 0
    for number in range(count):
        shape = int(rng.integers(3, 30)), int(rng.integers(2, 6))
        values = rng.normal(size=shape) * 10.0 ** rng.integers(-1, 6, shape[1])
        lines, above, _ = written(values, rng)
        damaged = number % 3 > 0
        at = int(rng.integers(0, len(lines)))
        text = "\n".join(mutated(lines, at, rng) if damaged else lines) + "\n"
        try:
            table = table_of(tmp_path, text)
            names = [f"c{i}" for i in range(len(table.cells.columns))]
            numbers = table.numbers(range(len(names)), names, names)
        except ValueError as error:
            assert damaged or "may be a decimal number" in str(error), (number, text, error)
            continue
        read += 1
        rows = text.splitlines()
        below = [line for line in rows if re.match(r'[-+"]*\d', line)]
        assert len(numbers) >= len(below), (number, text)
        for i, line in enumerate(lines[above:]):
            if damaged and i + above == at:
                continue
            places = [j for j, row in enumerate(rows) if row == line]
            kept = [table.lines.index(j + 1) for j in places if j + 1 in table.lines]
            assert kept, (number, text, line)
            exact = np.array([float(_plain(cell)) for cell in _cells(line, table.separator)])
            for j in kept:
                assert numbers[j].shape == exact.shape, (number, text, line)
                assert (abs(numbers[j] - exact) <= 1e-12 * abs(exact)).all(), (number, text, line)
            assert exact.shape == values[i].shape and (abs(exact - values[i]) <= 0.06).all(), (number, text)
    assert read > count // 2


def _cells(line: str, separator: str) -> list[str]:
    """Cells of a line that `written` made."""
    quoted = re.findall(r'"([^"]*)"', line)
    return quoted or line.split(separator or None)


def _plain(cell: str) -> str:
    """A number of `written`, whose last mark is the decimal one."""
    whole, _mark, part = re.fullmatch(r"(.*)([.,])(\d+)", cell.strip()).groups()  # type: ignore[union-attr]
    return re.sub("[.,]", "", whole) + "." + part
