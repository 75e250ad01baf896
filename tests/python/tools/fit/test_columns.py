"""Files of shear tests in other forms: wide brackets, encodings, rows, no header, sections."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.tools.fit import ShearTest, read_tests
from asperity.tools.tables import read_tables


def curve(bond: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Slips and shear tractions of a test."""
    slip = 0.05 * np.arange(41)
    tau = np.minimum(5.0 * slip, 0.6)
    return slip, np.where(slip > 1.0, 0.0, tau) if bond else tau


def is_curve(path: Path, **options: Any) -> None:
    """The file has the test of `curve` under 1 MPa."""
    [test] = read_tests(path, **options)
    assert isinstance(test, ShearTest)
    slip, tau = curve()
    assert test.slip == pytest.approx(slip) and test.tau == pytest.approx(tau) and test.sigma_N == -1.0


WIDE = str.maketrans({chr(code): chr(code + 0xFEE0) for code in range(0x21, 0x7F)})
SLIP, TAU, PRESSURE = "\u526a\u5207\u4f4d\u79fb", "\u526a\u5e94\u529b", "\u6b63\u5e94\u529b"
NAMES, UNITS = (SLIP, TAU, PRESSURE), ("[mm]", "(MPa)", "[MPa]")
WIDE_HEADS = {
    "um, kPa": (f"{SLIP}(\u03bcm),{TAU}(kPa),{PRESSURE}(MPa)".translate(WIDE), 1e3, 1e3),
    "mm, MPa": (",".join(f"{a}{b.translate(WIDE)}" for a, b in zip(NAMES, UNITS, strict=True)), 1.0, 1.0),
    "in English": ("slip(um),tau(MPa),sigma_N(MPa)".translate(WIDE | {ord(","): ","}), 1e3, 1.0),
}
"""Headings in wide brackets and commas, and the factors of slip and tau."""


@pytest.mark.parametrize("encoding", ["utf-8", "gb18030", "utf-16"])
@pytest.mark.parametrize("head", WIDE_HEADS.values(), ids=WIDE_HEADS)
def test_wide_brackets(head: tuple[str, float, float], encoding: str, tmp_path: Path) -> None:
    """Units in brackets as wide as a Chinese character count; an encoding that is not UTF-8 is named."""
    text, length, stress = head
    slip, tau = curve()
    lines = [f"{length * s:.4f},{stress * t:.4f},1" for s, t in zip(slip, tau, strict=True)]
    path = tmp_path / "test.csv"
    path.write_bytes("\n".join([text, *lines, ""]).encode(encoding))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        is_curve(path)
    name = {"utf-8": "", "gb18030": "GB 18030", "utf-16": "UTF-16"}[encoding]
    assert [*(f"test.csv is not UTF-8: read as {name}" in str(told.message) for told in caught)] == [
        True
    ] * bool(name)


def test_words_of_code_pages(tmp_path: Path) -> None:
    """Names in a code page of Windows are not taken for Chinese ones."""
    path = tmp_path / "test.csv"
    for word in (
        "Gr\u00f6\u00dfe",
        "M\u00fc\u00dfte \u00b5",
        "d\u00e9plac\u00e9",
        "\u00d6l",
        "\u00c4u\u00dferes",
    ):
        path.write_bytes(f"slip [\u00b5m],tau [N/mm\u00b2],{word}\n".encode("cp1252") + b"1,2,3\n2,3,4\n")
        with pytest.warns(ModelWarning, match="read as Windows-1252"):
            [table] = read_tables([path], "numbers")
        assert table.names[2] == word


@pytest.mark.parametrize("mark", [" ", ",", ";", "\t"])
def test_rows_in_place_of_columns(mark: str, tmp_path: Path) -> None:
    """Lines with a name and then numbers are columns, with units in brackets or in a cell of their own."""
    slip, tau = curve()
    path = tmp_path / "test.txt"
    for units in (["", ""], [" [mm]", " [MPa]"], *([[f"{mark}mm", f"{mark}MPa"]] if mark != " " else [])):
        names = [f"slip{units[0]}", f"tau{units[1]}", f"sigma_N{units[1]}"]
        rows = [[f"{1.0 * number:.4f}" for number in row] for row in (slip, tau, -np.ones(slip.size))]
        path.write_text("\n".join(mark.join([name, *row]) for name, row in zip(names, rows, strict=True)))
        is_curve(path)
    short = [mark.join([name, *row]) for name, row in zip(names, rows, strict=True)]
    path.write_text("\n".join([short[0], short[1].rpartition(mark)[0], short[2]]))
    with pytest.raises(ValueError, match="40 values: expected 41, as slip"):
        read_tests(path)


def test_columns_without_a_header(tmp_path: Path) -> None:
    """Columns go by place if the first one alone grows, or as --columns says; other files are refused."""
    slip, tau = curve()
    path = tmp_path / "test.txt"
    np.savetxt(path, np.column_stack([slip, tau, -np.ones(slip.size)]), fmt="%.4f")
    with pytest.warns(ModelWarning, match="no header: the columns are read as slip, tau, sigma_N"):
        is_curve(path)
    np.savetxt(path, np.column_stack([slip, tau]), fmt="%.4f")
    with pytest.warns(ModelWarning, match="no header: the columns are read as slip, tau"):
        is_curve(path, sigma_N=-1.0)
    np.savetxt(path, np.column_stack([tau, slip]), fmt="%.4f")
    with pytest.raises(ValueError, match="the first column alone of slip, tau, sigma_N grows"):
        read_tests(path, sigma_N=-1.0)
    is_curve(path, sigma_N=-1.0, columns={"slip": "2", "tau": "1"})
    np.savetxt(path, np.column_stack([10.0 * slip, slip, tau]), fmt="%.4f")  # time, slip, tau
    with pytest.raises(ValueError, match="the first column alone of slip, tau, sigma_N grows"):
        read_tests(path, sigma_N=-1.0)
    np.savetxt(path, np.column_stack([slip, tau, slip, slip]), fmt="%.4f")
    with pytest.raises(
        ValueError, match="4 columns without a header: expected a header, or --columns slip=1"
    ):
        read_tests(path, sigma_N=-1.0)


def test_sections(tmp_path: Path) -> None:
    """The section with lists of numbers is read, what is not read is named."""
    slip, tau = curve()
    lists = [
        f'{name} = "{", ".join(f"{v:.4f}" for v in row)}"'
        for name, row in (("Horizontal Displacement", slip), ("Force", tau))
    ]
    head = "[General]\nSample = A\nArea = 2\n[Consolidation Stage]\nVertical Displacement = 0.0, 0.1, 0.2\n"
    path = tmp_path / "box.ini"
    path.write_text(head + "\n".join(["[Shearing Stage]", *lists, ""]))
    with pytest.warns(
        ModelWarning, match="not read: General: Sample, General: Area, Consolidation Stage: Vert"
    ):
        [test] = read_tests(path, sigma_N=-1.0, area="2", columns={"shear_force": "Force"})
    assert isinstance(test, ShearTest) and test.tau == pytest.approx(tau / 2.0)
    for name, message in (
        ("box.ini:Shear", "section Shear: expected one of General, Consol"),
        ("no.ini", "no.ini"),
    ):
        with pytest.raises((ValueError, OSError), match=message):
            read_tests(tmp_path / name)
    path.write_text(head)
    with pytest.raises(ValueError, match="no section with lists of numbers"):
        read_tests(path)


def test_a_bond_may_have_no_end(tmp_path: Path) -> None:
    """A traction of 0 at the end says nothing about its unit."""
    slip, tau = curve(bond=True)
    path = tmp_path / "test.csv"
    np.savetxt(path, np.column_stack([slip, tau]), delimiter=",", header="slip,tau", comments="")
    assert len(read_tests(path, sigma_N=-0.5)) == 1
    with pytest.raises(ValueError, match="expected the same unit"):
        read_tests(path, sigma_N=-500.0)
