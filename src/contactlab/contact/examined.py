"""Checks that the last results of contact algorithms are finite, and a contact system that is checked at every step."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ExplicitIntegrator, Floats, Pieces, Solve
from contactlab.contact.examination import finite, refuse
from contactlab.contact.explicit_system import ContactSystem
from contactlab.contact.pair import ContactPair
from contactlab.errors import WrongAnswer


def examine_pair(pair: ContactPair) -> None:
    """Raise WrongAnswer if the last results of a contact algorithm are not finite."""
    pieces, found = getattr(pair, "pieces", None), getattr(pair, "found", None)
    if pieces is not None:
        _examine_pieces(pair, pieces, getattr(pair, "count", 0))
    elif found is not None:
        for name in ("gap", "normal_weight", "tangent_weight", "measure"):
            if not finite(getattr(found, name)) and finite(*pair.at):
                refuse(pair.method, "conditions", f"an entry of {name}", f" in {pair.name}")


def _examine_pieces(pair: ContactPair, pieces: Pieces, count: int) -> None:
    covered = pieces.T[:count].sum()
    others = pieces.D[:count].sum() + pieces.M[:count].sum() + pieces.normal.sum()
    if (covered > 0.0 or not count) and np.isfinite(covered + others):
        return
    if not finite(*pair.at):
        return
    for name in ("D", "M", "T"):
        if not finite(getattr(pieces, name)[:count]):
            refuse(pair.method, "pieces", f"an entry of {name}", f" in {pair.name}")
    if not finite(pieces.normal[pieces.multiplier[:count].ravel()]):
        refuse(pair.method, "pieces", "a normal", f" in {pair.name}")
    if count and not covered > 0.0:
        raise WrongAnswer(
            f"{type(pair.method).__name__}: pieces gave {count} pieces in {pair.name} whose T sums up to "
            f"{covered:g}, needed: integrals over the covered length"
        )


class ExaminedContact:
    """A contact system whose algorithms and enforcement are checked after every solve."""

    def __init__(self, contact: ContactSystem, integrator: ExplicitIntegrator) -> None:
        self._contact, self._integrator = contact, integrator

    def __getattr__(self, name: str) -> Any:
        return getattr(self._contact, name)

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Examine the algorithms' results, then solve by the enforcement."""
        if not finite(predicted):
            refuse(self._integrator, "its step", "a predicted position")
        done = self._contact.solve(predicted, current, compliance, force)
        for pair in self._contact.passes:
            examine_pair(pair)
        if not finite(force, self._contact.multipliers):
            refuse(self._contact.enforcement, "solve", "a force")
        return done
