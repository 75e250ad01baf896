"""A host is a folder: what host.toml and card.py of a new one must have, and what is told of wrong ones."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from asperity import Interface, Material, Pattern, hosts
from asperity.cli import main

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(2, 30.0))
CARD = """
def block_of(block):
    return f"{block.name}: {block.prop('sigma0'):g} {block.prop('theta'):g}\\n"
"""


@pytest.fixture
def new_host(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Folder of a host that the package does not have."""
    monkeypatch.setattr(hosts, "__path__", [*hosts.__path__, str(tmp_path)])
    hosts.hosts.cache_clear()
    folder = tmp_path / "newcode"
    folder.mkdir()
    (folder / "card.py").write_text(CARD, encoding="utf-8")
    yield folder
    hosts.hosts.cache_clear()


def test_new_host(new_host: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder with a host.toml and a card.py is a host of the commands, which refuse what it cannot take."""
    text = 'title = "New code"\nprograms = ["newcode-of-nobody"]\n[card.only]\nh = 1\n'
    (new_host / "host.toml").write_text(text, encoding="utf-8")
    assert JOINT.card("newcode", name="J") == "J: 3 30\n"
    with pytest.raises(ValueError, match=r"h = 0\.5: expected 1 for newcode, whose joints pass separations"):
        JOINT.card("newcode", h=0.5)
    with pytest.raises(ValueError, match=r"explicit, density: expected for abaqus, .*only, not for newcode"):
        JOINT.card("newcode", explicit=True)
    listed = Interface(JOINT.material, Pattern.planes([(1.0, 0.0, 0.0)], [1.0]))
    with pytest.raises(ValueError, match="m = -1: expected a regular pattern for newcode, not listed planes"):
        listed.card("newcode")
    assert main(["card", "newcode", "figure05b"]) == 0
    assert capsys.readouterr().out == "INTERFACE: 3 30\n"
    main(["doctor"])
    assert "New code" in (told := capsys.readouterr().out) and "newcode-of-nobody not found on PATH" in told


def test_constant_that_is_none(new_host: Path) -> None:
    """A name in `only` that no constant has is named with its file."""
    (new_host / "host.toml").write_text("title = 'x'\n[card.only]\nwatr = 0\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"newcode.host\.toml: card\.only: watr: expected dimension or"):
        JOINT.card("newcode")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("titel = 'x'\n", r"newcode.host\.toml: .*titel"),
        ("title = 'x'\n[card]\nonly = {h = 1}\nlist = true\n", r"newcode.host\.toml: .*list"),
        ("title = \n", r"newcode.host\.toml: Invalid value"),
        ("title = 'x'\n[mesh]\nlayer = true\n", r"newcode.host\.toml: .*ending"),
        ("title = 'x'\ncard = []\n", r"newcode.host\.toml: card = \[\]: expected a table"),
        ("title = nan\n", r"host\.toml: title = nan: expected a text"),
        ("title = 'x'\nprograms = [1]\n", r"host\.toml: programs = \[1\]: expected a list of texts"),
        ("title = 'x'\n[card.only]\nh = inf\n", r"only = \{'h': inf\}: expected a table of finite numbers"),
        ("title = 'x'\n[mesh]\nending = '.x'\nlayer = 1\n", r"layer = 1: expected true or false"),
        (f"title = {'[' * 20000}\n", r"newcode.host\.toml: .*recursion"),
    ],
)
def test_wrong_host(new_host: Path, text: str, told: str) -> None:
    """A key that no table has, a value that is missing and a file that is no TOML are named with the file."""
    path = new_host / "host.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=told):
        hosts.read(path)
    with pytest.raises(ValueError, match=told):
        JOINT.card("newcode")


def test_page_of_hosts() -> None:
    """Each host with a material block has a row in the page, which names all that the command takes."""
    page = Path(__file__).parents[2].joinpath("docs/how-to/hosts.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[([\w-]+)", page, re.MULTILINE)
    assert {host.title for host in hosts.hosts("card").values()} <= {*rows}, "rows of docs/how-to/hosts.md"
    [named] = re.findall(r"^`HOST`: ([^.]*)\.", page, re.MULTILINE)
    assert re.findall(r"`(\w+)`", named) == [*hosts.hosts("card")], "list HOST of docs/how-to/hosts.md"


@pytest.mark.parametrize("host", hosts.hosts("kit"))
def test_pages_name_a_host(host: str) -> None:
    """Each host with a kit stands in the first page, in the results and in a heading for its users."""
    root, title = Path(__file__).parents[2], re.escape(hosts.hosts("kit")[host].title)
    for name, pattern in (
        ("README.md", rf"^\|.*\b{title}\b"),
        ("docs/results/hosts.md", rf"\b{title}\b"),
        ("docs/how-to/verify.md", rf"\b{host}\b"),
        ("docs/how-to/*.md", rf"^#.*\b{title}\b"),
    ):
        sought = re.compile(pattern, re.MULTILINE)
        assert any(sought.search(page.read_text("utf-8")) for page in root.glob(name)), name
