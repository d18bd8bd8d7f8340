"""Every bundled scene with each algorithm, either slave and each integrator: what a run breaks, and whether it says so.

    python benchmarks/studies/bundled_scenes.py                  # all that has no row in bundled_scenes.csv yet
    python benchmarks/studies/bundled_scenes.py --only stack     # rows with this in their names, anew: a scene,
                                                                 # an algorithm or an integrator

Each row is a `contactlab run` of its own with at most `LIMIT` CPU seconds. A run is judged by the invariants of its
`summary.json`; one that breaks an invariant beyond its limit and has no warning of that code is *silent*.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from itertools import product
from pathlib import Path
from textwrap import shorten
from typing import Any

import kept_rows

from contactlab.scene.scene import bundled_scenes, load_scene

HERE = Path(__file__).parent
STORED, SOURCE = HERE / "bundled_scenes.csv", HERE / "bundled_scenes.md"
ALGORITHMS = ("mortar-p0", "mortar-p1", "node-on-segment")
INTEGRATORS = ("central-difference", "newton", "implicit-dynamics")
LIMIT = 90  # CPU seconds of one run
KEYS = ("scene", "algorithm", "slaves", "integrator", "ended", "why", "broken", "silent")
WIDTH = 150  # letters of a reason in the table
REFUSED, LATE = "refused", "not judged"


def plan() -> Iterable[tuple[str, str, str, str]]:
    """Scene, algorithm, slaves (as declared, or exchanged) and integrator of each row."""
    return product(sorted(bundled_scenes()), ALGORITHMS, ("declared", "exchanged"), INTEGRATORS)


def settings(scene: str, algorithm: str, slaves: str, integrator: str) -> list[str]:
    """`--set` words of a row; an integrator that the scene declares keeps its fields."""
    declared = load_scene(scene)
    words = [] if declared.integrator["use"] == integrator else [f"integrator={integrator}"]
    for number, contact in enumerate(declared.contacts):
        words.append(f"contacts.{number}.algorithm={algorithm}")
        if slaves == "exchanged":
            words.append(f"contacts.{number}.swap={str(not contact.swap).lower()}")
        if contact.enforcement is not None and words and words[0].startswith("integrator="):
            words.append(f"contacts.{number}.enforcement=none")  # each integrator has its own
    return [part for word in words for part in ("--set", word)]


def measure(key: tuple[str, str, str, str]) -> dict[str, str]:
    """One row."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        words = [sys.executable, "-m", "contactlab", "run", key[0], *settings(*key), "--out", str(out)]
        words += ["--set", "record.recorders=[]"]
        told = subprocess.run(
            words,
            text=True,
            capture_output=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LIMIT,) * 2),
        )
        found = dict(zip(KEYS, (*key, "", "", "", ""), strict=True))
        if told.returncode < 0:
            return found | {"ended": LATE, "why": f"more than {LIMIT} CPU seconds"}
        if told.returncode == 2:
            return found | {"ended": REFUSED, "why": refusal(told.stderr)}
        return found | judged(json.loads((out / "summary.json").read_text()))


def refusal(text: str) -> str:
    """The first line of an error, without the name of the program."""
    return text.strip().partition("\n")[0].removeprefix("contactlab: ").partition(": ")[2]


def judged(summary: dict[str, Any]) -> dict[str, str]:
    """How the run ended, what it broke, and what of that no warning names."""
    warned = {warning["code"] for warning in summary["warnings"]}
    broken = [one for one in summary["invariants"] if one["value"] is None or one["value"] > (one["limit"] or 1e300)]
    ended = str(summary["status"])
    why = "" if ended == "finished" else str(summary["reason"]).partition(";")[0]
    silent = {one["code"] for one in broken if ended == "finished" and one["code"] not in warned}
    shown = sorted({f"{one['code']} {one['value']:.2g} ({one['limit']:.2g})" for one in broken})
    return {"ended": ended, "why": why, "broken": ", ".join(shown), "silent": ", ".join(sorted(silent))}


def stored() -> list[dict[str, str]]:
    """Rows that are kept."""
    return kept_rows.read(STORED) if STORED.exists() else []


def keep(rows: list[dict[str, str]]) -> None:
    """Write all rows in the order of the plan."""
    known = {tuple(row[key] for key in KEYS[:4]): row for row in rows}
    kept_rows.write(STORED, KEYS, (known[key] for key in plan() if key in known))


def page(rows: list[dict[str, str]]) -> str:
    """The page of bundled scenes."""
    text = SOURCE.read_text(encoding="utf-8")
    counts = Counter(row["ended"] for row in rows)
    silent = [row for row in rows if row["silent"]]
    ends = ", ".join(f"{counts[end]} {end}" for end in sorted(counts, key=lambda end: -counts[end]))
    text = text.replace("<!-- ends -->", f"{len(rows)} runs: {ends}; {len(silent)} silent")
    text = text.replace("<!-- missing -->", missing(rows))
    lines = [
        "| scene | algorithm | slaves | integrator | ended | broken invariants, with limits |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        if row["ended"] != REFUSED:
            said = row["broken"] + (f" **silent: {row['silent']}**" if row["silent"] else "")
            ended = row["ended"] + (f": {shorten(row['why'], WIDTH, placeholder=' ...')}" if row["why"] else "")
            lines.append(f"| {' | '.join(row[key] for key in KEYS[:4])} | {ended} | {said} |")
    refused: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row["ended"] == REFUSED:
            what = f"{row['algorithm']}, {row['slaves']}, {row['integrator']}"
            refused.setdefault((row["scene"], row["why"]), []).append(what)
    why = ["| scene | what | why |", "|---|---|---|"]
    for (scene, reason), what in refused.items():
        why.append(f"| {scene} | {'; '.join(what) if len(what) < 4 else f'{len(what)} of 18'} | {reason} |")
    return text.replace("<!-- rows -->", "\n".join(lines)).replace("<!-- refused -->", "\n".join(why))


def missing(rows: list[dict[str, str]]) -> str:
    """Which scenes have not been run with everything yet."""
    known = {tuple(row[key] for key in KEYS[:4]) for row in rows}
    open_rows = Counter(key[0] for key in plan() if key not in known)
    told = ", ".join(f"{scene} ({number} of 18)" for scene, number in open_rows.items())
    return f"Still to be run: {told}." if told else "All of them have been run."


def main() -> None:
    """Run what is missing, and keep each row as it is done; `make pages` shows them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="TEXT", help="rows of scenes, algorithms or integrators with this name, anew")
    chosen = parser.parse_args()
    rows = stored()
    known = {tuple(row[key] for key in KEYS[:4]) for row in rows}
    for key in plan():
        if (chosen.only in key) if chosen.only else (key not in known):
            rows.append(measure(key))
            keep(rows)
            print(*rows[-1].values(), sep=" | ", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
