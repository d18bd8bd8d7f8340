"""The hard cases at full size, for every contact algorithm: what was measured, what must come out, the verdict.

    python benchmarks/studies/hard_cases.py [case ...]

Measured rows are kept in hard_cases.csv, those of the cases named are made anew (all without a name), and
docs/hard-cases.md is written from them and from the rows of million_steps.py. With `page` in place of cases nothing is
measured.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import process_time

import kept_rows
from kept_rows import Row

from contactlab.errors import SimulationFailure
from contactlab.testing.cases import CASES

ALGORITHMS = ("mortar-p0", "mortar-p1", "node-on-segment")
HERE = Path(__file__).parent
STORED, MILLION = HERE / "hard_cases.csv", HERE / "million_steps.csv"
PAGE = HERE.parents[1] / "docs" / "hard-cases.md"
COLUMNS = ("case", "algorithm", "measured", "value", "criterion", "verdict")


def measure(case: str) -> list[Row]:
    """All figures of a case; a run that does not come to its end is a row, too."""
    rows = []
    for algorithm in ALGORITHMS:
        began = process_time()
        try:
            found = [
                (figure.says, f"{figure.value:.4g}", figure.criterion, verdict(figure.judged, figure.met))
                for figure in CASES[case](algorithm, True)
            ]
        except SimulationFailure as failure:
            found = [("run to its end", failure.reason.replace("\n", " "), "finished", "**missed**")]
        rows += [dict(zip(COLUMNS, (case, algorithm, *row), strict=True)) for row in found]
        print(f"{case}, {algorithm}: {process_time() - began:.0f} s of CPU", file=sys.stderr, flush=True)
    return rows


def verdict(judged: bool, met: bool) -> str:
    """One word."""
    return "" if not judged else "met" if met else "**missed**"


def stored() -> list[Row]:
    """Rows measured before."""
    return kept_rows.read(STORED)


def case_table(rows: list[Row]) -> list[str]:
    """One line per figure, the algorithms side by side; verdicts stand beside the numbers that miss."""
    named = {(row["algorithm"], row["measured"]): row for row in rows}
    lines = [
        "| measured | criterion | " + " | ".join(ALGORITHMS) + " |",
        "|---|---" * 1 + "|---" * len(ALGORITHMS) + "|",
    ]
    for says, criterion in dict.fromkeys((row["measured"], row["criterion"]) for row in rows):
        cells = []
        for algorithm in ALGORITHMS:
            row = named.get((algorithm, says))
            missed = row is not None and row["verdict"].startswith("**")
            cells.append("" if row is None else f"**{row['value']}** missed" if missed else row["value"])
        lines.append(f"| {says} | {criterion} | " + " | ".join(cells) + " |")
    return lines


def million_table(rows: list[Row]) -> list[str]:
    """One line per quantity, the algorithms side by side."""
    if not rows:
        return ["Not run yet."]
    lines = [
        "| | " + " | ".join(f"{row['cells']}, {row['algorithm']}" for row in rows) + " |",
        "|---" * (len(rows) + 1) + "|",
    ]
    return lines + [
        f"| {key} | " + " | ".join(row[key] for row in rows) + " |"
        for key in rows[0]
        if key not in ("cells", "algorithm")
    ]


def page(rows: list[Row]) -> str:
    """docs/hard-cases.md."""
    text = (HERE / "hard_cases.md").read_text()
    for case in CASES:
        text = text.replace(f"<!-- {case} -->", "\n".join(case_table([row for row in rows if row["case"] == case])))
    missed = sum(row["verdict"].startswith("**") for row in rows)
    judged = sum(bool(row["verdict"]) for row in rows)
    counts = [
        f"{name} {sum(r['algorithm'] == name and r['verdict'] == 'met' for r in rows)} of "
        f"{sum(r['algorithm'] == name and bool(r['verdict']) for r in rows)}"
        for name in ALGORITHMS
    ]
    text = text.replace("<!-- counts -->", f"Criteria met: {', '.join(counts)} ({judged - missed} of {judged} in all).")
    return text.replace("<!-- million steps -->", "\n".join(million_table(kept_rows.read(MILLION))))


def main(cases: list[str]) -> None:
    """Measure the named cases, keep the others, write the page."""
    unknown = [case for case in cases if case not in (*CASES, "page")]
    if unknown:
        sys.exit(f"no case {unknown[0]!r}; there are: {', '.join(CASES)}")
    rows = stored()
    for case in [] if cases == ["page"] else cases or list(CASES):
        rows = [row for row in rows if row["case"] != case] + measure(case)
        rows.sort(key=lambda row: list(CASES).index(row["case"]))
        kept_rows.write(STORED, COLUMNS, rows)
    PAGE.write_text(page(rows))


if __name__ == "__main__":
    main(sys.argv[1:])
