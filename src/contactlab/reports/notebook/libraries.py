"""Libraries that come with the extra `notebook`: imported on use, named in an error if they are missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from contactlab.errors import RequestError


def library(name: str, use: str) -> Any:
    """The module of this name. Raises RequestError saying what to install."""
    try:
        return import_module(name)
    except ModuleNotFoundError as missing:
        raise RequestError(
            f"{use} needs the library {name}, which is not installed",
            hint=f'pip install {name}, or pip install "contactlab[notebook]" for all that notebooks use',
        ) from missing
