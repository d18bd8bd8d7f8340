"""Threads that call block updates side by side. Compiled kernels release the interpreter's lock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

Update = Callable[[float], None]


class Threads:
    """The caller's own thread and `threads` - 1 more, which live as long as this object is used."""

    def __init__(self, threads: int) -> None:
        self.pool = ThreadPoolExecutor(threads - 1, thread_name_prefix="contactlab-cells")

    def together(self, shares: Sequence[Sequence[Update]]) -> Update:
        """One call that makes those of every share in turn, the shares side by side; it ends when all are done."""
        own, others = shares[0], shares[1:]
        submit = self.pool.submit

        def update(dt: float) -> None:
            waiting = [submit(_run, share, dt) for share in others]
            try:
                _run(own, dt)
            finally:
                for other in waiting:
                    other.exception()  # nobody goes on while a share still writes
            for other in waiting:
                other.result()

        return update


def _run(share: Sequence[Update], dt: float) -> None:
    for update in share:
        update(dt)
