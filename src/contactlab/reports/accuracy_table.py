"""What accuracy costs, on a terminal: a row per case and contender, a column per target."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console, Group
from rich.table import Table as RichTable
from rich.text import Text

from contactlab.accuracy.run import Accuracy
from contactlab.accuracy.targets import Cost, best_of, shown
from contactlab.accuracy.winners import Winner, told
from contactlab.reports.numbers import percent

_STYLES = {"cheapest": "bold green", "tied": "green", "failed": "red", "grey": "dim", "not-run": "dim"}
_MARKS = {"cheapest": "*", "tied": "~"}


_NOTES = (
    "* cheapest   ~ cannot be told from the cheapest   \N{LESS-THAN OR EQUAL TO} the coarsest mesh is that good   "
    "\N{HORIZONTAL ELLIPSIS} below what the reference can tell"
)


def print_costs(found: Accuracy, costs: Sequence[Cost], console: Console) -> None:
    """Print the table of costs."""
    console.print(costs_table(found, costs), soft_wrap=True)


def print_winners(found: Accuracy, winners: Sequence[Winner], console: Console) -> None:
    """Print who wins where, a line per case and target."""
    table = RichTable(box=box.SIMPLE_HEAD, pad_edge=False, title=Text("Who wins"), title_justify="left")
    for name in ("case", "error", "cheapest", "CPU time", "next"):
        table.add_column(name, overflow="fold")
    label = ""
    for winner in winners:
        who, cost, after = told(winner)
        case, label = "" if winner.case == label else winner.case, winner.case
        style = "bold green" if len(winner.group) == 1 else "green" if winner.group else "dim"
        cells = Text(case), Text(f"{percent(winner.target, 1)} %"), Text(who, style=style), Text(cost), Text(after)
        table.add_row(*cells)
    console.print(table)


def costs_table(found: Accuracy, costs: Sequence[Cost]) -> Group:
    """CPU seconds to each target, and what the marks mean."""
    best = best_of(costs)
    targets = found.targets
    title = Text(f"{found.study.name}: CPU seconds to an error of")
    table = RichTable(box=box.SIMPLE_HEAD, pad_edge=False, title=title, title_justify="left")
    for name in ("case", "contender"):
        table.add_column(name, overflow="fold")
    for target in targets:
        table.add_column(f"{percent(target, 1)} %", justify="right", no_wrap=True)
    for asked in found.asked:
        label = asked.label
        for name in found.contenders:
            cells = [best.get((asked.label, name, target)) for target in targets]
            if any(cells):
                table.add_row(Text(label), Text(name), *map(_cell, cells))
                label = ""
        table.add_section()
    return Group(table, Text(_NOTES))


def _cell(cost: Cost | None) -> Text:
    if cost is None:
        return Text("")
    return Text(f"{shown(cost)}{_MARKS.get(cost.mark, '')}", style=_STYLES.get(cost.mark or cost.kind, ""))
