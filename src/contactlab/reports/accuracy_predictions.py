"""How well cost and error of the finest mesh are predicted by the coarser ones, as a section of the page."""

from __future__ import annotations

from collections.abc import Sequence

from contactlab.accuracy.error_model import CHANCE
from contactlab.accuracy.predictions import COST_OFF, WIDE, Prediction
from contactlab.reports.html import plain_table, section
from contactlab.reports.numbers import percent, significant

_TEXT = (
    "<p>The finest point of each line, predicted from coarser meshes only: the cost as start + counted work x unit "
    "cost (shared by the lines of a case), the error as C h<sup>q</sup> (the order near that of the "
    f"case) with an interval that should hold {CHANCE:.0%} of them.</p>"
)


def told(predictions: Sequence[Prediction]) -> str:
    """One sentence with the shares of what was predicted right; empty without predictions."""
    if not predictions:
        return ""
    near = sum(abs(one.cost_off) <= COST_OFF for one in predictions)
    errors = [one for one in predictions if one.tells_error]
    within, wide = sum(one.is_within for one in errors), sum(one.is_wide for one in errors)
    return (
        f"{near} of {len(predictions)} costs within {COST_OFF:.0%}; "
        f"{within} of {len(errors)} errors in their interval, of which {wide} are wider than a factor of {WIDE:g}."
    )


def predictions_section(predictions: Sequence[Prediction]) -> str:
    """The shares, and every misprediction; empty without predictions."""
    if not predictions:
        return ""
    off = [one for one in predictions if one.is_off]
    heads = (
        "case",
        "contender",
        "slave",
        "from levels",
        "level",
        "cost, s",
        "predicted",
        "error, %",
        "predicted",
        "interval",
    )
    rows = (
        (one.case, one.contender, one.slave, " ".join(map(str, one.levels)), str(one.level), significant(one.cost, 2),
         significant(one.predicted_cost, 2), percent(one.error),
         percent(one.predicted_error) if one.tells_error else "",
         f"{percent(one.low)} to {percent(one.high)}" if one.tells_error else "")
        for one in off
    )  # fmt: skip
    table = plain_table(heads, rows, texts=4)
    listed = f"<details><summary>{len(off)} mispredictions</summary>{table}</details>" if off else ""
    return section("Predicted from coarser meshes", f"{_TEXT}<p>{told(predictions)}</p>{listed}")
