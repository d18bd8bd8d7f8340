"""What the effects of a scene cost and change: cells of the table, and the table on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console, Group, RenderableType
from rich.table import Table as RichTable
from rich.text import Text

from contactlab.reports.numbers import percent, significant
from contactlab.studies.bill import Bill, Price
from contactlab.studies.table import COMPLETE, Table

HEADS = (
    "effect", "in the scene", "CPU per step, µs", "share of a step, %", "CPU in the run, s", "arrays, MiB",
    "force, %", "pressure, %", "energy, %", "the other run",
)  # fmt: skip
"""Columns of the table; the first two and the last are words."""


def by_cost(bill: Bill) -> list[Price]:
    """The dearest effect first, what is not known last."""
    return sorted(bill.prices, key=lambda price: -price.run_s if price.run_s == price.run_s else float("inf"))


def cells(price: Price, bill: Bill) -> tuple[str, ...]:
    """One row as texts."""
    return (
        price.effect,
        "yes" if price.declared else "no",
        significant(1e6 * price.step_s, 3),
        percent(price.step_s / bill.step_s, 2) if bill.step_s > 0.0 else significant(float("nan")),
        significant(price.run_s, 2),
        significant(price.memory_mib, 2),
        percent(price.reaction, 2),
        percent(price.pressure, 2),
        percent(price.energy, 2),
        price.status if price.declared else f"with it: {price.status}",
    )


def reasons(prices: Sequence[Price]) -> list[str]:
    """Why runs did not come to their end."""
    return [f"{'without' if p.declared else 'with'} {p.effect}: {p.status}: {p.reason}" for p in prices if p.reason]


def sentence(bill: Bill) -> str:
    """What the scene costs, and what of it buys least."""
    text = f"As declared: {significant(1e6 * bill.step_s, 3)} µs of CPU time per step, {significant(bill.run_s, 3)} s "
    text += f"in {bill.steps:.0f} steps, {significant(bill.memory_mib, 3)} MiB of arrays."
    spare = [p for p in bill.prices if p.declared and p.run_s > 0.02 * bill.run_s and p.error < 0.001]
    if spare:
        names = ", ".join(p.effect for p in spare)
        text += f" Of these the answer would not miss (under 0.1 %): {names}."
    return text


def print_bill(table: Table, console: Console) -> None:
    """Print the bill of a table that has one."""
    assert table.bill is not None
    console.print(render_bill(table.bill, table.study.name))


def render_bill(bill: Bill, title: str) -> RenderableType:
    """The table, and what needs words below it."""
    drawn = RichTable(box=box.SIMPLE_HEAD, title=title, title_justify="left", pad_edge=False)
    for number, head in enumerate(HEADS):
        drawn.add_column(head, justify="left" if number in (0, 1, len(HEADS) - 1) else "right")
    for price in by_cost(bill):
        drawn.add_row(*(Text(cell) for cell in cells(price, bill)))
    ended = [] if bill.status in COMPLETE else [f"the scene itself: {bill.status}: {bill.reason}"]
    notes = [Text(text, style="yellow") for text in (*ended, *reasons(bill.prices))]
    return Group(drawn, Text(sentence(bill)), Text(EXPLANATION, style="dim"), *notes)


EXPLANATION = (
    "What an effect costs is the run with it less the run without it; force, pressure and energy tell how far leaving "
    "it out changes the answer, relative to the run that has it. Negative costs: the run is slower without it."
)
