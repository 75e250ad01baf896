"""The built site: its pages as text, a server, and Chromium."""

from __future__ import annotations

import functools
import http.server
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.python.support_browser import chromium, missing

SITE = Path(__file__).parents[2] / "build" / "site"


@pytest.fixture(scope="session")
def pages() -> dict[Path, str]:
    """Return the text of every page of the site."""
    assert SITE.is_dir(), f"{SITE}: expected a site, which tools/site/build.sh builds"
    return {file: file.read_text(encoding="utf-8") for file in SITE.rglob("*.html")}


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Files, without a line for each request."""

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    """Serve the site on this machine."""
    handler = functools.partial(Quiet, directory=str(SITE))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Start Chromium with an empty profile."""
    if lacking := missing():
        pytest.skip(f"no Chromium: {lacking}")
    with chromium(tmp_path_factory.mktemp("profile")) as driver:
        driver.set_page_load_timeout(60)
        # each page chooses its colours anew, not those that the page before has stored
        driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": "localStorage.clear()"})
        yield driver
