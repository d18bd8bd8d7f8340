"""Whether the bodies of a scene that is to be at rest are held."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Integrator
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body
from contactlab.model.loading.supports import Prescribed, SupportPlan

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene

MOTIONS = ("sliding along x", "sliding along y", "turning")


def check_supported(scene: Scene, bodies: tuple[Body, ...], supports: SupportPlan, integrator: Integrator) -> None:
    """Raise SceneError for a body that could drift away where the scene asks for a state of rest.

    Without inertia every rigid motion needs a support, a contact or an effect against it. Explicit runs with
    `end = "auto"` damp what drifts, but something must push back: a body that nothing but one contact
    touches is pushed away.
    """
    if integrator.inertia and scene.time.end != "auto":
        return
    for body in bodies:
        free = free_motions(body, supports)
        neighbours = _neighbours(scene, body.name)
        pushed = bool(scene.effects) or any(load.on.partition(".")[0] == body.name for load in scene.loads)
        if len(free) == 3 and len(neighbours) < 2 and not (pushed and (neighbours or scene.effects)):
            raise _adrift(scene, body, free, "no support holds this body" + _touched(neighbours))
        if not integrator.inertia and free and not neighbours and not scene.effects:
            raise _adrift(scene, body, free, "the supports leave this body free to move")


def free_motions(body: Body, supports: SupportPlan | Prescribed) -> list[str]:
    """Which rigid motions of the body its supports do not prevent, in words."""
    own = supports.dof[(supports.dof >= 2 * body.first) & (supports.dof < 2 * (body.first + body.count))]
    modes = _rigid_modes(body)[own - 2 * body.first]
    _, sizes, directions = np.linalg.svd(modes) if len(own) else (None, np.zeros(0), np.eye(3))
    held = int((sizes > 1e-9 * max(1.0, sizes.max(initial=0.0))).sum())
    loose = directions[held:]
    if held == 0:
        return list(MOTIONS)
    return [MOTIONS[int(np.argmax(np.abs(mode)))] for mode in loose]


def _rigid_modes(body: Body) -> Floats:
    """Displacements (2 n, 3) of the nodes in the two shifts and the turn about the middle, of size one."""
    arm = body.mesh.nodes - body.mesh.nodes.mean(axis=0)
    arm = arm / np.abs(arm).max()
    modes = np.zeros((len(arm), 2, 3))
    modes[:, 0, 0], modes[:, 1, 1] = 1.0, 1.0
    modes[:, 0, 2], modes[:, 1, 2] = -arm[:, 1], arm[:, 0]
    return modes.reshape(-1, 3)


def _neighbours(scene: Scene, name: str) -> set[str]:
    """Bodies and rigid surfaces that share a contact with this one."""
    found: set[str] = set()
    for contact in scene.contacts:
        slave, master = ({target.partition(".")[0] for target in side} for side in contact.targets)
        found |= master if name in slave else slave if name in master else set()
    return found - {name}


def _touched(neighbours: set[str]) -> str:
    return f", and {next(iter(neighbours))} alone touches it" if neighbours else " and nothing touches it"


def _adrift(scene: Scene, body: Body, free: list[str], problem: str) -> SceneError:
    return SceneError(
        problem,
        where=scene.where(f"bodies.{body.name}"),
        got=f"free for {', '.join(free)}",
        allowed="bodies that supports, contacts or effects keep from drifting, where the end is a state of rest",
        hint=f'add a [[supports]] table with on = "{body.name}.EDGE_SET"',
    )
