"""Rows of node arrays and how far nodes have moved."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def take(values, index, out):
    """Rows `index` of values (N, 2) into out (m, 2)."""
    for i in range(index.size):
        out[i, 0] = values[index[i], 0]
        out[i, 1] = values[index[i], 1]


@kernel
def largest_move(now, before):
    """Largest absolute change of a coordinate between two (m, 2) arrays."""
    largest = 0.0
    for i in range(now.shape[0]):
        largest = max(largest, abs(now[i, 0] - before[i, 0]), abs(now[i, 1] - before[i, 1]))
    return largest
