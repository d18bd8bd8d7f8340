"""Formulas of the pages as MathML, which browsers draw themselves: nothing is fetched, and no script runs."""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert

MARKED = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(content: str, **given: Any) -> str:
    """Called by MkDocs: TeX that pymdownx.arithmatex has marked in a page's HTML becomes MathML."""
    return MARKED.sub(_formula, content)


def _formula(found: re.Match[str]) -> str:
    kind = "block" if found[1] == "div" else "inline"
    tex = re.sub(r"\\tfrac\s*(\d)\s*(\d)", r"\\tfrac{\1}{\2}", html.unescape(found[2]))  # \tfrac12
    made = convert(tex, display=kind)
    if "\\" in made:  # the converter writes what it does not know as it is
        raise ValueError(f"a formula has a command that is not known: {tex}")
    return f'<{found[1]} class="formula">{made}</{found[1]}>'
