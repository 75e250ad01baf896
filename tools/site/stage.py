"""stage.py WORK: gather what the site is made of in WORK/pages, and write WORK/mkdocs.yml.

The pages of the repository keep their paths, so that links hold. Navigation comes from docs/README.md. A
source file that a page links to becomes a page of its own, as do the paper, the C header and the public
Fortran sources, a linked folder a list of its files. The gallery starts with small pictures. The Python
reference has the public names of the package.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
TOP_PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CODE_OF_CONDUCT.md", "SECURITY.md")
LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
HEADING = re.compile(r"^## (.+)$", re.MULTILINE)
PICTURE = re.compile(r"!\[([^\]]*)\]\(([^)]+)\)")
LANGUAGES = {
    ".f90": "fortran",
    ".nml": "fortran",
    ".py": "python",
    ".h": "c",
    ".xml": "xml",
}
PAPER = ROOT / "docs" / "paper" / "paper.md"
FORTRAN = [f"asperity_{name}.f90" for name in "interface arrays contract kinds initial umat vumat".split()]
API = [next((ROOT / "src").rglob(name)) for name in ("asperity.h", *FORTRAN)]
"""Header and sources with what a program may call or use."""
KEPT = {".md", ".png", ".csv"}
"""Files of docs and of the top folder that the site has as they are."""


class Stage:
    """Pages and files of the site."""

    def __init__(self, pages: Path) -> None:
        """Start with an empty folder."""
        self.pages = pages
        shutil.rmtree(pages, ignore_errors=True)
        self.linked: set[Path] = set()

    def write(self, name: str | Path, text: str) -> None:
        """Write one page."""
        target = self.pages / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")

    def page(self, source: Path) -> None:
        """Stage a page of the repository; its links to source files lead to the pages of these."""
        text = source.read_text(encoding="utf-8")
        if source.parent.name == "gallery":
            text = with_thumbnails(text)

        def follow(m: re.Match[str]) -> str:
            target = Path(os.path.normpath(source.parent / m[2]))
            if "://" in m[2] or not target.is_relative_to(ROOT) or not target.exists():
                return m[0]
            kept = target.suffix in KEPT and target != PAPER
            if kept and target.parts[len(ROOT.parts)] in ("docs", target.name):
                return m[0]
            self.linked.add(target)
            path = os.path.relpath(ROOT / page_of(target), source.parent)
            return f"{m[1]}{path}{m[3] or ''}{m[4]}"

        self.write(source.relative_to(ROOT), LINK.sub(follow, text))

    def follow_links(self) -> None:
        """Stage the files and folders that pages link to."""
        for target in sorted(self.linked):
            if target.is_dir():
                names = sorted(f for f in target.rglob("*") if f.is_file() and "__pycache__" not in f.parts)
                here = (ROOT / page_of(target)).parent
                lines = [f"# {target.relative_to(ROOT)}", ""]
                for name in names:
                    self.source(name)
                    page = os.path.relpath(ROOT / page_of(name), here)
                    lines.append(f"- [{name.relative_to(target)}]({page})")
                self.write(page_of(target), "\n".join(lines) + "\n")
            else:
                self.source(target)

    def source(self, file: Path) -> None:
        """Stage a source file as a page."""
        text = file.read_text(encoding="utf-8").rstrip()
        if file.suffix == ".ipynb":
            self.write(page_of(file), notebook(text))
            return
        language = LANGUAGES.get(file.suffix, "text")
        self.write(page_of(file), f"# {file.relative_to(ROOT)}\n\n````{language}\n{text}\n````\n")


def notebook(text: str) -> str:
    """Page with the cells of a notebook and what they print."""
    parts = []
    for cell in json.loads(text)["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
        parts += [
            "```text\n" + "".join(output["text"]).rstrip() + "\n```" for output in cell.get("outputs", [])
        ]
    return "\n\n".join(parts) + "\n"


def page_of(target: Path) -> Path:
    """Page that shows a file or a folder of the repository."""
    name = target.relative_to(ROOT)
    return Path("files") / name / "index.md" if target.is_dir() else Path("files") / f"{name}.md"


def with_thumbnails(text: str) -> str:
    """Put small pictures that lead to the entries before the first entry of a gallery."""
    first = HEADING.search(text)
    if not first:
        return text
    cards = []
    for entry in re.split(r"(?=^## )", text[first.start() :], flags=re.MULTILINE):
        heading, picture = HEADING.search(entry), PICTURE.search(entry)
        if heading and picture:
            name = re.sub(r"[^\w\- ]", "", heading[1].lower()).replace(" ", "-")
            cards.append(f"[![]({picture[2]}) {heading[1]}](#{name})")
    grid = '<div class="gallery" markdown="span">\n' + "\n".join(cards) + "\n</div>\n\n"
    return text[: first.start()] + grid + text[first.start() :]


def navigation(text: str) -> list[object]:
    """Navigation from docs/README.md, pages by title: links of the first lines, then of each section."""
    nav: list[object] = [{"Home": "README.md"}, {"All pages": "docs/README.md"}]
    for part in re.split(r"^(?=\*\*\w)", text, flags=re.MULTILINE):
        entries = nav
        section = re.match(r"\*\*(\w[\w -]*):", part)
        if section:
            entries = []
            nav.append({section[1]: entries})
        targets = [os.path.normpath(f"docs/{target}") for target in re.findall(r"\]\(([^)#]+)\)", part)]
        entries += [target for target in targets if ROOT / target != PAPER]
    return nav


BEGIN = ("Interface", "Material", "Pattern", "Step", "History")
"""Names with which the Python reference begins."""
TOOLS = ("barton", "fit", "plots", "selection", "surface", "uncertainty")
"""Modules of the toolbox that the Python reference has."""


def python_page() -> str:
    """Python reference: the public names, those of a joint first."""
    package = (ROOT / "python" / "asperity" / "__init__.py").read_text(encoding="utf-8")
    lines = ["# Python", "", "The public names of the package, from the comments in its source.", ""]
    names = re.findall(r"^from \.([\w.]*) import (\w+) as", package, re.MULTILINE)
    for home, name in sorted(
        names, key=lambda entry: BEGIN.index(entry[1]) if entry[1] in BEGIN else len(BEGIN)
    ):
        lines += [f"::: {'.'.join(filter(None, ('asperity', home, name)))}", ""]
    lines += ["# Toolbox", "", "Modules of `asperity.tools`, each imported by its name.", ""]
    lines += [line for name in TOOLS for line in (f"::: asperity.tools.{name}", "")]
    return "\n".join(lines)


def version() -> str:
    """Version of the library, from its owner."""
    text = (ROOT / "src" / "law" / "asperity_contract.f90").read_text(encoding="utf-8")
    return re.findall(r'public :: version = "([0-9.]+)"', text)[0]


def main() -> None:
    """Run the command."""
    work = Path(sys.argv[1]).resolve()
    stage = Stage(work / "pages")
    sources = [ROOT / name for name in TOP_PAGES]
    sources += [f for f in sorted((ROOT / "docs").rglob("*")) if f.is_file() and f != PAPER]
    for source in sources:
        if source.suffix == ".md":
            stage.page(source)
        elif source.suffix in KEPT:
            target = stage.pages / source.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
    stage.linked.update(API)
    stage.follow_links()
    stage.write("api/python.md", python_page())
    shutil.copytree(Path(__file__).parent / "assets", stage.pages / "assets", dirs_exist_ok=True)
    shutil.copytree(work / "katex", stage.pages / "assets" / "katex")

    nav = navigation((ROOT / "docs" / "README.md").read_text(encoding="utf-8"))
    nav.append({"API": [{"Python": "api/python.md"}, *({file.name: str(page_of(file))} for file in API)]})
    about = [{name.removesuffix(".md").capitalize().replace("_", " "): name} for name in TOP_PAGES[2:]]
    nav.append({"Project": about})

    config = Path(__file__).with_name("mkdocs.yml").read_text(encoding="utf-8")
    config = config.replace("PYTHON_PACKAGE", str(ROOT / "python"))
    config += yaml.safe_dump(
        {"nav": nav, "docs_dir": str(stage.pages), "copyright": f"asperity {version()}, BSD-3-Clause"}
    )
    (work / "mkdocs.yml").write_text(config, encoding="utf-8")


if __name__ == "__main__":
    main()
