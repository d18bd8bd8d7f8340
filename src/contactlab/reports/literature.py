"""Works that parts and scenes name by authors and year: full references, and entries for BibTeX."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

Work = Mapping[str, Any]
"""Fields of a work in the words of BibTeX, all texts but `year`; authors are separated by " and "."""


def works(texts: Iterable[str]) -> dict[str, Work]:
    """Works that texts name by authors and year ("Simo 1992, (4.2); Wriggers 2006"), in the order of their names."""
    named = [work.strip() for text in texts for work in text.split(";")]
    return {key: work for key, work in sorted(_known().items()) if any(text.startswith(key) for text in named)}


@cache
def _known() -> dict[str, Work]:
    return tomllib.loads(files("contactlab").joinpath("data/literature.toml").read_text(encoding="utf-8"))


def reference(work: Work) -> str:
    """Full reference in one line."""
    if "journal" in work:
        number = f"({work['number']})" if "number" in work else ""
        where = f"{work['journal']} {work['volume']}{number}, {work['pages']}"
    else:
        where = work["publisher"] if "publisher" in work else f"arXiv:{work['eprint']}"
    title = work["title"] + (f", {work['edition']} edition" if "edition" in work else "")
    return f"{work['author'].replace(' and ', ', ')}: {title}. {where} ({work['year']})"


def bibtex(key: str, work: Work) -> str:
    """Entry for a bibliography in UTF-8: "Alart & Curnier 1991" gets the key AlartCurnier1991."""
    kind = next((kind for field, kind in KINDS.items() if field in work), "misc")
    fields = dict(work) | ({"archiveprefix": "arXiv"} if "eprint" in work else {})
    if "pages" in fields:
        fields["pages"] = fields["pages"].replace("-", "--")
    # double braces keep capitals of titles
    fields["title"] = f"{{{fields['title']}}}"
    lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items())
    return f"@{kind}{{{re.sub(r'[^A-Za-z0-9]', '', key)},\n{lines}}}"


KINDS = {"journal": "article", "publisher": "book", "version": "software"}
"""Kind of entry by the field that tells it."""
