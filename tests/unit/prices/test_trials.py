"""Trials of scenes: kept by content and versions, told where they cannot be used, and followed where they are."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from contactlab.errors import RequestError
from contactlab.prices import kept_trials, price_list, scene_trials
from contactlab.prices.counts import Length
from contactlab.prices.foreseen import bill_of
from contactlab.prices.kept_trials import (
    BrokenTrialsError,
    SceneTrial,
    load_trials,
    store_trials,
    trial_file,
    trial_key,
)
from contactlab.prices.measure import ENDED_AS, Measured, measure
from contactlab.prices.price import price_of
from contactlab.prices.price_list import PriceList
from contactlab.prices.quiet import Timed
from contactlab.prices.scene_trials import LIMIT, TIMES, make_trials, to_try, work_within
from contactlab.prices.tried import COUNTED, LATER, REPEATED, Pricing, tried_price
from contactlab.scene.scene import Scene, load_scene
from tests.unit.prices.test_foreseen import all_at

DAY = "2026-01-02"


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONTACTLAB_CACHE", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def block() -> Scene:
    return load_scene("dropped-block")


@pytest.fixture(scope="module")
def prices(block: Scene) -> PriceList:
    return all_at(1e-6, block)


def trial(scene: Scene, cpu_s: float = 2.0, **more: object) -> SceneTrial:
    return replace(SceneTrial(scene.name, DAY, 2010, 0, 201, cpu_s, 0.5), **more)  # type: ignore[arg-type]


# --- what is kept ---------------------------------------------------------------------------------


def test_what_is_stored_is_loaded_again(block: Scene) -> None:
    assert load_trials() == {}
    trials = {trial_key(block): trial(block), "other": SceneTrial("other", DAY, ended="diverged: step 3")}
    file = store_trials(trials)
    assert file == trial_file()
    assert load_trials() == trials
    with pytest.raises(price_list.NoPricesError) as none:
        price_list.load_prices()
    assert "of other versions or machines" not in str(none.value)  # a file of trials is not taken for one of prices


def test_the_key_follows_the_content_of_the_scene_and_versions(block: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    here = trial_key(block)
    assert trial_key(load_scene("dropped-block")) == here
    assert trial_key(block.with_({"level": 2})) != here
    assert trial_key(block.with_({"record.frames": 199})) != here
    monkeypatch.setattr(kept_trials, "versions_of", lambda scene, registry: {"contactlab-mortar": "9.9"})
    assert trial_key(block) != here


def test_the_key_follows_the_files_that_a_scene_names(block: Scene, tmp_path: Path) -> None:
    table = tmp_path / "push.csv"
    table.write_text("0, 0\n1e-5, 1\n")
    course = {"ramp": "table", "file": str(table)}
    pushed = block.with_({"loads": [{"on": "block.top", "ty": {"to": -1.0, **course}}]})
    before = trial_key(pushed)
    assert trial_key(pushed) == before
    table.write_text("0, 0\n1e-5, 2\n")
    assert trial_key(pushed) != before


def stored(change: Callable[[dict[str, object]], object]) -> None:
    """A file of trials that something was done to."""
    file = store_trials({"a": SceneTrial("a", DAY, 10, 0, 3, 0.5, 1.0)})
    data = json.loads(file.read_text())
    change(data)
    file.write_text(json.dumps(data))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data.clear(), "another format"),
        (lambda data: data.pop("trials"), "trials"),
        (lambda data: data.update(trials=[]), "no attribute 'items'"),
        (lambda data: data["trials"]["a"].update(cpu_s=math.nan), "a number of the trial of a is none"),
        (lambda data: data["trials"]["a"].update(steps="many"), "a number of the trial of a is none"),
        (lambda data: data["trials"]["a"].update(cpu_s=0.0), "took no time"),
        (lambda data: data["trials"]["a"].update(colour="red"), "colour"),
        (lambda data: data.update(machine="Another CPU, 64 cores"), "of another machine or version: Another CPU"),
        (lambda data: data.update(versions={"contactlab": "9.9"}), "of another machine or version"),
    ],
)
def test_a_broken_or_foreign_file_is_told_and_can_be_replaced(
    change: Callable[[dict[str, object]], object], said: str, block: Scene
) -> None:
    stored(change)
    with pytest.raises(BrokenTrialsError, match=said) as broken:
        load_trials()
    assert str(trial_file()) in str(broken.value)
    assert "contactlab calibrate SCENE" in str(broken.value)
    store_trials({"b": trial(block)})
    assert list(load_trials()) == ["b"]


def test_bytes_that_are_no_text_are_no_trials(block: Scene) -> None:
    store_trials({}).write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BrokenTrialsError, match="cannot be read"):
        load_trials()


# --- prices from trials -----------------------------------------------------------------------------


def test_a_run_that_came_to_its_end_costs_what_it_did(block: Scene, prices: PriceList) -> None:
    found = tried_price(block, prices, trial(block))
    assert (found.cpu_s, found.arrays_mib, found.steps, found.tried) == (2.0, 0.5, 2010, DAY)
    assert (found.least_s, found.most_s) == pytest.approx((2.0 * (1.0 - REPEATED), 2.0 * (1.0 + REPEATED)))


def test_of_a_run_that_was_cut_the_rest_costs_as_much_over_its_counted_work(block: Scene, prices: PriceList) -> None:
    """Half of the steps at 1.5 times the counted price: so will the others be; frames are counted apart."""
    made = Length(1002, 0, 101)
    cost = 1.5 * price_of(block, prices, made).cpu_s
    begun = trial(block, cost, steps=made.steps, frames=made.frames, ended="cut", done=0.5)
    whole = price_of(block, prices)
    found = tried_price(block, prices, begun)
    assert found.cpu_s == pytest.approx(1.5 * whole.cpu_s)
    assert (found.least_s, found.most_s) == pytest.approx((1.5 * whole.least_s, 1.5 * whole.most_s))
    assert found.steps == whole.steps


def test_of_load_steps_that_were_cut_the_rest_costs_what_they_did(block: Scene, prices: PriceList) -> None:
    still = block.with_({"integrator": "newton"})
    cut = trial(still, 1.0, steps=4, iterations=20, ended="cut", done=0.25)
    found = tried_price(still, prices, cut)
    assert (found.cpu_s, found.steps, found.iterations) == pytest.approx((4.0, 16, 80))
    assert (found.least_s, found.most_s) == pytest.approx((4.0 * LATER[0], 4.0 * LATER[1]))


def test_a_bill_says_which_prices_it_used(block: Scene, prices: PriceList) -> None:
    assert bill_of(block, prices).basis == COUNTED
    own = {trial_key(block): trial(block)}
    assert bill_of(block, prices, own).basis == f"trials of this scene of {DAY}"
    cut = {trial_key(block): trial(block, ended="cut", done=0.5)}
    assert bill_of(block, prices, cut).basis == f"trials of this scene of {DAY}, cut, and counted work"
    assert bill_of(block.with_({"level": 2}), prices, own).basis == COUNTED
    failed = {trial_key(block): SceneTrial("block", DAY, ended="diverged: step 3")}
    bill = bill_of(block, prices, failed)
    assert bill.basis == f"{COUNTED}: a trial of {DAY} failed: diverged: step 3"
    assert bill.whole.cpu_s == price_of(block, prices).cpu_s


def test_effects_are_differences_of_trials(block: Scene, prices: PriceList) -> None:
    """A variant without a trial costs its counted work times what the trial of the scene took over its own."""
    without = block.with_({"contacts": [], "rigid": {}})
    trials = {trial_key(block): trial(block, 2.0), trial_key(without): trial(without, 0.75)}
    found = {effect.effect: effect for effect in bill_of(block, prices, trials).effects}
    assert found["contact"].cpu_s == pytest.approx(1.25)
    factor = 2.0 / price_of(block, prices).cpu_s
    counted = {effect.effect: effect for effect in bill_of(block, prices).effects}
    assert found["gravity"].cpu_s == pytest.approx(factor * counted["gravity"].cpu_s)
    alone = bill_of(block, prices, {trial_key(without): trial(without)})
    # an unknown price is not a number, and such numbers are equal to none
    assert repr(alone.effects) == repr(bill_of(block, prices).effects)


def test_an_effect_whose_trial_failed_has_no_price_and_says_why(block: Scene, prices: PriceList) -> None:
    without = block.with_({"contacts": [], "rigid": {}})
    failed = SceneTrial("w", DAY, ended="diverged: step 3")
    bill = bill_of(block, prices, {trial_key(block): trial(block), trial_key(without): failed})
    found = {effect.effect: effect for effect in bill.effects}["contact"]
    assert found.failed
    assert math.isnan(found.cpu_s)
    assert found.reason == f"its trial of {DAY} failed: diverged: step 3"


# --- how trials are made ------------------------------------------------------------------------------


def test_a_run_is_cut_after_so_much_work(block: Scene) -> None:
    found = measure(block, work=300)
    assert (found.ended, found.length.steps) == ("cut", 301)
    assert found.done == pytest.approx(300 / 2004, abs=0.01)  # of the last frame; there are 200
    assert found.cpu_s > 0.0


def test_limits_are_foreseen_seconds(block: Scene, prices: PriceList) -> None:
    whole = price_of(block, prices)
    assert work_within(0.5 * whole.cpu_s, block, prices) == pytest.approx(0.5 * whole.steps)
    assert work_within(1e-12, block, prices) == 1.0
    assert math.isinf(work_within(1.0, block, replace(prices, units={"other": 1.0})))


class MadeUp:
    """Runs without friction fail; the others take 3, 1 and 2 s by turns, and are cut if they may not be longer."""

    def __init__(self, registry: object) -> None:
        self.made: list[float] = []

    def timed(self, scene: Scene, tries: int, work: float) -> Timed:
        if not scene.contacts:
            raise RequestError(f"{ENDED_AS}diverged: step 3")
        self.made.append(work)
        cost = 0.1 * (3, 1, 2)[len(self.made) % 3]
        return Timed(Measured(Length(10, 0, 3), cost, 1.0, "cut" if work < 100 else "", 0.25), 1.0)


def test_trials_of_a_scene_are_those_that_explain_asks_for(
    block: Scene, prices: PriceList, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_trials, "Quiet", MadeUp)
    made = dict(make_trials([block], prices))
    asked = []
    monkeypatch.setattr("contactlab.prices.tried.trial_key", lambda scene: asked.append(trial_key(scene)) or asked[-1])
    bill_of(block, prices, made)
    assert set(asked) <= set(made)
    assert made[trial_key(block)].cpu_s == pytest.approx(0.2)  # the middle one
    failed = made[trial_key(block.with_({"contacts": [], "rigid": {}}))]
    assert failed.failed
    assert failed.ended == "diverged: step 3"
    assert TIMES == 3


def test_a_long_run_is_cut(block: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_trials, "Quiet", MadeUp)
    dear = all_at(1e-3, block)
    assert price_of(block, dear).cpu_s > LIMIT
    assert {one.ended for one in dict(make_trials([block], dear)).values() if not one.failed} == {"cut"}


def test_the_scene_and_its_variants_are_tried_once_each() -> None:
    names = [one.name for one in to_try(load_scene("dropped-block"))]
    assert names[0] == "dropped-block"
    assert {"dropped-block without gravity", "dropped-block with friction (coulomb)"} <= set(names)
    assert len(set(names)) == len(names)


def test_pricing_without_trials_counts(block: Scene, prices: PriceList) -> None:
    pricing = Pricing(block, prices, {})
    assert pricing.factor == 1.0
    assert pricing.price(block) == price_of(block, prices)
