"""Where the nodes of a contact surface lie along it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Ints


class ArcLength(NamedTuple):
    """Arc length s (m,) [mm] of each node of a surface, and the number of its chain (m,), from 0."""

    s: Floats
    chain: Ints


def arc_length(positions: Floats, segments: Ints) -> ArcLength:
    """Arc length along the `segments` (s, 2) between `positions` (m, 2) [mm].

    Each chain goes on where the one before it ends, so that s never falls from chain to chain. Chains that begin at a
    free end come first, closed ones after them, each in the order of the nodes that they begin with.
    """
    following = {int(a): int(b) for a, b in segments}
    free = sorted(following.keys() - following.values())
    s, chain = np.zeros(len(positions)), np.full(len(positions), -1, np.int32)
    length, count = 0.0, 0
    for start in [*free, *sorted(following)]:
        if chain[start] >= 0:
            continue
        node, s[start], chain[start] = start, length, count
        while (after := following.get(node)) is not None:
            length = s[node] + np.hypot(*(positions[after] - positions[node]))
            if chain[after] >= 0:
                break  # a closed chain ends where it began
            node, s[after], chain[after] = after, length, count
        count += 1
    return ArcLength(s, chain)
