"""build/docs/friction.md from rows of all cells of the case `disc-with-friction` (case_rows.py): `make pages`."""

from __future__ import annotations

from pathlib import Path

import case_rows
import numpy as np
from case_tables import counts, table
from kept_rows import Row

HERE = Path(__file__).parent
FORCE, SPEED = "reaction in the end", "reaction at half the speed, less one"
CONE, WORK = (
    "force beyond the cone over the largest pressure",
    "least work of friction between frames over internal energy",
)
HEAD = (
    "variant", "reaction of mortars [N/mm]", "spread over multipliers and slaves", "of nodes on segments",
    "largest change at half the speed", "largest violation of the cone", "least work of friction over internal energy",
)  # fmt: skip


def stored() -> list[Row]:
    """Rows of all cells of the case."""
    return [row for row in case_rows.stored() if row["case"] in case_rows.FRICTION]


def summary(rows: list[Row]) -> list[str]:
    """One line per friction and depth: how much slaves, multipliers and speeds differ."""
    lines = [f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|"]
    for variant in dict.fromkeys(row["variant"] for row in rows):
        own = [row for row in rows if row["variant"] == variant]
        mortars = _values(own, FORCE, nodes=False)
        spreads = [f"{np.ptp(v) / v.mean():.2%}" for v in (mortars, _values(own, FORCE, nodes=True))]
        speed, cone = (np.abs(_values(own, name)).max() for name in (SPEED, CONE))
        least = f"{_values(own, WORK).min():.1e}"
        numbers = (f"{mortars.mean():.6g}", *spreads, f"{speed:.3%}", f"{cone:.1e}", least)
        lines.append(f"| {' | '.join((variant or 'default', *numbers))} |")
    return lines


def _values(rows: list[Row], measure: str, nodes: bool | None = None) -> np.ndarray:
    """Values of a measure: of mortars, of nodes on segments, or of all."""
    own = [r for r in rows if r["measure"] == measure and nodes in (None, r["contact"] == "node-on-segment")]
    return np.array([float(row["value"]) for row in own])


def page(rows: list[Row]) -> str:
    """The page of these rows."""
    text = (HERE / "friction.md").read_text()
    if not rows:
        return text
    parts = {"counts": f"Of {counts(rows)}", "summary": "\n".join(summary(rows)), "rows": "\n".join(table(rows))}
    for name, part in parts.items():
        text = text.replace(f"<!-- {name} -->", part)
    return text
