"""Stops a run whose contact is not solved, flickers, gives no numbers, or lets surfaces through each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from contactlab.kernels.checks import deepest, status_changes
from contactlab.model.bodies.body import Body
from contactlab.model.loading.held_bodies import free_motions, hold, loose_motions
from contactlab.model.model import Model
from contactlab.results.invariants import NOTHING
from contactlab.results.strain_scale import contact_force_of_strain
from contactlab.run.stopping import node_name, stop

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair
    from contactlab.model.implicit_model import ImplicitModel

LOOSE = 1e-6  # natural residual of a contact solve that counts as not converged
PATIENCE = 50  # consecutive steps with a loose residual before the run is stopped
FLICKER = 0.3  # share of the conditions whose status changes within a step
FEWEST = 4  # conditions below which a share means nothing: a corner's one or two alternate by nature
CHATTER = 100  # consecutive steps that flicker before the run is stopped
FEEBLE = 1e-4  # of the largest nodal force of the run: bodies that came apart and rattle with less change no answer
FADE = 0.9  # of that force from step to step: what rattled with more when the bodies came apart is forgotten
TOO_DEEP = 0.5  # segment lengths
APART = 0.1  # segment lengths between surfaces that do not touch any more
FAR_SIDE = 2.0  # segment lengths beyond which a node is on the far side of a thin body


class ContactGuard:
    """Checks all contact pairs of one run.

    pressed, closed    (k,) multipliers that pressed at the last step, and at any time with more than round-off
    felt, waiting      (k,) [N] what is more than round-off, and the pairs that have not closed
    loose, flickering  consecutive steps whose contact was not solved, or whose conditions changed too much
    largest, rattling  [N] largest nodal forces of the run, and of the last steps that flickered
    before             (N, 2) [mm] positions at the last look
    """

    def __init__(self, model: Model, shorter: str) -> None:
        self.model, self.shorter = model, shorter
        passes: tuple[ContactPair, ...] = tuple(model.contact.passes) if model.contact is not None else ()
        self.pairs = tuple(pair for pair in passes if not pair.at_corners)
        self.forces = model.state["multipliers"][0] if self.pairs else np.zeros(0)
        self.pressed = np.zeros(len(self.forces), np.bool_)
        self.closed = self.pressed.copy()
        self.felt = np.zeros(len(self.forces))
        for pair in passes:
            self.felt[pair.own] = contact_force_of_strain(model, pair, NOTHING)
        self.waiting = passes
        self.loose = self.flickering = 0
        self.largest = self.rattling = 0.0
        self.before = model.position.copy() if self.pairs else model.position
        self.unheld = () if model.integrator.inertia else _unheld(model, self.pairs)

    def after_step(self, residual: float) -> None:
        """Stop if the contact was not solved, or flickered, for many steps."""
        self.loose = self.loose + 1 if residual > LOOSE else 0
        if self.loose >= PATIENCE:
            self._not_solved(residual)
        if not self.pairs:
            return
        changes, conditions, last, force = status_changes(self.forces, self.pressed)
        if self.waiting and force > 0.0:
            self.closed |= self.forces > self.felt
            self.waiting = tuple(pair for pair in self.waiting if not self.closed[pair.own].any())
        self.largest = max(self.largest, force)
        flickers = conditions >= FEWEST and changes > FLICKER * conditions
        self.flickering, self.rattling = (
            (self.flickering + 1, max(FADE * self.rattling, force)) if flickers else (0, 0.0)
        )
        if self.flickering >= CHATTER:
            if self.rattling > FEEBLE * self.largest:
                self._chatters(changes, conditions, last)
            self.flickering, self.rattling = 0, 0.0

    def _not_solved(self, residual: float) -> None:
        stop(
            self.model,
            f"the contact solve left a residual of {residual:.1e} segment lengths (allowed {LOOSE:.0e}) in {PATIENCE} "
            f"consecutive steps{self._worst_condition()}",
            "make the lighter or finer side the slave, or allow more sweeps (Gauss-Seidel iterations)",
            "not-converged",
        )

    def _worst_condition(self) -> str:
        """Return the place of the largest violation: pressed nodes off the surface, or open nodes behind it."""
        found = []
        for pair in self.pairs:
            gaps = pair.snapshot(self.model.state, self.model.position).gaps
            pressed = self.forces[pair.own] > 0.0
            slot = int(np.argmax(np.where(pressed, np.abs(gaps), -gaps)))
            found.append((abs(float(gaps[slot])), pair, slot))
        if not found:
            return ""
        gap, pair, slot = max(found, key=lambda worst: worst[0])
        return f", worst in {pair.name} at {self._slave_node(pair, slot)}, {gap:.1e} off"

    def _slave_node(self, pair: ContactPair, slot: int) -> str:
        return node_name(self.model, int(pair.slave.nodes[slot % len(pair.slave.nodes)]))

    def _chatters(self, changes: int, conditions: int, last: int) -> None:
        pair = next(p for p in reversed(self.pairs) if p.first_slot <= last)
        by_itself = "; sliding with friction may flutter if damping is small" if pair.friction else ""
        stop(
            self.model,
            f"{pair.name} chatters: {changes} of {conditions} contact conditions opened or closed in the last "
            f"step (limit {FLICKER:.0%} of them in {CHATTER} consecutive steps), for example at "
            f"{self._slave_node(pair, last - pair.first_slot)}",
            f"try {self.shorter}, some damping, or the other side as slave{by_itself}",
        )

    def check_numbers(self) -> None:
        """Raise WrongAnswer for a contact algorithm whose answer is no number: its contact would vanish."""
        if not self.pairs:
            return
        from contactlab.contact.examined import examine_pair

        for pair in self.pairs:
            examine_pair(pair)

    def look(self) -> None:
        """Check where surfaces are, and which way they have come since the last look."""
        if not self.pairs:
            return
        self.check_penetration()
        self._check_passage()
        for body, pairs in self.unheld:
            self._check_held(body, pairs)
        self.before[:] = self.model.position

    def _check_passage(self) -> None:
        """Stop if nodes have passed through the other side, beyond the depth that `check_penetration` covers."""
        from contactlab.contact.passage import first_passage

        position = self.model.position
        moved = 2.0 * np.sqrt(2.0) * float(np.abs(position - self.before).max())  # of two nodes, along both axes
        if moved <= (FAR_SIDE - TOO_DEEP) * min(pair.size for pair in self.pairs):
            return
        deep = TOO_DEEP + max(self._asked_for(pair) / pair.size for pair in self.pairs)
        passage = first_passage(self.pairs, self.before, position, deep)
        if passage is not None:
            x, y = position[passage.node]
            stop(
                self.model,
                f"{passage.pair.name}: {node_name(self.model, passage.node)} has passed through the other side, to "
                f"({x:.4g}, {y:.4g})",
                f"it moved too far in one step: try {self.shorter}, or check the supports of the bodies",
            )

    def _check_held(self, body: Body, pairs: tuple[ContactPair, ...]) -> None:
        """Stop if a body that only contacts hold has left all of them: its position is undetermined."""
        for pair in pairs:
            own = pair.own
            if (self.forces[own] > 0.0).any() or pair.gaps[:, 0].min() <= APART * pair.size:
                return
        own = slice(body.first, body.first + body.count)
        moved = float(np.hypot(*(self.model.position[own] - self.before[own]).mean(axis=0)))
        size = min(pair.size for pair in pairs)
        if moved > APART * size and (loose := loose_motions(cast("ImplicitModel", self.model)).get(body.name)):
            stop(
                self.model,
                f"body {body.name} has moved by {moved:.3g} out of all its contacts and is free for "
                f"{' and '.join(loose)}",
                f"try more integrator.steps, or {hold(body.name, loose)}",
                "not-converged",
            )

    def check_penetration(self) -> None:
        """Stop if a node lies deep in the other side, by geometry alone."""
        for pair in self.pairs:
            assert pair.near is not None
            position, near = self.model.position, pair.near.candidates
            depth, place, side = deepest(
                position[pair.slave.nodes], pair.slave.segments, position[pair.master.nodes], pair.master.segments,
                near.start, near.master, FAR_SIDE * pair.size,
            )  # fmt: skip
            if depth > TOO_DEEP * pair.size + self._asked_for(pair):
                surface = (pair.slave, pair.master)[side]
                stop(
                    self.model,
                    f"{pair.name}: {node_name(self.model, int(surface.nodes[place]))} of the "
                    f"{('slave', 'master')[side]} lies {depth:.3g} deep in the other side, {depth / pair.size:.0%} of "
                    f"a segment (allowed {TOO_DEEP:.0%})",
                    f"try the other side as slave, a finer slave, or {self.shorter}",
                )

    def _asked_for(self, pair: ContactPair) -> float:
        """Deepest overlap [mm] that a pressure law of the scene implies: a foundation gives way by its pressure."""
        if not hasattr(self.model.contact.enforcement, "law"):  # type: ignore[union-attr]
            return 0.0
        gaps = pair.snapshot(self.model.state, self.model.position).gaps
        return max(0.0, -float(gaps[self.forces[pair.own] > 0.0].min(initial=0.0)))


def _unheld(model: Model, pairs: tuple[ContactPair, ...]) -> tuple[tuple[Body, tuple[ContactPair, ...]], ...]:
    """Bodies that supports leave free to move, with the contacts that are to hold them."""
    found = []
    for body in model.bodies:
        nodes = range(body.first, body.first + body.count)
        own = tuple(pair for pair in pairs if pair.slave.nodes[0] in nodes or pair.master.nodes[0] in nodes)
        if own and free_motions(body, model.prescribed):
            found.append((body, own))
    return tuple(found)
