"""Tables of docs/accuracy.md between its marks: who wins where, and who solves how much; the rows are kept here."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from itertools import groupby
from pathlib import Path

from filled import filled

from contactlab.jobs.rows import Row, read_csv

HERE = Path(__file__).parent
PAGE, STUDY = HERE.parents[1] / "docs" / "accuracy.md", HERE / "accuracy"
TIMES = (0.3, 1.0, 3.0, 10.0, 30.0)


def keep(folder: Path) -> None:
    """Take the rows, the picture and the state of a study."""
    STUDY.mkdir(exist_ok=True)
    for name in ("winners.csv", "solved.csv"):
        shutil.copyfile(folder / name, STUDY / name)
    found = json.loads((folder / "accuracy.json").read_text(encoding="utf-8"))
    counts = Counter(row["status"] for row in read_csv(folder / "accuracy.csv"))
    state = {name: found[name] for name in ("date", "commit", "system")} | {"statuses": counts}
    state |= {"cases": len(found["cases"]), "contenders": len(found["contenders"])}
    (STUDY / "state.json").write_text(json.dumps(state, indent=1) + "\n", encoding="utf-8")


def page() -> str:
    """docs/accuracy.md with its tables put in."""
    return filled(PAGE, state=_state(), winners=_winners(read_csv(STUDY / "winners.csv")),
                  solved=_solved(read_csv(STUDY / "solved.csv")))  # fmt: skip


def _state() -> str:
    found = json.loads((STUDY / "state.json").read_text(encoding="utf-8"))
    counts = Counter(found["statuses"])
    told = ", ".join(f"{number} {status or 'not run yet'}" for status, number in counts.most_common())
    return (
        f"{found['date']}, commit {found['commit']}: {sum(counts.values())} points of {found['cases']} cases and "
        f"{found['contenders']} contenders:\n{told}."
    )


def _winners(rows: list[Row]) -> str:
    targets = list(dict.fromkeys(row["target"] for row in rows))
    heads = ["case", *(f"{100 * float(target):g} %" for target in targets)]
    table = [_line(heads), _line(["---"] * len(heads))]
    for case, group in groupby(rows, key=lambda row: row["case"]):
        cells = {row["target"]: _cell(row) for row in group}
        table.append(_line([case, *(cells.get(target, "") for target in targets)]))
    return "\n".join(table)


def _cell(row: Row) -> str:
    names = row["group"].split("; ") if row["group"] else []
    if not names:
        return {"not-reached": "nobody", "not-run": "not run yet"}.get(row["kind"], row["kind"])
    least = "\N{LESS-THAN OR EQUAL TO} " if row["coarsest"] == "True" else ""
    after = f"; next {float(row['factor']):.2g} times" if row["factor"] else ""
    return f"{names[0]}: {least}{float(row['cost']):.2g}" + (f" + {len(names) - 1}" if names[1:] else "") + after


def _solved(rows: list[Row]) -> str:
    """A row per contender that solves a tenth, the best first."""
    table = []
    for name, group in groupby(rows, key=lambda row: row["contender"]):
        own = list(group)
        asked, put = int(own[0]["asked"]), int(own[0]["put"])
        shares = [sum(float(row["cpu_s"]) <= most for row in own) / asked for most in TIMES]
        if shares[-1] >= 0.1:
            table.append((shares, [name, *(f"{100 * share:.0f} %" for share in shares), f"{put} of {asked}"]))
    heads = ["contender", *(f"{most:g} s" for most in TIMES), "asked"]
    table.sort(key=lambda row: (-row[0][-1], [-share for share in row[0]]))
    return "\n".join([_line(heads), _line(["---"] * len(heads)), *(_line(cells) for _, cells in table)])


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"
