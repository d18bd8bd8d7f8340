"""A block that slides with friction flutters below a damping that its linear modes foresee, and only there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, near, reported, within
from contactlab_cases.dynamics import WORK
from contactlab_cases.flutter import Block, Flutter, flutter
from contactlab_cases.series import series, table

BEGIN, SPAN = 0.03, 0.03  # s: after the weight has come; vibrations grow by e in 3e-4 s without damping
LESS, MORE = 0.8, 1.25  # of the damping that theory asks for


def block(level: int) -> Block:
    """Return the block of the scene `block-on-incline`."""
    return Block((10.0, 5.0), (8 * level, 4 * level), young=100.0, poisson=0.3, density=7.8e-9)


@dataclass(frozen=True)
class SlidingFlutter(Case):
    """`mu` of the plane. The block of the scene `block-on-incline`, with damping below and above its limit.

    Below it vibrations grow until nodes leave the plane; above it the block slides evenly.
    """

    mu: float = 0.3

    title: ClassVar[str] = "block that flutters as it slides"
    source: ClassVar[str] = "Martins, Guimaraes & Faria 1995: unsymmetric eigenvalue problem"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.2, 0.25, 0.3)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction"})
    swaps: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if not 0.0 < self.mu < 0.36:
            raise ValueError(f"mu: got {self.mu}, allowed: above 0 and below 0.36, where the block slides")

    def theory(self, setup: Setup) -> Flutter:
        """Return the flutter of the block on its mesh, from an assembly of its own."""
        return flutter(block(setup.level), self.mu)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Two jobs that differ in damping alone."""
        damping = self.theory(setup).damping
        base = {
            **setup.changes("block"), "level": setup.level, "contacts.0.friction.mu": self.mu, "time.end": BEGIN + SPAN
        }  # fmt: skip
        watch = series("time", "push")
        rates = {"damped less": LESS * damping, "damped more": MORE * damping}
        return tuple(
            Job(name, "block-on-incline", {**base, "effects.1.rate": rate}, (watch,), work=WORK * setup.level)
            for name, rate in rates.items()
        )

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Swings of the force in the second half of the time, and how fast."""
        grown = "vibrations of 1e-7 grow by e^0.25 c t / 2 with c t near 400: only nodes that leave the plane end that"
        gone = "what the coming weight excites dies out as fast as it grows with less damping"
        lifted = "swings of this size lift nodes, which makes the contact softer"
        return (
            within(f"swing of the force over its mean, {LESS} of the damping", 0.01, np.inf, grown),
            at_most(f"swing of the force over its mean, {MORE} of the damping", 1e-4, gone),
            near("frequency of the swings", self.theory(setup).at, 0.1, lifted, "1/s"),
            reported("damping that stops all modes", "1/s"),
            reported("largest growth without damping", "1/s"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures from the force of every step."""
        theory = self.theory(setup)
        less, more = (table(done[name]) for name in ("damped less", "damped more"))
        swings = []
        for found in (less, more):
            push = found["push"][found["time"] > BEGIN]
            swings.append(float(np.ptp(push) / np.mean(push)))
        push, time = (less[name][less["time"] > BEGIN] for name in ("push", "time"))
        upwards = np.flatnonzero(np.diff(np.sign(push - np.mean(push))) > 0)
        turns, lasted = len(upwards) - 1, time[upwards[-1]] - time[upwards[0]]
        return {
            f"swing of the force over its mean, {LESS} of the damping": swings[0],
            f"swing of the force over its mean, {MORE} of the damping": swings[1],
            "frequency of the swings": float(2.0 * np.pi * turns / lasted) if lasted > 0.0 else np.nan,
            "damping that stops all modes": theory.damping,
            "largest growth without damping": theory.growth,
        }
