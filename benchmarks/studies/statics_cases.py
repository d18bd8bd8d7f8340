"""The page of static cases: rows of all cells of static and implicit cases (case_rows.py), and what studies add.

    python benchmarks/studies/statics_cases.py [STUDY ...]

measures a study on meshes finer than those of a matrix (all without a name), whose rows are kept in statics_cases.csv.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time

import case_rows
import kept_rows
from case_tables import counts, table
from kept_rows import Row
from statics.common import Figure, Rows
from statics.hertz import case_cgs1
from statics.ironing import case_ironing, case_ironing_converged
from statics.mindlin import case_mindlin

HERE = Path(__file__).parent
STORED, TEXT = HERE / "statics_cases.csv", HERE / "statics_cases.md"
COLUMNS = ("case", "variant", "measured", "value", "criterion", "verdict")

STUDIES: dict[str, Callable[[], Rows]] = {
    "hertz": case_cgs1, "mindlin": case_mindlin, "ironing": case_ironing, "ironing-converged": case_ironing_converged,
}  # fmt: skip
WORST_OVER = {"patch": ("variant",)}
"""Choices of which a table shows the worst."""


def row(case: str, variant: str, figure: Figure) -> Row:
    """One measured number."""
    verdict = "" if not figure.judged else "met" if figure.met else "**missed**"
    limit = figure.most if figure.least == -figure.most else None
    criterion = f"at most {limit:.4g}" if limit is not None and figure.judged else figure.criterion
    value = f"{figure.value:.0f}" if abs(figure.value) >= 1000.0 else f"{figure.value:.3g}"
    values = (case, variant, figure.says, value, criterion, verdict)
    return dict(zip(COLUMNS, values, strict=True))


def stored() -> list[Row]:
    """Rows measured before; none where there are none."""
    return kept_rows.read(STORED)


def store(case: str, found: list[Row]) -> None:
    """Rows of a case in place of its former ones, whatever other processes wrote meanwhile."""
    rows = [kept for kept in stored() if kept["case"] != case] + found
    rows.sort(key=lambda kept: list(STUDIES).index(kept["case"]))
    kept_rows.write(STORED, COLUMNS, rows)


def measure(case: str) -> None:
    """Make the rows of a case anew; they are also printed as they come."""
    began, found = process_time(), []
    for variant, figures in STUDIES[case]():
        found += [row(case, variant, figure) for figure in figures]
        print(f"{case}: {variant} | " + " | ".join(map(str, figures)), flush=True)
    store(case, found)
    print(f"{case}: {process_time() - began:.0f} s of CPU", file=sys.stderr, flush=True)


def study_table(rows: list[Row]) -> list[str]:
    """One line per variant, one column per measured number; what misses its criterion is bold."""
    if not rows:
        return ["Not run yet."]
    heads = {kept["measured"]: kept["criterion"] for kept in reversed(rows) if kept["verdict"]}
    names = list(dict.fromkeys(kept["measured"] for kept in rows))
    values = {(kept["variant"], kept["measured"]): kept for kept in rows}
    lines = [
        "| | " + " | ".join(name + (f" ({heads[name]})" if name in heads else "") for name in names) + " |",
        "|---" * (len(names) + 1) + "|",
    ]
    for variant in dict.fromkeys(kept["variant"] for kept in rows):
        found = [values.get((variant, name)) for name in names]
        cells = [
            "" if f is None else f"**{f['value']}**" if f["verdict"].startswith("**") else f["value"] for f in found
        ]
        lines.append(f"| {variant} | " + " | ".join(cells) + " |")
    return lines


def page(rows: list[Row]) -> str:
    """The page from the rows of the studies, and those of cells."""
    text, cells = TEXT.read_text(), [row for row in case_rows.stored() if row["case"] in case_rows.STATICS]
    for case in case_rows.STATICS:
        own = [row for row in cells if row["case"] == case]
        text = text.replace(f"<!-- {case} -->", "\n".join(table(own, WORST_OVER.get(case, ()))))
    for study in STUDIES:
        own = [kept for kept in rows if kept["case"] == study]
        text = text.replace(f"<!-- study {study} -->", "\n".join(study_table(own)))
    return text.replace("<!-- counts -->", f"Of {counts(cells)}")


def main(cases: list[str]) -> None:
    """Measure the named studies, and keep the others."""
    unknown = [case for case in cases if case not in STUDIES]
    if unknown:
        sys.exit(f"no study {unknown[0]!r}; there are: {', '.join(STUDIES)}")
    for case in cases or list(STUDIES):
        measure(case)


if __name__ == "__main__":
    main(sys.argv[1:])
