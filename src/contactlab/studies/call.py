"""A call that runs in another process, and what every pool of such processes gives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, Self

Report = Callable[[Any], None]


def _unheard(message: Any) -> None:
    """What a call reports where nobody listens."""


@dataclass(frozen=True)
class Call:
    """function(*arguments, report) in another process.

    report  is called here with what the call reports
    limit   time that the call may take [s], from when it reports `BEGUN`; None for any
    folder  what the call writes, if it writes: one of its arguments. Its files are there when the future is done.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    report: Report = _unheard
    limit: float | None = None
    folder: Path | None = None


class Pool(ABC):
    """Runs calls side by side; each may die, hang or raise without harm to the others.

    elsewhere  whether calls may run on machines that do not see the files of this one
    """

    elsewhere: ClassVar[bool]

    @abstractmethod
    def submit(self, call: Call) -> Future[Any]:
        """Begin a call as soon as a process is free. The future raises RaisedError, ProcessDiedError, TimedOutError."""

    @abstractmethod
    def stop(self) -> None:
        """Drop what has not begun and tell what runs to stop in order."""

    @abstractmethod
    def kill(self) -> None:
        """Drop what has not begun and end what runs at once."""

    def __enter__(self) -> Self:
        """The pool itself."""
        return self

    @abstractmethod
    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wait for what runs; after an exception, stop it."""
