"""Warnings of what meshes do not resolve at the end of a run: coarse facets, few nodes, gaps that facets keep."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, cast

import numpy as np

from contactlab.api import ContactCurve, Floats, Ints, RunWarning, SegmentContact, Surface
from contactlab.meshing.curves import facet_depths, nearest_segments
from contactlab.meshing.turns import turns
from contactlab.model.model import Model
from contactlab.results.facets import cusps
from contactlab.run.coordinates import coordinates

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair
    from contactlab.model.implicit_model import ImplicitModel
    from contactlab.results.contact_report import ContactReport

FACETS = 0.05  # depth of facets over the approach: unlike meshes of a press fit then miss 2.5 % of its mean pressure
FIT = 0.05  # segments: how far nodes of like meshes may have slid apart
FEW_PAIRS = 250_000  # of points: comparing all takes some ms, importing a search tree a tenth of a second
FEW = 6  # nodes: of a disc on a plane five or fewer press if its facets are as deep as FACETS of the approach
PEAK = 0.1  # multipliers above nodal pressures: with 3 nodes in a Hertz contact 34 to 52 %, with 5 2 to 6 %
DIPPED = 4  # nodes: as many do not resolve a pressure that is highest at its edges and falls to zero beyond
LEAN, FLAT = 0.01, 1e-3  # of a force: what pressed nodes on a curve may be off by; rad: a flat side turns by less


def coarse_facets(model: Model, pair: ContactPair, curve: ContactCurve) -> Iterator[RunWarning]:
    """Warn if the facets of a curved pair are deep where it presses, compared with the approach of its surfaces."""
    if pair.start_distance is not None or pair.smooth:
        return  # the depth of facets is not part of the gap
    chains = _chains(pair, curve)
    stretches = list(_stretches(curve, chains))
    if not stretches or _few_between_open_ones(curve, chains, stretches):
        return  # of a disc on a plane the mean pressure is right to 1 % with three nodes; see `few_nodes`
    force = model.state["multipliers"][0, pair.own]
    pressed = np.flatnonzero(force.reshape(pair.rows_per_node, -1).max(axis=0) > 0.0).astype(np.int32)
    if not len(pressed):
        return
    slave, master = pair.slave.nodes[pressed], pair.master.nodes
    nearest = nearest_points(model.position[slave], model.position[master])[1]
    if _facets_fit(pair, model.position, np.concatenate(stretches)):
        return  # facets of both sides coincide, however deep
    depth = max(
        float(_depths(pair, pair.slave, model.reference)[pressed].max()),
        float(_depths(pair, pair.master, model.reference)[nearest].max()),
    )
    displacement = model.state["displacement"]
    apart = displacement[slave] - displacement[master[nearest]]
    approach = float(np.abs(np.einsum("ni,ni->n", apart, _normals(pair.slave, model.position)[pressed])).max())
    if depth <= FACETS * approach or depth <= 1e-9 * pair.size:
        return
    # by what to divide lengths, rounded upwards to two figures
    factor = float(np.sqrt(depth / max(FACETS * approach, 1e-300)))
    unit = 10.0 ** (np.floor(np.log10(factor)) - 1.0)
    finer = f"{unit * np.ceil(factor / unit - 1e-9):.2g}"
    curves = isinstance(pair.method, SegmentContact) and pair.slave.edges.shape[1] == pair.master.edges.shape[1] == 2
    smooth = "smooth = true of the contact, or " if curves else ""
    low = f", the mean pressure of a fit is off by about {0.45 * depth / approach:.0%}" if depth <= approach else ""
    yield RunWarning(
        "coarse-facets", depth, FACETS * approach, f"{pair.name}.smooth" if curves else "level",
        f"{pair.name}: the facets of its curved surfaces are {depth:.3g} deep where they press, from "
        f"{coordinates(model, model.position[slave[0]])} on, and the surfaces approached by {approach:.3g} (limit "
        f"{FACETS:.0%} of the approach): the pressure oscillates from node to node{low}; take {smooth}cells that are "
        f"{finer} times finer along both surfaces (level; from a mesh file, second-order cells or a finer mesh)",
    )  # fmt: skip


def _depths(pair: ContactPair, side: Surface, reference: Floats) -> Floats:
    """Distance (m,) [mm] of a side's curve from its facets, or from its quadratic edges if gaps are measured to those.

    The parabola through the ends and the middle of an arc of radius R, 2h long, is h^4/(32 R^3) from it, the chords of
    its halves are h^2/(8 R).
    """
    depths = facet_depths(side, reference)
    straight = side.edges.shape[1] == 2 or pair.by_energy
    return depths if straight else 0.25 * turns(side, reference) ** 2 * depths


def few_nodes(model: Model, pair: ContactPair, report: ContactReport) -> Iterator[RunWarning]:
    """Warn if too few nodes carry the peak of a pressure that falls to zero on both sides of it.

    Multipliers and nodal forces over the overlap are two pressures of the same forces, which agree if the mesh resolves
    the pressure; if multipliers are nodal pressures, as for dual multipliers, the mean over a hat function shows how
    much the peak exceeds it: h^2/12 of the second derivative, h being the length of the adjacent segments.
    A peak at an edge or below an apex has no limit, and is skipped. Few nodes of which an outer one carries most do not
    resolve the pressure either: forces of an algorithm that fails the patch test alternate from node to node.
    """
    curve = report.curve
    peak = int(curve.nodal_pressure.argmax())
    chain = next(chain for chain in _chains(pair, curve) if peak in chain)
    at = int(np.flatnonzero(chain == peak)[0])
    if cusps(pair, model.reference)[chain[max(0, at - 1) : at + 2]].any():
        return
    ends = np.flatnonzero(curve.nodal_pressure[chain] == 0.0)
    before, after = ends[ends < at], ends[ends > at]
    if not len(before) or not len(after) or not all(curve.gap[chain[[before[-1], after[0]]]] > 0.0):
        return
    pressed = chain[before[-1] + 1 : after[0]]
    nodal, highest = float(curve.nodal_pressure[peak]), float(curve.pressure[pressed].max())
    beside = float(curve.nodal_pressure[chain[[at - 1, at + 1]]].sum())
    high, low = highest / nodal - 1.0, (2.0 * nodal - beside) / (12.0 * nodal)
    at_edge = len(pressed) <= DIPPED and peak in pressed[[0, -1]]
    dip = 1.0 - float(curve.nodal_pressure[pressed[1:-1]].min(initial=nodal)) / nodal if at_edge else 0.0
    if not max(high, low, dip) > PEAK:
        return
    value, told = high, f"multipliers reach {highest:.4g}, nodal pressures {nodal:.4g}, {high:.0%} apart"
    if high <= PEAK:
        value, told = low, f"nodal pressures, up to {nodal:.4g}, are means over its segments, about {low:.0%} below it"
    if dip > max(high, low):
        value, told = dip, f"nodal pressures, up to {nodal:.4g} at an edge of contact, are {dip:.0%} lower within"
    place = coordinates(model, np.array([curve.x[peak], curve.y[peak]]))
    carried = "1 node carries" if len(pressed) == 1 else f"{len(pressed)} nodes carry"
    lean = _lean(model, pair, report.resultant, model.position[pair.slave.nodes[peak]])
    told += f"; its force leans by {lean:.1%} from the normal of the flat side" if lean > LEAN else ""
    yield RunWarning(
        "few-nodes", float(f"{value:.4g}"), PEAK, f"{pair.name}.slave",  # an estimate: a resumed run differs by 1e-9
        f"{pair.name}: {carried} the pressure around {place}, too few for its peak: {told} "
        f"(limit {PEAK:.0%}); halve the cells of the slave there",
    )  # fmt: skip


def _lean(model: Model, pair: ContactPair, force: Floats, place: Floats) -> float:
    """Part of a force (2,) [N] without friction that is along the master at a place (2,) where that is flat; else 0."""
    if pair.friction is not None:
        return 0.0
    (nearest,), _ = nearest_segments(place[None], pair.master, model.position)
    ends = pair.master.segments[nearest]
    if np.abs(turns(pair.master, model.position)[ends]).max() > FLAT:
        return 0.0
    begin, end = model.position[pair.master.nodes[ends]]
    return float(abs(force @ (end - begin)) / (np.hypot(*(end - begin)) * max(np.hypot(*force), 1e-300)))


def warn_of_kept_gaps(model: Model, pairs: list[ContactPair], stored: float) -> Iterator[RunWarning]:
    """Warn if pressed nodes stand off the curve of the other side or lie within it, with the effect on forces."""
    from contactlab.run.kept_gap import HIGH, kept_gaps

    if any(pair.half for pair in pairs):
        return  # points have gaps of their own, and their multipliers belong to no single node
    for one in kept_gaps(cast("ImplicitModel", model), pairs, stored):
        size = "large" if one.share > 0.0 else "small"
        off = f"{abs(one.apart):.3g} {'off' if one.apart > 0.0 else 'within'}"
        told = [f"its force is {abs(one.share):.1%} too {size}"] if abs(one.share) > HIGH else []
        told += [f"displacements are off by up to {one.moved:.1%} of the largest"] if one.moved > HIGH else []
        yield RunWarning(
            "kept-gap", abs(one.share) if abs(one.share) > HIGH else one.moved, HIGH, f"{one.pair.name}.slave",
            f"{one.pair.name}: gaps are measured to facets and averaged over segments, so pressed nodes are up to "
            f"{off} the curve of the other side, at {coordinates(model, model.position[one.node])}: "
            f"{' and '.join(told)} (limit {HIGH:.0%}); halve the cells of both sides there, which makes the error a "
            "quarter",
        )  # fmt: skip


def _chains(pair: ContactPair, curve: ContactCurve) -> list[Ints]:
    """Slave nodes of each chain in order; a chain that is closed begins where it is open, if it is so anywhere."""
    found = []
    for number in np.unique(curve.chain):
        chain = np.flatnonzero(curve.chain == number)
        still = curve.nodal_pressure[chain] == 0.0
        still &= np.roll(still, 1)
        if pair.slave.node_segments[chain[0], 0] >= 0 and still.any():
            chain = np.roll(chain, -int(still.argmax()))
        found.append(chain.astype(np.int32))
    return found


def _few_between_open_ones(curve: ContactCurve, chains: list[Ints], stretches: list[Ints]) -> bool:
    """Return whether at most `FEW` nodes in a row are pressed everywhere, and the end of a stretch is open."""
    if any(len(stretch) > FEW for stretch in stretches):
        return False
    ends = [chain[[0, -1]] for chain in chains if (curve.nodal_pressure[chain] > 0.0).any()]
    return any((curve.nodal_pressure[pair] <= 0.0).any() for pair in ends)


def _stretches(curve: ContactCurve, chains: list[Ints]) -> Iterator[Ints]:
    """Slave nodes from a pressed one to another, with those between them, of which no more than `FEW` are in a row."""
    for chain in chains:
        pressed = np.flatnonzero(curve.nodal_pressure[chain] > 0.0)
        for spot in np.split(pressed, np.flatnonzero(np.diff(pressed) > FEW) + 1) if len(pressed) else ():
            yield chain[spot[0] : spot[-1] + 1]


def _facets_fit(pair: ContactPair, position: Floats, nodes: Ints) -> bool:
    """Return whether each of the slave's `nodes` lies opposite a master node, so that both sides have equal facets."""
    place = position[pair.slave.nodes[nodes]]
    nearest = nearest_points(place, position[pair.master.nodes])[1]
    apart, normal = place - position[pair.master.nodes[nearest]], _normals(pair.slave, position)[nodes]
    along = np.abs(apart[:, 0] * normal[:, 1] - apart[:, 1] * normal[:, 0])
    return bool(along.max() <= FIT * pair.size and len(np.unique(nearest)) == len(nearest))


def _normals(surface: Surface, position: Floats) -> Floats:
    """Unit normals (m, 2) of the nodes, of either sign: the sum of the normals of their segments.

    Normals of the pair belong to positions that the last step expected, and differ in a run that is resumed at its end.
    """
    begin, end = (position[surface.nodes[surface.segments[:, k]]] for k in range(2))
    across = (end - begin)[:, ::-1] * [1.0, -1.0]
    total = np.where(surface.node_segments[..., None] >= 0, across[surface.node_segments], 0.0).sum(axis=1)
    return np.asarray(total / np.maximum(np.hypot(*total.T), 1e-300)[:, None])


def nearest_points(points: Floats, others: Floats) -> tuple[Floats, Ints]:
    """Distance of each point to the nearest of `others`, and which one that is."""
    if len(points) * len(others) <= FEW_PAIRS:
        x, y = (points[:, None, k] - others[None, :, k] for k in range(2))
        squares = x * x + y * y
        which = squares.argmin(axis=1)
        return np.sqrt(squares[np.arange(len(points)), which]), which
    from scipy.spatial import cKDTree

    distance, which = cKDTree(others).query(points)
    return distance, which
