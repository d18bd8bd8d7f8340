"""What holds for all tests: Ctrl-C means Ctrl-C, also in the background, and garbage is looked for less often."""

from __future__ import annotations

import gc
import signal

import pytest


def pytest_configure() -> None:
    """A shell starts what it puts in the background with SIGINT ignored; tests send it to themselves and to others."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.set_threshold(100_000, 20, 20)  # as the program does: kernels that stay loaded are walked through in vain


def pytest_collection_finish() -> None:
    """What is collected, and the program, stay: no search walks through them any more."""
    gc.freeze()


def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Kernels that the tests of a file have loaded stay as well; a run looks for garbage where memory has grown."""
    if nextitem is not None and nextitem.path != item.path:
        gc.collect()
        gc.freeze()
