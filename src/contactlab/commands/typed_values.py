"""Numbers as they are typed in a command. Each raises ArgumentTypeError with what is allowed."""

from __future__ import annotations

import argparse


def positive(text: str) -> int:
    """A whole number of at least 1."""
    number = _whole(text)
    if number is None or number < 1:
        raise argparse.ArgumentTypeError(f"got {text[:40]}, allowed: a whole number >= 1")
    return number


def _whole(text: str) -> int | None:
    """The whole number that is written; None for other text and for more than 18 digits."""
    digits = text.strip().removeprefix("+")
    return int(digits) if digits.isdecimal() and len(digits) <= 18 else None


def share(text: str) -> float:
    """An error below 1: a fraction, or a percentage such as 1%."""
    try:
        number = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        number = 0.0
    if not 0.0 < number < 1.0:
        raise argparse.ArgumentTypeError(f"got {text}, allowed: an error such as 1% or 0.01, below 1")
    return number


def seconds(text: str) -> float:
    """A time above 0; the unit s may be added."""
    try:
        number = float(text.removesuffix("s"))
    except ValueError:
        number = 0.0
    if not 0.0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"got {text}, allowed: seconds, above 0")
    return number


def step(text: str) -> int:
    """A whole number of at least 0."""
    number = _whole(text)
    if number is None:
        raise argparse.ArgumentTypeError(f"got {text[:40]}, allowed: a whole number >= 0")
    return number
