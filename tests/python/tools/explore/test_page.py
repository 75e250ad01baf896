"""Command `asperity explore`: what the page shows, its texts, and its server."""

from __future__ import annotations

import importlib.util
import re
import signal
import subprocess
import sys
import urllib.parse
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import Pattern
from asperity.case_files import drive
from asperity.pattern import direction_vector
from asperity.tools.explore.model import (
    VALUES,
    Choice,
    answer,
    as_case,
    as_props,
    as_python,
    in_contact,
    plan,
    section,
)
from support_signals import heeds_signals

PLAIN = Choice(VALUES, "one cycle")
WORN = Choice(
    VALUES | {"height": 0.3, "W0": 0.8, "direction": 25.0, "sides": 5.0, "theta": 22.5}, "three cycles"
)
FLAT = Choice(VALUES | {"sides": 0.0, "sigma_N": -3.0}, "there and back")


@contextmanager
def served(*values: str) -> Iterator[str]:
    """Address of `asperity explore`, as it prints it; Ctrl-C ends it, with exit code 0."""
    command = [sys.executable, "-m", "asperity", "explore", "--no-browser", "--port", "0", *values]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=heeds_signals) as server:
        try:
            assert server.stdout is not None
            yield server.stdout.readline().split()[0]
            server.send_signal(signal.SIGINT)
            assert server.wait(timeout=60) == 0
        finally:
            server.kill()


def followed(text: str, folder: Path, direction: float) -> np.ndarray:
    """Slip, traction along it, s_N and damage of the driver, from the end of the preload on."""
    case = folder / "copied.nml"
    case.write_text(text)
    rows = drive(case)[None]
    e = direction_vector(direction)
    first = int(np.argmax(np.any(rows.separation[:, 1:] != 0.0, axis=1))) - 1
    curves = [rows.separation[:, 1:] @ e, rows.traction[:, 1:] @ e, rows.separation[:, 0], rows.damage]
    return np.column_stack(curves)[first:]


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("choice", [PLAIN, WORN, FLAT], ids=["plain", "worn", "flat"])
def test_texts_give_what_the_page_shows(choice: Choice, tmp_path: Path) -> None:
    """The case through the driver, the script and PROPS are those of the curves."""
    on_page = answer(choice)
    shown = np.column_stack([on_page.slip, on_page.tau, on_page.history.dilation, on_page.history.damage])
    driven = followed(as_case(choice), tmp_path, choice.values["direction"])
    assert driven.shape == shown.shape
    # where a worn facet is back at slip zero, a rounding error decides on the side of its foot
    sided = np.abs(on_page.slip) > (1e-12 if choice.values["W0"] else -1.0)
    np.testing.assert_allclose(driven[sided], shown[sided], rtol=0.0, atol=1e-9)
    given: dict[str, Any] = {}
    exec(as_python(choice).replace("print(test)", ""), given)
    rows = given["test"].after_step(1).traction
    np.testing.assert_allclose(rows[sided[1:]], on_page.history.traction[1:][sided[1:]], rtol=0.0, atol=1e-9)
    head, numbers = as_props(choice).split(")", 1)
    props = choice.interface.props()
    assert head == f"PROPS({len(props)}"
    np.testing.assert_array_equal([float(text) for text in numbers.split(",")], props)


def test_lost_equilibrium_and_warnings() -> None:
    """Rows up to the end of equilibrium are shown, and what the library warns of."""
    on_page = answer(Choice(VALUES | {"sides": 0.0, "sigma_N": 2.0}, "one way"))
    assert on_page.lost.startswith("row ") and 0 < len(on_page.history) < len(on_page.choice.slips)
    assert len(answer(Choice(VALUES | {"sigma_N": 3.5}, "one way")).history) == 0
    [warning] = answer(Choice(VALUES | {"mu": 1.0, "theta": 60.0}, "one way")).warnings
    assert "locks" in warning or "lock" in warning


@pytest.mark.parametrize("sides", [0, 2, 3, 4, 7, 16])
@pytest.mark.parametrize("flat", [0.0, 0.4, 1.0])
def test_areas_of_the_plan_are_the_weights(sides: int, flat: float) -> None:
    """Planes seen from above tile the whole, each with the area of its weight."""
    pattern = Pattern.regular(sides, 30.0 if sides else 0.0, flat)
    areas = []
    for x, y in zip(*plan(pattern), strict=True):
        area = 0.5 * (np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
        areas.append(abs(area))
    np.testing.assert_allclose(np.array(areas) / sum(areas), pattern.weights, atol=1e-12)


def test_section_has_slope_end_and_wear() -> None:
    """The section climbs by the slope that the slip meets, up to the height, and less where it is worn."""
    steep = answer(Choice(VALUES | {"direction": 20.0}, "one way"))
    x, z, (slip, s_N) = section(steep, -1)
    right = (z[-1] - z[-2]) / (x[-1] - x[-2])
    assert right == pytest.approx(np.tan(np.radians(30.0)) * np.cos(np.radians(20.0)), rel=1e-12)
    assert (slip, s_N) == (pytest.approx(0.4), steep.history.dilation[-1])
    high = answer(Choice(VALUES | {"height": 0.1}, "one way"))
    assert section(high, -1)[1].max() == pytest.approx(0.1, abs=0.002)
    worn = answer(Choice(VALUES | {"height": 0.1, "W0": 0.5}, "one way"))
    shares = [worn.history.worn(k)[-1] for k in range(1, worn.interface.n_planes + 1)]
    assert section(worn, -1)[1][-1] / section(high, -1)[1][-1] == pytest.approx(1.0 - max(shares))


def test_planes_in_contact() -> None:
    """All planes touch under pressure; a slip leaves the facing one in contact, and tension none of them."""
    slid = answer(Choice(VALUES | {"sides": 4.0}, "one way"))
    assert all(in_contact(slid, 0))
    facing = slid.interface.pattern.normals[:, 1] < -1e-9
    assert in_contact(slid, -1) == facing.tolist()
    # a facet that ends touches at another height than its plane
    high = answer(Choice(VALUES | {"sides": 4.0, "height": 0.2, "W0": 1.0}, "one way"))
    assert in_contact(high, -1) == facing.tolist()
    opened = answer(Choice(VALUES | {"sides": 4.0, "sigma_N": 0.0}, "one way"))
    assert not any(in_contact(opened, -1))


def test_page_without_a_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sliders change curves, texts and messages; changes that come together are one redraw."""
    from asperity.tools.explore.model import SLIDERS
    from asperity.tools.explore.page import Page
    from bokeh.document import Document

    assert set(SLIDERS) == set(VALUES)
    document = Document()
    page = Page(document, VALUES)
    redraws: list[Callable[[], None]] = []
    monkeypatch.setattr(document, "add_next_tick_callback", redraws.append)
    page.sliders["mu"].value = 0.7
    page.sliders["theta"].value = 20.0
    page.cycle.value = "one way"
    assert len(redraws) == 1
    redraws.pop()()
    expected = answer(Choice(VALUES | {"mu": 0.7, "theta": 20.0}, "one way"))
    np.testing.assert_array_equal(page.curves.data["tau"], expected.tau)
    page.place.value = 50
    assert page.here.data["slip"] == [pytest.approx(0.2)]
    page.kind.active = 2
    assert page.text.text == as_props(expected.choice)
    page.sliders["sides"].value = 1
    redraws.pop()()
    assert "sides = 1: expected 0 or 2 to 64" in page.message.text
    assert page.curves.data["tau"] == [] and page.text.text == ""
    page.sliders["sides"].value = 4
    redraws.pop()()
    assert "error" not in page.message.text and len(page.curves.data["tau"]) == 101


@pytest.mark.slow
def test_server_and_its_page() -> None:
    """The page asks for nothing but files of its own server, and Ctrl-C ends the command."""
    with served("mu=0.4") as address:
        page = urllib.request.urlopen(address, timeout=60).read().decode()
        sources = re.findall(r"""(?:src|href)=["']([^"']+)""", page)
        assert sources and all(re.match(r"/?static/|data:", source) for source in sources)
        script = next(source for source in sources if "bokeh" in source)
        assert urllib.request.urlopen(urllib.parse.urljoin(address, script), timeout=60).status == 200
    assert "asperity explore" in page


def test_missing_bokeh(monkeypatch: pytest.MonkeyPatch, said: Callable) -> None:
    """Without Bokeh the message says what to install."""
    real = importlib.util.find_spec
    monkeypatch.setattr("asperity.installed.find_spec", lambda name: None if name == "bokeh" else real(name))
    assert "asperity[explore]" in said("explore --no-browser", 1)[1]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("mu=-1", "mu = -1: expected >= 0"), ("sides=1", "sides = 1: expected 0 or 2 to 64"),
        ("theta=90", "theta = 90: expected 0 <= theta < 90"), ("sigma_N=1e400", "expected a finite number"),
        ("kc=0", "kc=0: expected a finite number > 0"), ("tau=1", "tau=1: expected one of sigma0"),
    ],
)  # fmt: skip
def test_values_that_are_refused(said: Callable, value: str, words: str) -> None:
    """They are refused before a page opens."""
    assert words in said(f"explore --no-browser {value}", 1)[1]
