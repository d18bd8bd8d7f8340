"""Parallel blocks of cells: which may add their forces at the same time, and their threads.

Blocks that share a node must add to it one after another, always in the same order, or the last digit of the sum
would depend on the order of threads. Blocks get colours: two of one colour share no node. Colours are done one
after another, by one thread or by many, so that results are the same to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from contactlab.api import Ints

Update = Callable[[float], None]

_COLOURS = 64  # as many as an integer has bits; blocks that find none free come last, one by one


def colours(blocks: Sequence[Ints], nodes: int) -> list[int]:
    """Return a colour for every block, given by its connectivity (a, B), the first that none of its neighbours has."""
    taken = np.zeros(nodes, np.uint64)
    found = []
    for number, cells in enumerate(blocks):
        used = int(np.bitwise_or.reduce(taken[cells], axis=None))
        colour = (~used & (used + 1)).bit_length() - 1
        if colour < _COLOURS:
            taken[cells] |= np.uint64(1 << colour)
        else:
            colour = _COLOURS + number
        found.append(colour)
    return found


def threads_of_blocks(found: Sequence[int], threads: int, first: int = 0) -> list[int]:
    """Return the thread of every block: blocks of one colour are dealt out alternately, from thread `first` on."""
    seen: dict[int, int] = {}
    block_threads = []
    for colour in found:
        block_threads.append((first + seen.get(colour, 0)) % threads)
        seen[colour] = seen.get(colour, 0) + 1
    return block_threads


def in_order(
    updates: Sequence[Update], found: Sequence[int], block_threads: Sequence[int], threads: int
) -> tuple[Update, ...]:
    """Return calls in order of execution: the updates by colour, or with several threads one call for each colour."""
    by_colour = sorted(range(len(updates)), key=lambda number: found[number])
    if threads == 1:
        return tuple(updates[number] for number in by_colour)

    team = Threads(threads)
    rounds: dict[int, list[list[Update]]] = {}
    for number in by_colour:
        rounds.setdefault(found[number], [[] for _ in range(threads)])[block_threads[number]].append(updates[number])
    return tuple(team.together([thread for thread in dealt if thread]) for dealt in rounds.values())


class Threads:
    """The caller's own thread and `threads` - 1 more, which live as long as this object is used.

    Compiled kernels release the interpreter's lock.
    """

    def __init__(self, threads: int) -> None:
        from concurrent.futures import ThreadPoolExecutor

        self.pool = ThreadPoolExecutor(threads - 1, thread_name_prefix="contactlab-cells")

    def together(self, shares: Sequence[Sequence[Update]]) -> Update:
        """Return one call that runs the shares in parallel, each in order; it ends when all are done."""
        own, others = shares[0], shares[1:]
        submit = self.pool.submit

        def update(dt: float) -> None:
            waiting = [submit(_run, share, dt) for share in others]
            try:
                _run(own, dt)
            finally:
                for other in waiting:
                    other.exception()  # wait while a share still writes
            for other in waiting:
                other.result()

        return update


def _run(share: Sequence[Update], dt: float) -> None:
    for update in share:
        update(dt)
