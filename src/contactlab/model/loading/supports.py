"""Prescribed motion: supports and rigid surfaces, and their degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Ints, RunWarning
from contactlab.errors import SceneError, Where, below
from contactlab.model.bodies.body import Body, RigidSurface
from contactlab.model.loading.edge_integrals import Edges
from contactlab.model.loading.edge_sets import edge_set, nodes_of
from contactlab.model.loading.load_profile import Varying
from contactlab.model.loading.node_profiles import tell_unresolved
from contactlab.model.loading.ramps import Course, Ramp, RampTime, course_of, courses_of
from contactlab.parts.registry import Registry
from contactlab.scene.keys import Rigid, Support
from contactlab.scene.scene import Scene

Values = Callable[[float], Floats]


@dataclass(frozen=True)
class SupportedSet:
    """Degrees of freedom held by the supports on one set of nodes, or a rigid surface: `on` as written in the scene.

    dof  held by the set and by no earlier set, so that every reaction counts once
    """

    on: str
    nodes: Ints
    dof: Ints

    def force(self, reaction: Floats) -> Floats:
        """Return the force (2,) [N] of the set on its body; `reaction` (N, 2) [N] of all nodes."""
        own = reaction.reshape(-1)[self.dof]
        along_x = self.dof % 2 == 0
        return np.array([own[along_x].sum(), own[~along_x].sum()])


class Shift(NamedTuple):
    """A value in time that all its nodes share."""

    course: Course
    size: int = 1

    def bind(self, run: RampTime) -> Ramp:
        """Return a function that gives the displacement at a time [s]."""
        return self.course.bind(run)

    @property
    def steady(self) -> bool:
        """True if the value never changes."""
        return self.course.steady


class Rotation(NamedTuple):
    """Displacements of nodes that turn about a centre, which itself may move: x and y of every node.

    offsets  (n, 2) [mm] from the centre to the nodes before the run
    angle    [rad]
    """

    offsets: tuple[tuple[float, float], ...]
    angle: Course
    ux: Course
    uy: Course

    @property
    def steady(self) -> bool:
        """True if the values never change."""
        return self.angle.steady and self.ux.steady and self.uy.steady

    @property
    def size(self) -> int:
        """Number of values: two for each node."""
        return 2 * len(self.offsets)

    def bind(self, run: RampTime) -> Values:
        """Return a function that gives the displacements (2 n,) [mm] at a time [s]."""
        courses = (self.angle, self.ux, self.uy)
        angle, ux, uy = ((course.to, course.bind(run)) for course in courses)
        x, y = np.array(self.offsets).T

        def values(time: float) -> Floats:
            turned = angle[0] * angle[1](time)
            # cos - 1 without cancellation, so that a small turn keeps all its digits
            sin, less = math.sin(turned), -2.0 * math.sin(0.5 * turned) ** 2
            out = np.empty((len(x), 2))
            out[:, 0] = less * x - sin * y + ux[0] * ux[1](time)
            out[:, 1] = less * y + sin * x + uy[0] * uy[1](time)
            return out.reshape(-1)

        return values


Motion = Shift | Rotation


class Prescribed:
    """Implements `contactlab.api.PrescribedMotion`: displacement = scale * ramp value."""

    def __init__(self, dof: Ints, scale: Floats, ramp: Ints, motions: tuple[Motion, ...], run: RampTime) -> None:
        self.dof, self.scale, self.ramp = dof, scale, ramp
        sizes = [motion.size for motion in motions]
        self._values = np.zeros(max(1, sum(sizes)))
        self._single: list[tuple[int, Ramp]] = []
        self._several: list[tuple[slice, Values]] = []
        for begin, motion in zip(np.cumsum([0, *sizes]).tolist(), motions, strict=False):
            place = slice(begin, begin + motion.size)
            if motion.steady:
                self._values[place] = motion.bind(run)(0.0)
            elif isinstance(motion, Shift):
                self._single.append((begin, motion.bind(run)))
            else:
                self._several.append((place, motion.bind(run)))

    def values(self, time: float) -> Floats:
        """Return ramp values at `time` [s]; the same array every call."""
        values = self._values
        for place, ramp in self._single:
            values[place] = ramp(time)
        for several, value in self._several:
            values[several] = value(time)
        return values


@dataclass(frozen=True)
class SupportPlan:
    """All prescribed motion of a scene before the times of the run are known.

    dof, scale, ramp  as in `contactlab.api.PrescribedMotion`
    motions           whose values are concatenated in the ramp values
    moving            (2,) True if anything is moved along x, along y
    """

    dof: Ints
    scale: Floats
    ramp: Ints
    motions: tuple[Motion, ...]
    sets: tuple[SupportedSet, ...]
    moving: tuple[bool, bool]

    def bind(self, run: RampTime) -> Prescribed:
        """Return the prescribed motion, with the ramp time of the `run` for ramps that name no duration."""
        return Prescribed(self.dof, self.scale, self.ramp, self.motions, run)


def plan_supports(
    scene: Scene, bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], reference: Floats, told: list[RunWarning]
) -> SupportPlan:
    """Return prescribed degrees of freedom; SceneError if two supports disagree. `told` gets warnings."""
    plan = _Plan(reference, scene.registry)
    for number, spec in enumerate(scene.supports):
        where = scene.where(f"supports.{number}")
        nodes = nodes_of(bodies, spec.on, below(where, "on"))
        plan.add(spec.on, nodes, spec, where, _factors(spec, nodes, bodies, reference, scene.registry, where, told))
    for surface in rigid:
        plan.add(surface.name, surface.nodes, scene.rigid[surface.name], scene.where(f"rigid.{surface.name}"))
    return plan.finished()


def _factors(
    spec: Support,
    nodes: Ints,
    bodies: tuple[Body, ...],
    reference: Floats,
    registry: Registry,
    where: Where,
    told: list[RunWarning],
) -> Floats:
    """Return factors of the values of a support at each of its nodes (n,)."""
    if spec.profile is None:
        return np.ones(len(nodes))
    key = below(where, "profile")
    varying, at = Varying(spec.profile, registry, key), np.zeros(len(reference))
    if spec.profile.by == "s":
        body, edges = edge_set(bodies, spec.on, below(where, "on"))
        along = Edges(body.element, edges, reference)
        places = np.linspace(-1.0, 1.0, edges.shape[1])
        nodes_at = body.element.edge_shape(places)[0].argmax(axis=1)
        every = np.repeat(np.arange(len(edges), dtype=np.int32), len(places))
        at[edges[:, nodes_at].ravel()] = along.arc_lengths(every, np.tile(places, len(edges)))
    else:
        at[nodes] = varying.at(reference[nodes])
    tell_unresolved(varying, bodies, nodes, at, key, told)
    return varying.values(at[nodes])


class _Held(NamedTuple):
    scale: float
    place: int
    course: Course | None


class _Plan:
    """Supports as they are read, one after another."""

    def __init__(self, reference: Floats, registry: Registry) -> None:
        self.reference, self.registry = reference, registry
        self.held: dict[int, _Held] = {}
        self.motions: list[Motion] = []
        self.sets: dict[str, Ints] = {}
        self.owner: dict[int, str] = {}
        self.on = ""
        self.places = 0
        self.moving = [False, False]

    def add(self, on: str, nodes: Ints, spec: Support | Rigid, where: Where, scales: Floats | None = None) -> None:
        """Hold or move `nodes` by the table at `where`, times `scales` (n,) by node."""
        scales = np.ones(len(nodes)) if scales is None else scales
        self.on = on
        self.sets[on] = nodes
        if spec.turn is not None:
            self._turn(nodes, spec, where)
            return
        for component, value in enumerate((spec.ux, spec.uy)):
            if value is not None:
                course = course_of(value, self.registry, below(where, ("ux", "uy")[component]))
                self.moving[component] |= course.moves
                place = self._append(Shift(course))
                key = below(where, ("ux", "uy")[component])
                for dof, factor in zip((2 * nodes + component).tolist(), scales.tolist(), strict=True):
                    self._hold(dof, _Held(factor * course.to, place, course), key)

    def _turn(self, nodes: Ints, spec: Support | Rigid, where: Where) -> None:
        assert spec.turn is not None
        turn, courses = spec.turn, courses_of(spec, ("ux", "uy"), self.registry, where)
        angle = course_of(turn, self.registry, where)._replace(to=math.radians(turn.to))
        offsets = self.reference[nodes] - np.asarray(turn.about)
        place = self._append(Rotation(tuple(map(tuple, offsets.tolist())), angle, *courses))
        self.moving = [True, True]
        key = below(where, "turn")
        for k, node in enumerate(nodes.tolist()):
            for component in range(2):
                self._hold(2 * node + component, _Held(1.0, place + 2 * k + component, None), key)

    def _append(self, motion: Motion) -> int:
        """Add the values of a motion. Return their first position."""
        begin = self.places
        self.motions.append(motion)
        self.places += motion.size
        return begin

    def _hold(self, dof: int, new: _Held, where: Where) -> None:
        old = self.held.setdefault(dof, new)
        self.owner.setdefault(dof, self.on)
        if old is not new and not _agree(old, new):
            raise SceneError(
                f"node {dof // 2} is given two different displacements in {'xy'[dof % 2]}",
                where=where,
                got=f"{_words(new)} after {_words(old)}",
                allowed="one displacement for each node",
                hint="let supports overlap only if they agree",
            )

    def finished(self) -> SupportPlan:
        """Return the complete plan, in the order of the degrees of freedom."""
        order = sorted(self.held)
        own = {on: np.array([dof for dof in order if self.owner[dof] == on], np.int32) for on in self.sets}
        return SupportPlan(
            np.array(order, np.int32),
            np.array([self.held[dof].scale for dof in order], np.float64),
            np.array([self.held[dof].place for dof in order], np.int32),
            tuple(self.motions),
            tuple(SupportedSet(on, nodes, own[on]) for on, nodes in self.sets.items()),
            (self.moving[0], self.moving[1]),
        )


def _agree(old: _Held, new: _Held) -> bool:
    """Return whether two supports give the same displacement at all times; zero is zero for any ramp."""
    if old.course is None or new.course is None:
        return False
    same = old.course == new.course and old.scale == new.scale
    return same or old.scale == new.scale == 0.0


def _words(held: _Held) -> str:
    if held.course is None:
        return "a rotation"
    return f"{held.scale:g}" if held.course.shape == "constant" else f"{held.scale:g} ({held.course.shape})"
