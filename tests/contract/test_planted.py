"""Parts of strangers: right ones are not refused, planted defects are found, in words that say what is wrong."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest
from planted import NOT_CAUGHT, PLANTED
from plugin_page import FILES

from contactlab.parts.registry import Registry
from contactlab.testing.check_part import PartReport, check_part
from contactlab.testing.subject import Subject

NUMBER = itertools.count()
HERE = Path(__file__).parent
TEMPLATES = HERE.parents[1] / "src" / "contactlab" / "data" / "new_plugin"
HOOK = """

from contactlab.api.plugin import Part as _Part, hookimpl as _hookimpl


@_hookimpl
def contactlab_parts():
    return [_Part("{kind}", "{name}", "{module}:{cls}", "of a stranger")]
"""
RIGHT = sorted(path.stem for path in (HERE / "right_parts").glob("*.py"))
QUICK = ("function", "mesh", "measure", "reference", "recorder", "case")
"""Kinds whose checks take a few hundredths of a second."""
EVERY = 5  # of the defects of quick kinds in the default tier


def source_of(base: str) -> tuple[str, str, str]:
    """Kind, class and source of a part: "right NAME", "template KIND/FILE", or "KIND outside (or page) PATH:CLASS"."""
    words = base.split()
    if words[0] == "right":
        text = (HERE / "right_parts" / f"{words[1]}.py").read_text(encoding="utf-8")
        found = re.match(r"# kind (\w+) cls (\w+)\n", text)
        assert found
        return found[1], found[2], text
    if words[0] == "template":
        kind, _, file = words[1].partition("/")
        text = (TEMPLATES / kind / f"{file or 'part'}.py.template").read_text(encoding="utf-8")
        return kind, "Mine", text.replace("$class_name", "Mine").replace("$name", "mine").replace("$$", "$")
    path, _, cls = words[2].partition(":")
    text = FILES[path] if words[1] == "page" else (HERE.parent / "outside" / path).read_text(encoding="utf-8")
    return words[0], cls, text.partition("@hookimpl")[0]


def changed(base: str, changes: tuple[str, ...]) -> str:
    """The source of a part with pieces exchanged."""
    text = source_of(base)[2]
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        every = old.startswith("*")
        piece = old.removeprefix("*")
        assert piece in text, f"{base}: {piece!r} does not stand in it"
        text = text.replace(piece, new) if every else text.replace(piece, new, 1)
    return text


def subject_of(base: str, folder: Path, changes: tuple[str, ...] = ()) -> Subject:
    """The part with pieces of its source exchanged, in a file of its own."""
    kind, cls, _ = source_of(base)
    text, module = changed(base, changes), f"stranger_{next(NUMBER)}"
    file = folder / f"{module}.py"
    file.write_text(text + HOOK.format(kind=kind, name="strange", module=module, cls=cls), encoding="utf-8")
    return Subject(Registry(files=[file]), kind, "strange")


def checked(base: str, folder: Path, changes: tuple[str, ...] = ()) -> PartReport:
    """What `contactlab check` says, up to the first failure."""
    return check_part(subject_of(base, folder, changes), until_failure=True)


def tier(names: list[tuple[str, str]]) -> list[object]:
    """Some of the quick ones in every tier, all others in the full one."""
    quick = [name for name in names if source_of(name[0])[0] in QUICK][::EVERY]
    return [n if n in quick else pytest.param(*n, marks=pytest.mark.full) for n in names]


CAUGHT = [(base, d[0]) for base, defects in PLANTED.items() for d in defects if (base, d[0]) not in NOT_CAUGHT]


def _changes(base: str, says: str) -> tuple[str, ...]:
    return next(d[1:] for d in PLANTED[base] if d[0] == says)


@pytest.mark.parametrize(("base", "says"), tier(CAUGHT))
def test_a_planted_defect_is_found(base: str, says: str, tmp_path: Path) -> None:
    report = checked(base, tmp_path, _changes(base, says))
    failed = [outcome for outcome in report.outcomes if outcome.status == "failed"]
    assert failed, f"{base}, {says}: not caught"
    assert len(failed[0].reason) > 20, "a failure must say what is wrong"


@pytest.mark.parametrize(("base", "says"), tier([(f"right {name}", "") for name in RIGHT]))
def test_a_right_part_is_not_refused(base: str, says: str, tmp_path: Path) -> None:
    report = checked(base, tmp_path)
    assert [(o.check, o.reason) for o in report.outcomes if o.status == "failed"] == []


def test_there_are_enough_of_each() -> None:
    assert len(RIGHT) >= 30
    assert sum(map(len, PLANTED.values())) >= 150


@pytest.mark.parametrize("base", PLANTED)
def test_what_is_exchanged_stands_in_the_part(base: str) -> None:
    for _, *changes in PLANTED[base]:
        assert changed(base, tuple(changes)) != source_of(base)[2]


def test_what_is_not_caught_is_listed_with_a_reason() -> None:
    known = {(base, defect[0]) for base, defects in PLANTED.items() for defect in defects}
    assert set(NOT_CAUGHT) <= known
    assert all(NOT_CAUGHT.values())
