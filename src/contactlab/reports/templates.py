"""Templates of pages, in data/report: Jinja fills them, and escapes what is filled in."""

from __future__ import annotations

from functools import cache
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from contactlab.reports.html import ASSETS


@cache
def _environment() -> Environment:
    return Environment(loader=FileSystemLoader(ASSETS), autoescape=True, undefined=StrictUndefined, trim_blocks=True)


def filled(name: str, **values: Any) -> str:
    """The template of a name with these values."""
    return _environment().get_template(name).render(**values)
