"""Write how near pressures come to the best approximation on the same nodes into docs/accuracy.md.

contactlab compare benchmarks/studies/efficiency.toml --jobs 1 --out runs/efficiency
python benchmarks/studies/efficiency_page.py runs/efficiency
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[2] / "docs" / "accuracy.md"
BEGIN, END = "<!-- efficiency: begin -->\n", "<!-- efficiency: end -->"


def section(points: list[dict[str, Any]]) -> str:
    """A row per case and contender, efficiencies at all levels in a cell per slave."""
    levels = sorted({point["level"] for point in points})
    rows = dict.fromkeys((point["case"], point["contender"]) for point in points)
    at = f"levels {', '.join(map(str, levels))}"
    lines = [f"| case | contender | slave as declared, {at} | exchanged, {at} |", "|---|---|---|---|"]
    for case, contender in rows:
        own = [point for point in points if (point["case"], point["contender"]) == (case, contender)]
        cells = [_cell(own, slave, levels) for slave in ("declared", "exchanged")]
        if any(cells):
            lines.append(f"| {case} | {contender} | {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def _cell(points: list[dict[str, Any]], slave: str, levels: list[int]) -> str:
    found = {point["level"]: point for point in points if point["slave"] == slave}
    if not any(point["efficiency"] is not None for point in found.values()):
        return ""
    return ", ".join(_value(found.get(level)) for level in levels)


def _value(point: dict[str, Any] | None) -> str:
    if point is None:
        return "not run"
    return f"{point['efficiency']:.2g}" if point["efficiency"] is not None else str(point["status"])


def main() -> None:
    """Write the section."""
    points = json.loads((Path(sys.argv[1]) / "accuracy.json").read_text(encoding="utf-8"))["points"]
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN, 1)
    PAGE.write_text(head + BEGIN + section(points) + END + rest.split(END, 1)[1], encoding="utf-8")


if __name__ == "__main__":
    main()
