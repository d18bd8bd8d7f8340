"""Edge sets by name, as scenes write them: "body.set"; and parts of edge sets with names of their own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats, Ints, Mesh
from contactlab.errors import SceneError, Where, below, did_you_mean
from contactlab.model.bodies.body import Body

SLACK = 1e-3  # of an edge: a bound this near a node goes through the node


def edge_set(bodies: tuple[Body, ...], name: str, where: Where) -> tuple[Body, Ints]:
    """Return the edges (e, b) named "body.set", in global node numbers."""
    body_name, _, set_name = name.partition(".")
    body = next((body for body in bodies if body.name == body_name), None)
    if body is None:
        known = [body.name for body in bodies]
        raise SceneError(
            "no such body", where=where, got=name, allowed=", ".join(known), hint=did_you_mean(body_name, known)
        )
    sets = body.mesh.edges
    if set_name not in sets:
        names = [f"{body_name}.{key}" for key in sets]
        raise SceneError(
            "no such edge set", where=where, got=name, allowed=", ".join(names), hint=did_you_mean(name, names)
        )
    if not len(sets[set_name]):
        raise SceneError(
            "the edge set is empty",
            where=where,
            got=name,
            allowed="a set with edges",
            hint="name another set, or mend the mesh",
        )
    return body, (sets[set_name] + body.first).astype(np.int32)


def nodes_of(bodies: tuple[Body, ...], name: str, where: Where) -> Ints:
    """Return numbers of the nodes of "body" or "body.edge_set"."""
    for body in bodies:
        if body.name == name:
            return np.arange(body.first, body.first + body.count, dtype=np.int32)
    return np.unique(edge_set(bodies, name, where)[1])


def with_parts(mesh: Mesh, parts: Mapping[str, Any], where: Where) -> Mesh:
    """Return the mesh with further edge sets: `parts` by name as in `[bodies.NAME.sets]`, in its present place."""
    sets = dict(mesh.edges)
    for name, part in parts.items():
        at = below(where, name)
        if name in mesh.edges:
            raise SceneError("the mesh has an edge set of this name", where=at, got=name, allowed="a name of its own")
        if part.of not in sets:
            raise SceneError(
                "no such edge set",
                where=below(at, "of"),
                got=part.of,
                allowed=", ".join(sets),
                hint=did_you_mean(part.of, sets),
            )
        sets[name] = _part(mesh.nodes, sets[part.of], part, at)
    return Mesh(mesh.nodes, mesh.cells, sets)


def _part(nodes: Floats, edges: Ints, part: Any, where: Where) -> Ints:
    """Return the edges that lie within the bounds; SceneError if a bound cuts through an edge."""
    inside = np.ones(len(edges), np.bool_)
    for axis, name in enumerate("xy"):
        span = getattr(part, name)
        if span is None:
            continue
        ends = nodes[edges[:, :2], axis]
        slack = SLACK * np.hypot(*(nodes[edges[:, 1]] - nodes[edges[:, 0]]).T)
        low, high = ends.min(axis=1), ends.max(axis=1)
        for bound in span:
            cut = np.flatnonzero(inside & (low < bound - slack) & (high > bound + slack))
            if len(cut):
                near = " and ".join(_to_place(end[cut[0]], slack[cut[0]]) for end in (low, high))
                raise SceneError(
                    f"{name} = {bound:g} cuts an edge in two",
                    where=below(where, name),
                    got=list(span),
                    allowed=f"bounds within 1/1000 of an edge of nodes; the nearest are at {near}",
                    hint="change the cells of the mesh, or give it spans, so that a node lies there",
                )
        inside &= (low >= span[0] - slack) & (high <= span[1] + slack)
    if not inside.any():
        raise SceneError(
            "no edge lies within these bounds",
            where=where,
            got={name: list(span) for name in "xy" if (span := getattr(part, name)) is not None},
            allowed=f"parts of {part.of}, which spans {_extent(nodes[edges[:, :2]])}",
        )
    return np.ascontiguousarray(edges[inside])


def _to_place(value: float, slack: float) -> str:
    """Return a coordinate with digits for a tenth of the slack."""
    return np.format_float_positional(value, max(0, math.ceil(1.0 - math.log10(slack))), trim="-")


def _extent(ends: Floats) -> str:
    low, high = ends.min(axis=(0, 1)), ends.max(axis=(0, 1))
    return f"x = {low[0]:.6g} to {high[0]:.6g}, y = {low[1]:.6g} to {high[1]:.6g}"
