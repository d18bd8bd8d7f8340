"""The choice of a configuration: in worlds of known errors and costs, and with runs."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.accuracy import judged as judging
from contactlab.accuracy.choose import LEVELS, Chosen, Wish, choose_plan
from contactlab.accuracy.configuration import (
    Configuration,
    algorithms_for,
    elements_for,
    exchangeable,
    integrators_for,
    possible,
)
from contactlab.accuracy.judged import Judge, PressuresJudged, highest_at_an_end, line_of, mean_profile
from contactlab.accuracy.remaining import Ladder, Truth, left_at, truth_of
from contactlab.accuracy.trials import Trial, Trials
from contactlab.api import ContactCurve, Job, Record
from contactlab.cli import main
from contactlab.jobs.perform import LEEWAY, made
from contactlab.jobs.run import Run, here
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.profile import Profile, norm

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 4001)
EXACT = Profile(np.sin(ANGLES), np.cos(ANGLES) ** 3)
"""Smooth up to its edges, so that interpolants on fine meshes are exact to what is looked for here."""
SCENE = load_scene("disc-on-block").with_({"supports.1.uy.to": -0.05})


@pytest.fixture(autouse=True)
def _edges_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judging, "with_root_edges", lambda profile: profile)  # those of EXACT are no roots


def curve(x: Any, y: Any, pressure: Any) -> ContactCurve:
    zero, state = np.zeros_like(x), np.zeros(len(x), np.int32)
    return ContactCurve(x, x, y, pressure, zero, pressure, zero, state, state)


def record(pressure: Callable[[Any], Any], cost: float, contacts: int = 1, force: float = 1.0) -> Record:
    x = np.linspace(-1.0, 1.0, 101)
    summary = {
        "cost": {"run_cpu_s": cost, "compile_s": 0.0}, "process_s": cost, "steps": 1,
        "reactions": {"disc.top": [0.0, force]},
    }  # fmt: skip
    found = {f"contacts.{n}": [curve(x, 0.0 * x, pressure(x))] for n in range(contacts)}
    return Record("finished", "", summary, curves=found)


class World:
    """Runs with errors C n^-q along a wave of their own, and costs c n^p, by configuration. Counts what was run."""

    constants = (0.16, 1.0, 0.1, 2.0), (0.08, 0.9, 0.3, 2.2), (0.3, 1.4, 0.2, 2.2), (0.06, 0.8, 0.3, 2.0)

    def __init__(self, seed: int = 0) -> None:
        self.seed, self.made = seed, dict[tuple[str, int], float]()

    def error_and_cost(self, name: str, level: int) -> tuple[float, float]:
        c, q, unit, p = self.constants[zlib.crc32(f"{name} {self.seed}".encode()) % len(self.constants)]
        return c * level**-q, unit * level**p

    def __call__(self, run: Run) -> Record:
        name = _name(run.scene)
        error, cost = self.error_and_cost(name, run.scene.level)
        cost *= 1.0 if run.scene.integrator["use"] == "newton" else 4.0
        self.made[name, run.scene.level] = cost
        wave = 1 + zlib.crc32(name.encode()) % 5

        def pressure(x: Any) -> Any:
            off = EXACT(x) * np.cos(wave * np.pi * x)
            size = norm(EXACT) / norm(Profile(x, off))
            return EXACT(x) + error * size * off

        return record(pressure, cost)


def _name(scene: Scene) -> str:
    contact = scene.data["contacts"][0]
    words = contact["algorithm"]["use"], scene.data["bodies"]["disc"]["element"]["use"]
    return " ".join((*words, str(bool(contact.get("swap")))))


def chosen(make: Callable[[Run], Record], error: float, scene: Scene = SCENE, search: float = 1e3) -> Chosen:
    found: Chosen = here(choose_plan(scene, Wish(error, 60.0, search), default_registry()), make)
    return found


@pytest.mark.parametrize(
    ("error", "seed"), some([(error, seed) for error in (0.07, 0.03) for seed in range(3)], [(0.07, 2), (0.03, 1)])
)
def test_the_promise_is_kept_at_nearly_the_least_cost(error: float, seed: int) -> None:
    world = World(seed)
    found = chosen(world, error)
    assert found.verdict == "ok"
    name = _name(SCENE.with_(dict(found.choice)))
    true, cost = world.error_and_cost(name, found.level)
    assert true <= error
    assert found.error_interval is not None
    assert found.error_interval[0] <= true <= found.error_interval[1] < error
    # errors of first order at costs of second: a third of the error for what is uncertain costs 2.25 times as much
    names = {name for name, _ in world.made}
    every = [world.error_and_cost(name, level) for name in names for level in LEVELS]
    assert cost <= 2.25 * min(cost for each, cost in every if each <= error)


def test_a_search_that_ends_early_promises_nothing_it_does_not_know() -> None:
    for search in (1.0, 5.0, 30.0):
        world = World()
        found = chosen(world, 0.01, search=search)
        true, _ = world.error_and_cost(_name(SCENE.with_(dict(found.choice))), found.level)
        assert found.verdict == "cannot" or true <= 0.01
        assert found.choice["contacts.0.algorithm"] in default_registry().names("contact")


def test_no_run_may_take_more_than_is_left_of_the_search() -> None:
    spent = 0.0
    world = World()

    def make(run: Run) -> Record:
        nonlocal spent
        assert run.cpu_limit * LEEWAY <= 1.05 * max(30.0 - spent, 0.1)  # of two digits
        found = world(run)
        spent += found.summary["process_s"]
        return found

    chosen(make, 0.01, search=30.0)
    assert spent > 15.0


def test_elements_that_lock_alike_do_not_vouch_for_each_other() -> None:
    """Runs with the scene's elements agree on a wrong pressure, which others leave behind on the finest meshes."""

    def locked(run: Run) -> Record:
        off = 0.2 * run.scene.level**-0.2 if _name(run.scene).split()[1] == "q1" else 0.1 * run.scene.level**-1.0
        return record(lambda x: (1.0 + off) * EXACT(x), 0.1 * run.scene.level**2)

    found = chosen(locked, 0.02, search=100.0)
    element = _name(SCENE.with_(dict(found.choice))).split()[1]
    assert found.verdict == "cannot" or element != "q1"


def test_forces_are_promised_where_nothing_is_pressed_at_the_end() -> None:
    found = chosen(lambda run: record(np.zeros_like, 0.1 * run.scene.level**2, force=1.0 + 0.1 / run.scene.level), 0.04)
    true = 0.1 / found.level / (1.0 + found.uncertainty)  # over the force of the reference, which is as much too large
    assert found.verdict == "ok"
    assert found.error_interval is not None
    assert found.error_interval[0] <= true <= found.error_interval[1] < 0.04
    assert found.judged == "forces only"
    assert "nothing is pressed" in found.why


def test_pressures_that_are_no_function_of_a_position_promise_nothing() -> None:
    zigzag = np.tile([0.0, 1.0], 20)

    def folded(run: Run) -> Record:
        found = record(np.ones_like, 0.1 * run.scene.level**2, force=1.0 + 0.1 / run.scene.level)
        curves = {"contacts.0": [curve(zigzag, zigzag, np.ones_like(zigzag))]}
        return Record("finished", "", found.summary, curves=curves)

    found = chosen(folded, 0.04)
    assert found.verdict == "cannot"
    assert found.error_interval is None
    assert "forces" in found.why
    assert found.error < 0.04


@pytest.mark.full
def test_where_no_mesh_settles_the_pressure_forces_choose() -> None:
    """Pressures that fall with the fifth root of the cells stay unknown to more than is asked, and forces are exact."""

    def singular(run: Run) -> Record:
        return record(lambda x: (1.0 + 0.5 * run.scene.level**-0.2) * EXACT(x), 0.3 * run.scene.level**2, force=1.0)

    found = chosen(singular, 0.02, search=100.0)
    assert found.verdict == "cannot"
    assert found.uncertainty > 0.02
    assert found.level == 2  # the finest is 4
    assert "forces" in found.why
    assert "--search" in found.why
    assert "edge" not in found.why
    assert "smaller" in chosen(singular, 0.02, search=2e3).why  # the finest meshes have been tried


def test_a_pressure_that_is_highest_where_contact_ends_is_one_of_an_edge() -> None:
    x = np.linspace(-1.0, 1.0, 101)
    edge = (1.0001 - x**2) ** -0.5
    inner = np.where(abs(x) > 0.5, np.maximum(abs(x) - 0.4999, 1e-4) ** -0.5, 0.0)  # of two stretches
    apart = np.maximum((abs(x) - 0.1) * (0.9 - abs(x)), 0.0)
    for values in (edge, np.where(abs(x) < 0.5, edge, 0.0), inner):
        assert highest_at_an_end(Profile(x, values))
    for values in (1.0 - x**2, apart):
        assert not highest_at_an_end(Profile(x, values))

    def singular(run: Run) -> Record:
        return record(lambda x: (1.0001 - x**2) ** -0.5 * (1.0 + 0.5 * run.scene.level**-0.2), 0.3 * run.scene.level**2)

    assert "sharp edge" in chosen(singular, 0.02, search=100.0).why


def test_runs_that_all_fail_leave_an_answer_with_the_reason() -> None:
    def failing(run: Run) -> Record:
        part = 0.7 if _name(run.scene).startswith("mortar-p1") else 0.2
        return Record("diverged", "it blew up", {"reached": {"share": part}, "process_s": 0.1})

    found = chosen(failing, 0.02)
    assert found.verdict == "cannot"
    assert found.error_interval is None
    assert math.isnan(found.error)
    assert "it blew up" in found.why
    assert found.choice["contacts.0.algorithm"] == "mortar-p1"  # which came furthest


@pytest.mark.parametrize("after", [0, 1, 7, 25])
def test_an_interruption_is_answered_by_what_is_known(after: int) -> None:
    world = World()

    def make(run: Run) -> Record:
        if len(world.made) >= after:
            return Record("interrupted", "stopped before it began", {})
        return world(run)

    found = chosen(make, 0.02)
    assert found.choice["level"] >= 1
    assert len({name for name, _ in world.made}) <= after
    assert found.verdict == "ok" or "stopped early" in found.why or not found.tried


def test_contacts_are_exchanged_one_by_one_but_for_rigid_masters() -> None:
    scene = load_scene("three-body-forging")
    assert exchangeable(scene.data) == (0, 1)
    exchanged: set[tuple[bool, ...]] = set()

    def make(run: Run) -> Record:
        exchanged.add(tuple(bool(contact.get("swap")) for contact in run.scene.data["contacts"]))
        return record(EXACT, 0.1, contacts=3)

    chosen(make, 0.02, scene, 10.0)
    assert exchanged == {(False, False, False), (True, True, False), (True, False, False), (False, True, False)}


@pytest.mark.full
def test_a_pressure_with_one_wrong_contact_is_not_ok() -> None:
    """The error is the largest of all contacts that are pressed."""

    def make(run: Run) -> Record:
        found = record(EXACT, 0.1 * run.scene.level**2, contacts=3)
        x = np.linspace(-1.0, 1.0, 101)
        off = 1.0 + 0.5 / run.scene.level
        curves = {**found.curves, "contacts.2": [curve(x, 0.0 * x, off * EXACT(x))]}
        return Record("finished", "", found.summary, curves=curves)

    found = chosen(make, 0.05, load_scene("three-body-forging"), 100.0)
    assert found.verdict == "cannot" or found.level > 8


def test_integrators_are_tried_where_they_apply() -> None:
    registry = default_registry()
    assert integrators_for(SCENE, registry) == ["newton", ""]
    assert integrators_for(load_scene("tresca-block"), registry) == ["", "central-difference"]
    assert integrators_for(load_scene("dropped-block"), registry) == [""]
    assert elements_for(SCENE, registry) == ["", "q1-fbar", "q2"]


def test_potentials_are_tried_only_if_the_scene_names_one() -> None:
    registry = default_registry()
    scene = SCENE.with_({"contacts.0.algorithm": "mortar-p1"})
    assert algorithms_for(scene, registry)[0] == "mortar-p1"
    assert algorithms_for(scene, registry)[-1] == "node-on-segment"  # which fails the patch test
    assert not {"barrier", "midplane"} & set(algorithms_for(scene, registry))
    assert "midplane" in algorithms_for(SCENE.with_({"contacts.0.algorithm": "midplane"}), registry)


def test_runs_that_fail_the_patch_test_are_no_reference() -> None:
    """Node-on-segment changes least from mesh to mesh here, and stays 10 % off."""

    def make(run: Run) -> Record:
        off = 0.1 if _name(run.scene).startswith("node-on-segment") else 0.2 * run.scene.level**-1.0
        return record(lambda x: (1.0 + off) * EXACT(x), 0.2 * run.scene.level**2)

    found = chosen(make, 0.05, search=100.0)
    assert "node-on-segment" not in found.reference
    assert found.verdict == "ok"
    assert not found.name.startswith("node-on-segment")


def test_configurations_name_the_keys_that_run_takes() -> None:
    own = SCENE.data
    found = Configuration("mortar-p1", (0,), "q2", "newton", 20).changes(own, 3)
    scene = SCENE.with_(found)
    assert scene.level == 3
    assert scene.integrator["steps"] == 20
    assert scene.data["contacts"][0]["swap"]
    assert {body["element"]["use"] for body in scene.data["bodies"].values()} == {"q2"}


# --- smooth surfaces ------------------------------------------------------------------------------------

WARNING = {"code": "coarse-facets", "key": "contacts.0.smooth"}


def facets(run: Run, warned: bool = True) -> Record:
    """Facets leave 40 % on the coarsest mesh and report it, q2 a quarter of that, and smooth surfaces a fortieth."""
    scene = run.scene
    smooth = scene.contacts[0].smooth
    off = 0.01 if smooth else 0.1 if "q2" in _name(scene) else 0.4
    found = record(lambda x: (1.0 + off / scene.level) * EXACT(x), 0.2 * scene.level**2)
    warnings = [WARNING] if warned and not smooth else []
    return Record("finished", "", {**found.summary, "warnings": warnings}, curves=found.curves)


def test_smooth_surfaces_are_tried_where_facets_are_coarse() -> None:
    made: list[Scene] = []

    def make(run: Run) -> Record:
        made.append(run.scene)
        return facets(run)

    found = chosen(make, 0.02)
    assert found.verdict == "ok"
    assert found.choice["contacts.0.smooth"] is True
    assert found.level == 1
    assert ", smooth" in found.name
    assert SCENE.with_(dict(found.choice)).contacts[0].smooth
    smooth = {_name(scene).rsplit(" ", 1)[0] for scene in made if scene.contacts[0].smooth}
    own = SCENE.data["bodies"]["disc"]["element"]["use"]
    assert {name.split()[1] for name in smooth} == {own, "q1-fbar"}
    assert {name.split()[0] for name in smooth} == {"mortar-p0", "mortar-p1", "mortar-dual"}


def test_scenes_without_coarse_facets_have_no_trial_with_smooth_surfaces() -> None:
    made: list[bool] = []

    def make(run: Run) -> Record:
        made.append(run.scene.contacts[0].smooth)
        return facets(run, warned=False)

    found = chosen(make, 0.02, search=30.0)
    assert made
    assert not any(made)
    assert "contacts.0.smooth" not in found.choice


def test_algorithms_and_elements_that_cannot_be_smooth_do_without() -> None:
    scene, registry = SCENE.with_({"contacts.0.smooth": True}), default_registry()
    for algorithm, element, able in (("mortar-p0", "", True), ("mortar-p0", "q2", False), ("gauss-point", "", False)):
        own = Configuration(algorithm, (), element)
        (found,) = possible([own], scene, registry)
        assert scene.with_(found.changes(scene.data, 1)).contacts[0].smooth is able
        assert ("not smooth" in found.named(1)) is not able
        assert possible([own], SCENE, registry) == [own]
        curved = Configuration(algorithm, (), element, smooth=(0,))
        assert possible([curved], SCENE, registry) == [curved] * able


def test_names_tell_which_contacts_are_smooth() -> None:
    assert Configuration("mortar-p0", (0,), smooth=(0,)).named(1) == "mortar-p0, smooth, exchanged"
    assert Configuration("mortar-p0", smooth=(1,)).named(3) == "mortar-p0, smooth contacts.1"


def test_a_shrink_fit_of_half_rings_is_answered_with_lames_pressure() -> None:
    """Facets of unlike meshes leave most of the pressure away; the error promised holds against the closed form."""
    a, b, c, over = 4.0, 6.0, 8.5, 0.006
    inner, outer, poisson = 70000.0, 7000.0, 0.3

    def body(material: str, radii: list[float], cells: list[int]) -> dict[str, Any]:
        mesh = {"use": "ring", "radii": radii, "cells": cells, "angles": [0.0, 180.0]}
        return {"element": "q1", "material": material, "mesh": mesh}

    scene = Scene.from_data({
        "format": 1, "name": "fit", "integrator": {"use": "newton"},
        "materials": {
            name: {"use": "linear-elastic", "young": young, "poisson": poisson, "density": 1e-9}
            for name, young in (("hard", inner), ("soft", outer))
        },
        "bodies": {"in": body("hard", [a, b + over], [20, 4]), "out": body("soft", [b, c], [16, 4])},
        "contacts": [{
            "slave": "in.outer", "master": "out.inner", "algorithm": "mortar-p0", "start": {"overlap": "ramp"},
        }],
        "supports": [{"on": f"{name}.{end}", "uy": 0.0} for name in ("in", "out") for end in ("start", "end")],
        "effects": [
            {"use": "spring", "on": on, "stiffness": [1e-2, 0.0]} for on in ("in.inner", "out.outer")
        ],
    }, registry=default_registry())  # fmt: skip

    def make(run: Run) -> Record:
        own, element = run.scene, run.scene.data["bodies"]["in"]["element"]["use"]
        kinds = element, own.contacts[0].algorithm["use"], own.integrator["use"]
        fast = kinds == ("q1", "mortar-p0", "newton") and own.level <= 3 and not own.contacts[0].swap
        return made(run.job, own) if fast else Record("refused", "to save time", {})

    found = chosen(make, 0.03, scene)
    assert found.verdict == "ok"
    assert found.error_interval is not None
    run = made(Job("run", dict(scene.data), found.choice, curves="last"), scene.with_(dict(found.choice)))
    # plane strain: u = p r (1 + nu) ((1 - 2 nu) r^2 + R^2) / E (r^2 - R^2) with the other radius R of the ring
    soft, hard = (
        (1.0 + poisson) / young * ((1.0 - 2.0 * poisson) * b**2 + other**2) / abs(b**2 - other**2)
        for young, other in ((outer, c), (inner, a))
    )
    lame = over / b / (soft + hard)
    curve = run.curve()
    off = float(np.sqrt(np.mean((np.asarray(curve.pressure)[1:-1] / lame - 1.0) ** 2)))
    assert off <= 0.03
    own = made(Job("run", dict(scene.data), curves="last"), scene).curve()
    assert abs(np.mean(own.pressure) / lame - 1.0) > 0.2


# --- pressures along lines, and what is left of errors --------------------------------------------------


def test_lines_follow_flat_upright_and_closed_contacts() -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 61)[:-1]
    for x, y, axis in ((t, 0.01 * t**2, "x"), (0.01 * t**2, t, "y"), (np.cos(t), np.sin(t), "angle")):
        line = line_of(curve(x, y, 1.0 + 0.0 * t))
        assert line is not None
        assert line.axis == axis
        # the same pressure on nodes in the other direction that begin elsewhere
        other = line.profile(curve(x[::-1], y[::-1], 1.0 + 0.0 * t))
        assert norm(other) == pytest.approx(norm(line.profile(curve(x, y, 1.0 + 0.0 * t))), rel=0.02)
    assert line_of(curve(t, t, 0.0 * t)) is None


def error_left(values: dict[int, Any], judged: PressuresJudged) -> float:
    """The error left at the finest level, the mean over the orders."""
    return float(np.dot(*left_at(values, judged, judged.orders(values[max(values)]))))


def test_levels_before_convergence_begins_are_left_out() -> None:
    """A peak twice as high on two coarse meshes, which is gone from the third one on."""
    x = np.linspace(-1.0, 1.0, 101)
    judged = PressuresJudged(Judge())
    coarse = {n: {0: Profile(x, EXACT(x) + np.exp(-100.0 * (x - 0.1 * n) ** 2))} for n in (1, 2)}
    fine = {n: {0: Profile(x, (1.0 + 0.1 / n) * EXACT(x))} for n in (4, 8, 16)}
    assert error_left(coarse | fine, judged) == pytest.approx(0.1 / 16.0, rel=0.1)
    assert error_left(fine, judged) == error_left(coarse | fine, judged)


def test_low_orders_are_those_of_sharp_edges() -> None:
    x = np.linspace(-1.0, 1.0, 101)
    judged = PressuresJudged(Judge())
    below_an_edge = Profile(x, np.minimum((1.0 - x**2 + 1e-3) ** -0.5, 10.0))
    assert judged.orders({0: Profile(x, EXACT(x))}).min() == 0.5
    assert judged.orders({0: below_an_edge}).min() == 0.2
    assert judged.orders({0: Profile(x, EXACT(x)), 1: below_an_edge}).min() == 0.2


@pytest.mark.parametrize("order", [0.5, 0.75, 1.0, 1.5])
def test_what_is_left_is_bounded_by_tried_orders(order: float) -> None:
    x = np.linspace(-1.0, 1.0, 101)
    judged = PressuresJudged(Judge())
    values = {n: {0: Profile(x, (1.0 + 0.1 * n**-order) * EXACT(x))} for n in (1, 2, 4)}
    left, two = (error_left({n: values[n] for n in levels}, judged) for levels in ((1, 2, 4), (2, 4)))
    # the norm differs by the error itself; beside 0.5, the lowest, only higher orders have a weight
    assert left == pytest.approx(0.1 * 4**-order, rel=0.15 if order == 0.5 else 0.1)
    assert two >= left * 0.5


def test_pressures_that_do_not_settle_are_known_badly() -> None:
    """At a singular end each doubling adds as much: no mesh has the pressure, and two levels do not show it."""
    x = np.linspace(-1.0, 1.0, 101)
    judged = PressuresJudged(Judge())

    def ladder(name: str, levels: tuple[int, ...]) -> Ladder:
        values = {n: {0: Profile(x, (1.0 + 0.004 * np.log2(n)) * (1.0001 - x**2) ** -0.5)} for n in levels}
        return Ladder(name, (name,), values, 1.0)

    alike = [ladder("a", (1, 2, 4, 8)), ladder("b", (1, 2, 4, 8)), ladder("c", (1, 2))]
    truth = truth_of(alike, judged, 3)
    assert truth is not None
    assert truth.level == 8
    assert truth.uncertainty > 4 * 0.004


def test_a_run_that_disagrees_widens_the_uncertainty() -> None:
    x = np.linspace(-1.0, 1.0, 101)
    judged = PressuresJudged(Judge())

    def ladder(name: str, family: str, off: float, levels: tuple[int, ...]) -> Ladder:
        values = {n: {0: Profile(x, (1.0 + off + 0.01 / n) * EXACT(x))} for n in levels}
        return Ladder(name, (family,), values, 1.0)

    alike = [ladder("a", "a", 0.0, (1, 2, 4)), ladder("b", "b", 0.0, (1, 2, 4))]
    agreeing, apart = (truth_of([*alike, ladder("c", "c", off, (1, 2))], judged, 3) for off in (0.0, 0.1))
    assert agreeing is not None
    assert apart is not None
    assert agreeing.uncertainty < 0.005
    assert apart.uncertainty > 0.08


def test_a_run_that_is_much_less_exact_does_not_spoil_the_others() -> None:
    """A tenth of the mean would be of a run that is off by 9 %: alone the other one is known to 1.5 times its error."""
    x = np.linspace(-1.0, 1.0, 101)
    judged = PressuresJudged(Judge())

    def ladder(name: str, off: float) -> Ladder:
        return Ladder(name, (name,), {n: {0: Profile(x, (1.0 + off / n) * EXACT(x))} for n in (1, 2, 4)}, 1.0)

    exact, poor = ladder("exact", 0.04), ladder("poor", 0.36)
    truth = truth_of([exact, poor], judged, 3)
    assert truth is not None
    assert truth.words == "exact at level 4"
    assert not truth.alone
    assert truth.uncertainty == pytest.approx(0.015, rel=0.2)


def test_an_edge_of_contact_may_fall_well() -> None:
    """Pressures that happen to be right at level 3 are taken, where forces that cross zero are not."""
    judged = Trials(SCENE, Wish(0.02), default_registry())
    first, truth = Configuration("mortar-p1"), EXACT
    for level, off in ((2, 0.04), (3, 0.01), (4, 0.023)):
        made = judged.all[first, level] = Trial("finished", "", [0.1 * level])
        made.pressures, made.forces = {0: Profile(EXACT.x, (1.0 + off) * EXACT.value)}, np.array([1.0 + off])
        made.facts = {"pressed": True}
    judged._judged_at, judged._truth = 3, Truth({0: truth}, 0.0, "exact", 8)
    assert judged.errors(first) == pytest.approx({2: 0.04, 3: 0.01, 4: 0.023}, rel=1e-6)
    for trial in judged.all.values():
        trial.pressures, trial.facts = {}, {"pressed": False}
    judged._off, judged._truth = {}, Truth(np.array([1.0]), 0.0, "exact", 8)
    assert judged.errors(first) == pytest.approx({2: 0.04, 3: 0.023, 4: 0.023}, rel=1e-6)


def test_a_cheap_coarse_run_is_no_reference() -> None:
    """Errors that fall with the root of the cells, as those of a pressure without bound: fine runs count for it."""
    x = np.linspace(-1.0, 1.0, 101)

    def ladder(name: str, off: float, levels: tuple[int, ...], cost: float) -> Ladder:
        values = {n: {0: Profile(x, (1.0 + off * n**-0.5) * EXACT(x))} for n in levels}
        return Ladder(name, (name,), values, cost)

    fine, cheap = ladder("fine", 0.1, (1, 2, 4, 8, 16), 5.0), [ladder(name, 0.08, (1, 2), 0.05) for name in "abc"]
    truth = truth_of([fine, *cheap], PressuresJudged(Judge()), 3)
    assert truth is not None
    assert truth.level == 16


def test_a_pressure_up_to_the_end_of_a_body_is_not_halved_there() -> None:
    # two runs whose last nodes lie apart, and their mirror images: the mean is as high at the ends as each of them
    x = np.linspace(-1.0, 1.0, 9)
    for apart in (1e-7, 1e-2):
        runs = [Profile(x * (1.0 + off), np.full(9, 2.0)) for off in (0.0, apart)]
        mean = mean_profile([*runs, *(run.mirrored() for run in runs)])
        np.testing.assert_array_equal(mean.value, 2.0)
        for one, other in ((mean, runs[0]), (mean, runs[1]), runs, runs[::-1]):
            assert Judge().apart({0: one}, {0: other}) < 1e-12  # distance() alone: apart^(1/2)
    # one that ends a segment earlier does not press beyond
    short = mean_profile([runs[0], Profile(x[:-1], np.full(8, 2.0))])
    assert short(np.array([1.0]))[0] == 1.0


@pytest.mark.parametrize(("option", "value"), [("--error", "200%"), ("--error", "no"), ("--budget", "0s")])
def test_wrong_wishes_are_told(option: str, value: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["choose", "disc-on-block", option, value]) == 2
    said = capsys.readouterr().err
    assert f'choose, {option}: this value is not allowed\n  got      "{value}"' in said
