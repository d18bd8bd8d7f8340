"""Code of all pages: commands can be typed, and name what there is; Python is run, here or by the test named here."""

from __future__ import annotations

import re
import shlex
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from contactlab_solids.neo_hookean import NeoHookean

from contactlab.api import Material, RunWarning
from contactlab.commands.arguments import make_parser
from contactlab.commands.common import parse_settings
from contactlab.parts.registry import Registry, default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import bundled_scenes, load_scene

ROOT = Path(__file__).parents[2]
PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("plugins/*/*.md"))
}
RUN_BY = {
    "README.md": "tests/docs/test_code.py",
    "docs/package.md": "tests/docs/test_code.py",
    "docs/effects.md": "tests/docs/test_code.py",
    "docs/find-the-step.md": "tests/docs/test_code.py",
    "docs/warnings.md": "tests/docs/test_code.py",
    "docs/parts/": "tests/contract/test_parts_pages.py",
    "docs/results-in-paraview-and-python.md": "tests/timeline/test_pages.py",
    "docs/theory/": "tests/architecture/test_theory_pages.py",
    "docs/tutorials/": "tests/docs/test_pages.py",
    "docs/write-a-plugin.md": "tests/contract/test_strangers.py",
}
"""Pages with Python, or folders of them, and who runs it."""
PLACEHOLDERS = re.compile(r"[A-Z]{2,}|\.\.\.|\||…")


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGES[page], re.MULTILINE | re.DOTALL)


def commands(page: str) -> Iterator[list[str]]:
    """The words behind `contactlab` in each command of the page that stands for itself, in blocks and in sentences."""
    for language in ("sh", "text"):
        for text in blocks(page, language):
            for line in text.replace("\\\n", " ").splitlines():
                if re.match(r"(\.venv/bin/)?contactlab ", line):
                    yield shlex.split(line.partition(" > ")[0], comments=True)[1:]
    without_blocks = re.sub(r"^```.*?^```$", "", PAGES[page], flags=re.MULTILINE | re.DOTALL)
    for inline in re.findall(r"`contactlab ([^`]+)`", without_blocks):
        text = " ".join(inline.split()).replace("\\|", "|")
        if " " in text and not PLACEHOLDERS.search(text):  # a word alone is the name of a command
            yield shlex.split(text.partition(" > ")[0])


ELSEWHERE = ("docs/write-a-plugin.md",)
"""Pages whose commands are typed by tests/contract/test_strangers.py."""
ALL = [(page, words) for page in sorted(PAGES) for words in commands(page) if page not in ELSEWHERE]


@pytest.mark.parametrize("page", sorted({page for page, _ in ALL}))
def test_commands_can_be_typed_and_name_what_there_is(page: str) -> None:
    registry = default_registry()
    for words in (words for other, words in ALL if other == page):
        if words[0] in registry.commands():
            continue
        options = make_parser().read(words)
        _check_scene(options)
        for name in (*getattr(options, "cases", []), *_names(words[0], options)):
            assert _known(name, registry), f"{page}: contactlab {shlex.join(words)}: there is no {name}"


def _check_scene(options: Namespace) -> None:
    """Keys that a command sets in a bundled scene are keys of it."""
    scene = getattr(options, "scene", None) or getattr(options, "source", "")
    if scene not in bundled_scenes() or not hasattr(options, "settings"):
        return
    settings = parse_settings(options.settings)
    load_scene(scene).with_(settings)
    for key, values in parse_settings(getattr(options, "vary", [])).items():
        for value in values:
            if not str(value).startswith("my-"):
                load_scene(scene).with_({**settings, key: value})


def _names(command: str, options: Namespace) -> Iterator[str]:
    """Parts that a command names."""
    for method in getattr(options, "contacts", []):
        yield from (part.split()[0] for part in method.split(" + "))
    if command == "parts" and options.name:
        yield options.name
    if command == "check":
        yield options.target


def _known(name: str, registry: Registry) -> bool:
    """Whether it is installed, or one that the reader of the page writes."""
    installed = any(offer.part.name == name for offer in registry.parts())
    return installed or name.startswith(("my-", "my_", "gauss-")) or name.endswith(".py")


def test_commands_are_found() -> None:
    assert len(ALL) > 80
    assert {words[0] for _, words in ALL} >= {"run", "compare", "choose", "matrix", "check", "view", "explain"}


def test_python_of_every_page_is_run_by_a_test() -> None:
    for page in (page for page in PAGES if blocks(page, "python")):
        (name,) = (name for name in RUN_BY if page == name or (name.endswith("/") and page.startswith(name)))
        assert Path(name).stem in (ROOT / RUN_BY[name]).read_text(encoding="utf-8"), page


@pytest.mark.parametrize("page", ["README.md", "docs/package.md"])
def test_python_of_the_front_pages_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = blocks(page, "python")
    names: dict[str, Any] = {}
    exec(compile(code, page, "exec"), names)
    assert names["results"].status == "finished"
    named = re.search(r"# ([\w, ]+)$", code.rstrip())
    assert named is not None
    for field in named[1].split(", "):
        assert len(getattr(names["curve"], field)) == len(names["curve"].s), field


def test_declarations_of_effects_are_those_of_the_law() -> None:
    (code,) = blocks("docs/effects.md", "python")
    names: dict[str, Any] = {"Material": Material}
    exec(compile(code, "effects.md", "exec"), names)
    assert (names["NeoHookean"].without, names["NeoHookean"].beyond) == (NeoHookean.without, NeoHookean.beyond)


def test_the_warning_of_the_page_can_be_raised() -> None:
    (code,) = blocks("docs/warnings.md", "python")
    raised: list[RunWarning] = []
    warnings = SimpleNamespace(add=raised.append)
    exec(
        compile(code, "warnings.md", "exec"), {"model": SimpleNamespace(warnings=warnings), "value": 2.0, "limit": 1.0}
    )
    assert raised[0].text == "contacts.0: the thing seen is 2 (allowed 1); try this or that"


def test_python_that_finds_the_step_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a short run of the scene of the page, which keeps everything that the code looks at."""
    monkeypatch.chdir(tmp_path)
    (words,) = (words for _, words in ALL if words[0] == "run" and words[-1] == "runs/chatter")
    options = make_parser().read(words)
    scene = load_scene(options.scene).with_({**parse_settings(options.settings), "time.end": 2e-6, "record.frames": 2})
    simulate(scene, Path(options.out))
    for code in blocks("docs/find-the-step.md", "python"):
        exec(compile(code, "find-the-step.md", "exec"), {})
