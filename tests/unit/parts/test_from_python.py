"""Parts of a program: a class or a file, for runs, and for processes that import it themselves."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import contactlab
from contactlab.api import FrictionBound, FrictionLaw
from contactlab.errors import PartError
from contactlab.parts.registry import Registry, default_registry


@dataclass(frozen=True)
class HalfGrip(FrictionLaw):
    """Half of what Coulomb allows."""

    mu: float = 0.2

    def bound(self) -> FrictionBound:
        return FrictionBound(0.5 * self.mu, 0.0, 0.0)


class Forgotten(FrictionLaw):
    """Neither frozen nor complete."""


@pytest.fixture
def fresh() -> Iterator[Registry]:
    """The registry of a process that has used nothing yet."""
    default_registry.cache_clear()
    yield default_registry()
    default_registry.cache_clear()


def test_a_class_serves_in_a_scene(fresh: Registry) -> None:
    assert contactlab.use(HalfGrip) == "half-grip"
    assert contactlab.use(HalfGrip) == "half-grip"  # a cell of a notebook is run again
    scene = contactlab.load_scene("disc-on-block").with_({"contacts.0.friction": {"use": "half-grip", "mu": 0.4}})
    assert scene.registry.make("friction", scene.contacts[0].friction).bound().coefficient == 0.2
    assert [o.part.summary for o in fresh.parts() if o.part.name == "half-grip"] == ["Half of what Coulomb allows"]


def test_another_process_finds_it(fresh: Registry) -> None:
    contactlab.use(HalfGrip, "own-grip")
    assert "own-grip" in pickle.loads(pickle.dumps(fresh)).names("friction")


def test_a_class_of_the_running_program_stays_there(fresh: Registry, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(HalfGrip, "__module__", "__main__")
    contactlab.use(HalfGrip)
    with pytest.raises(PartError, match="other processes cannot import"):
        pickle.dumps(fresh)


@pytest.mark.parametrize(
    ("part", "name", "word"),
    [(Forgotten, "", "it has no bound"), (int, "", "cannot be used as a part"), (HalfGrip, "coulomb", "already")],
)
def test_what_is_no_part_is_refused(part: type, name: str, word: str, fresh: Registry) -> None:
    with pytest.raises(PartError, match=word):
        contactlab.use(part, name)


def test_a_file_serves_as_with_the_command(fresh: Registry, tmp_path: Path) -> None:
    file = tmp_path / "python_friction.py"
    file.write_text(
        "from dataclasses import dataclass\n"
        "from contactlab.api import FrictionBound, FrictionLaw\n"
        "from contactlab.api.plugin import Part, hookimpl\n\n"
        "@dataclass(frozen=True)\nclass Law(FrictionLaw):\n"
        "    def bound(self):\n        return FrictionBound(0.1, 0.0, 0.0)\n\n"
        "@hookimpl\ndef contactlab_parts():\n"
        "    return [Part('friction', 'from-file', 'python_friction:Law', 'a law')]\n"
    )
    contactlab.use(file)
    assert "from-file" in fresh.names("friction")
    assert "from-file" in pickle.loads(pickle.dumps(fresh)).names("friction")
