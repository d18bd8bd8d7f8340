"""Recorders: they see accepted frames and change nothing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any


class Recorder(ABC):
    """Subclasses are frozen dataclasses; what they open is handed back to them."""

    @abstractmethod
    def open(self, folder: Path, model: Any, scene: Any) -> Any:
        """Start a recording in `folder`; the returned object is given to the other calls."""

    @abstractmethod
    def record(self, recording: Any, frame: Any) -> None:
        """Take one stored frame (`contactlab.results.Frame`)."""

    @abstractmethod
    def close(self, recording: Any) -> None:
        """Finish; called once, also after a failed run."""
