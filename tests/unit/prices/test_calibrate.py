"""Prices from samples: made-up costs give the made-up prices back; what cannot be measured is said to be unknown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from contactlab.api import Effect, Part
from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.parts.registry import Registry
from contactlab.prices import calibrate as calibration
from contactlab.prices.calibrate import calibrate
from contactlab.prices.counts import Length, counts_of, total
from contactlab.prices.measure import Measured
from contactlab.prices.price import price_of
from contactlab.prices.price_list import PriceList
from contactlab.prices.quiet import Timed
from contactlab.prices.samples import Stages
from contactlab.run.prepare import schedule_of
from contactlab.scene.scene import Scene, load_scene


class MadeUp:
    """A machine where every unit costs what a hash of its name says; gauges cost nothing."""

    def __init__(self, registry: Registry) -> None:
        self.gauges = Stages(registry).gauges()

    def price(self, unit: str) -> float:
        return self.gauges.get(unit, 1e-6 * (1 + sum(map(ord, unit)) % 17))

    def timed(self, scene: Scene) -> Timed:
        model = build(scene, scene.registry)
        steps = schedule_of(model, scene).estimated_steps()
        length = Length(steps, 0 if model.explicit else 3 * steps, min(scene.record.frames, steps) + 1)
        counts = counts_of(scene, model, length)
        cost = sum(count * self.price(unit) for unit, count in counts.items())
        return Timed(Measured(length, cost, 2.0), 1.0)


@dataclass(frozen=True)
class Needy(Effect):
    """An effect that no usual value is known for."""

    secret: float

    def bind(self, view: object) -> object:  # type: ignore[override]
        raise ValueError("secret: never")


@pytest.fixture(scope="module")
def made_up() -> Iterator[tuple[PriceList, MadeUp]]:
    registry = Registry()
    registry.add_class(Part("effect", "needy", f"{__name__}:Needy", "for tests"), Needy)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibration, "Quiet", MadeUp)
        patch.setattr(calibration, "measured_starts", lambda base: ({"explicit": 1.5}, {"explicit": 200.0}))
        yield calibrate(registry, rounds=1), MadeUp(registry)


def test_runs_with_many_parts_cost_what_their_units_do(made_up: tuple[PriceList, MadeUp]) -> None:
    prices, _ = made_up
    assert prices.together == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize("name", ["disc-on-block", "stack", "corner-slide", "tresca-block"])
def test_costs_of_bundled_scenes_follow_from_the_samples(name: str, made_up: tuple[PriceList, MadeUp]) -> None:
    """Samples tell all units apart that the scenes have: the same prices, made up, give the same cost."""
    prices, machine = made_up
    scene = load_scene(name)
    model = build(scene, scene.registry)
    counts = counts_of(scene, model, Length(400, 0 if model.explicit else 1200, 51))
    expected = sum(count * machine.price(unit) for unit, count in counts.items())
    assert total(counts, prices.units) == pytest.approx(expected, rel=0.05)


def test_a_part_without_usual_values_is_unknown_with_the_reason(made_up: tuple[PriceList, MadeUp]) -> None:
    prices, _ = made_up
    assert "no usual value is known for secret" in prices.unknown["effect needy"]
    assert not any(unit.startswith("effect needy") for unit in prices.units)


def test_memory_of_implicit_steps_is_what_arrays_grow_by(made_up: tuple[PriceList, MadeUp]) -> None:
    prices, _ = made_up
    assert prices.step_mib > 0.0
    scene = load_scene("tresca-block")
    without = PriceList(**{**vars(prices), "step_mib": 0.0})
    assert price_of(scene, prices).arrays_mib > price_of(scene, without).arrays_mib


def test_a_run_that_fails_makes_its_part_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken(MadeUp):
        def timed(self, scene: Scene) -> Timed:
            if scene.contacts and scene.contacts[0].friction:
                raise RequestError("it failed")
            return super().timed(scene)

    registry = Registry()
    stages = [stage for stage in Stages(registry) if stage.part in ("friction coulomb", "effect gravity")][:2]
    trials = [calibration.Trial.of(stage, Stages(registry).base) for stage in stages]
    for trial in trials:
        trial.run(Broken(registry))  # type: ignore[arg-type]
    assert {trial.stage.part: trial.reason for trial in trials} == {
        "friction coulomb": "it failed", "effect gravity": ""
    }  # fmt: skip
