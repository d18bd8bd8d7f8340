"""What holds for all tests: Ctrl-C means Ctrl-C, also where the whole suite was started in the background."""

from __future__ import annotations

import signal


def pytest_configure() -> None:
    """A shell starts what it puts in the background with SIGINT ignored; tests send it to themselves and to others."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
