"""The first table of the page: CPU seconds to each target, a row per contender and a column per case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from contactlab.accuracy.run import Accuracy
from contactlab.accuracy.targets import Cost, best_of, shown
from contactlab.accuracy.winners import Winner, told
from contactlab.reports.accuracy_plots import Look, looks
from contactlab.reports.html import section
from contactlab.reports.numbers import percent

_MARKS = {"cheapest": "\N{BLACK STAR} ", "tied": "\N{ALMOST EQUAL TO} "}
_USUAL = 0.01

_TEXT = (
    "<p>CPU seconds of the cheapest run of each contender that keeps the target, with the better of its slaves. "
    "\N{BLACK STAR} is the cheapest, \N{ALMOST EQUAL TO} are those that cannot be told "
    "from it: their intervals overlap. \N{LESS-THAN OR EQUAL TO}: the coarsest mesh is already that good. "
    "\N{HORIZONTAL ELLIPSIS}: below three times what the reference is known to. \N{MIDDLE DOT}: the case is not made "
    "for it. Hover for intervals and reasons.</p>"
)
_WINNERS = (
    "<p>The method that keeps an error at the least cost: the median CPU time of the steps of a mesh that was run. "
    "Methods tie where intervals of repeated runs, and of what the reference is known to, overlap. "
    "\N{LESS-THAN OR EQUAL TO}: the coarsest mesh is already that good. Empty: not asked.</p>"
)
_FILTER = (
    '<input class="filter" data-table="targets" type="search" placeholder="words that a contender must have" '
    'aria-label="filter the contenders">'
)


def winners_section(found: Accuracy, winners: Sequence[Winner]) -> str:
    """A row per case, a column per target: who wins at what cost, and by how much the next is dearer."""
    chosen = looks(found)
    cells = {(winner.case, winner.target): winner for winner in winners}
    heads = "".join(f'<th scope="col" class="text">{percent(target, 1)} %</th>' for target in found.targets)
    rows = "".join(
        f'<tr><th scope="row">{escape(asked.label)}</th>'
        + "".join(_winner(cells.get((asked.label, target)), chosen) for target in found.targets)
        + "</tr>\n"
        for asked in found.asked
    )
    table = f'<table class="costs winners"><thead><tr><th>case</th>{heads}</tr></thead><tbody>{rows}</tbody></table>'
    return section("Who wins", f'{_WINNERS}<div class="scroll">{table}</div>')


def _winner(winner: Winner | None, chosen: Mapping[str, Look]) -> str:
    if winner is None:
        return "<td></td>"
    who, cost, after = map(escape, told(winner))
    if not winner.group:
        return f'<td class="text {winner.kind}">{who}</td>'
    colours = dict.fromkeys(chosen[name].colour for name in winner.group)
    marks = "".join(f'<i style="background:{colour}"></i>' for colour in colours)
    kind = "cheapest" if len(winner.group) == 1 else "tied"
    says = f"{winner.low:.2g} to {winner.high:.2g} s, slave {winner.slave}"
    return f'<td class="text" title="{says}">{marks}<b class="{kind}">{who}</b><br>{cost}<br>{after}</td>'


def costs_section(found: Accuracy, costs: Sequence[Cost]) -> str:
    """A table per target, one of them shown, all of them printed."""
    targets = found.targets
    best = best_of(costs)
    first = _USUAL if _USUAL in targets else targets[0]
    parts, rules = [], []
    for number, target in enumerate(targets):
        checked = " checked" if target == first else ""
        parts.append(
            f'<input type="radio" name="target" id="target-{number}"{checked}>'
            f'<label class="tab" for="target-{number}">{percent(target, 1)} %</label>'
        )
        rules.append(f"#target-{number}:checked ~ .t{number} {{ display: block; }}")
    for number, target in enumerate(targets):
        parts.append(f'<div class="target t{number}">{_table(found, best, target)}</div>')
    style = f"<style>{' '.join(rules)}</style>"
    return section(
        "CPU seconds to an accuracy", f'{_TEXT}{style}{_FILTER}<div class="targets" id="targets">{"".join(parts)}</div>'
    )


def _table(found: Accuracy, best: Mapping[tuple[str, str, float], Cost], target: float) -> str:
    heads = "".join(f'<th scope="col" title="{escape(a.title)}: {escape(a.measure)}">{escape(a.label)}</th>'
                    for a in found.asked)  # fmt: skip
    rows = []
    for name in found.contenders:
        cells = [best.get((asked.label, name, target)) for asked in found.asked]
        if any(cell is not None for cell in cells):
            rows.append(f'<tr><th scope="row">{escape(name)}</th>{"".join(map(_cell, cells))}</tr>')
    return (
        '<div class="scroll"><table class="costs">'
        f'<caption class="note">CPU seconds to {percent(target, 1)} %</caption>'
        f"<thead><tr><th>contender</th>{heads}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _cell(cost: Cost | None) -> str:
    if cost is None:
        return '<td class="none" title="the case is not made for it">\N{MIDDLE DOT}</td>'
    says = cost.why
    if cost.kind == "reached":
        says = f"{_span(cost)}, slave {cost.slave}" + (": the coarsest mesh is that good" if cost.coarsest else "")
    kind = cost.mark or cost.kind
    return f'<td class="{kind}" title="{escape(says)}">{_MARKS.get(cost.mark, "")}{escape(shown(cost))}</td>'


def _span(cost: Cost) -> str:
    high = f"{cost.high:.2g}" if cost.high < float("inf") else "unknown"
    return f"{cost.low:.2g} to {high} s"
