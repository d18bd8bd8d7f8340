"""Cost and influence of the effects of a scene: cells of the table, and the table on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from contactlab.reports.numbers import percent, significant
from contactlab.reports.sheet import Column, Sheet, numbers
from contactlab.studies.cost_breakdown import CostBreakdown, EffectCost

HEADS: tuple[Column | str, ...] = (
    "effect", "in the scene",
    *numbers("CPU per step, µs", "share of a step, %", "CPU in the run, s", "arrays, MiB", "force, %", "pressure, %",
             "energy, %"),
    "the other run",
)  # fmt: skip


def by_cost(breakdown: CostBreakdown) -> list[EffectCost]:
    """The dearest effect first, what is not known last."""
    return sorted(breakdown.effects, key=lambda cost: -cost.run_s if cost.run_s == cost.run_s else float("inf"))


def effects_sheet(breakdown: CostBreakdown, title: str = "") -> Sheet:
    """A row per effect."""
    return Sheet(HEADS, (_cells(cost, breakdown) for cost in by_cost(breakdown)), title)


def _cells(cost: EffectCost, breakdown: CostBreakdown) -> tuple[str, ...]:
    return (
        cost.effect,
        "yes" if cost.declared else "no",
        significant(1e6 * cost.step_s, 3),
        percent(cost.step_s / breakdown.step_s, 2) if breakdown.step_s > 0.0 else significant(float("nan")),
        significant(cost.run_s, 2),
        significant(cost.memory_mib, 2),
        percent(cost.reaction, 2),
        percent(cost.pressure, 2),
        percent(cost.energy, 2),
        cost.status if cost.declared else f"with it: {cost.status}",
    )


def reasons(effects: Sequence[EffectCost]) -> list[str]:
    """Say why runs did not come to their end."""
    return [f"{'without' if p.declared else 'with'} {p.effect}: {p.status}: {p.reason}" for p in effects if p.reason]


def sentence(breakdown: CostBreakdown) -> str:
    """Return the cost of the scene, and which effects can be switched off."""
    text = (
        f"As declared: {significant(1e6 * breakdown.step_s, 3)} µs of CPU time per step, "
        f"{significant(breakdown.run_s, 3)} s in {breakdown.steps:.0f} steps, "
        f"{significant(breakdown.memory_mib, 3)} MiB of arrays."
    )
    spare = [p for p in breakdown.effects if p.declared and p.run_s > 0.02 * breakdown.run_s and p.error < 0.001]
    if spare:
        names = ", ".join(p.effect for p in spare)
        text += f" Can be switched off (the answer changes by less than 0.1 %): {names}."
    return text


def render_breakdown(breakdown: CostBreakdown, title: str) -> RenderableType:
    """The table of all effects, with sentences and reasons of failures below it."""
    ended = [] if breakdown.status == "finished" else [f"the scene itself: {breakdown.status}: {breakdown.reason}"]
    notes = [Text(text, style="yellow") for text in (*ended, *reasons(breakdown.effects))]
    sheet = effects_sheet(breakdown, title)
    return Group(sheet, Text(sentence(breakdown)), Text(EXPLANATION, style="dim"), *notes)


EXPLANATION = (
    "The cost of an effect is the run with it minus the run without it; force, pressure and energy are the changes of "
    "the answer without it, relative to the run that has it. Negative costs: the run is slower without it."
)
