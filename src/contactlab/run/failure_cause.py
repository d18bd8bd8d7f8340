"""Likely causes of an implicit step that finds no equilibrium: what it is, where, and what to try."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
from scipy.sparse import csc_matrix

from contactlab.api import Conditions, Floats, FrictionBound, Iteration, PointContact, StepStatus, Surface
from contactlab.api.frame import SLIP, STICK
from contactlab.model.implicit_model import ImplicitModel
from contactlab.model.loading.held_bodies import MOTIONS, driven, free_motions, hold, loose_motions, opposed, unbalanced
from contactlab.model.model import Model
from contactlab.run.coordinates import coordinates
from contactlab.scene.scene import Scene

if TYPE_CHECKING:
    from contactlab.contact.implicit_system import ImplicitContactSystem
    from contactlab.contact.pair import ContactPair

SHARP = 20.0  # degrees by which a surface turns at a corner: meshes of curves turn by less
TURNS = 0.1  # degrees by which a master turns at a vertex: at less the force hardly jumps
OVER = 0.02  # of a segment, by which a node is beside a vertex that it goes to and fro over
LAST = 8  # iterations whose changes of contact states count
FILLET = 3.0  # segments: the radius that a snap fit needed to get past a corner
LARGEST = 1.0  # of the extent of a side: a larger fillet has no room
AT_CORNER = 1.0  # in the longest segment next to a corner
SLOPE = 0.05  # of the resistance: normals that lean by deformation resist sliding a little, but do not hold
USED = 0.9  # of the friction that a contact can carry: above this the load is near its limit
SLIPS = 0.999  # of the friction that a contact can carry: all of its nodes slip
TIPPED = 0.02  # of the length of a contact: a resultant so near to its end has left the last segments but one


def cause_of_failure(model: Model, scene: Scene, trace: Sequence[Iteration], dt: float) -> str:
    """Return the likely cause at the last accepted state, with place and advice; general advice if none is found.

    trace  iterations of the last attempt; dt  its length [s]
    """
    if model.contact is None:
        return _unstable(model, dt) or StepStatus.gave_up.value
    changed = _changes(model, trace)
    return (
        _friction_used_up(model, scene)
        or _tipping(model, scene)
        or _unbalanced(model, dt)
        or _at_a_corner(model, scene, changed)
        or _unstable(model, dt)
        or _over_a_vertex(model, scene, changed)
        or _cycling(model, scene, changed)
        or _at_a_corner(model, scene, _closed(model))
        or _over_a_vertex(model, scene, _closed(model))
        or "no equilibrium found; try the other side as slave (swap), another algorithm, or shorter steps"
    )


def nothing_holds(model: Model, dt: float = 0.0) -> str:
    """Say in statics which bodies are free, or held only by friction without pressure; empty if all is held.

    dt  [s] length of the step that failed. Friction is not too weak if nothing pushes a body along it.
    """
    if model.integrator.inertia:
        return ""
    model = cast("ImplicitModel", model)
    if not (loose := loose_motions(model)):
        return ""
    if not (never := loose_motions(model, pressed=False)):
        if not driven(model, model.state.time + dt):
            return ""
        told = [f"{body} against {' or '.join(motions)}" for body, motions in loose.items()]
        return (
            f"only friction holds {', and '.join(told)}, and it is too weak from the start: the tangential load "
            "exceeds what the pressure allows; try more friction, pressure before the push, or a support"
        )
    told = [f"{body} against {' or '.join(motions)}" for body, motions in never.items()]
    holds = [hold(body, motions) for body, motions in never.items()]
    return (
        f"no support holds {', nor '.join(told)}; {holds[0]}; or let it start in contact with the body that should "
        "hold it; free motion needs inertia (implicit-dynamics)"
    )


# --- contact states ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Node:
    """A slave node, and the contact states that it had in the last iterations."""

    pair: ContactPair
    number: int
    states: frozenset[int] = frozenset()

    def position(self, model: Model) -> Floats:
        return np.asarray(model.position[self.pair.slave.nodes[self.number]])


def _changes(model: Model, trace: Sequence[Iteration]) -> list[_Node]:
    """Slave nodes whose states changed in the last iterations, the most restless first."""
    known = [np.frombuffer(one.statuses.encode(), np.uint8) - ord("0") for one in trace[-LAST:] if one.statuses]
    if model.contact is None or len(known) < 2 or len({len(one) for one in known}) > 1:
        return []
    states = np.array(known).astype(int)
    count = np.count_nonzero(np.diff(states, axis=0), axis=0)
    found: list[tuple[int, int, _Node]] = []
    for pair in model.contact.pairs:
        for slot in np.flatnonzero(count[pair.own]):
            seen = frozenset(states[:, pair.first_slot + slot].tolist())
            node = _Node(pair, int(slot) % len(pair.slave.nodes), seen)
            found.append((-int(count[pair.first_slot + slot]), len(found), node))
    return [node for *_, node in sorted(found, key=lambda one: one[:2])]


def _closed(model: Model) -> list[_Node]:
    """Slave nodes with a force at the last accepted state."""
    force = model.state["multipliers"][0]
    return [
        _Node(pair, int(slot) % len(pair.slave.nodes))
        for pair in (model.contact.pairs if model.contact is not None else ())
        for slot in np.flatnonzero(force[pair.own] > 0.0)
    ]


def _place(model: Model, scene: Scene, pair: ContactPair, point: Floats) -> str:
    """Return a place in words: coordinates and the sides of the contact."""
    slave, master = scene.contacts[_number(pair)].sides
    return f"near {coordinates(model, point)}, {slave} on {master}"


def _number(pair: ContactPair) -> int:
    return int(pair.name.rpartition(".")[2])


def _at_a_corner(model: Model, scene: Scene, nodes: Sequence[_Node]) -> str:
    """Report the first of some slave nodes at a sharp corner of either side; empty if there is none."""
    for node in nodes:
        point, pair = node.position(model), node.pair
        slave, master = scene.contacts[_number(pair)].sides
        for name, surface in ((master, pair.master), (slave, pair.slave)):
            for corner, angle, length in _corners(model.position, surface):
                if np.hypot(*(corner - point)) <= AT_CORNER * length:
                    room = float(np.ptp(model.position[surface.nodes], axis=0).max())
                    large = FILLET * length > LARGEST * room
                    fillet = (
                        f"cells there of at most {LARGEST / FILLET * room:.2g} ({length:.2g} now), and a fillet"
                        if large
                        else f"a fillet of about {FILLET * length:.2g}"
                    )
                    return (
                        f"{_place(model, scene, pair, corner)}: {name} has a sharp corner there ({angle:.0f} degrees), "
                        f"where the direction of contact forces jumps; try {fillet} ({FILLET:.0f} segments)"
                    )
    return ""


def _over_a_vertex(model: Model, scene: Scene, nodes: Sequence[_Node]) -> str:
    """Report the one of some slave nodes that lies nearest over a vertex where its master turns.

    If conditions are set at nodes, the force of such a node jumps from one segment's normal to the next.
    """
    found: list[tuple[float, ContactPair, Floats, float]] = []
    for node in nodes:
        pair, point = node.pair, node.position(model)
        if not isinstance(pair.method, PointContact) or pair.method.points:
            continue
        for vertex, angle, length in _corners(model.position, pair.master, TURNS):
            found.append((float(np.hypot(*(vertex - point))) / length, pair, vertex, angle))
    if not found or (nearest := min(found, key=lambda one: one[0]))[0] > OVER:
        return ""
    _, pair, vertex, angle = nearest
    swap = "false" if scene.contacts[_number(pair)].swap else "true"
    return (
        f"{_place(model, scene, pair, vertex)}: a node of the slave lies over a vertex of the master, which turns by "
        f"{angle:.2g} degrees there, and its force jumps from one normal to the other; try {pair.name}.swap = {swap}, "
        "or a mortar"
    )


def _corners(position: Floats, surface: Surface, sharp: float = SHARP) -> Iterator[tuple[Floats, float, float]]:
    """Corners above `sharp` [degrees]: position, angle by which the surface turns, longer of the two segments."""
    begin, end = (position[surface.nodes[surface.segments[:, k]]] for k in range(2))
    along = end - begin
    into, out = surface.node_segments.T
    for node in np.flatnonzero((into >= 0) & (out >= 0)):
        a, b = along[into[node]], along[out[node]]
        angle = abs(float(np.degrees(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))))
        if angle > sharp:
            yield position[surface.nodes[node]], angle, float(max(np.hypot(*a), np.hypot(*b)))


def _cycling(model: Model, scene: Scene, changed: Sequence[_Node]) -> str:
    """Report nodes that change their contact states without end; empty if there are none."""
    if not changed:
        return ""
    first = changed[0]
    spec = scene.contacts[_number(first.pair)]
    between = "stick and slip" if first.states <= {STICK, SLIP} else "open and closed"
    sides = f"{first.pair.name}.swap = {'false' if spec.swap else 'true'}"
    where = _place(model, scene, first.pair, first.position(model))
    return (
        f"{where}: nodes switch between {between} in the last iterations, {len(changed)} of "
        f"{len(first.pair.slave.nodes)}; try {sides}, finer cells (level = {2 * scene.level}), or more integrator.steps"
    )


# --- bodies that friction alone holds ---------------------------------------------------------------


def _friction_used_up(model: Model, scene: Scene) -> str:
    """Report contacts that carry nearly all the friction that they can, if nothing else holds a body."""
    if model.integrator.inertia or not (closed := _closed(model)):
        return ""
    contact = cast("ImplicitContactSystem", model.contact)
    if not len(contact.conditions.slip):
        return ""
    used = {pair: friction_share(contact.conditions, pair.first_slot, pair.slots) for pair in contact.pairs}
    loose = loose_motions(cast("ImplicitModel", model), friction=False, least=SLOPE)
    if loose and opposed(cast("ImplicitModel", model), SLOPE) < USED:
        return ""
    if not (loose := loose or _sliding(model, scene, used)):
        return ""
    at_limit = [
        f"friction of {pair.name} carries {share:.1%} of its limit" for pair, share in used.items() if share > USED
    ]
    if not at_limit:
        return ""
    node = next(node for node in closed if used[node.pair] > USED)
    held = ", ".join(f"{body} against {' or '.join(motions)}" for body, motions in loose.items())
    where = _place(model, scene, node.pair, node.position(model))
    return (
        f"{where}: {', '.join(at_limit)}, and nothing else holds {held}: "
        "this is a limit load; try less load, more pressure or friction, or a support"
    )


def _sliding(model: Model, scene: Scene, used: dict[ContactPair, float]) -> dict[str, tuple[str, ...]]:
    """Return bodies without supports whose pressing nodes all slip in the same direction along the surface.

    A belt on a drum is one: it slides although no rigid motion of it is free.
    """
    forces = model.state["multipliers"]
    pressed = [pair for pair in used if forces[0, pair.own].any()]
    found: dict[str, tuple[str, ...]] = {}
    for body in model.bodies:
        own = [pair for pair in pressed if body.name in _bodies(scene, pair)]
        if len(free_motions(body, model.prescribed)) < len(MOTIONS) or not own:
            continue
        around = np.concatenate([forces[1, pair.own] for pair in own])
        if min(used[pair] for pair in own) > SLIPS and abs(around.sum()) > USED * np.abs(around).sum():
            found[body.name] = ("sliding along its contacts",)
    return found


def _tipping(model: Model, scene: Scene) -> str:
    """Report a body that only one contact keeps from turning, if its resultant has reached the end of that contact."""
    if model.integrator.inertia or model.contact is None:
        return ""
    turning = {body.name for body in model.bodies if MOTIONS[2] in free_motions(body, model.prescribed)}
    pressed = [pair for pair in model.contact.pairs if model.state["multipliers"][0, pair.own].any()]
    for name in turning:
        touched = [pair for pair in pressed if name in _bodies(scene, pair)]
        if len(touched) != 1:
            continue
        share, end = _reserve(model, touched[0])
        if share < TIPPED:
            return (
                f"{_place(model, scene, touched[0], end)}: body {name} tips: the contact force acts within {share:.1%} "
                "of the end of the contact, and nothing else holds it against turning: this is a limit load; try less "
                "load, a wider contact, or a support"
            )
    return ""


def _unbalanced(model: Model, dt: float) -> str:
    """Report bodies whose loads no pressures of the nodes that touch balance, if no step was possible."""
    if model.integrator.inertia or model.state.step:
        return ""
    if not (found := unbalanced(cast("ImplicitModel", model), model.state.time + dt)):
        return ""
    return (
        f"no pressures of the nodes that touch, with their friction, balance the loads of {' and '.join(found)}: what "
        "stands there tips, slides or lifts off; try finer cells at the ends of these contacts, a mortar, or a support"
    )


def _bodies(scene: Scene, pair: ContactPair) -> set[str]:
    """Names of the bodies on both sides of a contact."""
    return {target.partition(".")[0] for side in scene.contacts[_number(pair)].targets for target in side}


def _reserve(model: Model, pair: ContactPair) -> tuple[float, Floats]:
    """Distance of the resultant from the nearer end of the contact, over the contact's length; position of that end."""
    from contactlab.kernels.contact.pair import FAR

    force = model.state["multipliers"][0, pair.own]
    at = np.tile(model.position[pair.slave.nodes], (pair.rows_per_node, 1))
    meets = at[(pair.gaps[:, 0] < FAR) | (force > 0.0)]
    ends = meets[(meets @ (meets[-1] - meets[0])).argsort()[[0, -1]]]
    along = ends[1] - ends[0]
    length = float(along @ along)
    share = float((force @ at / force.sum() - ends[0]) @ along) / length if length > 0.0 else 0.5
    return min(share, 1.0 - share), ends[int(share > 0.5)]


def friction_share(conditions: Conditions, first: int, count: int) -> float:
    """Tangential forces of the conditions from `first` on over their bounds."""
    own = slice(first, first + count)
    pressed, pulled = conditions.force[0, own], np.abs(conditions.force[1, own])
    bound, _ = FrictionBound(*conditions.bound[:, own]).limits(pressed, conditions.measure[own])
    return float(pulled.sum() / max(bound.sum(), 1e-300))


# --- bodies that lose their stiffness ---------------------------------------------------------------


def _unstable(model: Model, dt: float) -> str:
    """Report a body whose stiffness has a negative eigenvalue: it buckles or snaps through."""
    if model.integrator.inertia:
        return ""
    for body in model.bodies:
        if free_motions(body, model.prescribed) or not _negative(model, body.first, body.count, dt):
            continue
        middle = model.position[body.first : body.first + body.count].mean(axis=0)
        flows = ", or flows plastically at its limit load" if body.material.history_size else ""
        return (
            f"body {body.name}, around {coordinates(model, middle)}: its stiffness is no longer positive definite: it "
            f"buckles or snaps through{flows}; try implicit-dynamics, which follows the jump, or a smaller load"
        )
    return ""


def _negative(model: Model, first: int, count: int, dt: float) -> bool:
    """Return whether the stiffness of a body, with its supports, has a negative pivot."""
    from scipy.sparse.linalg import splu

    memory = model.state.snapshot()
    model.internal_force(dt)
    matrix = csc_matrix(model.stiffness(dt))  # type: ignore[attr-defined]
    model.state.restore(memory)
    held = np.zeros(matrix.shape[0], bool)
    held[model.prescribed.dof] = True
    free = np.flatnonzero(~held[2 * first : 2 * (first + count)]) + 2 * first
    own = matrix[free][:, free]
    if not len(free):
        return False
    try:
        factor = splu(
            csc_matrix(0.5 * (own + own.T)), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )  # fmt: skip
    except RuntimeError:  # singular to the last digit
        return True
    return bool((factor.U.diagonal() < 0.0).any())
