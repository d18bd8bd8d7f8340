"""What every effect of a dozen scenes costs, and what it changes in the answer.

    python benchmarks/studies/effect_costs.py                # all scenes, rows to effect_costs.csv; some 10 CPU minutes
    python benchmarks/studies/effect_costs.py dropped-block  # rows of this scene anew

Each scene is a `contactlab compare SCENE --effects` of its own, one run at a time.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import kept_rows
from kept_rows import Row

from contactlab.reports.numbers import percent

HERE = Path(__file__).parent
STORED, SOURCE = HERE / "effect_costs.csv", HERE / "effect_costs.md"
COULOMB = 'contacts.0.friction={use="coulomb", mu=0.2}'
SOFT = (
    'materials.soft={use="linear-hardening", young=7000, poisson=0.3, density=2.7e-9, yield_stress=300, hardening=500}'
)
SCENES: dict[str, tuple[str, ...]] = {
    "disc-on-block": ("level=1",),
    "disc-on-block, friction": ("level=1", COULOMB),
    "disc-on-block, friction, statics": ("level=2", COULOMB, "integrator=newton"),
    "disc-on-block, plastic, statics": ("level=1", SOFT, "integrator=newton"),
    "tresca-block": (),
    "block-on-incline": (),
    "two-bars": (),
    "bouncing-bar": (),
    "dropped-block": (),
    "spinning-pair": (),
    "vertex-to-vertex": (),
    "initial-overlap": (),
    "corner-slide": (),
}
KEYS = (
    "scene",
    "effect",
    "declared",
    "run_s",
    "share",
    "step_us",
    "memory_mib",
    "reaction",
    "pressure",
    "energy",
    "ended",
)
DEAR, NOTHING = 0.1, 1e-3
"""Of the CPU time of the run; of the answer."""
CHEAP, MUCH = 0.05, 0.1


def measure(scene: str) -> list[Row]:
    """The rows of one scene."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "contactlab", "compare", scene.partition(",")[0], "--effects", "--json"]
        words += ["--jobs", "1", "--keep", "none", "--out", str(Path(folder) / "out")]
        words += [word for setting in SCENES[scene] for word in ("--set", setting)]
        told = subprocess.run(words, text=True, capture_output=True)
    if told.returncode == 2:
        raise SystemExit(f"{scene}: {told.stderr}")
    bill = json.loads(told.stdout)["bill"]
    return [_row(scene, price, bill["run_s"]) for price in bill["prices"]]


def _row(scene: str, price: dict[str, Any], whole: float) -> Row:
    run, step = price["run_s"], price["step_s"]
    found = {
        "scene": scene, "effect": price["effect"], "declared": "yes" if price["declared"] else "no",
        "run_s": _figure(run), "share": _figure(None if run is None else run / whole),
        "step_us": _figure(None if step is None else 1e6 * step), "memory_mib": _figure(price["memory_mib"]),
        **{name: _figure(price[name]) for name in ("reaction", "pressure", "energy")},
        "ended": price["status"],
    }  # fmt: skip
    return {name: found[name] for name in KEYS}


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def stored() -> list[Row]:
    """Rows that are kept."""
    return kept_rows.read(STORED) if STORED.exists() else []


def change(row: Row) -> float | None:
    """The largest change in the answer, None where none is known."""
    known = [float(row[name]) for name in ("reaction", "pressure", "energy") if row[name]]
    return max(known, default=None)


def page(rows: list[Row]) -> str:
    """The page of these rows."""
    judged = [row for row in rows if row["share"] and change(row) is not None]
    declared = [row for row in judged if row["declared"] == "yes"]
    idle = [row for row in declared if float(row["share"]) > DEAR and change(row) < NOTHING]
    needed = [row for row in judged if float(row["share"]) < CHEAP and change(row) > MUCH]
    text = SOURCE.read_text(encoding="utf-8")
    scenes = len({row["scene"] for row in rows})
    text = text.replace("<!-- count -->", f"{len(rows)} effects of {scenes} scenes")
    text = text.replace("<!-- idle -->", "\n".join(_table(idle)) if idle else "None.")
    text = text.replace("<!-- needed -->", "\n".join(_table(needed)) if needed else "None.")
    return text.replace("<!-- rows -->", "\n".join(_table(rows)))


def _table(rows: list[Row]) -> list[str]:
    lines = ["| scene | effect | declared | CPU s | of the run | force | pressure | energy | |", "|---" * 9 + "|"]
    for row in rows:
        ended = "" if row["ended"] in ("finished", "settled") else row["ended"]
        shares = [_percent(row[name]) for name in ("share", "reaction", "pressure", "energy")]
        lines.append(f"| {' | '.join([row['scene'], row['effect'], row['declared'], row['run_s'], *shares, ended])} |")
    return lines


def _percent(text: str) -> str:
    return f"{percent(float(text))} %" if text else ""


def main() -> None:
    """Measure what is asked for and keep the rows; `make pages` shows them."""
    rows = stored()
    for scene in sys.argv[1:] or SCENES:
        rows = [row for row in rows if row["scene"] != scene] + measure(scene)
        rows.sort(key=lambda row: list(SCENES).index(row["scene"]))
        kept_rows.write(STORED, KEYS, rows)


if __name__ == "__main__":
    main()
