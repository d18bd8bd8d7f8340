"""matrix.html: a heat map of all cells that filters and sorts, each leading to its numbers, runs and reason."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

from contactlab.cases.verdict import WORST
from contactlab.verdicts.files import plain_cells
from contactlab.verdicts.orders import orders
from contactlab.verdicts.run import Matrix

COLOURS = {
    "met": "#1a7f4b", "missed": "#c77700", "failed": "#b42318", "silent": "#7a0bc0", "not-judged": "#5b7083",
    "ill-posed": "#2f6f9f", "not-applicable": "#c3c9d0",
}  # fmt: skip

MEANINGS = {
    "silent": "finished, wrong, and nothing said so",
    "failed": "did not finish",
    "missed": "a number is outside of what the case allows, or a warning said so",
    "not-judged": "was stopped: more steps and iterations than the case allows",
    "ill-posed": "said that there is no answer, where there is none",
    "met": "all numbers are within what the case allows",
    "not-applicable": "was not made",
}


def write_page(matrix: Matrix, folder: Path) -> None:
    """Write the page of a matrix as one self-contained HTML file."""
    data = json.dumps(
        {
            "cells": plain_cells(matrix), "colours": COLOURS, "meanings": MEANINGS, "order": WORST,
            "orders": orders(matrix),
        },
        allow_nan=False,
    )  # fmt: skip
    place = files("contactlab") / "data" / "report"
    style = (place / "page.css").read_text(encoding="utf-8")
    page = (place / "matrix.html").read_text(encoding="utf-8")
    # "</" would end the script in which the data stand
    text = page.replace("/* style */", style).replace("/* data */", data.replace("</", "<\\/"))
    (folder / "matrix.html").write_text(text, encoding="utf-8")
