"""Assertions and outcomes of checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest import SkipTest
from warnings import warn

import numpy as np


class NotApplicable(SkipTest):
    """The part declares that it does not offer the checked property; the message is the reason."""


class Expected(SkipTest):
    """The part misses what it never promised; the message gives the finding and the declaration."""


class Undeclared(UserWarning):
    """A part has a property that it does not declare."""


def tell(fact: str) -> None:
    """Report a property that the part does not declare; the check continues."""
    warn(fact, Undeclared, stacklevel=2)


def require(condition: object, message: str) -> None:
    """Raise AssertionError with `message` unless the condition holds (also under python -O)."""
    if not condition:
        raise AssertionError(message)


def agree(got: Any, expected: Any, within: float, what: str) -> None:
    """Raise AssertionError unless the arrays differ by at most `within`, which is absolute."""
    got, expected = np.asarray(got), np.asarray(expected)
    require(got.shape == expected.shape, f"{what}: shape {got.shape}, expected {expected.shape}")
    if not got.size:
        return
    difference = np.abs(got - expected)
    # nan is a failure too, so the comparison is written to be false for it
    if not np.all(difference <= within):
        worst = np.unravel_index(int(np.argmax(np.nan_to_num(difference, nan=np.inf))), got.shape)
        raise AssertionError(
            f"{what}: off by {difference[worst]:.3e}, allowed {within:.1e} "
            f"(got {got[worst].item()!r}, expected {expected[worst].item()!r} at {tuple(int(i) for i in worst)})"
        )


def identical(got: Any, expected: Any, what: str) -> None:
    """Raise AssertionError unless the arrays are equal to the last bit."""
    require(np.array_equal(got, expected, equal_nan=True), f"{what}: results differ, bit-identical ones are required")


@contextmanager
def untouched(**arrays: Any) -> Iterator[None]:
    """Raise AssertionError if one of the named arrays is changed inside the block."""
    before = {name: np.array(array) for name, array in arrays.items()}
    yield
    for name, array in arrays.items():
        require(np.array_equal(array, before[name], equal_nan=True), f"the input {name} was changed; it is read-only")


Check = Callable[[Any], None]
"""A check of one part."""
