"""Foreseen bills: counted work of a scene and its variants times prices, with what is unknown told."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import pytest

from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.prices.counts import Length, counts_of, total, unpriced
from contactlab.prices.expected import Expected, expected_length, touching
from contactlab.prices.foreseen import bill_of
from contactlab.prices.lacking import lacking
from contactlab.prices.price import price_of
from contactlab.prices.price_list import PriceList
from contactlab.run.prepare import schedule_of
from contactlab.scene.scene import Scene, load_scene

STARTS = {"explicit": 1.0, "explicit, recorded": 1.5}
MEMORY = {"explicit": 150.0, "explicit, recorded": 200.0}
LENGTH = Length(100, 0, 11)


def all_at(price: float, *scenes: Scene) -> PriceList:
    """A price list in which every unit of work costs the same."""
    units: dict[str, float] = {}
    for scene in scenes:
        variants = [scene, *(scene.with_(v.changes) for v in lacking(scene))]
        for one in (*variants, scene.with_({"integrator": "newton"})):
            with suppress(RequestError):
                units |= dict.fromkeys(counts_of(one, build(one, one.registry), Length(3, 3, 3)), price)
    return PriceList("2026-01-02", "here", {}, units, {}, STARTS, MEMORY, 1e-4)


def counted(scene: Scene, length: Length = LENGTH, share: float = 1.0) -> dict[str, float]:
    return counts_of(scene, build(scene, scene.registry), length, share)


def length_of(scene: Scene, model: Model) -> Expected:
    return expected_length(scene, model, schedule_of(model, scene))


def test_work_goes_with_steps_frames_cells_and_touching_nodes() -> None:
    scene = load_scene("disc-on-block")
    once, twice = counted(scene), counted(scene, Length(200, 0, 11))
    assert once["element q1: cell"] == 100 * 360
    assert once["material neo-hookean: point"] == 100 * 1440
    assert once["contact mortar-p0: node"] == 100 * 25
    assert twice["element q1: cell"] == 2 * once["element q1: cell"]
    assert twice["frame: node"] == once["frame: node"] == 11 * 434
    assert counted(scene, share=0.5)["contact mortar-p0: node"] == 50 * 25


def test_what_is_not_declared_is_not_counted() -> None:
    scene = load_scene("disc-on-block")
    assert not any("friction" in unit or "effect" in unit for unit in counted(scene))
    without = counted(scene.with_({"contacts": [], "record.recorders": []}))
    assert not any(
        "contact" in unit or "recorder" in unit or "pair" in unit.split() for unit in without if without[unit]
    )
    rubbing = counted(scene.with_({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}))
    assert rubbing["friction coulomb: pair"] == 100


def test_a_record_with_fewer_rows_counts_fewer() -> None:
    scene = load_scene("disc-on-block").with_({"record.recorders": ["vtkhdf"]})
    assert counted(scene)["recorder vtkhdf: contact step"] == 100
    assert counted(scene.with_({"record.every": 4}))["recorder vtkhdf: contact step"] == 25


def test_the_price_is_work_times_prices() -> None:
    scene = load_scene("dropped-block")
    prices = all_at(1e-6, scene)
    model = build(scene, scene.registry)
    expected = total(counts_of(scene, model, length_of(scene, model).usual, touching(scene, model)[1]), prices.units)
    found = price_of(scene, prices)
    assert found.cpu_s == pytest.approx(expected)
    assert found.least_s < found.cpu_s < found.most_s
    assert found.steps == pytest.approx(2004, abs=1)
    assert not found.unknown
    assert price_of(scene, replace(prices, together=1.1)).cpu_s == pytest.approx(1.1 * found.cpu_s)
    assert price_of(scene, all_at(2e-6, scene)).cpu_s == pytest.approx(2.0 * found.cpu_s)


def test_effects_that_are_there_and_effects_that_are_not() -> None:
    scene = load_scene("dropped-block")
    bill = bill_of(scene, all_at(1e-6, scene))
    declared = {effect.effect: effect for effect in bill.effects if effect.declared}
    lacked = {effect.effect: effect for effect in bill.effects if not effect.declared}
    assert {"contact", "recording", "gravity", "vibration-damping"} <= set(declared)
    assert {"friction (coulomb)", "friction (tresca)", "spring"} <= set(lacked)
    assert declared["gravity"].cpu_s == pytest.approx(2004e-6 * (1 + 46), rel=0.01)
    assert lacked["friction (coulomb)"].cpu_s > 0.0
    for effect in bill.effects:
        assert effect.reason or effect.least_s <= effect.cpu_s <= effect.most_s
    assert bill.summary["memory_mib"] > 200.0
    assert bill.summary["cpu_s"] == pytest.approx(1.5 + bill.whole.cpu_s)


def test_a_part_without_a_price_is_called_unknown_and_not_guessed() -> None:
    scene = load_scene("dropped-block")
    known = all_at(1e-6, scene)
    units = {
        unit: price
        for unit, price in known.units.items()
        if not unit.startswith(("friction coulomb", "effect gravity"))
    }
    bill = bill_of(scene, replace(known, units=units))
    assert list(bill.whole.unknown) == ["effect gravity"]
    found = {effect.effect: effect.reason for effect in bill.effects}
    assert found["friction (coulomb)"] == "unknown: no price is known for friction coulomb"
    assert found["gravity"] == "unknown: no price is known for effect gravity"
    assert found["friction (tresca)"] == ""


def test_a_variant_that_is_refused_says_why() -> None:
    scene = load_scene("two-bars")
    bill = bill_of(scene, all_at(1e-6, scene))
    refused = {effect.effect: effect for effect in bill.effects if effect.refused}
    assert "longer than the stable one" in refused["quadratic shape functions"].reason


def test_nested_levels_are_part_of_the_price() -> None:
    scene = load_scene("disc-on-block").with_({"integrator": "newton", "level": 2})
    prices = all_at(1e-6, scene)
    model = build(scene, scene.registry)
    own = total(counts_of(scene, model, length_of(scene, model).usual, touching(scene, model)[1]), prices.units)
    coarse = price_of(scene.with_({"level": 1}), prices).cpu_s
    assert price_of(scene, prices).cpu_s == pytest.approx(own + coarse)


def test_lengths_of_runs() -> None:
    block = load_scene("dropped-block")
    fixed = length_of(block, build(block, block.registry))
    assert fixed.least == fixed.usual == fixed.most
    assert fixed.usual.frames == 201
    disc = load_scene("disc-on-block")
    settles = length_of(disc, build(disc, disc.registry))
    assert settles.least.steps < settles.usual.steps < settles.most.steps
    assert settles.usual.steps == pytest.approx(8.0 / 7.0 * settles.least.steps)
    still = disc.with_({"integrator": "newton"})
    static = length_of(still, build(still, still.registry))
    assert static.usual.steps == 1
    assert static.least.iterations < static.usual.iterations < static.most.iterations


@pytest.mark.parametrize(("name", "least"), [("block-on-incline", 1.0), ("stack", 1.0), ("bouncing-bar", 0.0)])
def test_surfaces_that_lie_on_each_other_touch_from_the_start(name: str, least: float) -> None:
    scene = load_scene(name)
    found = touching(scene, build(scene, scene.registry))
    assert found[0] == least
    assert found[0] <= found[1] <= found[2] == 1.0


def test_units_without_a_price_are_told_by_their_part() -> None:
    assert unpriced({"effect wind: call": 1.0, "effect wind: node": 1.0, "frame": 1.0}, {"frame": 1.0}) == [
        "effect wind"
    ]
