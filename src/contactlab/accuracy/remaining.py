"""Errors left on the finest meshes of a scene: least squares over runs of several meshes, with tried orders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contactlab.accuracy.judged import Judged
from contactlab.api.arrays import Floats, Ints

LATER = 0.1
"""Relative misfit beyond which the coarsest of four levels or more is left out: convergence had not begun there."""
MISFIT = 0.02
"""Relative misfit, root mean square, beyond that of the best order with which an order counts by a third less."""
FLOOR = 0.1
"""Mean square of distances that is added to each: two levels that agree by chance tell nothing of the order."""
ALONE = 1.5
"""Times the error that a single line of runs leaves by its own estimate: nothing stands beside it."""
NEAR_FINEST = 0.6
"""Level over the finest one from which on a run takes part in the reference."""
ALIKE = 3.0
"""Times the least error left of these runs up to which others are as exact."""


@dataclass(frozen=True)
class Ladder:
    """Results of one configuration by level; `cost` of its finest run [s]."""

    name: str
    family: tuple[Any, ...]
    values: Mapping[int, Any]
    cost: float

    @property
    def finest(self) -> int:
        """Its finest level."""
        return max(self.values)


@dataclass(frozen=True)
class Truth:
    """Reference of the runs.

    uncertainty  relative, of the value
    words        where both are from
    level        of its finest run
    alone        whether it is a single run
    """

    value: Any
    uncertainty: float
    words: str
    level: int
    alone: bool = False


def left_at(values: Mapping[int, Any], judged: Judged, orders: Floats) -> tuple[Floats, Floats]:
    """Relative errors left at the finest of two levels or more for each of the orders q, and weights of these orders.

    The error at level n is taken as C n^-q, in part along one direction that all levels share (what Richardson's rule
    extrapolates) and in part along one of its own (where an edge of contact falls in its cell). Least squares over the
    distances of all pairs of levels,

        d_ij^2 = a (x_i - x_j)^2 + b (x_i^2 + x_j^2),    x = n^-q,    a, b >= 0

    leave x (a + b)^(1/2). Orders weigh by how well they fit; two levels tell nothing of b and q.
    """
    levels = sorted(values)
    fine: list[Any] = [judged.sharpened(values[level]) for level in levels]
    squares = np.array([[judged.apart(one, other) for other in fine] for one in fine]) ** 2
    left, misfit = _fitted(np.array(levels), squares, orders)
    while len(levels) > 3 and misfit.min() > LATER**2:
        levels, squares = levels[1:], squares[1:, 1:]
        left, misfit = _fitted(np.array(levels), squares, orders)
    weight = np.exp((misfit.min() - misfit) / (2.0 * MISFIT**2))
    return left, weight / weight.sum()


def _fitted(levels: Ints, squares: Floats, orders: Floats) -> tuple[Floats, Floats]:
    """Errors left at the finest level and mean squares of relative misfits of distances, for each order."""
    i, j = np.triu_indices(len(levels), 1)
    x = (levels / levels[-1]) ** -orders[:, None]
    size = x[:, i] ** 2 + x[:, j] ** 2
    shared, own = (x[:, i] - x[:, j]) ** 2 / size, squares[i, j] / size
    a, b = np.array([_line(*both) for both in zip(shared, own, strict=True)]).T
    floor = FLOOR * np.maximum(own.mean(axis=1), 1e-300)[:, None]
    found = a[:, None] * shared + b[:, None]
    misfit = np.mean((0.5 * np.log((found + floor) / (own + floor))) ** 2, axis=1)
    return np.sqrt(a + b), misfit


def _line(t: Floats, y: Floats) -> tuple[float, float]:
    """Least squares y = a t + b with a, b >= 0; of less than three points with b = 0."""
    steep = float(t @ y) / float(t @ t)
    if len(y) < 3:
        return steep, 0.0
    away = t - t.mean()
    a = float(away @ y) / float(away @ away)
    b = float(y.mean() - a * t.mean())
    return (steep, 0.0) if b < 0.0 else (a, b) if a > 0.0 else (0.0, float(y.mean()))


def ranked(ladders: Sequence[Ladder], judged: Judged, truth: Truth | None = None) -> list[tuple[float, Ladder]]:
    """Ladders with the error that each has left, the least for its cost first; single levels by the truth so far.

    Two levels do not determine an order: they use the weights of orders of longer ladders.
    """
    finest = max(ladders, key=lambda each: each.finest, default=None)
    orders = judged.orders(finest.values[finest.finest]) if finest else np.empty(0)
    fits = {each.name: left_at(each.values, judged, orders) for each in ladders if len(each.values) > 1}
    longer = [fits[each.name][1] for each in ladders if len(each.values) > 2]

    def left(each: Ladder) -> float:
        if each.name in fits:
            found, weight = fits[each.name]
            return float((np.mean(longer, axis=0) if longer and len(each.values) == 2 else weight) @ found)
        return judged.apart(each.values[each.finest], truth.value) + truth.uncertainty if truth else math.inf

    found = [(left(each), each) for each in ladders]
    return sorted(found, key=lambda pair: pair[0] * max(pair[1].cost, 1e-3) ** 0.4)


def beside(pairs: Sequence[tuple[float, Ladder]], most: int) -> list[tuple[float, Ladder]]:
    """The first of these, and further ones that differ from those before in algorithm or slave, or in element."""
    taken: list[tuple[float, Ladder]] = []
    for pair in pairs:
        if len(taken) < most and all(pair[1].family != other.family for _, other in taken):
            taken.append(pair)
    return taken


def truth_of(ladders: Sequence[Ladder], judged: Judged, climbers: int) -> Truth | None:
    """The mean of the best runs near the finest level, or of those alike exact: the better known; None without any.

    One that is much less exact than the others adds more to their mean than it takes away. Beside a single one near the
    finest level those alike exact on coarser meshes count, such as of quadratic elements.
    """
    known = ranked([each for each in ladders if len(each.values) > 1], judged)
    pairs = sorted(((judged.safety * left, ladder) for left, ladder in known), key=lambda pair: pair[0])
    if not pairs:
        return None
    best = beside(pairs, climbers)
    finest = max(ladder.finest for _, ladder in best)
    near = [pair for pair in best if pair[1].finest >= NEAR_FINEST * finest]
    alike = [pair for pair in (near if len(near) > 1 else best) if pair[0] <= ALIKE * near[0][0]]
    means = [(*_mean(within, best, judged), finest, len(near) == len(within) == 1) for within in (near, alike)]
    return min((Truth(*mean) for mean in means), key=lambda truth: truth.uncertainty)


def _mean(
    within: Sequence[tuple[float, Ladder]], best: Sequence[tuple[float, Ladder]], judged: Judged
) -> tuple[Any, float, str]:
    """Mean of the finest runs of ladders, with weights 1/u for errors u left, its uncertainty, and whose it is.

    The uncertainty is the largest of the error of the mean (squared: the mean of u^2 minus the mean squared distance
    from the mean), of these distances, and of the distances of the best runs with other elements or slaves beyond twice
    their own errors.
    """
    values: list[Any] = [judged.sharpened(ladder.values[ladder.finest]) for _, ladder in within]
    own = np.array([max(left, 1e-12) for left, _ in within])
    weights = 1.0 / own / np.sum(1.0 / own)
    mean: Any = judged.mean(values, weights)
    spread = np.array([judged.apart(value, mean) for value in values])
    # the parallelogram law, which holds for whatever parts of their errors are the same in all
    shared = float(weights @ (own**2 - spread**2))
    uncertainty = max(math.sqrt(max(shared, 0.0)), spread.max()) if len(own) > 1 else ALONE * own[0]
    for left, ladder in best:
        best_run: Any = judged.sharpened(ladder.values[ladder.finest])
        off = judged.apart(best_run, mean)
        uncertainty = max(uncertainty, off - 2.0 * left)
    return mean, float(uncertainty), " and ".join(f"{ladder.name} at level {ladder.finest}" for _, ladder in within)
