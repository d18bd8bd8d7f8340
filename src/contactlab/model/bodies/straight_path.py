"""Flow within an implicit step, integrated to second order along the straight path of the deformation.

A law that flows takes one implicit Euler step (`Material.implicit_euler`): it sees the end of the step alone, and flows
in the direction of the end throughout the step. If the direction turns, its error is first order in
the step. Here the law is also evaluated on the path from start to end. Each of `PARTS` equal parts of the path
is one step of the stiffly accurate, L-stable Runge-Kutta method of second order with the stages

    h1 = h0 + c k1,   h = h0 + b1 k1 + b2 k2,     c = 1/4, b1 = 2/3, b2 = 1/3

(k: change of the history in the part, at the rate of each stage). Both are implicit Euler steps of the law: the second
starts from h0 + b1/c (h1 - h0), so that stresses at the end fulfil the law's own equations, such as yielding
(Ellsiepen & Hartmann 2001, Int. J. Numer. Meth. Engng 51, 679; Hairer & Wanner 1996, IV.6). On a straight path flow
that has begun lasts until the end of the path, so that this extrapolation cannot overshoot.

Between the deformation gradients F0 and F1 the path is F(s) = (F1 F0^-1)^s F0: its velocity gradient is constant. A
rigid rotation stays one, and a stretch or simple shear passes through smaller ones. "small" laws go straight in du/dX.
"""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, Material

PARTS = 2
STAGE, WEIGHT, LAST = 0.25, 2.0 / 3.0, 1.0 / 3.0  # c, b1, b2
STEP = 1e-8  # of differences of stresses: truncation is this over the elastic strain, cancellation similar


class StraightPath:
    """The law of one block of points in implicit steps.

    law    a material with `implicit_euler`, in terms of the whole deformation
    start  gradient (4, P) at the start of the step; None outside of steps: the law then answers itself
    """

    def __init__(self, law: Material) -> None:
        self.law = law
        self.start: Floats | None = None

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Compute `Material.stress`, after a step of length dt [s] from `start`. The histories are different arrays."""
        self.law.stress(gradient, history, dt, stress, new_history)
        if self.start is None:
            return
        flowing = _changed(history, new_history)
        if len(flowing):
            path = Path(self.law, self.start, gradient, flowing)
            stress[:, flowing], new_history[:, flowing] = self._follow(path, history.take(flowing, axis=1), dt)

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """Compute `Material.tangent`: the law's tangent without flow, differences of the path's end with flow."""
        if self.start is None:
            self.law.tangent(gradient, history, dt, tangent)
            return
        spare, ended = np.empty_like(gradient), np.empty_like(history)
        self.law.stress(gradient, history, dt, spare, ended)
        flowing = _changed(history, ended)
        if len(flowing) < gradient.shape[1]:
            self.law.tangent(gradient, history, dt, tangent)
        if not len(flowing):
            return
        before, end = history.take(flowing, axis=1), gradient.copy()
        base, _ = self._follow(Path(self.law, self.start, gradient, flowing), before, dt)
        for j in range(4):
            end[j] = gradient[j] + STEP
            moved, _ = self._follow(Path(self.law, self.start, end, flowing), before, dt)
            tangent[:, j, flowing] = (moved - base) / STEP
            end[j] = gradient[j]

    def _follow(self, path: Path, history: Floats, dt: float) -> tuple[Floats, Floats]:
        """Return stress (4, P) and history (h, P) at the end of the path."""
        law, stress = self.law, np.empty_like(path.end)
        stage, history = np.empty_like(history), history.copy()
        for number in range(PARTS):
            law.stress(path.at((number + STAGE) / PARTS), history, STAGE * dt / PARTS, stress, stage)
            start = history + WEIGHT / STAGE * (stage - history)
            law.complete_history(start)
            law.stress(path.at((number + 1) / PARTS), start, LAST * dt / PARTS, stress, history)
        return stress, history


class Path:
    """Gradients between the start and the end of a step, at some of their points."""

    def __init__(self, law: Material, start: Floats, end: Floats, points: Ints) -> None:
        self.start, self.end = start.take(points, axis=1), end.take(points, axis=1)
        self.turns = law.kinematics == "finite"
        if self.turns:
            self.change = _product(_inverse(self.start), self.end)  # F0 F1^-1
            self.roots = [self.change]  # each the square root of the last

    def at(self, part: float) -> Floats:
        """Return the gradient (4, P) after a part of the path: a multiple of an eighth, or of any power of two."""
        if part == 1.0:
            return self.end
        if not self.turns:
            return self.start + part * (self.end - self.start)
        found, left, number = self.start, part, 0
        while left > 0.0:
            left, number = 2.0 * left, number + 1
            while len(self.roots) <= number:
                self.roots.append(_root(self.roots[-1]))
            if left >= 1.0:
                found, left = _product(found, self.roots[number]), left - 1.0
        return found


def _changed(history: Floats, new_history: Floats) -> Ints:
    """Return points at which a step changed the history."""
    return np.flatnonzero((history != new_history).any(axis=0)).astype(np.int32)


def _product(a: Floats, b: Floats) -> Floats:
    """Return products of matrices given by rows xx, xy, yx, yy (4, P)."""
    return np.stack([
        a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]
    ])  # fmt: skip


def _inverse(a: Floats) -> Floats:
    return np.asarray(np.stack([a[3], -a[1], -a[2], a[0]]) / (a[0] * a[3] - a[1] * a[2]))


def _root(a: Floats) -> Floats:
    """Return principal square roots: (A + d I)/sqrt(tr A + 2 d), d = sqrt(det A) (Cayley & Hamilton).

    Folded states have none; they occur in trials that are undone, and get a finite number.
    """
    middle = np.sqrt(np.maximum(a[0] * a[3] - a[1] * a[2], 0.0))
    out = a.copy()
    out[0] += middle
    out[3] += middle
    return np.asarray(out / np.sqrt(np.maximum(a[0] + a[3] + 2.0 * middle, 1e-12)))
