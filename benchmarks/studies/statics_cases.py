"""Static and implicit scenes with exact or published answers: what was measured, what must come out, the verdict.

    python benchmarks/studies/statics_cases.py [CASE ...]

Measured rows are kept in statics_cases.csv, those of the cases named are made anew (all without a name), and
docs/statics-cases.md is written from them. With `page` in place of cases nothing is measured.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time

import kept_rows
from kept_rows import Row
from statics.bars import case_bars, case_beams, case_bouncing, case_rest
from statics.common import Figure, Rows
from statics.hertz import case_cgs1, case_contrast, case_incompressible, case_mesh_ratio
from statics.ironing import case_ironing, case_ironing_converged
from statics.mindlin import case_mindlin
from statics.patches import case_patch, case_patch_ratio
from statics.plates import case_high_friction, case_plate, case_pulled_block, case_tresca
from statics.punches import case_elastic_punch, case_rigid_punch

HERE = Path(__file__).parent
STORED, TEXT = HERE / "statics_cases.csv", HERE / "statics_cases.md"
PAGE = HERE.parents[1] / "docs" / "statics-cases.md"
COLUMNS = ("case", "variant", "measured", "value", "criterion", "verdict")

CASES: dict[str, Callable[[], Rows]] = {
    "patch": case_patch,
    "patch-ratio": case_patch_ratio,
    "tresca": case_tresca,
    "hertz": case_cgs1,
    "mindlin": case_mindlin,
    "rigid-punch": case_rigid_punch,
    "elastic-punch": case_elastic_punch,
    "plate": case_plate,
    "high-friction": case_high_friction,
    "pulled-block": case_pulled_block,
    "contrast": case_contrast,
    "incompressible": case_incompressible,
    "mesh-ratio": case_mesh_ratio,
    "bar": case_bars,
    "bouncing": case_bouncing,
    "beams": case_beams,
    "rest": case_rest,
    "ironing": case_ironing,
    "ironing-converged": case_ironing_converged,
}


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
    rows.sort(key=lambda kept: list(CASES).index(kept["case"]))
    kept_rows.write(STORED, COLUMNS, rows)


def measure(case: str) -> None:
    """Make the rows of a case anew; they are also printed as they come."""
    began, found = process_time(), []
    for variant, figures in CASES[case]():
        found += [row(case, variant, figure) for figure in figures]
        print(f"{case}: {variant} | " + " | ".join(map(str, figures)), flush=True)
    store(case, found)
    print(f"{case}: {process_time() - began:.0f} s of CPU", file=sys.stderr, flush=True)


def table(rows: list[Row]) -> list[str]:
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
    """docs/statics-cases.md."""
    text = TEXT.read_text()
    for case in CASES:
        text = text.replace(f"<!-- {case} -->", "\n".join(table([kept for kept in rows if kept["case"] == case])))
    judged = [kept for kept in rows if kept["verdict"]]
    missed = sum(kept["verdict"].startswith("**") for kept in judged)
    return text.replace("<!-- counts -->", f"Of {len(judged)} judged numbers {missed} miss their criterion (bold).")


def main(cases: list[str]) -> None:
    """Measure the named cases, keep the others, write the page."""
    unknown = [case for case in cases if case not in (*CASES, "page")]
    if unknown:
        sys.exit(f"no case {unknown[0]!r}; there are: {', '.join(CASES)}")
    for case in [] if cases == ["page"] else cases or list(CASES):
        measure(case)
    PAGE.write_text(page(stored()))


if __name__ == "__main__":
    main(sys.argv[1:])
