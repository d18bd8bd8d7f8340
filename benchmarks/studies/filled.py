"""Numbers in pages: what stands between `<!-- NAME -->` and `<!-- end of numbers -->` is written by a program."""

from __future__ import annotations

from pathlib import Path

END = "<!-- end of numbers -->"
"""Each name has its own, which follows it."""


def filled(page: Path, **parts: str) -> str:
    """Text of the page with each part behind its mark, in place of what was there. Raises ValueError without a mark."""
    text = page.read_text(encoding="utf-8")
    for name, part in parts.items():
        head, rest = text.split(f"<!-- {name} -->\n")
        text = f"{head}<!-- {name} -->\n{part}\n{END}{rest.partition(END)[2]}"
    return text
