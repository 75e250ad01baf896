"""What a fit writes: cases that reach the fitted strengths, pages for a client, and units of predictions."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, read_case

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore::asperity.ModelWarning")]

PEAKS = "sigma_N [MPa],peak [MPa],residual [MPa]\n1,1.2,0.6\n2,2.2,\n3,3.1,1.8\n4,3.9,2.4\n5,4.6,3.0\n"
SLIPS = re.sub(r"(?m),(\d\.\d)?$", r",\1,0.8,6", PEAKS).replace(
    "l [MPa]\n", "l [MPa],peak_slip [mm],slip [mm]\n"
)


@pytest.mark.parametrize("text", [PEAKS, SLIPS], ids=["peaks", "slips"])
def test_case_of_strengths_reaches_the_fitted_peaks(text: str, said: Callable) -> None:
    """The increments of the case that a fit of strengths writes find its peaks and residual strengths."""
    Path("peaks.csv").write_text(text)
    said("fit peaks.csv -o joint.nml")
    fitted = [test["fitted"] for test in json.loads(Path("joint.fit.json").read_text())["tests"]]
    said("run joint.nml --quiet -o run.csv")
    for number, sigma_N in zip(fitted, range(1, 6), strict=True):
        rows = np.genfromtxt(f"run_-{sigma_N}.csv", delimiter=",", names=True)
        # the closed form neglects the compliance of the contact, and increments pass beside the peak
        assert rows["t_Tx"].max() == pytest.approx(number["peak"], rel=0.03)
        if "residual" in number:
            assert rows["t_Tx"][-1] == pytest.approx(number["residual"], rel=0.03)


def test_page_of_strengths_with_gaps(said: Callable) -> None:
    """Numbers have their units, tests their pressures; what was not measured has no fitted number."""
    Path("peaks.csv").write_text(PEAKS)
    said("fit peaks.csv --report page.html")
    page = Path("page.html").read_text()
    heads = [re.findall(r"<th[^>]*>(.*?)</th>", table) for table in re.findall("<table>.*?</table>", page)]
    assert heads[0] == ["test", "pressure [MPa]", "peak [MPa]", "residual [MPa]"]
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall("<tr>(?!<th).*?</tr>", page)][:5]
    assert [row[1] for row in rows] == ["1", "2", "3", "4", "5"]
    assert [bool(row[3]) for row in rows] == [True, False, True, True, True]
    assert "pressures of 1 to 5 MPa" in page


def test_prediction_has_the_units_of_the_case(said: Callable) -> None:
    """A case in metres and kilopascals predicts tests in millimetres and megapascals, without --units."""
    joint = Interface(
        Material.from_joint(kn=500.0, ks=50.0, mu=0.6, height=0.5), Pattern.regular(2, theta=15.0)
    )
    slip = np.linspace(0.1, 6.0, 60)
    for pressure in (1.0, 2.0, 3.0):
        box = joint.confined_slip(0.0, np.append(0.0, slip), -pressure)
        opening = box.separation[1:, 0] - box.separation[0, 0]
        rows = zip(slip, box.traction[1:, 1], opening, strict=True)
        lines = [f"{s:.6g},{t:.6g},{d:.6g},{pressure}" for s, t, d in rows]
        head = "slip [mm],tau [MPa],dilation [mm],sigma_N [MPa]"
        Path(f"{pressure:g}.csv").write_text("\n".join([head, *lines, ""]))
    said("fit 1.csv 3.csv --units m,kPa -o joint.nml")
    assert json.loads(Path("joint.fit.json").read_text())["units"] == ["m", "kPa"]
    assert read_case("joint.nml").runs[0].material.height == pytest.approx(0.5e-3, rel=0.05)
    out, _ = said("predict joint.nml 2.csv")
    peak, predicted = map(float, re.findall(r"2\.csv +([\d.]+) / ([\d.]+)", out)[0])
    assert peak > 1000.0 and predicted == pytest.approx(peak, rel=0.05)
    assert "grade       good" in out
