"""Check that the bodies of a scene with a state of rest are held."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Floats, FrictionBound, Integrator
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body
from contactlab.model.loading.supports import Prescribed, SupportPlan
from contactlab.scene.scene import Scene

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair
    from contactlab.model.implicit_model import ImplicitModel

RANK = 1e-6  # of the largest resistance: motions with less are free
ROUND = 1e-12  # of the stiffness: less from loads is round-off
FREE = 0.1  # of a unit motion: bodies that move together share one
TOUCHING = 1e-6  # segments apart: closed as soon as a force comes
MOTIONS = ("sliding along x", "sliding along y", "turning")


def check_supported(scene: Scene, bodies: tuple[Body, ...], supports: SupportPlan, integrator: Integrator) -> None:
    """Raise SceneError for a body that could drift away if the scene asks for a state of rest.

    Without inertia every rigid motion needs a support, a contact or an effect against it. Explicit runs with
    `end = "auto"` damp drift, but something must push back: a body touched by nothing but one contact
    is pushed away.
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
    """Return the rigid motions of the body that its supports do not prevent, in words."""
    own = supports.dof[(supports.dof >= 2 * body.first) & (supports.dof < 2 * (body.first + body.count))]
    modes = _rigid_modes(body)[own - 2 * body.first]
    _, sizes, directions = np.linalg.svd(modes) if len(own) else (None, np.zeros(0), np.eye(3))
    held = int((sizes > 1e-9 * max(1.0, sizes.max(initial=0.0))).sum())
    loose = directions[held:]
    if held == 0:
        return list(MOTIONS)
    return [MOTIONS[int(np.argmax(np.abs(mode)))] for mode in loose]


def loose_motions(
    model: ImplicitModel, friction: bool = True, least: float = RANK, pressed: bool = True
) -> dict[str, tuple[str, ...]]:
    """Return rigid motions that neither supports, effects nor closed contacts resist at the present state, by body.

    friction  True if friction of contacts counts
    least     resistance below this share of the largest resistance does not count
    pressed   True if friction needs a force; otherwise a law and touch are enough
    """
    bodies = _unheld(model)
    if not bodies:
        return {}
    _, free = _loose(model, bodies, friction, least, pressed)
    found: dict[str, tuple[str, ...]] = {}
    for number, body in enumerate(bodies):
        share = np.linalg.norm(free[:, 3 * number : 3 * number + 3], axis=0)  # of each free motion
        if (most := float(share.max(initial=0.0))) > FREE:
            alike = (1.0 - FREE) * most
            found[body.name] = tuple(motion for motion, own in zip(MOTIONS, share, strict=True) if own >= alike)
    return found


def _loose(
    model: ImplicitModel, bodies: list[Body], friction: bool, least: float, pressed: bool
) -> tuple[Floats, Floats]:
    """Rigid motions (2N, 3b) of bodies, and combinations (m, 3b) of them without resistance (`loose_motions`)."""
    modes = _modes(model, bodies)
    rows = [modes[model.prescribed.dof]]
    if model.loading.loads:
        stiffness = model.stiffness(0.0)
        bare = stiffness @ modes
        model.add_load_stiffness(model.state.time, stiffness, 1.0, 0.0)
        added = stiffness @ modes - bare
        rows.append(added / max(float(np.abs(added).max()), ROUND * float(np.abs(stiffness.diagonal()).max())))
    if model.contact is not None:
        model.contact.evaluate(model.position)
        c = model.contact.conditions
        closed = c.present & ((c.force[0] > 0.0) | (c.gap <= TOUCHING * c.size))
        force = c.force[0] if pressed else 1.0
        sticks = np.flatnonzero(closed & (c.bound[0] * force + c.bound[1] > 0.0)) if len(c.slip) else None
        along, across = model.contact.directions(np.flatnonzero(closed).astype(np.int32))
        rows.append(along @ modes)
        if friction and across is not None and sticks is not None:
            rows.append((across @ modes)[np.searchsorted(np.flatnonzero(closed), sticks)])
        for pair in model.contact.passes:
            if pair.by_energy:
                rows += [row @ modes for row in _held_by(pair, model, friction, pressed)]
    _, sizes, directions = np.linalg.svd(np.concatenate(rows))
    return modes, directions[int((sizes > least * max(1.0, sizes.max(initial=0.0))).sum()) :]


def driven(model: ImplicitModel, time: float) -> bool:
    """Return whether loads at a `time` [s] push bodies along motions that friction alone resists, or supports move."""
    moved = model.prescribed
    if np.any(moved.scale * moved.values(time)[moved.ramp]):
        return True
    force = np.zeros_like(model.reference)
    model.external_force(time, force)
    modes, free = _loose(model, _unheld(model), True, RANK, True)
    return bool(np.any(np.abs(free @ (modes.T @ force.ravel())) > RANK * np.abs(force).sum()))


def opposed(model: ImplicitModel, least: float) -> float:
    """Return the share of its bound with which friction opposes the motions that nothing else resists.

    Of these motions it is the one along which friction has the largest resultant. Friction of two contacts that pull
    against each other opposes no motion of the body, even if both are at their bounds.
    """
    modes, free = _loose(model, _unheld(model), False, least, True)
    assert model.contact is not None
    c = model.contact.conditions
    closed = np.flatnonzero(c.present & (c.force[0] > 0.0)).astype(np.int32)
    _, across = model.contact.directions(closed)
    if across is None or not len(free):
        return 0.0
    slips = np.asarray(across @ modes) @ free.T
    resultant = c.force[1, closed] @ slips
    bound, _ = FrictionBound(*c.bound[:, closed]).limits(c.force[0, closed], c.measure[closed])
    return float(resultant @ resultant) / max(float(bound @ np.abs(slips @ resultant)), 1e-300)


def unbalanced(model: ImplicitModel, time: float) -> list[str]:
    """Names of bodies whose loads at a `time` [s] no forces within the friction cones of touching nodes balance.

    Bodies are taken as rigid, and nodes as touching as they are now; potentials and bodies with other supports, or
    moved ones, are not judged.
    """
    from scipy.optimize import nnls

    contact, bodies = model.contact, [body for body in _unheld(model) if len(free_motions(body, model.prescribed)) == 3]
    if contact is None or contact.by_energy or not bodies:
        return []
    modes = _modes(model, bodies)
    force = np.zeros_like(model.reference)
    model.external_force(time, force)
    contact.evaluate(model.position)
    c = contact.conditions
    closed = np.flatnonzero(c.present & ((c.force[0] > 0.0) | (c.gap <= TOUCHING * c.size))).astype(np.int32)
    along, across = contact.directions(closed)
    push = np.asarray(along @ modes)
    if across is not None and len(c.slip):
        rub = c.bound[0, closed, None] * np.asarray(across @ modes)
        push = np.concatenate([push + rub, push - rub])
    load = modes.T @ force.ravel()
    answer = nnls(push.T, -load)[0] if len(push) else np.zeros(0)
    left = np.abs(load + push.T @ answer).reshape(-1, 3).max(axis=1)
    return [body.name for body, rest in zip(bodies, left, strict=True) if rest > RANK * np.abs(force).sum()]


def _modes(model: ImplicitModel, bodies: list[Body]) -> Floats:
    """Return rigid motions (2N, 3b) of bodies."""
    modes = np.zeros((model.reference.size, 3 * len(bodies)))
    for number, body in enumerate(bodies):
        modes[2 * body.first : 2 * (body.first + body.count), 3 * number : 3 * number + 3] = _rigid_modes(body)
    return modes


def _unheld(model: ImplicitModel) -> list[Body]:
    return [body for body in model.bodies if free_motions(body, model.prescribed)]


def _held_by(pair: ContactPair, model: ImplicitModel, friction: bool, pressed: bool) -> Iterator[Any]:
    """Yield derivatives (k, 2 N) of gaps, and of slips that friction holds, of the closed nodes of a potential."""
    from scipy.sparse import coo_array

    from contactlab.contact.gap_pair import GapPair

    assert isinstance(pair, GapPair)
    pair.update(model.position, np.zeros((0, len(pair.slave.nodes))))
    found, force = pair.found, model.state["multipliers"][0, pair.own]
    assert found is not None  # of the update
    touching = found.gap <= pair.clearance + TOUCHING * pair.size
    row = np.repeat(np.arange(len(found.gap)), np.diff(found.start))
    weights = [(found.normal_weight, touching | (force[found.owner] > 0.0))]
    if friction and pair.friction is not None:
        weights.append((found.tangent_weight, force[found.owner] > 0.0 if pressed else touching))
    for weight, chosen in weights:
        place = np.repeat(row, 2), np.add.outer(2 * found.node, np.arange(2)).ravel()
        yield coo_array((weight.ravel(), place), shape=(len(found.gap), model.reference.size)).tocsr()[chosen]


def hold(body: str, motions: tuple[str, ...]) -> str:
    """Return a hint for holding a body against some of `MOTIONS`."""
    keys = [f"u{motion[-1]} = 0.0" for motion in motions if motion[-1] in "xy"] or ["ux = 0.0"]
    return (
        f'hold it: [[supports]] with on = "{body}.EDGE_SET" and {", ".join(keys)}, friction, or a soft spring, '
        f'[[effects]] with use = "spring" and on = "{body}.EDGE_SET"'
    )


def _rigid_modes(body: Body) -> Floats:
    """Return displacements (2 n, 3) of the nodes in the two shifts and the turn about the middle, of size one."""
    arm = body.mesh.nodes - body.mesh.nodes.mean(axis=0)
    arm = arm / np.abs(arm).max()
    modes = np.zeros((len(arm), 2, 3))
    modes[:, 0, 0], modes[:, 1, 1] = 1.0, 1.0
    modes[:, 0, 2], modes[:, 1, 2] = -arm[:, 1], arm[:, 0]
    return modes.reshape(-1, 3)


def _neighbours(scene: Scene, name: str) -> set[str]:
    """Return bodies and rigid surfaces that share a contact with this body."""
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
        allowed="bodies that supports, contacts or effects keep from drifting, if the end is a state of rest",
        hint=f'add a [[supports]] table with on = "{body.name}.EDGE_SET"',
    )
