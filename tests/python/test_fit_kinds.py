"""Fits of other kinds of test: a measured path of sigma_N, slip of the machine, peak and residual."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, Step
from asperity.cli import main
from asperity.fit.fitting import fit
from asperity.fit.records import read_tests
from asperity.tables import read_table

MATERIAL = {"sigma0": 1.5, "Gc": 0.15, "eta": 0.9, "mu": 0.5, "kc": 20.0}
RT = {"theta": 20.0, "flat": 0.3333}
JOINT = Interface(Material(**MATERIAL), Pattern.regular(2, **RT))
SLIP = np.linspace(0.0, 0.6, 61)[1:]
HEADER, ENVELOPE = "slip,tau,sigma_N\n", "sigma_N,peak,residual,slip\n"
LINE = HEADER + "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},-1\n" for i in range(1, 8))


def box(sigma_N: Any, material: dict[str, float] | None = None) -> np.ndarray:
    """Shear traction at SLIP; sigma_N of each row, or of all."""
    joint = Interface(Material(**(material or MATERIAL)), JOINT.pattern)
    first = float(np.ravel(sigma_N)[0])
    path = [Step(t_N=first, increments=50), Step(t_N=sigma_N, slip=SLIP, increments=10)]
    return joint.run(path).traction[59::10, 1]


def written(folder: Path, text: str) -> Path:
    """File of a test."""
    path = folder / "box.csv"
    path.write_text(text, encoding="utf-8")
    return path


def rows(*columns: Any) -> str:
    """Rows of a CSV file."""
    return "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in np.broadcast(*columns))


def found(tests: Any, **free: float) -> dict[str, float]:
    """Values of the free constants, fitted from a start."""
    fixed = {name: value for name, value in (MATERIAL | RT).items() if name not in free}
    return fit(tests, tuple(free), fixed, start=free, starts=1, sides=2).values


def test_units_in_names(tmp_path: Path) -> None:
    """A unit follows a name in brackets, after a blank, `in` or a slash; a name may end in its letters."""
    path = tmp_path / "data.csv"
    for name, unit in (("Weg", "mm"), ("tau", "N/mm2"), ("Norm", "")):
        for text in (
            (f"{name} [{unit}]", f"{name} in {unit}", f"{name} / {unit}", f"{name} {unit}")
            if unit
            else (name,)
        ):
            path.write_text(f"{text};x\n1;2\n", encoding="utf-8")
            table = read_table(path, "numbers")
            assert (table.names[0], table.units[0]) == (name, unit), text


def test_headers_and_numbers_of_instruments(tmp_path: Path) -> None:
    """A header may have # in a name and a comment; nan is no header, and 1_0 no number."""
    path = tmp_path / "data.csv"
    path.write_text("# box\nTest #,slip [mm],tau # MPa\n1,0.1,0.2 # first\n")
    table = read_table(path, "numbers")
    assert (table.names, table.units) == (["Test #", "slip", "tau"], ["", "mm", ""])
    assert table.cells.values.tolist() == [["1", "0.1", "0.2"]]
    path.write_text("nan,nan\n1,2\n")
    table = read_table(path, "numbers")
    assert table.names == [] and len(table.cells) == 2
    with pytest.raises(ValueError, match="line 1, column x: nan: expected a finite number"):
        table.numbers([0], ["x"])
    path.write_text("x,y\n1_0,2\n")
    with pytest.raises(ValueError, match="line 2, column x: 1_0: expected a finite number"):
        read_table(path, "numbers").numbers([0], ["x"])


LABS = {
    "spreadsheet in German": (
        "utf-8-sig",
        "Labor f\u00fcr Felsmechanik;;;\nDatum;12.03.2024;;\nVersuch;Scher 3;;\n;;;\n"
        "Schubspannung [kPa];Vertikalverschiebung [mm];Horizontalverschiebung [mm];Normalspannung [kPa]\n",
        lambda x, y, z: f"{1000 * y:.2f};{z:.4f};{x:.3f};-1000,00\n".replace(".", ","),
    ),
    "thousands, in Windows": (
        "cp1252",
        "Scherweg / mm;Scherspannung in kPa;Normalspannung, kPa;Dilatanz [\u00b5m]\n",
        lambda x, y, z: f"{x:.3f};{1000 * y:,.1f};-1,000.0;{1000 * z:.3f}\n".translate(
            {ord(","): ".", ord("."): ","}
        ),
    ),
    "tabs, row of units": (
        "utf-16",
        "Test A\n\nShear displ.\tShear stress\tNormal stress\tDilation\nmm\tMPa\tN/mm\u00b2\tmm\n",
        lambda x, y, z: f"{x:.3f}\t{y:.5f}\t-1\t{z:.5f}\n",
    ),
    "French": (
        "utf-8",
        "D\u00e9placement tangentiel (mm),Contrainte de cisaillement (MPa),D\u00e9placement normal (mm),"
        "Contrainte normale (MPa),Force normale (kN)\n",
        lambda x, y, z: f"{x:.3f},{y:.5f},{z:.5f},-1.0,7\n",
    ),
    "errors of a spreadsheet": (
        "utf-8",
        "Spostamento orizzontale [mm];Tensione tangenziale [MPa];Tensione normale [MPa];"
        "Spostamento verticale [mm]\n"
        "#DIV/0!;#WERT!;-1;0\n",
        lambda x, y, z: f"{x:.3f};{y:.5f};-1;{z:.5f}\n",
    ),
}
"""Encoding, head and rows of files."""


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("name", LABS)
def test_files_of_laboratories(name: str, tmp_path: Path) -> None:
    """Languages, decimal commas, thousands, units in the header or below, preambles and errors are read."""
    encoding, head, row = LABS[name]
    tau, s_N = box(-1.0), 0.1 * SLIP
    path = tmp_path / "box.csv"
    path.write_text(head + "".join(map(row, SLIP, tau, s_N)), encoding=encoding)
    [test] = read_tests([path])
    for found, expected in ((test.slip, SLIP), (test.tau, tau), (test.s_N, s_N)):
        assert found == pytest.approx(expected, abs=1e-4)
    assert test.sigma_N == pytest.approx(-1.0) and test.units == {"length": "mm", "stress": "MPa"}


def test_normal_tractions_of_the_command(tmp_path: Path) -> None:
    """Files without sigma_N have that of the argument, one for each or one for all."""
    paths = []
    for i in (1, 2):
        paths.append(tmp_path / f"{i}.csv")
        paths[-1].write_text("slip,tau\n" + rows(SLIP, i * SLIP), encoding="utf-8")
    assert [one.sigma_N for one in read_tests(paths, sigma_N=[0.5, 1.0])] == [-0.5, -1.0]
    assert [one.sigma_N for one in read_tests(paths, sigma_N=-2.0)] == [-2.0, -2.0]
    with pytest.raises(ValueError, match=r"sigma_N: 3 values for 2 tests without that column"):
        read_tests(paths, sigma_N=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"expected sigma_N, too .*--sigma-N VALUE"):
        read_tests(paths)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "slip;tau;sigma_N\n0,1;950;-1\n0,2;1,234;-1\n",
            "column tau: 950 beside 1,234: expected no separators",
        ),
        ("slip;tau;sigma_N\n0.5;1,5;-1\n0.2;2;-1\n", "expected one decimal mark"),
        (
            "slip,tau,sigma_N\n0.1,0.2,-1\n0.2,MPa,-1\n0.3,0.3,-1\n",
            "line 3, column tau: MPa: expected a finite",
        ),
        ("slip,tau,sigma_N\n0.1,0.2,-1\n0.2,0.3,-1,7\n", "line 3: 4 values: expected 3"),
    ],
)
def test_wrong_files(text: str, message: str, tmp_path: Path) -> None:
    """What can be read in two ways is refused."""
    with pytest.raises(ValueError, match=re.escape(message)):
        read_tests([written(tmp_path, text)])


def test_measured_path_of_the_normal_traction(tmp_path: Path) -> None:
    """A normal traction that changes in the test is prescribed, and gives back the constants."""
    sigma_N = -1.0 - 2.0 * SLIP
    path = written(tmp_path, HEADER + rows(SLIP, box(sigma_N), sigma_N))
    with pytest.raises(ValueError, match=r"is more than 5% off the mean .*: .* or --sigma-N-path"):
        read_tests([path])
    [test] = read_tests([path], sigma_N_path=True)
    assert test.pressed == pytest.approx(-2.2)
    values = found([test], Gc=0.2, mu=0.6)
    assert values["Gc"] == pytest.approx(0.15, rel=2e-3) and values["mu"] == pytest.approx(0.5, rel=2e-3)


def test_deformation_of_the_machine(tmp_path: Path) -> None:
    """The slip of the machine is tau/k_T more than that of the joint; a softer k_T is refused."""
    tau = box(-1.0)
    path = written(tmp_path, HEADER + rows(SLIP + tau / 40.0, tau, -1.0))
    [test] = read_tests([path], k_T=40.0)
    assert test.slip == pytest.approx(SLIP, abs=1e-7)
    with pytest.raises(ValueError, match=r"line \d+: k_T = 5 takes .* expected more than tau/slip"):
        read_tests([path], k_T=5.0)


def test_peak_and_residual_strength(tmp_path: Path) -> None:
    """Peaks and residual strengths under several pressures give back strength and friction, and no more."""
    text = ENVELOPE
    for sigma_N in (-0.5, -1.0, -2.0, -4.0):
        tau = box(sigma_N)
        text += rows(sigma_N, tau.max(), tau[-1], SLIP[-1])
    tests = read_tests([written(tmp_path, text)])
    assert len(tests) == 4 and all(test.envelope for test in tests)
    values = found(tests, sigma0=1.2, mu=0.6)
    # the rows of the curve are 0.01 mm apart, and the peak is a kink
    assert values["sigma0"] == pytest.approx(1.5, rel=0.02) and values["mu"] == pytest.approx(0.5, rel=0.01)


def test_verdict_on_envelopes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Residual strengths alone do not give the bond: exit code 3; report and picture have the test."""
    text = ENVELOPE + rows([-1.0, -2.0, -3.0], [1.05, 2.1, 3.15], [1.05, 2.1, 3.15], 0.6)
    path = written(tmp_path, text)
    known = "eta=0.9 kc=20 theta=20 flat=0.3333"
    command = ["fit", str(path), "--sides", "2", "--set", known, "--free", "sigma0,Gc", "--starts", "1"]
    command += ["--increments", "50"]
    assert main([*command, "--set", "mu=0.5", "--plot", str(tmp_path / "fit.png")]) == 3
    printed = capsys.readouterr().out
    assert "line 2: peak 1.05, residual 1.05, sigma_N -1" in printed and "no result" in printed
    assert (tmp_path / "fit.png").stat().st_size > 10000


def test_verdict_where_no_other_pattern_fits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Free parameters that a flat joint does not have are no error while other patterns are tried."""
    text = ENVELOPE + rows([-1.0, -2.0, -3.0, -4.0], [1.6, 2.7, 3.7, 4.6], [1.05, 2.1, 3.15, 4.2], 0.6)
    command = ["fit", str(written(tmp_path, text)), "--set", "eta=0.9 kc=20 flat=0.3333 mu=0.5 Gc=0.15"]
    assert main([*command, "--free", "sigma0,theta", "--starts", "1", "--increments", "50"]) in (0, 3)
    assert "sigma0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (ENVELOPE + "-1,2,1,5\n-2,1,2,5\n", {}, "line 3, column peak: 1: expected at least the residual"),
        (ENVELOPE + "-1,2,1,-5\n", {}, "line 2, column slip: -5: expected > 0"),
        (ENVELOPE + "1,2,1,5\n", {}, "line 2, column sigma_N: 1 is tension: expected compression"),
        (ENVELOPE + "-1,2,,5\n-1,2,,5\n", {}, "box.csv: 0 rows: expected at least 1"),
        ("sigma_N,peak,slip\n-1,2,5\n", {}, "line 1: columns sigma_N, peak, slip: expected residual, too"),
        (ENVELOPE + "-1,2,1,5\n", {"k_T": 5.0}, "k_T, sigma_N_path: expected columns slip, tau, sigma_N"),
        (LINE, {"k_T": 0.0}, "k_T = 0: expected a finite stiffness > 0"),
        (LINE, {"k_T": 2.0}, "line 5: k_T = 2 takes 0.4 off the slip 0.4: expected more than tau/slip = 2"),
        (LINE, {"k_N": 5.0, "sigma_N_path": True}, "k_N = 5: expected no stiffness beside a prescribed"),
    ],
)
def test_bad_input(text: str, options: dict[str, Any], message: str, tmp_path: Path) -> None:
    """Errors have line, column, value and expectation."""
    with pytest.raises(ValueError, match=re.escape(message)):
        read_tests([written(tmp_path, text)], **options)
