"""`contactlab check`: what is meant, what comes out, and the exit status."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from contactlab.cli import main
from contactlab.commands.new_plugin import plugin_files
from contactlab.errors import RequestError
from contactlab.parts.registry import default_registry
from contactlab.testing.check_part import check_part
from contactlab.testing.find import subjects

OUTSIDE = Path(__file__).parents[1] / "outside" / "closest-point"
SLIP = '''
from dataclasses import dataclass

from contactlab.api import FrictionBound, FrictionLaw
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Slip(FrictionLaw):
    """Coulomb's law, or one whose bound falls."""

    mu: float = 0.2

    def bound(self):
        return FrictionBound(self.mu, {grip}, 5.0)


@hookimpl
def contactlab_parts():
    return [Part("friction", "{name}", "{module}:Slip", "Coulomb with some grip")]
'''


def file_with(folder: Path, module: str, grip: float) -> Path:
    path = folder / f"{module}.py"
    path.write_text(SLIP.format(grip=grip, name=module.replace("_", "-"), module=module))
    return path


def test_a_wrong_part_fails_and_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")  # a narrow terminal breaks the reason into several lines
    path = file_with(tmp_path, "wrong_slip", -1.0)
    assert main(["check", str(path)]) == 1
    told = capsys.readouterr().out
    assert "adhesion: got -1.0, allowed: finite and at least 0" in told
    assert "2 failed" in told


def test_a_part_that_breaks_the_contract_is_checked_no_further(tmp_path: Path) -> None:
    path = tmp_path / "no_slip.py"
    path.write_text(SLIP.format(grip=0.0, name="no-slip", module="no_slip").replace("def bound", "def limit"))
    report = check_part(subjects(str(path))[0])
    assert [(o.check, o.status) for o in report.outcomes] == [("keeps_the_contract", "failed")]
    assert "it has no bound" in report.outcomes[0].reason


PUSH = """
from dataclasses import dataclass

from contactlab.api import Effect
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Push(Effect):
    gain: float

    def __post_init__(self):
        if self.gain < {least}:
            raise ValueError(f"gain: got {{self.gain}}, allowed: {least} and more")

    def bind(self, view):
        def add(time, force):
            force[:, 1] -= self.gain

        return add


@hookimpl
def contactlab_parts():
    return [Part("effect", "{name}-push", "{name}_push:Push", "an even push")]
"""


def test_a_field_of_an_unknown_name_gets_a_value_by_its_type(tmp_path: Path) -> None:
    path = tmp_path / "soft_push.py"
    path.write_text(PUSH.format(name="soft", least=0.5))
    (subject,) = subjects(str(path))
    assert subject.make().gain == 1.0
    report = check_part(subject, only=["gives_forces", "numbers_count"])
    assert [outcome.status for outcome in report.outcomes] == ["passed"] * 3


def test_a_part_of_which_nothing_can_be_checked_is_not_right(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It refuses the value that was tried for its field: the table says so and what to type, and the status is 1."""
    monkeypatch.setenv("COLUMNS", "250")
    path = tmp_path / "hard_push.py"
    path.write_text(PUSH.format(name="hard", least=7.0))
    assert main(["check", str(path)]) == 1
    told = capsys.readouterr().out
    assert "1 not applicable" in told
    assert "--set gain=..." in told
    assert main(["check", str(path), "--set", "gain=8.0", "--only", "gives forces"]) == 0


def test_a_generated_effect_moves_and_turns_with_its_scene(tmp_path: Path) -> None:
    """It declares the centre that its frame turns about as a point."""
    for name, text in plugin_files("effect", "frame-effect").items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    only = ["the_frame_does_not_matter", "rotation_turns_the_answers", "points_and_vectors_are_fields"]
    report = check_part(subjects(str(tmp_path))[0], only=only)
    assert [outcome.status for outcome in report.outcomes] == ["passed"] * 4, report.outcomes


def test_a_folder_and_a_distribution_mean_all_their_parts(tmp_path: Path) -> None:
    file_with(tmp_path, "first_slip", 0.0)
    file_with(tmp_path, "second_slip", 0.0)
    assert [s.name for s in subjects(str(tmp_path))] == ["first-slip", "second-slip"]
    assert {s.kind for s in subjects("contactlab-statics")} == {"integrator", "enforcement"}
    assert {s.kind for s in subjects("contactlab-statics", "integrator")} == {"integrator"}


def test_a_package_that_is_not_installed_is_checked_from_its_folder(tmp_path: Path) -> None:
    source = tmp_path / "src" / "loose_slip"
    source.mkdir(parents=True)
    (source / "__init__.py").touch()
    text = SLIP.format(grip=0.0, name="loose-slip", module="loose_slip.plugin")
    (source / "plugin.py").write_text(text)
    (tmp_path / "pyproject.toml").write_text(
        '[project]\nname = "loose-slip"\n[project.entry-points.contactlab]\nloose = "loose_slip.plugin"\n'
    )
    (subject,) = subjects(str(tmp_path))
    assert subject.make().mu == 0.2


def package(folder: Path, module: str, text: str) -> Path:
    """A package of one module that is not installed."""
    source = folder / "src" / module
    source.mkdir(parents=True)
    (source / "__init__.py").touch()
    (source / "plugin.py").write_text(text)
    (folder / "pyproject.toml").write_text(
        f'[project]\nname = "{module}-parts"\nversion = "0.3"\n'
        f'[project.entry-points.contactlab]\n{module} = "{module}.plugin"\n'
    )
    return folder


@pytest.mark.full
def test_a_card_names_the_package_of_a_folder_and_its_version(tmp_path: Path) -> None:
    text = SLIP.format(grip=0.0, name="shown-slip", module="shown_slip.plugin")
    folder = package(tmp_path / "shown", "shown_slip", text)
    assert main(["check", str(folder), "--card", str(tmp_path / "card")]) == 0
    card = json.loads((tmp_path / "card" / "card.json").read_text())
    assert card["parts"][0]["from"] == "shown_slip-parts 0.3"
    assert card["versions"]["shown_slip-parts"] == "0.3"
    assert card["format"] == 1


def test_a_package_that_cannot_be_imported_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = package(tmp_path / "broken", "broken_slip", "import nothing_of_this_name\n")
    assert main(["check", str(folder)]) == 2
    assert "No module named 'nothing_of_this_name'" in capsys.readouterr().err


@pytest.mark.parametrize("target", ["block-on-incline", "contactlab-cases"])
def test_what_a_usual_package_would_bring_is_told(
    target: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CONTACTLAB_PLUGINS", "contactlab-mortar")
    default_registry.cache_clear()
    try:
        assert main(["check", target]) == 2
        assert "pip install contactlab-cases" in capsys.readouterr().err
        assert main(["matrix"]) == 2
        assert "pip install contactlab-cases" in capsys.readouterr().err
    finally:
        default_registry.cache_clear()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["mortar"], "no part, file, folder or distribution"),
        (["mortar-p1", "--kind", "contacts"], 'did you mean "contact"'),
        (["mortar-p1", "--kind", "element"], "no part of this kind"),
        (["missing.py"], "there is no such file"),
        (["coulomb", "--set", "grip=0.7"], 'unknown key "grip"'),
        (["coulomb", "--set", "mu=-0.7"], "a coefficient of at least 0"),
        (["coulomb", "--only", "rub_at_all"], 'did you mean "rubs_at_all"'),
        (["coulomb", "--only", "rubs at all", "--card", "card"], "a card needs all checks"),
        (["mortar-p1", "--python", "--json"], "--python runs the unit checks only"),
        (["tests"], "no parts in this folder"),
    ],
)
def test_a_wrong_request_is_refused(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tests").mkdir()
    monkeypatch.chdir(tmp_path)
    assert main(["check", *words]) == 2
    assert told in capsys.readouterr().err


def test_fields_can_be_given() -> None:
    (subject,) = subjects("coulomb", given={"mu": 0.7})
    assert subject.make().mu == 0.7
    with pytest.raises(RequestError):
        subjects("coulomb", given={"grip": 0.7})[0].make()


def test_single_checks_are_made_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    """As they are shown, or as functions; what everything rests on is asked first."""
    assert main(["check", "coulomb", "--only", "rubs at all", "--only", "same_bound_twice", "--json"]) == 0
    (part,) = json.loads(capsys.readouterr().out)["parts"]
    assert [check["name"] for check in part["checks"]] == ["keeps_the_contract", "rubs_at_all", "same_bound_twice"]
    assert part["cost"] == []


def test_cost_stands_beside_parts_that_are_asked_for_the_same() -> None:
    """One in NumPy for fewer segments, and then the shipped ones, too."""
    from contactlab.testing.cost import costs

    (subject,) = subjects(str(OUTSIDE), "contact")[:1]
    found = {cost.name: cost.of for cost in costs(subject)}
    assert {"mortar-p1", "node-on-segment"} < set(found)
    assert set(found.values()) == {"pieces and rows of 40 segments"}


POINTS = '''
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import PointContact, formula
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Halves(PointContact):
    """Closest points, with a case that never is."""

    passes_patch_test: ClassVar[bool] = False

    @formula
    def foot(x, master):
        """Of the line."""
        return share(x.at - master.start, master.edge())


def share(way, edge):
    if edge @ edge < 0.0:
        return 0.5
    return (way @ edge) / (edge @ edge)


@hookimpl
def contactlab_parts():
    return [Part("contact", "halves", "halves:Halves", "closest points")]
'''


@pytest.mark.full
def test_formulas_run_as_plain_python_and_lines_that_did_not_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All but one of a function that the formula calls, and no kernel was compiled; the environment is as before."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.delenv("CONTACTLAB_PYTHON", raising=False)
    file = tmp_path / "halves.py"
    file.write_text(POINTS)
    assert main(["check", str(file), "--python", "--only", "weights_are_the_derivative"]) == 0
    assert "CONTACTLAB_PYTHON" not in os.environ
    said = capsys.readouterr().out
    line = 1 + POINTS.splitlines().index("        return 0.5")
    assert f"halves.py: {line}" in said
    assert re.search(r"foot +1 of 1 .*share +2 of 3 ", said, re.DOTALL)
    assert main(["check", "coulomb", "--python"]) == 2
    assert "none of these parts has formulas" in capsys.readouterr().err


def test_a_file_without_parts_is_called_that(tmp_path: Path) -> None:
    path = tmp_path / "nothing_here.py"
    path.write_text(
        "from contactlab.api.plugin import hookimpl\n\n\n@hookimpl\ndef contactlab_parts():\n    return []\n"
    )
    with pytest.raises(RequestError, match="no parts in this file"):
        subjects(str(path))
