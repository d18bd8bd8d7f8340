"""What a run can see of itself when it is over: contacts that never closed, forces that do not agree, coarse facets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Ints, RunWarning, Surface
from contactlab.api.arrays import Flags
from contactlab.errors import SimulationFailure
from contactlab.results.invariants import invariants
from contactlab.results.saw_tooth import CORNER
from contactlab.run.breaches import breach

if TYPE_CHECKING:
    from contactlab.model.contact.pair import ContactPair
    from contactlab.model.model import Model
    from contactlab.results.sample import Sample

WRONG = 0.25  # of the contact force: the pressure is that of another one
FACETS = 0.05  # depth of facets over the approach: unlike meshes of a press fit then miss 2.5 % of its mean pressure
FIT = 0.05  # segments: how far nodes of like meshes may have slid apart
FEW_PAIRS = 250_000  # of points: comparing all takes some ms, importing a search tree a tenth of a second
ENOUGH = 3  # pressed conditions: one or two in the middle of a symmetric pair may have no shear


def judge(model: Model, sample: Sample | None, closed: Flags) -> None:
    """Add warnings to those of a finished run.

    sample  the last one; closed (k,)  multipliers that pressed at any time. Raises SimulationFailure("not-converged")
    where a pressure belongs to another force than the one that acts.
    """
    if sample is None:
        return
    for one in invariants(model, sample):
        if one.broken:
            model.warnings.add(breach(one, model.explicit))
    for pair in model.contact.pairs if model.contact is not None else ():
        if not closed[pair.first_slot : pair.first_slot + pair.slots].any():
            _never_closed(model, pair)
            continue
        _judge_facets(model, pair)
        _judge_friction(model, pair)
    for name, report in sample.contacts.items():
        _judge_pressure(name, report.force_error(report.covered_integral), sample.step)


def _never_closed(model: Model, pair: ContactPair) -> None:
    distance = float(_nearest(model.position[pair.slave.nodes], model.position[pair.master.nodes])[0].min())
    model.warnings.add(
        RunWarning(
            "open-contact", distance, 0.0, pair.name,
            f"{pair.name} never closed: at the end its nodes are {distance:.4g} apart at the nearest place; look at "
            "what moves the bodies together, go on for longer, or take the contact out",
        )
    )  # fmt: skip


def _judge_pressure(name: str, share: float, step: int) -> None:
    """`share` of the nodal forces on the slave that the integral of its tractions over what is covered lacks.

    Multipliers of segments that a rim covers in part are shown on whole segments: that is warned of. A run is wrong
    where even the integral over the covered part is another force.
    """
    if share > WRONG:
        raise SimulationFailure(
            "not-converged",
            f"step {step}: {name}: the pressure over the slave adds up to a force that differs by {share:.0%} from "
            f"the one that acts (allowed {WRONG:.0%}); try finer cells, the other side as slave (swap), or another "
            "algorithm",
        )


def _judge_friction(model: Model, pair: ContactPair) -> None:
    """Friction that is declared and that enforcement or algorithm do not deliver: no tangential force at all."""
    if pair.friction is None or not any(pair.friction.bound()[:2]):
        return
    normal, tangential = model.state["multipliers"][:2, pair.first_slot : pair.first_slot + pair.slots]
    pressed = int(np.count_nonzero(normal > 0.0))
    if pressed >= ENOUGH and not np.any(tangential):
        parts = f"{type(pair.method).__name__} and {type(model.contact.enforcement).__name__}"  # type: ignore[union-attr]
        raise SimulationFailure(
            "failed",
            f"step {model.state.step}: {pair.name}: friction is declared, and {parts} gave no tangential force in any "
            f"of {pressed} pressed conditions; take the contact's key friction out, or use an enforcement and an "
            "algorithm that deliver it",
        )


# --- facets -----------------------------------------------------------------------------------------


def _judge_facets(model: Model, pair: ContactPair) -> None:
    """How deep the facets of a curved pair are where it presses, against how far its surfaces came together there."""
    if pair.start_distance is not None:
        return  # what facets are deep by is no gap
    force = model.state["multipliers"][0, pair.first_slot : pair.first_slot + pair.slots]
    pressed = np.flatnonzero(force.reshape(pair.rows_per_node, -1).max(axis=0) > 0.0).astype(np.int32)
    if not len(pressed):
        return
    slave, master = pair.slave.nodes[pressed], pair.master.nodes
    nearest = _nearest(model.position[slave], model.position[master])[1]
    if _facets_fit(pair, model.position, pressed, nearest):
        return  # facets of one side lie on those of the other, however deep
    depth = max(
        float(facet_depths(pair.slave, model.reference)[pressed].max()),
        float(facet_depths(pair.master, model.reference)[nearest].max()),
    )
    displacement = model.state["displacement"]
    apart = displacement[slave] - displacement[master[nearest]]
    approach = float(np.abs(np.einsum("ni,ni->n", apart, _normals(pair.slave, model.position)[pressed])).max())
    if depth <= FACETS * approach or depth <= 1e-9 * pair.size:
        return
    model.warnings.add(
        RunWarning(
            "coarse-facets", depth, FACETS * approach, "level",
            f"{pair.name}: the facets of its curved surfaces are {depth:.3g} deep where they press, and the surfaces "
            f"came together by {approach:.3g} there ({FACETS:.0%} of that is fine enough): the pressure of a "
            f"fit is about {0.45 * depth / approach:.0%} too low in the mean, and swings from node to node; try "
            f"cells that are {_finer(depth / max(FACETS * approach, 1e-300))} times finer along the "
            "surfaces (level)",
        )
    )  # fmt: skip


def _finer(ratio: float) -> str:
    """By what to divide lengths where a depth must fall by `ratio`, rounded upwards to two figures."""
    factor = float(np.sqrt(ratio))
    unit = 10.0 ** (np.floor(np.log10(factor)) - 1.0)
    return f"{unit * np.ceil(factor / unit - 1e-9):.2g}"


def _facets_fit(pair: ContactPair, position: Floats, pressed: Ints, nearest: Ints) -> bool:
    """Whether each pressed slave node has a master node beside it, so that both sides have the same facets."""
    apart = position[pair.slave.nodes[pressed]] - position[pair.master.nodes[nearest]]
    normal = _normals(pair.slave, position)[pressed]
    along = np.abs(apart[:, 0] * normal[:, 1] - apart[:, 1] * normal[:, 0])
    return bool(along.max() <= FIT * pair.size and len(np.unique(nearest)) == len(nearest))


def _normals(surface: Surface, position: Floats) -> Floats:
    """Unit normals (m, 2) of the nodes, of either sign: those of their segments, summed.

    Not those of the pair, which belong to where nodes were expected in the last step: a run that is taken up at its end
    has others.
    """
    begin, end = (position[surface.nodes[surface.segments[:, k]]] for k in range(2))
    across = (end - begin)[:, ::-1] * [1.0, -1.0]
    total = np.where(surface.node_segments[..., None] >= 0, across[surface.node_segments], 0.0).sum(axis=1)
    return np.asarray(total / np.maximum(np.hypot(*total.T), 1e-300)[:, None])


def facet_depths(surface: Surface, reference: Floats) -> Floats:
    """Distance (m,) [mm] of a smooth curve from its segments at each node that turn by an angle: L angle / 8."""
    begin, end = (reference[surface.nodes[surface.segments[:, k]]] for k in range(2))
    along = end - begin
    length = np.hypot(*along.T)
    into, out = surface.node_segments.T
    inner = np.flatnonzero((into >= 0) & (out >= 0))
    a, b = along[into[inner]], along[out[inner]]
    angle = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("ni,ni->n", a, b)))
    depth = np.zeros(len(surface.nodes))
    longest = np.maximum(length[into[inner]], length[out[inner]])
    depth[inner] = np.where(angle < CORNER, longest * angle / 8.0, 0.0)
    return depth


def _nearest(points: Floats, others: Floats) -> tuple[Floats, Ints]:
    """Distance of each point to the nearest of `others`, and which one that is."""
    if len(points) * len(others) <= FEW_PAIRS:
        x, y = (points[:, None, k] - others[None, :, k] for k in range(2))
        squares = x * x + y * y
        which = squares.argmin(axis=1)
        return np.sqrt(squares[np.arange(len(points)), which]), which
    from scipy.spatial import cKDTree

    distance, which = cKDTree(others).query(points)
    return distance, which
