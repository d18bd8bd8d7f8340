"""Checks of reference solutions: they state their scope and accuracy, and are the same in every call."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from contactlab.api import ReferenceSolution, Solution
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, bundled_scenes, load_scene
from contactlab.studies.find_reference import PartSource
from contactlab.studies.profile import integral
from contactlab.studies.reference import Reference
from contactlab.testing.assertions import Check, NotApplicable, require
from contactlab.testing.partners import partners

ASIDE = 0.75
"""Distance by which bodies are moved along x [mm]."""
STRANGE: tuple[dict[str, Any], ...] = ({}, {"name": "x"}, {"contacts": [], "bodies": {}, "supports": [{}]})
"""Scenes without what a reference may look for."""


def scenes(reference: ReferenceSolution) -> Iterator[Scene]:
    """Yield its examples, and bundled scenes to which it applies, as they are or at another depth of a support."""
    for example in reference.examples():
        scene = Scene.from_data(dict(example))
        why = reference.mismatch(scene.data)
        require(not why, f"it does not hold for its own example: {why}")
        yield scene
    for name in bundled_scenes():
        plain = load_scene(name)
        for changes in ({}, {"supports.1.uy.to": -0.01}):
            try:
                scene = plain.with_(changes)
            except Exception:
                continue
            if not reference.mismatch(scene.data):
                yield scene
                break


def says_what_it_is(reference: ReferenceSolution) -> None:
    """Title and origin are given; it can be pickled and is equal to its copy."""
    require(bool(reference.title) and bool(reference.origin), "its title or its origin is empty")
    require(pickle.loads(pickle.dumps(reference)) == reference, "it differs from its copy after pickling")


def is_silent_about_strange_scenes(reference: ReferenceSolution) -> None:
    """A scene without what it looks for has a reason why it does not hold; nothing is raised."""
    for scene in STRANGE:
        require(bool(reference.mismatch(scene)), f"it holds for the empty scene {scene}")


def does_not_depend_on_the_mesh(reference: ReferenceSolution) -> None:
    """A reference that holds for a bundled scene does so at any level, with any algorithm and either slave."""
    another = partners(default_registry(), "contact")[-1]
    for scene in _some(reference):
        for key, value in {"level": 2, "contacts.0.swap": True, "contacts.0.algorithm": another}.items():
            why = reference.mismatch(scene.with_({key: value}).data)
            require(not why, f"it holds for {scene.name}, but not with {key} = {value!r}: {why}")


def can_be_compared_with(reference: ReferenceSolution) -> None:
    """Pressures are functions of x, with an error; equal each time, the scene left as it was."""
    for scene in _some(reference):
        data: Mapping[str, Any] = scene.data
        before = copy.deepcopy(dict(data))
        first, second = reference.solution(data), reference.solution(data)
        rises = bool(np.all(np.diff(first.x) > 0.0)) and np.shape(first.x) == np.shape(first.pressure)
        require(rises, f"its x does not rise, or has not one pressure for each entry: {np.shape(first.x)}")
        found = PartSource("reference", reference).at(data)
        require(dict(data) == before, f"it changes the scene {scene.name}")
        same = np.array_equal(first.x, second.x) and np.array_equal(first.pressure, second.pressure)
        require(same, "a second call gives another pressure")
        require(float(np.max(found.profile.value)) > 0.0, f"its solution of {scene.name} has no pressure")
        if first.spread is not None:
            shapes = np.shape(first.spread), np.shape(first.x)
            require(shapes[0] == shapes[1], f"its spread has the shape {shapes[0]}, x has {shapes[1]}")
        require(math.isnan(first.error) or 0.0 <= first.error < 1.0, f"its error is {first.error}, allowed: 0 to 1")
        for name, scalar in first.scalars.items():
            good = math.isfinite(scalar.value) and scalar.error >= 0.0
            require(good, f"its {name} is {scalar.value} +- {scalar.error}")


def pressure_carries_the_reaction(reference: ReferenceSolution) -> None:
    """The integral of the pressure over x is the reaction, within the stated errors."""
    for scene in _some(reference):
        solution = reference.solution(scene.data)
        if "reaction" not in solution.scalars:
            raise NotApplicable("its solution has no reaction")
        _carries(PartSource("reference", reference).at(scene.data), solution)


def follows_the_depth(reference: ReferenceSolution) -> None:
    """Nine tenths of the displacement or load give less force, if it holds for that as well."""
    seen = 0
    for scene in _some(reference):
        key, value = _drive(scene)
        less = scene.with_({key: 0.9 * value}) if value else scene
        if less is scene or reference.mismatch(less.data):
            continue
        carried = [integral(PartSource("reference", reference).at(one.data).profile) for one in (scene, less)]
        text = f"it carries {carried[0]:.6g} at {key} = {value:g}, {carried[1]:.6g} at 0.9 of that"
        require(carried[1] < carried[0], text)
        seen += 1
    if not seen:
        raise NotApplicable("it holds for one depth only")


def _drive(scene: Scene) -> tuple[str, float]:
    """Key and value of the longest way of a support along y, or of the largest pressure; 0 without any."""
    moves: dict[str, float] = {}
    loads: dict[str, float] = {}
    for group, found, name in (("supports", moves, "uy"), ("loads", loads, "pressure")):
        for number, entry in enumerate(scene.data.get(group, ())):
            value, key = entry.get(name), f"{group}.{number}.{name}"
            if isinstance(value, Mapping):
                found[f"{key}.to"] = float(value.get("to", 0.0))
            elif isinstance(value, int | float):
                found[key] = float(value)
    some = {key: value for key, value in (moves if any(moves.values()) else loads).items() if value}
    return max(some.items(), key=lambda one: abs(one[1]), default=("", 0.0))


def moves_with_the_bodies(reference: ReferenceSolution) -> None:
    """Bodies that lie elsewhere along x have the same pressure there, if it holds for them as well."""
    seen = 0
    for scene in _some(reference):
        bodies = scene.data["bodies"]
        shifts = {
            name: [body.get("shift", [0.0, 0.0])[0] + ASIDE, body.get("shift", [0.0, 0.0])[1]]
            for name, body in bodies.items()
        }
        if scene.data.get("rigid") or scene.data.get("effects"):
            continue
        moved = scene.with_({f"bodies.{name}.shift": shift for name, shift in shifts.items()})
        if reference.mismatch(moved.data):
            continue
        one, other = reference.solution(scene.data), reference.solution(moved.data)
        off = float(np.abs(other.x - one.x - ASIDE).max())
        require(off <= 1e-9 * float(np.ptp(one.x)), f"bodies that lie {ASIDE:g} mm aside have x off by {off:.3g} mm")
        seen += 1
    if not seen:
        raise NotApplicable("it holds for one place only")


def _carries(found: Reference, solution: Solution) -> None:
    reaction = solution.scalars["reaction"]
    share = solution.error if math.isfinite(solution.error) else 0.01
    # a pressure by straight lines between m nodes misses an arc's by the square of the spacing, an even one by nothing
    pressure = np.abs(solution.pressure)
    curved = float(np.ptp(pressure)) / max(float(pressure.max()), 1e-300)
    allowed = reaction.error + (share + 1e-9 + 4.0 * curved / len(found.profile.x) ** 2) * abs(reaction.value)
    carried = integral(found.profile)
    text = f"its integrated pressure is {carried:.6g} N/mm, its reaction {reaction.value:.6g} N/mm"
    require(abs(carried - abs(reaction.value)) <= allowed, text)


def _some(reference: ReferenceSolution) -> list[Scene]:
    """Scenes to look at. Raises NotApplicable without any."""
    found = list(scenes(reference))
    if not found:
        raise NotApplicable("it holds for no bundled scene, and gives no examples()")
    return found


CHECKS: tuple[Check, ...] = (
    says_what_it_is, is_silent_about_strange_scenes, does_not_depend_on_the_mesh, can_be_compared_with,
    pressure_carries_the_reaction, follows_the_depth,
    moves_with_the_bodies,
)  # fmt: skip
"""All checks of references."""
