"""Check that prescribed motion leaves room for the bodies: it must not move held edges through each other."""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.errors import SceneError
from contactlab.meshing.checks import pieces
from contactlab.meshing.mesh import segments_of
from contactlab.model.bodies.body import Body, RigidSurface
from contactlab.model.loading.supports import Prescribed
from contactlab.scene.scene import Scene

SAMPLES = 33  # times at which motion is checked: ramps are monotonic, tables have a few corners


class _Held(NamedTuple):
    """Nodes of a body or rigid surface that are moved along an axis: all of them, or a run of neighbours.

    low, high  (times, 2) [mm] bounds of their positions
    """

    part: Any
    nodes: Ints
    low: Floats
    high: Floats


def check_approach(
    scene: Scene,
    bodies: tuple[Body, ...],
    rigid: tuple[RigidSurface, ...],
    reference: Floats,
    prescribed: Prescribed,
    end: float,
) -> None:
    """Raise SceneError if held nodes of one body pass through held nodes of another body in contact with it.

    Only sure cases count. A run of held nodes, each joined to the next by a side of a cell, begins on one side of a run
    of the other body, and later is on the other side, while their places across overlap all the time. Between two
    runs of one body, as between the clamped ends of a sheet, there is room.
    """
    every: list[Any] = [*bodies, *rigid]
    by_axis = [_held(every, prescribed, axis) for axis in range(2)]
    _follow([one for held in by_axis for one in held], reference, prescribed, end)
    groups = _joined(scene, [part.name for part in every])
    for axis, held in enumerate(by_axis):
        starts = np.array([(one.low[0, 1 - axis], one.high[0, 1 - axis]) for one in held]).reshape(-1, 2)
        for number, a in enumerate(held):
            beside = (starts[number + 1 :, 0] < starts[number, 1]) & (starts[number + 1 :, 1] > starts[number, 0])
            for b in (held[number + 1 + other] for other in np.flatnonzero(beside)):
                if groups[a.part.name] != groups[b.part.name] or _room(a, b, axis) is None:
                    continue  # not even the bounds of all their nodes pass
                runs = [_runs(one) for one in (a, b)]
                _follow([run for one in runs for run in one], reference, prescribed, end)
                for one, other in product(*runs):
                    if (room := _room(one, other, axis)) is not None:
                        _refuse(scene, one, other, axis, room)


def _held(parts: list[Any], prescribed: Prescribed, axis: int) -> list[_Held]:
    """Return the parts that are held along an axis."""
    nodes = np.sort(prescribed.dof[prescribed.dof % 2 == axis] // 2)
    found = []
    for part in parts:
        own = nodes[slice(*np.searchsorted(nodes, [part.first, part.first + part.count]))]
        if len(own):
            found.append(_bounded(part, own))
    return found


def _bounded(part: Any, nodes: Ints) -> _Held:
    return _Held(part, nodes, np.zeros((SAMPLES, 2)), np.zeros((SAMPLES, 2)))


def _runs(held: _Held) -> list[_Held]:
    """Return runs of held nodes joined by sides of cells: between runs the body is free to give way."""
    part = held.part
    sides = (
        part.edges if hasattr(part, "edges") else np.concatenate([part.cells[:, list(e)] for e in part.element.edges])
    )
    joined = segments_of(sides) - part.first
    own = np.zeros(part.count, np.bool_)
    own[held.nodes - part.first] = True
    label = pieces(joined[own[joined].all(axis=1)], part.count)[held.nodes - part.first]
    return [_bounded(part, held.nodes[label == one]) for one in np.unique(label)]


def _follow(held: list[_Held], reference: Floats, prescribed: Prescribed, end: float) -> None:
    """Fill the bounds: positions of the rest of a body are unknown. One time after the other, to save memory."""
    for number, time in enumerate(np.linspace(0.0, end, SAMPLES)):
        place = reference.copy()
        place.ravel()[prescribed.dof] += prescribed.scale * prescribed.values(float(time))[prescribed.ramp]
        for one in held:
            one.low[number] = place[one.nodes].min(axis=0, initial=np.inf)
            one.high[number] = place[one.nodes].max(axis=0, initial=-np.inf)


def _joined(scene: Scene, names: list[str]) -> dict[str, str]:
    """Return a name for each body and rigid surface, equal if contacts join them, directly or through others."""
    of = {name: name for name in names}

    def root(name: str) -> str:
        while of[name] != name:
            of[name] = of[of[name]]
            name = of[name]
        return name

    for contact in scene.contacts:
        first, *others = {target.partition(".")[0] for side in contact.targets for target in side}
        for other in others:
            of[root(other)] = root(first)
    return {name: root(name) for name in names}


def _room(a: _Held, b: _Held, axis: int) -> tuple[float, float] | None:
    """Return the room [mm] between two sets of nodes that pass through each other, and their approach [mm].

    None if they do not pass, as far as their bounds can tell.
    """
    (below, above), across = ((a, b) if a.low[0, axis] < b.low[0, axis] else (b, a)), 1 - axis
    room = above.low[:, axis] - below.high[:, axis]
    left = above.high[:, axis] - below.low[:, axis]
    # a single node passes what it lies within; two nodes always pass next to each other
    overlap = (a.low[:, across] < b.high[:, across]) & (b.low[:, across] < a.high[:, across])
    if room[0] <= 0.0 or not left.min() <= 0.0 or not overlap[: int(np.argmax(left <= 0.0)) + 1].all():
        return None
    return float(room[0]), float(room[0] - room.min())


def _refuse(scene: Scene, a: _Held, b: _Held, axis: int, room: tuple[float, float]) -> None:
    raise SceneError(
        f"what holds {a.part.name} and what holds {b.part.name} would pass through each other along {'xy'[axis]}",
        where=scene.where("supports"),
        got=f"they come {room[1]:.4g} mm closer",
        allowed=f"less than the {room[0]:.4g} mm between them, which the bodies fill",
        hint="press less deep, or hold less of the bodies",
    )
