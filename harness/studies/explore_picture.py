"""Draw the page of `asperity explore`, as a headless Chromium shows it.

python -m harness.studies.explore_picture docs/images/explore.png
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from tests.python.support_browser import chromium, missing, served

VALUES = ("sides=4", "theta=25", "height=0.25", "direction=20", "sigma_N=-2", "kc=50")
"""Values at the start, whose facets end."""

POSITION = 5
"""Position on the path, per cent, where the damage of the planes differs."""

SIZE = (1400, 1360)
"""Width and height of the window, which show the whole page."""


def wait(driver: Any, condition: str) -> None:
    """Wait until a condition in JavaScript is met."""
    from selenium.webdriver.support.ui import WebDriverWait

    WebDriverWait(driver, 60).until(lambda browser: browser.execute_script(f"return {condition}"))


def main(picture: Path) -> None:
    """Write the picture."""
    lacking = missing("bokeh")
    if lacking:
        raise SystemExit(f"needs {lacking}")
    with (
        tempfile.TemporaryDirectory() as folder,
        served(*VALUES) as address,
        chromium(Path(folder, "profile")) as driver,
    ):
        driver.get(address)
        driver.set_window_size(*SIZE)
        model = "Bokeh.documents[0].get_model_by_name('{}')".format
        wait(driver, f"window.Bokeh && Bokeh.documents.length && {model('curves')} != null")
        driver.execute_script(f"{model('position')}.value = {POSITION}; {model('mu')}.value = 0.55")
        wait(driver, f"{model('text')}.text.includes('mu = 0.55')")
        # two frames later everything is drawn
        driver.execute_async_script("const d = arguments[0]; requestAnimationFrame(() => setTimeout(d, 500))")
        driver.save_screenshot(str(picture))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
