"""Checks that results of contact algorithms are finite, and the messages if not: plugins get finite numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import ContactView, Floats, Pieces
from contactlab.errors import WrongAnswer

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair


def finite(*arrays: Floats) -> bool:
    """Return whether all numbers are finite; sums show it, without an array of booleans."""
    return all(bool(np.isfinite(array.sum())) or bool(np.isfinite(array).all()) for array in arrays)


def refuse(part: Any, method: str, what: str, place: str = "") -> None:
    """Raise WrongAnswer: a method of a plugin component gave a result that is not finite."""
    raise WrongAnswer(f"{type(part).__name__}: {method} gave {what} that is not finite{place}, from finite numbers")


def copies(view: ContactView) -> dict[str, Floats]:
    """Return copies of all arrays of a view except `memory`, which an algorithm may write."""
    return {name: array.copy() for name, array in _arrays(view).items()}


def refuse_written(view: ContactView, before: dict[str, Floats], part: Any, method: str) -> None:
    """Raise WrongAnswer if an algorithm wrote to its view, whose `copies` were made before.

    The surfaces belong to the model: gaps and forces would silently belong to other positions.
    """
    for name, array in _arrays(view).items():
        if not np.array_equal(array, before[name]):
            raise WrongAnswer(
                f"{type(part).__name__}: {method} wrote to {name} of its view, which it may only read\n"
                f"  allowed  a copy to work on: view.{name}.copy()"
            )


def _arrays(view: ContactView) -> dict[str, Floats]:
    parts = {
        "slave": vars(view.slave),
        "master": vars(view.master),
        "at": view.at._asdict(),
        "near": view.near._asdict(),
    }
    held = {f"{name}.{field}": value for name, fields in parts.items() for field, value in fields.items()}
    return {name: value for name, value in held.items() if isinstance(value, np.ndarray)}


def examine_contact(contact: Any) -> None:
    """Check the algorithm of every pair at its last update, then the enforcement; None without contact."""
    for pair in contact.passes if contact is not None else ():
        examine_pair(pair)


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
