"""Inputs of a contact algorithm are only read, and `memory` is all that it keeps."""

from __future__ import annotations

import copy
from dataclasses import fields, replace
from typing import Any

import numpy as np

from contactlab.api import ContactMethod, ContactView, Floats, GapAlgorithm, Pieces, SurfacePositions
from contactlab.kernels.contact.search import REACH, near_segments
from contactlab.testing.assertions import Check, NotApplicable, identical, require, untouched
from contactlab.testing.surfaces import Chains, chains, conditions, curved, dense, flat, stations

SURFACE = ("nodes", "segments", "node_segments", "edges", "segment_edge")
FILLED = ("slave", "multiplier", "master", "D", "M", "T")
"""Arrays of pieces that every algorithm fills."""
GARBAGE = {np.dtype(np.int32): -7, np.dtype(np.float64): np.nan}
NUMBERS = ("start", "node", "owner")
"""Arrays of gap conditions that hold int32."""
NOTCH = 0.6  # slope of its sides
GLIDE, STRIDE = 0.15, 0.005
"""Way of a gliding slave and its steps [mm]: half a segment, in steps a third of where nodes face two segments."""


def view_of(algorithm: ContactMethod, at: Chains, memory: Floats | None = None) -> ContactView:
    """The algorithm's view of surfaces, with its own arrays."""
    sides = SurfacePositions(at.nodes[at.slave.nodes], at.nodes[at.master.nodes])
    reach = REACH * at.spacing
    near = near_segments(sides.slave, at.slave.segments, sides.master, at.master.segments, 2.0 * reach)
    memory = np.zeros((algorithm.memory_size, len(at.slave.nodes))) if memory is None else memory
    return ContactView(at.slave, at.master, sides, near, reach, memory)


def asked(algorithm: Any, view: ContactView, garbage: bool = False) -> list[Floats]:
    """Return the arrays that the algorithm gives for a view, up to the pieces in use."""
    if isinstance(algorithm, GapAlgorithm):
        found = algorithm.conditions(view, tangent=True)
        return [np.array(getattr(found, f.name)) for f in fields(found)]
    multipliers = len(view.slave.nodes) * algorithm.rows_per_node
    room = algorithm.capacity(view.slave, view.near) + 4 * len(view.slave.nodes)
    out = Pieces.allocate(room, algorithm.widths(view.slave, view.master), multipliers)
    if garbage:
        for name in FILLED:  # normals of multipliers without a piece stay what they were
            array = getattr(out, name)
            array[...] = GARBAGE[array.dtype]
    count = algorithm.pieces(view, out)
    used = [np.array(getattr(out, name)[:count]) for name in FILLED]
    return [*used, out.normal[np.unique(used[1])]]


def inputs_are_only_read(algorithm: ContactMethod) -> None:
    """Surfaces, positions and candidates belong to the run: no call changes them."""
    for at in (flat(), curved()):
        view = view_of(algorithm, at)
        arrays = {
            f"{side} {name}": getattr(getattr(view, side), name) for side in ("slave", "master") for name in SURFACE
        }
        arrays |= {"positions of the slave": view.at.slave, "positions of the master": view.at.master}
        with untouched(**arrays, candidates=view.near.master, starts=view.near.start):
            asked(algorithm, view)


def pieces_are_filled(algorithm: ContactMethod) -> None:
    """All of a piece is written: earlier contents of the arrays do not matter."""
    if isinstance(algorithm, GapAlgorithm):
        raise NotApplicable("finished gap conditions come in arrays of their own")
    for at in (flat(), flat(order=2), curved()):
        clean, dirty = asked(algorithm, view_of(algorithm, at)), asked(algorithm, view_of(algorithm, at), garbage=True)
        require(len(clean[0]) == len(dirty[0]), "the number of pieces depends on earlier contents of the arrays")
        for one, other in zip(clean, dirty, strict=True):
            identical(other, one, "pieces in arrays that were not empty")


def arrays_are_of_their_types(algorithm: ContactMethod) -> None:
    """Finished conditions are contiguous arrays of float64 and int32: others lose digits, or are copied."""
    if not isinstance(algorithm, GapAlgorithm):
        raise NotApplicable("pieces are written into arrays of the core")
    for tangent in (False, True):
        found = algorithm.conditions(view_of(algorithm, curved()), tangent=tangent)
        for name in (f.name for f in fields(found)):
            array, wanted = getattr(found, name), np.dtype(np.int32 if name in NUMBERS else np.float64)
            require(isinstance(array, np.ndarray), f"{name}: got {type(array).__name__}, needed an array of {wanted}")
            require(array.dtype == wanted, f"{name}: got an array of {array.dtype}, needed {wanted}")
            require(array.flags.c_contiguous, f"{name}: got an array that is not contiguous: np.ascontiguousarray")


def positions_change_in_place(algorithm: ContactMethod) -> None:
    """Runs change arrays in place: the result follows their present values."""
    at = curved()
    moved = at.lifted((0.013, -0.006))
    view = view_of(algorithm, at)
    asked(algorithm, view)
    later = view_of(algorithm, moved)
    view.at.slave[:], view.at.master[:] = later.at.slave, later.at.master
    again = view._replace(near=later.near, memory=np.zeros_like(view.memory))
    for one, other in zip(asked(algorithm, again), asked(algorithm, later), strict=True):
        identical(one, other, "answers after positions have changed in place")


def memory_is_all_it_remembers(algorithm: ContactMethod) -> None:
    """A new part that has seen other positions resumes from the memory with the same bits.

    A slave glides in a bowl and back, so slowly that nodes stand where two segments are as near: there an algorithm
    with memory answers by the side from which the node came.
    """
    way = np.concatenate([np.arange(0.0, GLIDE, STRIDE), np.arange(GLIDE, 0.0, -STRIDE)])
    slave, master = stations(-0.6, 0.6, 6, seed=3), stations(-1.0, 1.0, 7, seed=4)
    bowl = chains(np.stack([slave, 0.3 * slave**2], axis=1), np.stack([master, 0.3 * master**2], axis=1))
    path = [bowl.lifted((float(by), 0.1)) for by in way]
    memories, answers = [np.zeros((algorithm.memory_size, len(path[0].slave.nodes)))], []
    for at in path:
        memory = memories[-1].copy()
        answers.append(asked(algorithm, view_of(algorithm, at, memory)))
        memories.append(memory)
    kept = any(memory.any() for memory in memories)
    require(kept or not algorithm.memory_size, f"memory_size is {algorithm.memory_size}, and the memory stays zero")
    aside, again = np.zeros_like(memories[0]), replace(algorithm)  # type: ignore[type-var]
    for number in reversed(range(len(path))):
        asked(again, view_of(again, path[number], aside))
        memory = memories[number].copy()
        for one, other in zip(asked(again, view_of(again, path[number], memory)), answers[number], strict=True):
            identical(one, other, f"answers at position {number} of a new part with the same memory")
        identical(memory, memories[number + 1], "memory after a step of a new part with the same memory")
    require(copy.copy(algorithm) == algorithm, "a copy of the part differs from it: it holds more than its fields")


def reach_is_kept(algorithm: ContactMethod) -> None:
    """Surfaces farther apart than the view's `reach` have no conditions, even if they are listed as near."""
    view = view_of(algorithm, flat().lifted((0.0, GLIDE)))
    found = asked(algorithm, view._replace(reach=0.5 * GLIDE))
    given = max(0, len(found[0]) - (1 if isinstance(algorithm, GapAlgorithm) else 0))
    require(given == 0, f"{given} conditions or pieces at gaps of {GLIDE} mm, though reach is {0.5 * GLIDE} mm")


def a_notch_is_held_by_both_sides(algorithm: ContactMethod) -> None:
    """A node in a notch of the master is constrained by both sides, if nodes may carry several conditions."""
    if algorithm.rows_per_node < 2 or getattr(algorithm, "points_press", False):
        raise NotApplicable("a node carries one condition, or none of its own")
    x = np.array([-1.0, 0.0, 1.0])
    slave = np.stack([0.6 * x, NOTCH * 1.6 * np.abs(0.6 * x) + 1e-4], axis=1)
    at = chains(slave, np.stack([x, NOTCH * np.abs(x)], axis=1))
    found = conditions(algorithm, at)
    m = len(at.slave.nodes)
    require(len(np.unique(found.owner)) == len(found.owner), "owner: two conditions belong to the same slot")
    own = np.flatnonzero(found.owner % m == 1)
    require(len(own) == 2, f"{len(own)} conditions hold a node in a notch, expected one of each side")
    normal = dense(found, found.normal_weight, len(at.nodes))[own][:, at.slave.nodes].sum(axis=1)
    sides = np.array([[-NOTCH, 1.0], [NOTCH, 1.0]]) / np.hypot(NOTCH, 1.0)
    off = min(float(np.abs(normal[order] - sides).max()) for order in ([0, 1], [1, 0]))
    require(
        off < 1e-9, f"normals of a node in a notch are {normal.round(4).tolist()}, expected the normals of both sides"
    )


CHECKS: tuple[Check, ...] = (
    inputs_are_only_read,
    pieces_are_filled,
    arrays_are_of_their_types,
    positions_change_in_place,
    memory_is_all_it_remembers,
    reach_is_kept,
    a_notch_is_held_by_both_sides,
)
