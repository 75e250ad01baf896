"""README and docs: every example and command runs, every link exists, tables and names are of the code."""

from __future__ import annotations

import inspect
import itertools
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import asperity
import pytest
from asperity import cli, contract
from asperity.installed import driver
from refresh import printed_by_cells

from harness.studies import tables

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TEXTS = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in PAGES}
ALL = "\n".join(TEXTS.values())
CONTRACT, DRIVER = "docs/reference/contract.md", "docs/reference/driver.md"
ARCHITECTURE = "docs/architecture.md"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$(?:\n+```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")
EXTRA = re.compile(r"(?:asperity|\"\.)\[([a-z,-]+)\]")


class Block(NamedTuple):
    """A fenced block: position, text, and the text block that follows, if any."""

    place: str
    text: str
    shown: str | None


def blocks(language: str) -> list[Block]:
    """Blocks of a language on all pages, of which there is at least one."""
    examples = [
        Block(f"{name}:{text.count(chr(10), 0, m.start()) + 1}", m[2], m[3])
        for name, text in TEXTS.items()
        for m in FENCE.finditer(text)
        if m[1] == language
    ]
    assert examples
    return examples


def examples(language: str) -> pytest.MarkDecorator:
    """Parametrise a test by the blocks of a language."""
    return pytest.mark.parametrize("block", blocks(language), ids=lambda block: block.place)


def run(*command: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command; `harness.studies` is found from any folder."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        list(command), capture_output=True, text=True, cwd=cwd, timeout=120, check=False, env=environment
    )


def prose(text: str) -> str:
    """Text of a page without fenced blocks."""
    return FENCE.sub("", text)


# --- examples -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@examples("python")
def test_python_example(block: Block, tmp_path: Path) -> None:
    """A Python example prints the shown text, without warnings."""
    done = run(sys.executable, "-c", block.text, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == block.shown


@examples("c")
def test_c_example(block: Block, tmp_path: Path) -> None:
    """A C example compiles without a warning, with the header of the tree and the library of the package."""
    (tmp_path / "example.c").write_text(block.text, encoding="utf-8")
    library = asperity.library()
    # the name in an installation
    for name in (library.name, f"{library.name}.{asperity.__version__.split('.')[0]}"):
        (tmp_path / name).symlink_to(library)
    flags = ["-Wall", "-Wextra", "-Werror", "-I", str(ROOT / "src"), "-L", ".", f"-Wl,-rpath,{tmp_path}"]
    build = run(os.environ.get("CC", "cc"), "example.c", *flags, "-lasperity", "-o", "example", cwd=tmp_path)
    assert (build.returncode, build.stderr) == (0, "")
    done = run(tmp_path / "example")
    assert (done.returncode, done.stdout) == (0, block.shown)


def test_fortran_example() -> None:
    """The program of the page is the one that the test of the installed package compiles and runs."""
    installed = (ROOT / "harness/examples/program/example.f90").read_text(encoding="utf-8")
    [shown] = [block for block in blocks("fortran") if block.text.startswith("program example")]
    assert installed.endswith(shown.text)


@examples("nml")
def test_case_example(block: Block, tmp_path: Path) -> None:
    """A case has an expected end, and ends so."""
    (tmp_path / "case.nml").write_text(block.text, encoding="utf-8")
    done = run(driver(), "case.nml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "&expect" in block.text


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.ipynb")), ids=lambda page: page.name)
def test_notebook(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each cell prints as many lines as it shows, with the same words; digits of a fit differ."""
    monkeypatch.chdir(tmp_path)
    for cell, printed in printed_by_cells(json.loads(page.read_text(encoding="utf-8"))["cells"]):
        shown = "".join("".join(part["text"]) for part in cell["outputs"])
        ours, theirs = (
            [[word for word in line.split() if not re.search(r"\d", word)] for line in text.splitlines()]
            for text in (printed, shown)
        )
        assert ours == theirs, f"python tests/python/refresh.py {page} writes what the cells print"


def commands() -> list[tuple[str, list[str]]]:
    """Page and words of every command asperity of the pages, without their shell."""
    lines = []
    for name, text in TEXTS.items():
        consoles = re.findall(r"^```(?:console|sh)\n(.*?)^```", text, re.M | re.S)
        for line in "\n".join(consoles).replace("\\\n", " ").splitlines():
            words = shlex.split(re.sub(r"\[[^][]*(\[[^][]*\])?[^][]*\]", "", line), comments=True)
            words = list(itertools.takewhile(lambda word: word not in ("|", ">", "&&", "2>"), words))
            if words[:1] == ["asperity"]:
                lines.append((name, words[1:]))
    return lines


@pytest.mark.parametrize(("page", "words"), commands())
def test_commands_have_their_options(page: str, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Every command of a page is one of the parser, with options that are there."""
    try:
        cli._parser(words[0]).parse_args(words)
    except SystemExit as end:
        # HOST and RHO stand for values
        assert end.code == 0 or re.search(
            r"invalid (choice|float value): '[A-Za-z0-9|]+'", capsys.readouterr().err
        )


# --- tables and names ---------------------------------------------------------------------------------------


def section(page: str, heading: str) -> str:
    """Text under a heading, up to the next one of its level or above."""
    level = len(heading.split(" ")[0])
    pattern = rf"^{re.escape(heading)}\n(.*?)(?=^#{{1,{level}}} |\Z)"
    m = re.search(pattern, TEXTS[page], re.MULTILINE | re.DOTALL)
    assert m, heading
    return m[1]


def names_in_table(text: str) -> set[str]:
    """Names in the first column of a table, head left out, `s_N, ..., t_Ty` written out."""
    body = re.sub(r"^\|.*\n\|---.*\n", "", text, flags=re.MULTILINE)
    cells = re.findall(r"^\| ([^|]*) \|", body, re.MULTILINE)
    names = {name.strip() for cell in cells for name in cell.split(",")}
    if "..." in names:
        names |= {f"{letter}_{component}" for letter in "st" for component in ("N", "Tx", "Ty")}
    return names - {"..."}


def test_tables_of_the_contract() -> None:
    """`python -m harness.studies.tables --check` agrees; the status codes are those of asperity.h."""
    pages = CONTRACT, ARCHITECTURE
    done = run(sys.executable, "-m", "harness.studies.tables", "--check", *pages, cwd=ROOT)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    header = (ROOT / "src" / "asperity.h").read_text(encoding="utf-8")
    codes = [(number, name) for name, number in re.findall(r"(ASPERITY_\w+) = (\d+)", header)]
    assert codes and re.findall(r"^\| (\d+) \| `(ASPERITY_\w+)`", TEXTS[CONTRACT], re.MULTILINE) == codes


def test_every_constant_is_explained() -> None:
    """Each constant of law and pattern has a row in the table of concepts; the reserved entries are named."""
    shown = names_in_table(section("docs/concepts.md", "## What each constant does"))
    assert {row.name for row in contract.owned("law", "pattern")} - shown == set()
    reserved = " and ".join(str(row.index) for row in contract.props_table() if row.owner == "reserved")
    assert f"{reserved} are reserved and 0" in TEXTS[CONTRACT]


def test_rooms() -> None:
    """Each room that has a size has a row in the tree, and each row of the tree is there."""
    named = re.findall(r"^\|((?: ?`[\w/]+`,?)+) \|", section(ARCHITECTURE, "## The tree"), re.MULTILINE)
    folders = {name for cell in named for name in re.findall(r"`([\w/]+)`", cell)}
    assert len(folders) > 20 and {name for name in folders if not (ROOT / name).is_dir()} == set()
    rooms = {
        f"{part}/{room}"
        for part, rooms in tables.ROW_OF_SIZES.findall(TEXTS[ARCHITECTURE])
        for room in re.findall(r"(\S+) \d+", rooms)
        if part not in ("tests", "tools") and room != tables.TOP
    }
    assert len(rooms) > 15 and rooms <= folders


def test_sizes(tmp_path: Path) -> None:
    """A number of lines stays while it is near, and is written anew where it is not."""
    (tmp_path / "src" / "law").mkdir(parents=True)
    (tmp_path / "src" / "law" / "a.f90").write_text("x\n" * 1234, encoding="utf-8")
    (tmp_path / "src" / "law" / "a.csv").write_text("x\n" * 1234, encoding="utf-8")
    (tmp_path / "src" / "b.h").write_text("x\n" * 7, encoding="utf-8")
    for shown, expected in (("", 1200), ("law 1000", 1000), ("law 980", 1200)):
        (tmp_path / "page.md").write_text(f"| `src` | 1 | {shown} |\n", encoding="utf-8")
        assert f"| `src` | {expected + 7} | law {expected}, itself 7 |" in tables.sizes(tmp_path, "page.md")


def test_python_signatures() -> None:
    """The table of the contract has the names and the order of the arguments."""
    shown = re.findall(r"^\| `([\w.]+)\((.*?)\)` \|", section(CONTRACT, "## Python"), re.MULTILINE)
    assert len(shown) > 5
    for name, arguments in shown:
        function = asperity.Interface if name.startswith(".") else asperity
        for part in name.removeprefix("asperity").strip(".").split("."):
            function = getattr(function, part)
        names = [parameter for parameter in inspect.signature(function).parameters if parameter != "self"]
        listed = [argument.split("=")[0] for argument in arguments.split(", ") if argument]
        if "..." in listed:
            i = listed.index("...")
            names[i : len(names) - (len(listed) - i - 1)] = ["..."]
        assert listed == names, name


@pytest.mark.parametrize(
    "group", ["case", "material", "pattern", "step", "expect", "sweep", "replay", "initial", "state", "umat"]
)
def test_names_of_the_case_file(group: str, tmp_path: Path) -> None:
    """The driver lists the names of a group when it meets an unknown one; the page has just these."""
    (tmp_path / "case.nml").write_text(f"&{group} unheard_of = 1 /\n", encoding="utf-8")
    message = run(driver(), "case.nml", cwd=tmp_path).stderr
    m = re.search(rf"&{group}: unheard_of = 1: unknown name, expected one of (.*)", message)
    assert m, message
    text = section(DRIVER, f"### &{group}")
    shown = set(re.findall(r"(\w+) = ", text)) if group == "sweep" else names_in_table(text)
    assert shown == set(m[1].split(", ")), f"docs/reference/driver.md, &{group}"


def test_columns_and_events(tmp_path: Path) -> None:
    """Columns of the driver's CSV with those of one plane, and the events that its source names."""
    case = next(block.text for block in blocks("nml") if block.place.startswith(DRIVER))
    case = case.replace("&case ", "&case stability = T, ", 1)
    (tmp_path / "case.nml").write_text(case, encoding="utf-8")
    assert run(driver(), "case.nml", "--planes", cwd=tmp_path).returncode == 0
    columns = (tmp_path / "case.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    rows = section(DRIVER, "## Rows")
    of_rows, of_events = re.split(r"^(?=\| event \| what)", rows, flags=re.MULTILINE)
    expected = {re.sub(r"_1$", "_k", name) for name in columns if not re.search(r"_[2-9]$", name)}
    assert names_in_table(of_rows) == expected
    sources = [ROOT / name for name in ("src/joint/asperity_rie_law.f90", "src/run/asperity_load_path.f90")]
    source = "".join(path.read_text(encoding="utf-8") for path in sources)
    events = set(re.findall(r'name_event\((?:row%)?events?, "(\w+)"', source))
    assert events and names_in_table(of_events) == events


def test_options_of_the_driver() -> None:
    """Both synopses have the options of --help, and the table of the page has each once."""
    head = TEXTS[DRIVER].partition("\n## ")[0]
    known = set()
    for name, *words in (["rie_driver", driver()], ["asperity run", sys.executable, "-m", "asperity", "run"]):
        options = set(re.findall(r"^  (-[\w-]+)", run(*words, "--help").stdout, re.MULTILINE)) - {"-h"}
        synopsis = "".join(re.findall(rf"^{name} (.*\n(?: .*\n)*)", head, re.MULTILINE))
        assert options and set(re.findall(r"(?<!\w)-[\w-]+", synopsis)) == options, name
        known |= options
    assert sorted(re.findall(r"^\| `(-[\w-]+)", head, re.MULTILINE)) == sorted(known)


def texts_of(*patterns: str) -> str:
    """Texts of files of the repository."""
    paths = [path for pattern in patterns for path in ROOT.glob(pattern)]
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


def test_names_that_the_pages_have() -> None:
    """Targets of make, options of CMake, cases, tests, decks and extras of the package are there."""
    targets = set(re.findall(r"`make ([\w-]+)", ALL))
    known = run("make", "--print-data-base", "--question", "--silent", cwd=ROOT).stdout
    assert {"demo", "check"} <= targets <= set(re.findall(r"^([\w-]+):", known, re.MULTILINE))
    cmake = texts_of("CMakeLists.txt", "cmake/*")
    building = texts_of("docs/reference/c.md", "CONTRIBUTING.md")
    options = set(re.findall(r"`((?:ASPERITY|PFUNIT)_[A-Z]+)`", building))
    assert options and {name for name in options - {"ASPERITY_OK"} if name not in cmake} == set()
    cases = set(re.findall(r"harness/cases/[\w./]*\w", ALL))
    assert cases and {case for case in cases if not (ROOT / case).exists()} == set()
    code = texts_of("tests/**/*.p[fy]", "harness/**/*.p[fy]")
    tests = set(re.findall(r"`test: (\w+)`", ALL))
    procedures = set(re.findall(r"^\s*(?:subroutine|def) (\w+)\(", code, re.MULTILINE))
    assert tests and tests <= procedures | {deck.stem for deck in ROOT.glob("tests/decks/*.nml")}
    part = texts_of("pyproject.toml").partition("[project.optional-dependencies]")[2].partition("\n[")[0]
    sources = ALL + texts_of("python/asperity/**/*.py", "harness/**/*.py")
    extras = {name for names in EXTRA.findall(sources) for name in names.split(",")}
    assert len(extras) > 3 and extras <= set(re.findall(r"^([a-z-]+) =", part, re.MULTILINE))


def test_examples_that_the_page_lists() -> None:
    """Each is named by a test, by a command of a page or is a notebook; all of harness/examples are there."""
    links = [target for _, target in LINK.findall(section("docs/how-to/start.md", "## Examples"))]
    files = [ROOT / "docs" / "how-to" / target for target in links if not target.endswith("hosts.md")]
    commands = "".join(block.text for block in blocks("console"))
    built = "harness/examples/program/CMakeLists.txt"  # by tests/package
    tests = (
        texts_of("tests/**/test_*.py", "tests/python/conftest.py", built, "harness/**/test_*.py") + commands
    )
    names = {file.name: file.stem if file.suffix == ".nml" else file.name for file in files}
    modules = {f"{file.stem}.py": rf"\b{file.stem}\b" for file in files if file.suffix == ".py"}
    unused = [
        name
        for name, word in names.items()
        if not re.search(modules.get(name, rf"\b{re.escape(word)}\b"), tests) and not name.endswith(".ipynb")
    ]
    assert len(files) > 10 and unused == []
    own = (ROOT / "harness" / "examples").rglob("*.[cfnp]*")
    assert {file.name for file in own} <= names.keys()


# --- links --------------------------------------------------------------------------------------------------


def anchors(page: Path) -> set[str]:
    """Names that GitHub gives to the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", prose(page.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", TEXTS)
def test_links(name: str) -> None:
    """Files and headings."""
    links = LINK.findall(prose(TEXTS[name]))
    assert links
    for _, target in links:
        assert "://" not in target, target
        path, _, anchor = target.partition("#")
        file = (ROOT / name).parent / path if path else ROOT / name
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target


def test_numbers_of_the_paper() -> None:
    """Each linked number of the paper stands on the page that it leads to; citations have an entry."""
    page = ROOT / "docs" / "paper" / "paper.md"
    text = prose(page.read_text(encoding="utf-8"))
    linked = [(words, target) for words, target in LINK.findall(text) if target.endswith(".md")]
    assert len(linked) > 10
    for words, target in linked:
        linked_page = " ".join((page.parent / target).read_text(encoding="utf-8").split()).replace("**", "")
        number = re.escape(" ".join(words.split()))
        assert re.search(rf"(?<![\d.]){number}(?![\d.]*\d)", linked_page), (words, target)
    cited = set(re.findall(r"@(\w+)", text))
    known = re.findall(r"^@\w+{(\w+),", page.with_suffix(".bib").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited == set(known) and len(known) == len(set(known))
