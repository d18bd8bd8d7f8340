"""Tables of docs/accuracy.md between its marks: who wins where, and who solves how much; the rows are kept here."""

from __future__ import annotations

import json
import re
import shutil
from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from filled import filled

from contactlab.jobs.rows import Row, read_csv, write_csv
from contactlab.reports.sheet import Sheet

HERE = Path(__file__).parent
PAGE, STUDY = HERE.parents[1] / "docs" / "accuracy.md", HERE / "accuracy"
PICTURE = HERE.parents[1] / "docs" / "pictures" / "accuracy.svg"
TIMES = (0.3, 1.0, 3.0, 10.0, 30.0)
SOLVES = 0.25  # of all questions: contenders that answer less are not listed


def keep(folder: Path) -> None:
    """Take who wins, the shares that contenders solve, the picture and the state of a study."""
    STUDY.mkdir(exist_ok=True)
    shutil.copyfile(folder / "winners.csv", STUDY / "winners.csv")
    heads = ["contender", *(f"{most:g} s" for most in TIMES), "put", "asked"]
    write_csv(STUDY / "solved.csv", heads, _shares(read_csv(folder / "solved.csv")))
    drawn = (folder / "error-against-cost.svg").read_text(encoding="utf-8")
    PICTURE.write_text(re.sub(r"(\d\.\d)\d+| +$", r"\1", drawn, flags=re.MULTILINE), encoding="utf-8")  # 0.1 points
    found = json.loads((folder / "accuracy.json").read_text(encoding="utf-8"))
    counts = Counter(row["status"] for row in read_csv(folder / "accuracy.csv"))
    state = {name: found[name] for name in ("date", "commit", "system")} | {"statuses": counts}
    state |= {"cases": len(found["cases"]), "contenders": len(found["contenders"])}
    (STUDY / "state.json").write_text(json.dumps(state, indent=1) + "\n", encoding="utf-8")


def _shares(rows: list[Row]) -> Iterator[dict[str, object]]:
    """Of each contender the share of all questions that it answers within each of `TIMES`."""
    for name, group in groupby(rows, key=lambda row: row["contender"]):
        own = list(group)
        asked = int(own[0]["asked"])
        shares = {f"{most:g} s": round(sum(float(row["cpu_s"]) <= most for row in own) / asked, 4) for most in TIMES}
        yield {"contender": name, **shares, "put": own[0]["put"], "asked": asked}


def page() -> str:
    """docs/accuracy.md with its tables put in."""
    return filled(PAGE, state=_state(), winners=_winners(read_csv(STUDY / "winners.csv")),
                  solved=_solved(read_csv(STUDY / "solved.csv")))  # fmt: skip


def _state() -> str:
    found = json.loads((STUDY / "state.json").read_text(encoding="utf-8"))
    counts = Counter(found["statuses"])
    told = ", ".join(f"{number} {status}" for status, number in counts.most_common())
    return (
        f"{found['date']}, commit {found['commit']}, {found['system']['processor']}: {sum(counts.values())} points of "
        f"{found['cases']} cases and {found['contenders']} contenders:\n{told}."
    )


def _winners(rows: list[Row]) -> str:
    """A row per case, a column per target."""
    targets = list(dict.fromkeys(row["target"] for row in rows))
    lines = []
    for case, group in groupby(rows, key=lambda row: row["case"]):
        cells = {row["target"]: _cell(row) for row in group}
        lines.append([case, *(cells.get(target, "") for target in targets)])
    return Sheet(["case", *(f"{100 * float(target):g} %" for target in targets)], lines).markdown()


def _cell(row: Row) -> str:
    names = row["group"].split("; ") if row["group"] else []
    if not names:
        return {"not-reached": "nobody", "not-run": "not run yet"}.get(row["kind"], row["kind"])
    least = "\N{LESS-THAN OR EQUAL TO} " if row["coarsest"] == "True" else ""
    after = f"; next {float(row['factor']):.2g} times" if row["factor"] else ""
    return f"{names[0]}: {least}{float(row['cost']):.2g}" + (f" + {len(names) - 1}" if names[1:] else "") + after


def _solved(rows: list[Row]) -> str:
    """A row per contender that solves `SOLVES` in the end, the best first."""
    heads = [f"{most:g} s" for most in TIMES]
    rows = [row for row in rows if float(row[heads[-1]]) >= SOLVES]
    rows.sort(key=lambda row: [-float(row[head]) for head in reversed(heads)])
    lines = []
    for row in rows:
        shares = (f"{100 * float(row[head]):.0f} %" for head in heads)
        lines.append([row["contender"], *shares, f"{row['put']} of {row['asked']}"])
    return Sheet(["contender", *heads, "asked"], lines).markdown()
