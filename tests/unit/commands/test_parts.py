"""What `contactlab parts NAME` tells, and which package is named where a part is missing."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from contactlab.cli import main
from contactlab.commands.part_page import page_of
from contactlab.errors import PartError
from contactlab.parts.description import described_fields, prose
from contactlab.parts.loading import installed
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.schema import KINDS

OFFERS = [offer for offer in default_registry().parts() if offer.part.kind in KINDS]


@dataclass(frozen=True)
class Base:
    """Of bases, too.

    x, y  from and
          to [mm]
    """

    x: float
    y: float = 1.0


@dataclass(frozen=True)
class Derived(Base):
    """A part for tests
    in two lines.

    slow   whether it takes its time
    y [mm/s], another meaning

    Last words.
    """

    slow: bool = False


def test_descriptions_come_from_the_class_and_its_bases() -> None:
    x, y, slow = described_fields(Derived)
    assert (x.name, x.default, x.unit, x.meaning, x.accepts) == ("x", "required", "mm", "from and to", "a number")
    assert (y.default, y.unit, y.meaning) == ("1.0", "mm/s", "another meaning")
    assert (slow.default, slow.accepts) == ("false", "true or false")
    assert prose(Derived) == "A part for tests in two lines.\n\nLast words."


@pytest.mark.parametrize("offer", OFFERS, ids=lambda offer: f"{offer.part.kind} {offer.part.name}")
def test_every_part_of_a_scene_tells_all(offer: object) -> None:
    page = page_of(offer, default_registry())  # type: ignore[arg-type]
    assert page["says"]
    assert not [field["name"] for field in page["fields"] if not (field["meaning"] or field["unit"])]
    assert page["example"] or page["name"] == "file"


def test_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["parts", "friction.coulomb", "--json"]) == 0
    (part,) = json.loads(capsys.readouterr().out)["parts"]
    assert part["fields"][0]["name"] == "mu"


def test_an_unknown_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["parts", "colomb"]) == 2
    assert 'did you mean "coulomb"?' in capsys.readouterr().err


class TestMissing:
    @pytest.fixture
    def core_alone(self) -> Registry:
        return Registry([point for point in installed() if point.dist is not None and point.dist.name == "contactlab"])

    def test_the_package_that_brings_a_part_is_named(self, core_alone: Registry) -> None:
        with pytest.raises(PartError, match="pip install contactlab-mortar"):
            core_alone.make("contact", "mortar-p0")

    def test_what_nobody_brings_is_not(self, core_alone: Registry) -> None:
        with pytest.raises(PartError) as raised:
            core_alone.make("contact", "dual-mortar")
        assert "pip install" not in str(raised.value)

    def test_the_list_is_that_of_this_repository(self) -> None:
        path = Path(__file__).parents[2] / "architecture" / "known_parts.py"
        specification = importlib.util.spec_from_file_location("known_parts", path)
        assert specification is not None
        assert specification.loader is not None
        module = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(module)
        written = json.loads(module.FILE.read_text())
        assert written == module.known_parts(), "run python tests/architecture/known_parts.py"
