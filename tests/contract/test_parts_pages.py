"""The pages of docs/parts hold what they say: parts are those of new-plugin, examples run, names only grow."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contactlab_solids.neo_hookean import NeoHookean
from contactlab_statics.penalty import Penalty
from inline import runs_inline

from contactlab.api import Conditions, ImplicitEnforcement, Response
from contactlab.api.part import KINDS
from contactlab.cli import main
from contactlab.commands.new_plugin import plugin_files
from contactlab.parts.registry import default_registry

PARTS = Path(__file__).parents[2] / "docs" / "parts"
STORED = Path(__file__).with_name("public_names.txt")


def code_of(page: str, language: str = "python") -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", (PARTS / page).read_text(), re.MULTILINE | re.DOTALL)


def files_of(page: str) -> dict[str, str]:
    text = (PARTS / page).read_text()
    return dict(re.findall(r"^File `([^`]+)`:\n\n```\w+\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_shows_the_part_that_is_tested(kind: str) -> None:
    """tests/contract/test_strangers.py builds, installs and runs the packages with these very files."""
    ((name, text),) = files_of(f"{kind}.md").items()
    assert name == f"src/my_{kind}/{kind}.py"
    start = "rows" if kind == "contact" else ""  # formulas are on a page of their own
    assert text == plugin_files(kind, f"my-{kind}", start=start)[name]


def test_every_page_is_found_from_the_first() -> None:
    linked = set(re.findall(r"\]\((\S+\.md)\)", (PARTS / "README.md").read_text()))
    assert {page.name for page in PARTS.glob("*.md")} - {"README.md"} <= linked
    for page in PARTS.glob("*.md"):
        for link in re.findall(r"\]\((\S+\.md)\)", page.read_text()):
            assert (PARTS / link).exists(), f"{page.name} links to {link}"


@pytest.mark.parametrize("page", ["quadratic-edges.md", "from-python.md", "beside-the-others.md"])
def test_examples_run(page: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    default_registry.cache_clear()
    monkeypatch.syspath_prepend(str(tmp_path))
    for number, code in enumerate(code_of(page)):
        module = f"page_{page.split('.')[0].replace('-', '_')}_{number}"
        Path(f"{module}.py").write_text(code)
        with runs_inline():
            importlib.import_module(module)
    default_registry.cache_clear()


def test_the_penalty_of_the_page_is_the_shipped_one() -> None:
    """Without friction: the same forces, statuses and derivatives, whatever gaps and forces."""
    code = code_of("enforcement.md")[1]
    space: dict[str, Any] = {"np": np, "ImplicitEnforcement": ImplicitEnforcement}
    exec(code, space)
    draw, k = np.random.default_rng(1), 40
    conditions = Conditions(
        present=draw.uniform(size=k) > 0.2, gap=draw.normal(size=k), slip=np.zeros(0),
        force=np.zeros((1, k)), anchor=np.zeros((1, k)), measure=np.ones(k), size=np.ones(k),
        bound=np.zeros((3, 0)), stiffness=draw.uniform(1.0, 2.0, k),
    )  # fmt: skip
    found = []
    for enforcement in (space["Penalty"](), Penalty(factor=100.0)):
        out = Response.allocate(1, k)
        enforcement.respond(conditions, out)
        # what a force becomes at a fixed gap, and how that changes with the gap: free of how a residual is scaled
        found.append((-out.residual[0] / out.by_force[0], -out.by_gap[0] / out.by_force[0], out.status))
    for own, shipped in zip(*found, strict=True):
        np.testing.assert_allclose(own, shipped, atol=1e-10)


def test_the_law_of_the_page_is_the_shipped_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stress, tangent and energy by formulas, at random deformations."""
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "page_law.py").write_text(code_of("material.md")[0])
    shipped = NeoHookean(young=100.0, poisson=0.3, density=1e-9)
    own = importlib.import_module("page_law").MyMaterial(young=100.0, poisson=0.3, density=1e-9)
    gradient = np.array([[1.0], [0.0], [0.0], [1.0]]) + np.random.default_rng(3).uniform(-0.2, 0.2, (4, 64))
    found = []
    for law in (own, shipped):
        stress, energy, none = np.zeros((4, 64)), np.zeros(64), np.zeros((0, 64))
        law.stress(gradient, none, 0.0, stress, none)
        law.energy(gradient, none, energy)
        found.append((stress, energy, law.wave_speeds()))
    for mine, theirs in zip(*found, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-12, atol=1e-12)  # round-off of some ten operations


@pytest.mark.full
def test_hooks_bring_a_scene_a_command_and_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ((name, text),) = files_of("hooks.md").items()
    Path(name).write_text(text)
    assert main(["new-scene", "own-scene", "--from", "disc-on-block"]) == 0
    scenes, run = ([*line.split()][1:] for line in code_of("hooks.md", "sh")[0].splitlines())
    assert main(scenes) == 0
    assert "own-scene" in capsys.readouterr().out
    assert main([*run, "--set", "time.end=1e-6"]) == 0
    assert Path("run", "note.txt").read_text() == "own-scene: finished\n"
    monkeypatch.syspath_prepend(str(tmp_path))
    module = importlib.import_module("bench_hooks")
    assert module.contactlab_commands() == {"hello": "bench_hooks:hello"}
    assert module.hello(["you"]) == 0


def test_public_names_only_grow() -> None:
    """A name that was promised is there; new ones are added by `python tests/contract/public_names.py`."""
    from contactlab.api import __all__ as own

    lost = []
    for name in STORED.read_text().split():
        parts = name.split(".")
        end = next(n for n in range(len(parts), 0, -1) if _module(".".join(parts[:n])))
        found: Any = importlib.import_module(".".join(parts[:end]))
        for part in parts[end:]:
            there = hasattr(found, part) or part in getattr(found, "__annotations__", {})
            found = getattr(found, part, found)
            if not there:
                lost.append(name)
                break
    assert not lost, f"names that the contract promised are gone: {', '.join(lost)}"
    assert {f"contactlab.api.{name}" for name in own} <= set(STORED.read_text().split()), "python public_names.py"


def test_every_public_name_stands_on_a_page() -> None:
    """On that of its kind, or in the table of the contract."""
    from contactlab.api import __all__ as own

    pages = [PARTS.parent / "write-a-plugin.md", *PARTS.glob("*.md")]
    said = set(re.findall(r"\w+", "".join(page.read_text() for page in pages)))
    assert sorted(set(own) - said) == []


def _module(name: str) -> bool:
    try:
        importlib.import_module(name)
    except ModuleNotFoundError:
        return False
    return True
