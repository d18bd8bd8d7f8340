"""Disc on block with Coulomb friction: what the choice of slave, of multipliers and of the loading speed changes.

    python benchmarks/studies/friction.py [page]

Level 2, mu = 0.05 and 0.2, shallow (0.01) and deep (0.1581). Rows go to friction.csv, the page to docs/friction.md;
`page` writes it anew from rows measured before.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import kept_rows
import numpy as np
from kept_rows import Row

from contactlab.model.build import build
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

HERE = Path(__file__).parent
STORED, PAGE = HERE / "friction.csv", HERE.parents[1] / "docs" / "friction.md"
MORTARS = ("mortar-p0", "mortar-p1")
LIMIT = 0.005  # by which reactions may differ
CONE = 1e-8
ROUND = 1e-9  # sticking nodes keep a slip of at most 1e-10 segments a step, of either sign
PERIODS = 15.0  # what `auto` allows any scene is 50


def press(mu: float, depth: float, algorithm: str, swap: bool, periods: float) -> Results:
    """One run, loaded in so many periods of the mode that the load excites."""
    changes: dict[str, Any] = {
        "level": 2,
        "contacts.0.algorithm": algorithm,
        "contacts.0.swap": swap,
        "contacts.0.friction": {"use": "coulomb", "mu": mu},
        "supports.1.uy": {"ramp": "parabola", "to": -depth},
        "record.frames": 20,
    }
    scene = load_scene("disc-on-block").with_(changes)
    return simulate(scene.with_({"time.ramp": periods * build(scene, scene.registry).timing.period}))


def row(results: Results, **keys: object) -> Row:
    """What is kept of a run."""
    contact = results.summary["contacts"]["contacts.0"]
    dissipated = np.asarray(results.history["energy.slip"])
    return {key: str(value) for key, value in keys.items()} | {
        "status": results.status,
        "reaction": f"{results.summary['reactions']['disc.top'][1]:.9g}",
        "cone": f"{abs(contact['cone_violation']):.3g}",
        "dissipated": f"{dissipated[-1]:.6g}",
        "least step of it": f"{np.diff(dissipated).min() / max(dissipated[-1], 1e-300):.3g}",
        "over internal energy": f"{dissipated[-1] / results.summary['balance']['internal']:.3g}",
    }


def stored() -> list[Row]:
    """Rows measured before."""
    return kept_rows.read(STORED)


def measure(mu: float, depth: float) -> list[Row]:
    """Both multipliers and both slaves, and one of them at half the speed."""
    rows = []
    for algorithm in MORTARS:
        for swap in (False, True):
            slave = "block" if swap else "disc"
            results = press(mu, depth, algorithm, swap, PERIODS)
            rows.append(row(results, mu=mu, depth=depth, algorithm=algorithm, slave=slave, speed=1))
            if not swap and algorithm == MORTARS[1]:
                slow = press(mu, depth, algorithm, swap, 2.0 * PERIODS)
                rows.append(row(slow, mu=mu, depth=depth, algorithm=algorithm, slave=slave, speed=0.5))
    print(f"mu {mu}, depth {depth}: done", file=sys.stderr, flush=True)
    return rows


def summary(rows: list[Row]) -> list[str]:
    """Table lines: one per friction and depth."""
    lines = [
        "| mu | depth | reaction [N/mm] | spread over multipliers and slaves | change at half the speed | "
        "cone violation | least dissipation between frames over internal energy | verdict |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for mu, depth in dict.fromkeys((r["mu"], r["depth"]) for r in rows):
        own = [r for r in rows if (r["mu"], r["depth"]) == (mu, depth)]
        full = np.array([float(r["reaction"]) for r in own if r["speed"] == "1"])
        slow = next(r for r in own if r["speed"] != "1")
        fast = next(r for r in own if r["speed"] == "1" and (r["algorithm"], r["slave"]) == (slow["algorithm"], "disc"))
        spread = float(np.ptp(full) / np.abs(full).mean())
        speed = abs(float(slow["reaction"]) / float(fast["reaction"]) - 1.0)
        cone, least = (
            max(float(r["cone"]) for r in own),
            min(float(r["least step of it"]) * float(r["over internal energy"]) for r in own),
        )
        finished = all(r["status"] == "finished" for r in own)
        met = finished and spread < LIMIT and speed < LIMIT and cone < CONE and least >= -ROUND
        lines.append(
            f"| {mu} | {depth} | {full.mean():.6g} | {spread:.2%} | {speed:.3%} | {cone:.1e} | {least:.1e} | "
            f"{'met' if met else '**missed**'} |"
        )
    return lines


def page(rows: list[Row]) -> str:
    """docs/friction.md."""
    text = (HERE / "friction.md").read_text()
    detail = ["| " + " | ".join(rows[0]) + " |", "|---" * len(rows[0]) + "|"]
    detail += ["| " + " | ".join(r.values()) + " |" for r in rows]
    return text.replace("<!-- summary -->", "\n".join(summary(rows))).replace("<!-- rows -->", "\n".join(detail))


def main() -> None:
    """Run everything, keep the rows, write the page."""
    if sys.argv[1:] == ["page"]:
        rows = stored()
    else:
        rows = [row for mu in (0.05, 0.2) for depth in (0.01, 0.1581) for row in measure(mu, depth)]
        kept_rows.write(STORED, list(rows[0]), rows)
    PAGE.write_text(page(rows))


if __name__ == "__main__":
    main()
