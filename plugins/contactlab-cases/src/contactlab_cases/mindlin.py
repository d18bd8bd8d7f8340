"""Cattaneo and Mindlin: a cylinder that is pressed, pushed sideways, and pushed back to the other side.

Both bodies are of the same material, so that normal and tangential problems are uncoupled. Shear follows the exact
solution at the measured forces; on the way back it is the shear of the loading less
twice the shear at half the decrease of Q.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, ContactCurve, Floats, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported
from contactlab_cases.circles import disc_on_block, hertz, only
from contactlab_cases.statics import iterations, l2_error, ordered, plane_strain

RADIUS, YOUNG = 10.0, 70000.0
MODULUS = plane_strain(YOUNG) / 2.0
DEPTH, HALF_WIDTH = 8.59e-4, 0.0182  # radii: P close to 100 N/mm
PHASES = {2: "loaded", 3: "half-way back", 4: "reversed"}


@dataclass(frozen=True)
class Mindlin(Case):
    """Pressed until t = 1, pushed sideways until 2, back through the middle at 3 to the other side at 4.

    mu        coefficient of friction
    segments  in a half-width, on both bodies
    steps     load steps of the whole path
    """

    mu: float = 0.3
    segments: float = 8.0
    steps: int = 8

    title: ClassVar[str] = "partial slip and its reversal (Cattaneo, Mindlin)"
    source: ClassVar[str] = "Cattaneo 1938; Mindlin 1949; Johnson 1985, 7.2"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.15, 0.3, 0.6), "steps": (4, 8)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "stick and slip"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run; sideways so far that Q is close to a half of mu P."""
        shift = 2.6e-4 * self.mu / 0.3
        way = [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 0.0], [4.0, -1.0]]
        push = {
            "on": "disc.top",
            "ux": {"ramp": "table", "to": shift * RADIUS, "points": way},
            "uy": {"ramp": "linear", "to": -DEPTH * RADIUS, "duration": 1.0},
        }
        return (
            disc_on_block(
                setup, RADIUS, (YOUNG, YOUNG), DEPTH, HALF_WIDTH / self.segments / setup.level, growth=1.03, zone=0.024,
                push=push, contact={"friction": {"use": "coulomb", "mu": self.mu}}, time={"end": 4.0},
                steps=self.steps, frames=4,
            ),
        )  # fmt: skip

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The peak of q is a kink where sticking begins, which nodal values round off."""
        size = 16.0 / self.segments / setup.level
        kink = "the peak of q is a kink at the end of sticking, which P1 multipliers overshoot"
        shear = [reported(f"{phase}: {what}") for phase in PHASES.values() for what in ("peak", "L2")]
        return [
            error("stick half-width in segments", 1.0, "nodes show the end of sticking to half a segment", "h"),
            error("loaded: peak of the shear", 0.06 * size, kink),
            error("resultant of the shear over Q, less one", 1e-6, "forces of statics balance"),
            at_most("cone violation", 1e-8, "Newton's tolerance"),
            at_most(
                "shear reversed against loaded",
                5e-4,
                "full reversal mirrors the loading, the ends of contact to 1e-4",
            ),
            reported("Q/(mu P)"),
            reported("segments in the half-width"),
            *shear,
            reported("iterations"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare shear tractions when loaded, half-way back, and fully reversed."""
        record = only(done)
        fy, fx = (record.history[f"block.bottom.{axis}"] for axis in ("fy", "fx"))
        contact = record.summary["contacts"]["contacts.0"]
        found = {
            "Q/(mu P)": abs(float(fx[2])) / (self.mu * float(fy[2])),
            "resultant of the shear over Q, less one": abs(float(contact["resultant"][0])) / abs(float(fx[-1])) - 1.0,
            "cone violation": float(contact["cone_violation"]),
            "iterations": iterations(record),
        }
        for time, curve in zip(record.times["contacts.0"], record.curves["contacts.0"], strict=True):
            frame = round(time)
            if frame >= 2:
                found |= self._of_frame(curve, frame, fx, fy)
        changes = [abs(found[f"reversed: {what}"] - found[f"loaded: {what}"]) for what in ("peak", "L2")]
        return found | {"shear reversed against loaded": max(changes)}

    def _of_frame(self, curve: ContactCurve, frame: int, fx: Floats, fy: Floats) -> dict[str, float]:
        a, _, _ = hertz(float(fy[frame]), RADIUS, MODULUS)
        exact = self._partial_slip(float(fy[frame]), float(fx[frame]), a, float(fx[2]) if frame > 2 else None)
        x, wanted = centred(curve), exact(np.linspace(-a, a, 2001))
        at, shear = ordered(x, curve.shear)
        side = np.sign(float(np.interp(0.0, at, shear)) * float(exact(np.zeros(1))[0]))
        peak = float(np.abs(curve.shear).max() / np.abs(wanted).max() - 1.0)
        found = {
            f"{PHASES[frame]}: peak": peak,
            f"{PHASES[frame]}: L2": l2_error(x, side * curve.shear, exact, 2.0 * a),
        }
        if frame == 2:
            stick = np.sqrt(1.0 - abs(float(fx[2])) / (self.mu * float(fy[2]))) * a
            found |= {"loaded: peak of the shear": peak, **_stick_width(curve, a, float(stick))}
        return found

    def _partial_slip(self, force: float, side: float, a: float, before: float | None) -> Callable[[Floats], Floats]:
        """q(x) at a tangential force `side`; after unloading from `before` the slip of the way back counts twice."""
        limit = self.mu * 2.0 * force / (np.pi * a)

        def loaded(at: Floats, amount: float) -> Floats:
            c = a * np.sqrt(max(0.0, 1.0 - abs(amount) / (self.mu * force)))
            full = np.sqrt(np.maximum(0.0, 1.0 - at**2 / a**2))
            core = np.sqrt(np.maximum(0.0, c**2 - at**2)) / a
            return np.asarray(np.sign(amount) * limit * (full - core))

        if before is None:
            return lambda at: loaded(at, side)
        return lambda at: loaded(at, before) - 2.0 * loaded(at, 0.5 * (before - side))


def centred(curve: ContactCurve) -> Floats:
    """x from the middle of the pressure: the disc is sheared, so that its contact rolls on by 1 % of a or two."""
    return np.asarray(curve.x - float((curve.x * curve.pressure).sum() / curve.pressure.sum()))


def _stick_width(curve: ContactCurve, a: float, c: float) -> dict[str, float]:
    """Compare with Mindlin's c, half of the way between the middles of the segments on which sticking ends."""
    x, state = ordered(centred(curve), curve.state)
    size = float(np.diff(x[np.abs(x) < 1.2 * a]).mean())
    stuck = np.flatnonzero(state == 1)
    width = 0.25 * float(x[stuck[-1]] + x[stuck[-1] + 1] - x[stuck[0]] - x[stuck[0] - 1])
    return {"segments in the half-width": a / size, "stick half-width in segments": (width - c) / size}
