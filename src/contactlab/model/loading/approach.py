"""Whether prescribed motion leaves any room for what lies between: an indentation deeper than the bodies is refused."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body
from contactlab.model.loading.supports import Prescribed

if TYPE_CHECKING:
    from contactlab.model.loading.rigid import RigidSurface
    from contactlab.scene.scene import Scene

SAMPLES = 33  # times at which motion is looked at: ramps have one way to go, tables a few corners


class _Held(NamedTuple):
    """The nodes of a body or rigid surface that are moved along an axis, and where: (times, nodes) [mm]."""

    name: str
    nodes: Ints
    along: Floats


def check_approach(
    scene: Scene,
    bodies: tuple[Body, ...],
    rigid: tuple[RigidSurface, ...],
    reference: Floats,
    prescribed: Prescribed,
    end: float,
) -> None:
    """Raise SceneError where what holds one body is to pass through what holds another that contact joins to it.

    Of each two only what is sure counts: along an axis all held nodes of one lie on one side of those of the other,
    and later all on the other side, while their places across overlap all the time.
    """
    places = _places(reference, prescribed, np.linspace(0.0, end, SAMPLES))
    every: list[Any] = [*bodies, *rigid]
    for group in _joined(scene, [part.name for part in every]):
        parts = [part for part in every if part.name in group]
        for axis in range(2):
            held = [_held(part, prescribed, places, axis) for part in parts]
            for a, b in combinations([one for one in held if len(one.nodes)], 2):
                _refuse_passing(scene, a, b, places[:, :, 1 - axis], axis)


def _places(reference: Floats, prescribed: Prescribed, times: Floats) -> Floats:
    """Positions (times, N, 2) with prescribed displacements; where the rest of a body is, nobody knows yet."""
    places = np.repeat(reference[None], len(times), axis=0)
    flat = places.reshape(len(times), -1)
    for row, time in zip(flat, times, strict=True):
        row[prescribed.dof] += prescribed.scale * prescribed.values(float(time))[prescribed.ramp]
    return places


def _joined(scene: Scene, names: list[str]) -> list[set[str]]:
    """Names of bodies and rigid surfaces in groups that contacts join, directly or one through another."""
    groups = [{name} for name in names]
    for contact in scene.contacts:
        touched = {target.partition(".")[0] for side in contact.targets for target in side}
        both = set().union(*(group for group in groups if group & touched))
        groups = [group for group in groups if not group & touched] + [both]
    return [group for group in groups if len(group) > 1]


def _held(part: Any, prescribed: Prescribed, places: Floats, axis: int) -> _Held:
    own = prescribed.dof[(prescribed.dof >= 2 * part.first) & (prescribed.dof < 2 * (part.first + part.count))]
    nodes = own[own % 2 == axis] // 2
    return _Held(part.name, nodes, places[:, nodes, axis])


def _refuse_passing(scene: Scene, a: _Held, b: _Held, across: Floats, axis: int) -> None:
    below, above = (a, b) if a.along[0].mean() < b.along[0].mean() else (b, a)
    room = above.along.min(axis=1) - below.along.max(axis=1)
    width = np.minimum(across[:, a.nodes].max(axis=1), across[:, b.nodes].max(axis=1)) - np.maximum(
        across[:, a.nodes].min(axis=1), across[:, b.nodes].min(axis=1)
    )
    left = above.along.max(axis=1) - below.along.min(axis=1)
    if room[0] <= 0.0 or not left.min() <= 0.0 or not width[: int(np.argmax(left <= 0.0)) + 1].min() > 0.0:
        return
    raise SceneError(
        f"what holds {a.name} and what holds {b.name} would pass through each other along {'xy'[axis]}",
        where=scene.where("supports"),
        got=f"they come {room[0] - room.min():.4g} mm closer",
        allowed=f"less than the {room[0]:.4g} mm between them, which the bodies fill",
        hint="press less deep, or hold less of the bodies",
    )
