"""Stops a run whose contact is not solved, flickers, gives no numbers, or lets surfaces through each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.kernels.checks import deepest, status_changes
from contactlab.model.model import Model
from contactlab.run.stopping import node_name, stop

if TYPE_CHECKING:
    from contactlab.model.contact.pair import ContactPair

LOOSE = 1e-6  # natural residual of a contact solve that counts as not converged
PATIENCE = 50  # consecutive steps with a loose residual before the run is stopped
FLICKER = 0.3  # share of the conditions whose status changes within a step
FEWEST = 4  # conditions below which a share means nothing: a corner's one or two alternate by nature
CHATTER = 100  # consecutive steps that flicker before the run is stopped
TOO_DEEP = 0.5  # segment lengths
FAR_SIDE = 2.0  # segment lengths beyond which a node is on the far side of a thin body


class ContactGuard:
    """Checks all contact pairs of one run.

    pressed, closed    (k,) multipliers that pressed at the last step, and at any time
    loose, flickering  consecutive steps whose contact was not solved, or whose conditions changed too much
    """

    def __init__(self, model: Model, shorter: str) -> None:
        self.model, self.shorter = model, shorter
        self.pairs: tuple[ContactPair, ...] = tuple(model.contact.pairs) if model.contact is not None else ()
        self.forces = model.state["multipliers"][0] if self.pairs else np.zeros(0)
        self.pressed = np.zeros(len(self.forces), np.bool_)
        self.closed = self.pressed.copy()
        self.loose = self.flickering = 0

    def after_step(self, residual: float) -> None:
        """Stop where the contact was not solved, or flickered, for many steps."""
        self.loose = self.loose + 1 if residual > LOOSE else 0
        if self.loose >= PATIENCE:
            self._not_solved(residual)
        if not self.pairs:
            return
        changes, conditions, last = status_changes(self.forces, self.pressed)
        if changes:
            self.closed |= self.pressed
        flickers = conditions >= FEWEST and changes > FLICKER * conditions
        self.flickering = self.flickering + 1 if flickers else 0
        if self.flickering >= CHATTER:
            self._chatters(changes, conditions, last)

    def _not_solved(self, residual: float) -> None:
        stop(
            self.model,
            f"the contact solve left a residual of {residual:.1e} segment lengths (allowed {LOOSE:.0e}) in {PATIENCE} "
            f"consecutive steps{self._worst_condition()}",
            "make the lighter or finer side the slave, or allow more sweeps",
            "not-converged",
        )

    def _worst_condition(self) -> str:
        """Where contact conditions hold least: pressed ones off the surface, or open ones behind it."""
        found = []
        for pair in self.pairs:
            gaps = pair.snapshot(self.model.state, self.model.position).gaps
            pressed = self.forces[pair.first_slot : pair.first_slot + pair.slots] > 0.0
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
        by_itself = "; sliding with friction flutters by itself where damping is small" if pair.friction else ""
        stop(
            self.model,
            f"{pair.name} chatters: {changes} of {conditions} contact conditions opened or closed in the last "
            f"step, more than {FLICKER:.0%} in each of {CHATTER} steps, among them that of "
            f"{self._slave_node(pair, last - pair.first_slot)}",
            f"try {self.shorter}, some damping, or the other side as slave{by_itself}",
        )

    def check_numbers(self) -> None:
        """Raise WrongAnswer for a contact algorithm whose answer is no number: its contact would vanish."""
        if not self.pairs:
            return
        from contactlab.model.examination import examine_pair

        for pair in self.pairs:
            examine_pair(pair)

    def check_penetration(self) -> None:
        """Stop where a node lies deep in the other side, by geometry alone."""
        for pair in self.pairs:
            if pair.near is None:
                continue
            position, near = self.model.position, pair.near.candidates
            depth, place, side = deepest(
                position[pair.slave.nodes], pair.slave.segments, position[pair.master.nodes], pair.master.segments,
                near.start, near.master, FAR_SIDE * pair.size,
            )  # fmt: skip
            if depth > TOO_DEEP * pair.size:
                surface = (pair.slave, pair.master)[side]
                stop(
                    self.model,
                    f"{pair.name}: {node_name(self.model, int(surface.nodes[place]))} of the "
                    f"{('slave', 'master')[side]} lies {depth:.3g} deep in the other side, {depth / pair.size:.0%} of "
                    f"a segment (allowed {TOO_DEEP:.0%})",
                    f"try the other side as slave, a finer slave, or {self.shorter}",
                )
