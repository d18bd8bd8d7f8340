"""build/docs/references.md: what scenes and cases without an exact answer are compared with (case_references.py).

The value of a question is the mean over its runs of the limit of each over its levels, with an error by the rule of
`contactlab.studies.make_reference.common_limit`, and the change by twice as many load steps on top of that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from contactlab.jobs.rows import Row, read_csv
from contactlab.reports.sheet import Sheet
from contactlab.studies.make_reference import common_limit, limit
from contactlab.studies.reference import bundled, load_reference

HERE = Path(__file__).parent
STORED, TEXT = HERE / "case_references.csv", HERE / "references.md"
RESOLUTION = {"last closed node [mm]": 0.025}
"""Of a quantity at level 1, to which it cannot be known better however little it changes: a length of a segment."""
Cells = tuple[object, ...]
"""A row of a table."""


@dataclass(frozen=True)
class Found:
    """A quantity of a question.

    finest    level of the runs in the mean
    own       value and error of each run's own limit, by its name; `others` are runs that end at coarser levels
    by_level  value and error with nothing finer than a level
    """

    question: str
    quantity: str
    value: float
    error: float
    steps: float
    finest: int
    own: Mapping[str, tuple[float, float]]
    others: Mapping[str, tuple[float, float]]
    by_level: Mapping[int, tuple[float, float]]
    minutes: float
    failed: Sequence[str]


def stored() -> list[Row]:
    """Rows of all runs."""
    return read_csv(STORED)


def found(rows: Sequence[Row]) -> list[Found]:
    """Every quantity that runs at two levels or more have."""
    questions = {(row["question"], row["quantity"]): None for row in rows if row["quantity"]}
    return [one for key in questions if (one := _found(rows, *key)) is not None]


def _found(rows: Sequence[Row], question: str, quantity: str) -> Found | None:
    asked = [row for row in rows if row["question"] == question]
    own = [row for row in asked if row["quantity"] == quantity]
    numbers = sorted({int(row["steps"] or 0) for row in own})
    runs = _runs(own, numbers[0])
    ladders = {name: run for name, run in runs.items() if len(run) > 1}
    if not ladders:
        return None
    last = [max(run) for run in ladders.values()]
    finest = max(
        (level for level in last if last.count(level) > 1), default=max(last)
    )  # one run would vouch for itself
    kept = {name: run for name, run in ladders.items() if max(run) == finest}
    others = {name: _limit(run) for name, run in ladders.items() if name not in kept}
    value, error = _known(quantity, list(kept.values()))
    error = max(error, *(abs(its - value) - own for its, own in others.values())) if others else error
    more = _runs(own, numbers[-1]) if len(numbers) > 1 else {}
    changes = [abs(run[level] - runs[name][level]) for name, run in more.items() for level in run]
    steps = max(changes, default=0.0)
    by_level = {}
    for level in sorted({level for run in kept.values() for level in run})[1:-1]:
        by_level[level] = _known(quantity, [{k: v for k, v in run.items() if k <= level} for run in kept.values()])
    costs = {tuple(row[k] for k in ("algorithm", "slave", "element", "steps", "level")): row["cpu_s"] for row in asked}
    failed = [f"{_name(row)} at level {row['level']}: {row['status']}" for row in asked if not row["quantity"]]
    return Found(
        question, quantity, value, error + steps, steps, finest, {name: _limit(run) for name, run in kept.items()},
        others, by_level,
        sum(map(float, costs.values())) / 60.0, failed,
    )  # fmt: skip


def _known(quantity: str, runs: Sequence[Mapping[int, float]]) -> tuple[float, float]:
    value, error = common_limit(runs)
    return value, max(error, RESOLUTION.get(quantity, 0.0) / max(max(run) for run in runs))


def _runs(rows: Sequence[Row], steps: int) -> dict[str, dict[int, float]]:
    runs: dict[str, dict[int, float]] = {}
    for row in rows:
        if int(row["steps"] or 0) == steps:
            runs.setdefault(_name(row), {})[int(row["level"])] = float(row["value"])
    return runs


def _name(row: Row) -> str:
    slave = " exchanged" if row["slave"] == "exchanged" else ""
    return f"{row['algorithm']} {row['element']}{slave}"


def _limit(run: Mapping[int, float]) -> tuple[float, float]:
    return limit([run[level] for level in sorted(run)], sorted(run))


# --- the page ---------------------------------------------------------------------------------------------


def curves() -> Iterator[Cells]:
    """Bundled references: pressures and reactions."""
    for name in bundled():
        one = load_reference(name)
        force = one.scalars["reaction"]
        level = one.level or "another code"
        yield f"`{name}`", level, f"{one.pressure_uncertainty:.2%}", f"{force['value']:.6g} +- {force['error']:.2g}"


def values(rows: Sequence[Row]) -> Iterator[Cells]:
    """One line for each quantity."""
    last = ""
    for one in found(rows):
        minutes = "" if one.question == last else f"{one.minutes:.1f}"
        steps = f"{one.steps / abs(one.value):.2%}" if one.steps else ""
        who = f"{len(one.own)} at level {one.finest}"
        known = f"{one.error / abs(one.value):.2%}"
        yield one.question, one.quantity, f"{one.value:.5g}", known, steps, who, minutes
        last = one.question


def contributors(rows: Sequence[Row]) -> Iterator[Cells]:
    """The limit of each run, and of those that are not in the mean as they end earlier."""
    for one in found(rows):
        for name, (value, error) in {**one.own, **one.others}.items():
            beside = " (beside the mean: its finest level is coarser)" if name in one.others else ""
            off = f"{value / one.value - 1.0:+.2%}"
            yield one.question, one.quantity, f"{name}{beside}", f"{value:.5g} +- {error:.2g}", off


def tried(rows: Sequence[Row]) -> Iterator[Cells]:
    """The rule with coarser levels alone, against the value with all."""
    for one in found(rows):
        for level, (value, error) in one.by_level.items():
            off = abs(value - one.value)
            shares = f"{error / abs(one.value):.2%}", f"{off / abs(one.value):.2%}"
            yield one.question, one.quantity, level, *shares, "yes" if off <= error else "**no**"


def failures(rows: Sequence[Row]) -> list[str]:
    """Runs that did not come to their end."""
    return sorted({f"- {one.question}: {text}" for one in found(rows) for text in one.failed}) or ["- none"]


HEADS = {
    "curves": ("reference", "of runs at level", "pressure known to (L2)", "reaction [N/mm]"),
    "values": (
        "case", "quantity", "value", "known to", "of it by load steps", "contributors at the finest level", "CPU min"
    ),
    "contributors": ("case", "quantity", "run", "its own limit", "off the value"),
    "tried": ("case", "quantity", "finest level", "error by the rule", "distance from the value", "held"),
}  # fmt: skip


def page(rows: Sequence[Row]) -> str:
    """The page of these rows."""
    tables = {"curves": curves(), "values": values(rows), "contributors": contributors(rows), "tried": tried(rows)}
    parts = {name: Sheet(HEADS[name], lines).markdown() for name, lines in tables.items()}
    text = TEXT.read_text(encoding="utf-8")
    for name, part in (parts | {"failures": "\n".join(failures(rows))}).items():
        text = text.replace(f"<!-- {name} -->", part)
    return text
