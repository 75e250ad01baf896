"""What a fit writes: cases that reach the fitted strengths, pages for a client, and units of predictions."""

from __future__ import annotations

import ast
import html
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, read_case
from asperity.tools.fit import command
from asperity.tools.fit import html as client

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
    """The page has the report as it is printed, the files, and the range of the pressures."""
    Path("peaks.csv").write_text(PEAKS)
    text, _ = said("fit peaks.csv --report page.html --verbose")
    page = html.unescape(Path("page.html").read_text())
    assert text[: text.index("PROPS(")].rstrip() in page and "friction coefficient" in page
    head, *rows = page[page.index("measured / fitted / blind") :].splitlines()[:6]
    assert re.split(r"  +", head)[1:4] == ["pressure [MPa]", "peak [MPa]", "residual [MPa]"]
    assert [re.split(r"  +", row)[1] for row in rows] == ["1", "2", "3", "4", "5"]
    assert "pressures of 1 to 5 MPa" in page and "<li>peaks.csv, 5 tests</li>" in page


def test_page_has_the_warnings(said: Callable) -> None:
    """A page says what was doubted in the files, and the whole range of the pressures."""
    slip = np.linspace(0.0, 4.0, 41)
    dilation = 0.3 * (1.0 - np.exp(-slip))
    for start in (0.5, 1.5):
        pressure = start + 2.0 * dilation
        slope = 0.3 * np.exp(-slip)
        tau = np.minimum(10.0 * slip, pressure * (0.6 + slope) / (1.0 - 0.6 * slope))
        rows = "".join(
            f"{u:.4g},{t:.6g},{d + 0.2:.6g},{p:.6g},7\n"
            for u, t, d, p in zip(slip, tau, dilation, pressure, strict=True)
        )
        Path(f"{start}.csv").write_text("slip [mm],tau [MPa],dilation [mm],sigma_N [MPa],time [s]\n" + rows)
    said("fit 0.5.csv 1.5.csv --k-N 2 --free kT,mu,theta,height --report page.html")
    page = Path("page.html").read_text()
    for text in ("columns not used: time [s]", "column dilation: 0.2 where 0% of the largest traction acts"):
        assert f"Warning about the tests: 0.5.csv: {text}" in page.replace("line 2, ", "")
    # 2.089 MPa at the end, 1.5 + 2 times 0.3 (1 - exp(-4))
    assert re.search(r"pressures of 0\.[45]\d* to 2\.0[89]\d* MPa and slips up to 4 mm", page)


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
    assert re.split(r"  +", out.splitlines()[0])[:3] == [
        "measured / predicted", "pressure [kPa]", "peak [kPa]"
    ]  # fmt: skip
    pressure, peak, predicted = map(float, re.findall(r"2\.csv +([\d.]+) +([\d.]+) / ([\d.]+)", out)[0])
    assert pressure == 2000.0 and "dilation [m]" in out[out.index("predicted, 0.95 interval") :]
    assert peak > 1000.0 and predicted == pytest.approx(peak, rel=0.05)
    assert "grade       good" in out
    _, message = said("predict joint.nml 2.csv --units mm,MPa", 1)
    assert "--units mm,MPa: the constants of joint.nml are in m,kPa" in message
    # what the tests of the fit did not cover is said, and how good the fit was
    far = Path("2.csv").read_text().replace(",2.0\n", ",20\n")
    Path("far.csv").write_text(far)
    out, _ = said("predict joint.nml far.csv", 3)
    assert "fit         grade good" in out
    assert "note        a pressure of 2e+04: the tests of the fit had 1000 to 3000 kPa" in out
    Path("joint.nml").write_text(re.sub("mu = [0-9.]+", "mu = 0.3", Path("joint.nml").read_text()))
    out, _ = said("predict joint.nml 2.csv", 3)
    assert re.search(r"fit         mu = 0\.\d+, but the case has 0\.3: another joint", out)


def test_model_error_of_strengths(said: Callable) -> None:
    """It is the root mean square of the blind errors of peaks and residual strengths."""
    Path("peaks.csv").write_text(PEAKS)
    said("fit peaks.csv -o joint.nml --residuals rows.csv")
    content = json.loads(Path("joint.fit.json").read_text())
    rows = [line.split(",") for line in Path("rows.csv").read_text().splitlines()[1:]]
    errors = [float(row[-1]) for row in rows]
    assert len(errors) == 9 and content["pressures"] == [1.0, 5.0]
    # seven digits of the file
    assert content["model error of tau and s_N"][0] == pytest.approx(
        np.sqrt(np.mean(np.square(errors))), rel=1e-4
    )


def test_nonsense_in_the_file_of_a_fit(said: Callable) -> None:
    """Numbers that no fit writes, wrong types and lengths are refused with their name and value."""
    Path("peaks.csv").write_text(PEAKS)
    said("fit peaks.csv -o joint.nml")
    written, path = Path("joint.fit.json").read_text(), Path("joint.fit.json")
    for key, place, raw, told in (
        ("pressures", 1, "1e308", "pressures = 1e+308: expected"),
        ("pressures", 1, "0", "pressures = [1.0, 0]: expected the smallest and the largest one"),
        ("slip", None, "-2", "slip = -2: expected"),
        ("values", 0, "Infinity", "values = inf: expected"),
        ("values", 0, "1" + 400 * "0", "values = 1000"),
        ("values", 0, "true", "values = True: expected"),
        ("values", None, "[]", "values = []: expected a list of"),
        ("units", None, "7", "units = 7: expected a list of words"),
        ("grade", None, '"perfect"', "grade = 'perfect': expected one of good, fair, poor"),
        ("covariance on the scales", 0, "[NaN]", "covariance on the scales = [nan]: expected a list of"),
        ("covariance on the scales", None, "{}", "covariance on the scales = {}: expected a list of"),
        ("model error of tau and s_N", 0, "NaN", "model error of tau and s_N = nan: expected"),
    ):
        content = json.loads(written)
        if place is None:
            content[key] = "PLACE"
        else:
            content[key][place] = "PLACE"
        path.write_text(json.dumps(content).replace('"PLACE"', raw))
        _, message = said("predict joint.nml peaks.csv", 1)
        assert (
            f"joint.fit.json: expected a file that this version of asperity fit -o has written ({told}"
            in message
        )
    path.write_text("null")
    assert "(None: expected an object)" in said("predict joint.nml peaks.csv", 1)[1]


def test_constants_that_are_not_determined(said: Callable) -> None:
    """A result whose slope is not determined says so wherever its value stands."""
    strengths = (
        (1.0, 1.28, 0.862),
        (2.0, 2.31, 1.775),
        (3.0, 3.418, 2.575),
        (4.0, 4.468, 3.483),
        (5.0, 5.719, 4.331),
    )
    rows = "".join(f"{p},{peak},{end}\n" for p, peak, end in strengths)
    Path("peaks.csv").write_text("sigma_N [MPa],peak [MPa],residual [MPa]\n" + rows)
    out, _ = said("fit peaks.csv -o joint.nml --report page.html")
    for name in ("theta", "crush"):
        assert re.search(rf"^{name} .*\(not determined\)$", out, re.MULTILINE)
    content = json.loads(Path("joint.fit.json").read_text())
    assert content["not determined"] == ["theta", "crush"] and not content["no result"]
    text = "not determined: theta, crush"
    assert text in Path("joint.nml").read_text()
    assert Path("page.html").read_text().count("(not determined)") == 2
    said("card abaqus joint.nml -o joint.inp")
    assert text in Path("joint.inp").read_text()
    # some of its samples lock
    out, _ = said("uncertainty joint.nml --samples 20 --seed 1", code=3)
    assert text in out


ROOM = Path(command.__file__).parent


def test_a_row_visits_twelve_modules(said: Callable) -> None:
    """A row of a shear test is followed from file to report through at most 12 modules of the fit."""
    slips = np.linspace(0.2, 3.0, 15)
    decay = np.exp(-slips)
    rows = (
        f"{u:.2f},{p * (0.6 + 0.3 * left) * min(1.0, 4.0 * u / p):.4f},{0.3 * (1.0 - left):.4f},-{p}"
        for p in (1, 2)
        for u, left in zip(slips, decay, strict=True)
    )
    Path("tests.csv").write_text("\n".join(["slip,tau,dilation,sigma_N", *rows]) + "\n")
    visited = set[str]()

    def note(frame: FrameType, *rest: object) -> None:
        visited.add(frame.f_code.co_filename)

    before = sys.gettrace()
    sys.settrace(note)
    try:
        said("fit tests.csv", 3)
    finally:
        sys.settrace(before)
    modules = {path.stem for path in map(Path, visited) if path.parent == ROOM}
    assert {"command", "report"} <= modules and len(modules) <= 12
    assert Path(client.__file__).stem not in modules


def test_one_name_has_one_value() -> None:
    """A constant of the fit stands in one module."""
    places: dict[str, list[str]] = {}
    for path in ROOM.glob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            names = {
                name.id
                for target in targets
                for name in ast.walk(target)
                if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
            }
            for name in filter(str.isupper, names):
                places.setdefault(name, []).append(path.name)
    assert {name: files for name, files in places.items() if len({*files}) > 1} == {}
