"""Pages: their links lead somewhere, their code runs, their commands can be typed, and the site has all of them."""

from __future__ import annotations

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from contactlab.cli import main
from contactlab.commands.arguments import make_parser
from contactlab.parts.registry import default_registry

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), *sorted(ROOT.glob("*.md")), *sorted(ROOT.glob("plugins/*/*.md"))]
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
BUILT = (ROOT / "benchmarks" / "studies" / "pages.py").read_text().split("\nBUILT: ")[1].split("\n}\n")[0]
MADE = {
    *re.findall(r'^    "([\w-]+\.md)": ', BUILT, re.MULTILINE),
    *("gallery.md", "index.md", "contributing.md"),
    *(f"reference/{name}.md" for name in ("python", "contract", "parts")),
    *(f"tutorials/{path.stem}.md" for path in (DOCS / "notebooks").glob("*.ipynb")),
}
"""Pages that are made with the site."""
LONG = ("choose", "compare", "matrix", "explain", "view")
"""Commands of tutorials that are only looked at: processes of their own, or a window."""


def blocks(text: str) -> list[tuple[str, str]]:
    """Language and content of every block of code."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def without_code(text: str) -> str:
    return re.sub(r"^```.*?^```$|`[^`\n]*`", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(text: str) -> set[str]:
    """Names of headings that GitHub and the site give alike: the site makes one hyphen of several."""
    heads = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL), re.MULTILINE)
    names = {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}
    return {name for name in names if "--" not in name}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text(encoding="utf-8"))):
        if re.match(r"https?:|mailto:", link):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        made = target.is_relative_to(DOCS) and target.relative_to(DOCS).as_posix() in MADE
        if not made and not target.exists():
            broken.append(link)
        elif anchor and target.suffix == ".md" and target.exists():
            broken += [link] if anchor not in anchors(target.read_text(encoding="utf-8")) else []
    assert not broken


def test_pages_are_named_by_links() -> None:
    """A page that names another leads to it."""
    named = {
        page.relative_to(ROOT).as_posix(): names
        for page in DOCS.rglob("*.md")
        if (names := re.findall(r"`(docs/[\w/-]+\.md)`", re.sub(r"(?ms)^```.*?^```$", "", page.read_text())))
    }
    assert not named


def test_every_page_is_in_the_site() -> None:
    listed = set(re.findall(r"[\w./-]+\.md", (ROOT / "mkdocs.yml").read_text()))
    own = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")} - {"package.md"}
    assert listed - {"package.md"} == own | MADE  # that page is what an index shows


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda path: path.stem)
def test_tutorials_do_what_they_say(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python is run, files are written, commands are typed; those that take long are only understood."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for language, text in blocks(page.read_text(encoding="utf-8")):
        if language == "python":
            exec(compile(text, page.name, "exec"), names)
        elif language == "toml":
            Path(text.split()[1]).write_text(text)
        for line in text.splitlines() if language == "sh" else []:
            program, *words = shlex.split(line)
            assert program == "contactlab"
            assert make_parser().parse_args(words)
            if words[0] not in LONG:
                assert main(words) == 0


def test_commands_of_the_front_page_can_be_typed() -> None:
    for page in (ROOT / "README.md", DOCS / "package.md"):
        lines = [line for language, text in blocks(page.read_text(encoding="utf-8")) if language == "sh"
                 for line in text.splitlines()]  # fmt: skip
        commands = [shlex.split(line, comments=True) for line in lines]
        ours = [words for words in commands if words and words[0].endswith("contactlab")]
        assert len(ours) >= 4
        for words in ours:
            assert make_parser().parse_args(words[1:])


class TestSite:
    @pytest.fixture
    def tool(self, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
        monkeypatch.syspath_prepend(str(ROOT / "tools" / "site"))
        specification = importlib.util.spec_from_file_location("make_site", ROOT / "tools" / "site" / "make.py")
        assert specification is not None
        assert specification.loader is not None
        module = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(module)
        yield module
        for name in ("notebooks", "gallery"):
            sys.modules.pop(name, None)

    def test_names_of_the_reference_exist(self, tool: ModuleType) -> None:
        for name in (name for names in tool.PYTHON.values() for name in names):
            module, _, attribute = name.rpartition(".")
            assert getattr(importlib.import_module(module), attribute).__doc__
        for name in tool.CONTRACT:
            assert importlib.import_module(f"contactlab.api.{name}").__doc__

    @pytest.mark.full
    def test_the_gallery(self, tool: ModuleType, tmp_path: Path) -> None:
        """Two scenes and a case, not run; each with picture, words, TOML and command."""
        text = tool.gallery(tmp_path / "pictures", False, ["three-body-forging", "disc-in-box"], ["two-bars"])
        for name in ("three-body-forging", "disc-in-box", "case-two-bars"):
            assert f'id="{name}"' in text
            assert (tmp_path / "pictures" / f"{name}.png").exists()
        for words in ("A round-nosed billet", "contactlab matrix two-bars", "[bodies.disc]", "exchange their momentum"):
            assert words in text

    def test_cost_is_that_of_compiled_kernels(self, tool: ModuleType) -> None:
        """The first run of a scene on a machine compiles them, and no later one does."""
        summary = {"cost": {"run_cpu_s": 18.5, "compile_s": 18.0}, "steps": 1}
        results = SimpleNamespace(summary=summary, status="finished")
        assert sys.modules["gallery"].cost(results) == "1 step; 0.5 s of one core"
        results = SimpleNamespace(summary=summary | {"steps": 40_000}, status="timed-out")
        assert sys.modules["gallery"].cost(results) == "40 000 steps, stopped there; 0.5 s of one core"

    def test_cases_of_the_gallery_lead_to_their_numbers(self, tool: ModuleType) -> None:
        registry = default_registry()
        headings = anchors(tool.pages.BUILT["cases.md"]())
        places = {sys.modules["gallery"]._anchor(registry.part_class("case", name)) for name in registry.names("case")}
        assert places <= headings

    def test_links_that_lead_nowhere_are_found(self, tmp_path: Path) -> None:
        (tmp_path / "a.html").write_text(
            '<h2 id="here"></h2><a href="b.html#there">b</a><img src="no.png"><a href="#here">'
        )
        (tmp_path / "b.html").write_text('<a href="a.html#here"></a><a href="https://example.org/x">')
        done = subprocess.run(
            [sys.executable, ROOT / "tools" / "site" / "links.py", tmp_path],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 1
        assert done.stdout.splitlines() == ["a.html: b.html#there, there is no such place in it", "a.html: no.png"]

    def test_parts_have_their_fields(self, tool: ModuleType) -> None:
        registry = default_registry()
        text = tool._part(tool.part_page(registry.offer("mesh", "arc-block"), registry))
        assert "### arc-block" in text
        assert "| half_width | required | mm |" in text
        assert "```toml\n[bodies.NAME]\nmesh = " in text
