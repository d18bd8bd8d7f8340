"""All benchmarks in one go: ratios on the terminal, a page with plots, and what became slower than the baseline.

    python benchmarks/bench.py                  # `make bench`: some twenty minutes
    python benchmarks/bench.py --quick          # `make bench QUICK=1`: three minutes, no large meshes
    python benchmarks/bench.py --update         # keep these ratios as the newest of this kind of machine
    python benchmarks/bench.py --only steps     # a part of it alone, printed as JSON: no page, nothing is judged

Ratios are between things measured in turns in one process (peers: in processes of their own, in turns), CPU time,
medians. They belong to the machine all the same, as the share of memory in them differs (ours over Akantu was 25 on
one machine, 12 on another), and are compared with the newest in `benchmarks/baselines.json` of the same kind of
machine: a ratio that lost more than a fifth is marked, and the exit status is 1. Without such a baseline nothing is
judged. Peers are installed into `.venv-peers` by pip, and left out with the reason where that does not work.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import venv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.extend(str(Path(__file__).parent / folder) for folder in ("kernels", "studies"))

import baselines
import compile_times
import elements
import numpy as np
import numpy_law
import steps
from bench_page import write_page
from machine import kind, machine

HERE = Path(__file__).resolve().parent
LOSS = 0.2  # share of a ratio that may be lost before it is called a loss
PEERS = ("akantu", "kratos")
LESS_IS_BETTER = ("contact over elements", "numpy law", "exponent", "bytes", "python calls")
OTHER_ELEMENTS = ("q1-fbar", "q1-reduced", "q2", "q2-lagrange")


# --- measurements ------------------------------------------------------------------------------------


def element_rows(quick: bool, rounds: int) -> list[dict[str, Any]]:
    """Bilinear quadrilaterals with all laws and sizes, then the other elements with one law and size."""
    arrays = tuple(np.ones(4_000_000 if quick else 20_000_000) for _ in range(3))
    elements.triad(*arrays)
    sizes = (10_000,) if quick else (1_000, 10_000, 100_000, 1_000_000)
    wanted = [("q1", law, size) for law in elements.LAWS for size in sizes]
    wanted += [(element, "neo-hookean", 10_000) for element in OTHER_ELEMENTS]
    rows = []
    for element, law, size in wanted:
        row = elements.measure(element, law, size, rounds, arrays)
        rows.append(asdict(row))
        speed = f"{row.millions_per_s:6.1f} M/s, {row.share_of_bound:.0%}"
        print(f"  {element:11s} {law:17s} {row.cells:8d} cells {speed}", flush=True)
    return rows


def peers_python() -> Path:
    """The interpreter that has the peers. Raises RuntimeError with pip's own words where they cannot be installed."""
    folder = Path(".venv-peers")
    python = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    if not python.exists():
        venv.create(folder, with_pip=True)
    command = [str(python), "-m", "pip", "install", "--quiet", "-r", str(HERE / "peers" / "requirements.txt")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError((done.stderr.strip().splitlines() or ["pip failed"])[-1])
    return python


def peer_rows(quick: bool) -> list[dict[str, Any]]:
    """Updates of ours over those of each peer in the same time, same mesh and law; or why there is none."""
    rows: list[dict[str, Any]] = []
    sizes = (10_000,) if quick else (10_000, 100_000)
    for name in PEERS:
        try:
            python = peers_python()
            for cells in sizes:
                rows.append(_beside(python, name, cells))
        except RuntimeError as reason:
            rows.append({"peer": name, "skipped": str(reason)})
            print(f"  {name}: left out: {reason}")
    return rows


def _beside(python: Path, name: str, cells: int) -> dict[str, Any]:
    """A peer and ours in turns, three times."""
    ours: list[float] = []
    theirs: list[float] = []
    version = ""
    step = elements.stepper(elements.model_of("q1", "linear-elastic", cells))
    for _ in range(3):
        elements.seconds(step, 2)
        ours.append(elements.seconds(step, max(2, 200_000 // cells)))
        command = [str(python), str(HERE / "peers" / f"{name}_explicit.py"), "--cells", str(cells), "--rounds", "3"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError((done.stderr.strip().splitlines() or ["it failed without a word"])[-1])
        found = json.loads(done.stdout.strip().splitlines()[-1])
        theirs.append(found["median"])
        version = found["version"]
    ratio = median(a / b for a, b in zip(theirs, ours, strict=True))
    print(f"  {name} {version}: {cells} cells, {cells / median(theirs) / 1e6:.2f} M/s; ours {ratio:.0f} times as many")
    ns = 1e9 / cells * np.array([median(theirs), min(theirs), max(theirs)])
    return {
        "peer": name, "version": version, "cells": cells, "ns": float(ns[0]), "spread": ns[1:].tolist(), "ratio": ratio
    }  # fmt: skip


def step_costs(quick: bool, rounds: int) -> dict[str, Any]:
    """A step by phase, contact alone, and what both are made of."""
    print("a step of two pressed blocks by phase")
    phases = steps.phases(steps.CELLS[:4] if quick else steps.CELLS, rounds)
    print("contact alone")
    contact = steps.contacts(steps.NODES[:3] if quick else steps.NODES, rounds)
    return {
        "phases": phases, "contact": contact, "exponents": steps.exponents(phases, contact),
        "overhead": steps.overhead(rounds), "memory": steps.memory(), "start_up": steps.start_up(3),
    }  # fmt: skip


PARTS: dict[str, Callable[[bool, int], dict[str, Any]]] = {
    "elements": lambda quick, rounds: {"elements": element_rows(quick, rounds)},
    "steps": step_costs,
    "peers": lambda quick, rounds: {"peers": peer_rows(quick)},
    "numpy-law": lambda quick, rounds: {"numpy law": numpy_law.study(10_000, rounds)},
    "compilation": lambda quick, rounds: {"compilation": compile_times.study("mortar-p1" if quick else "")},
}
"""What is measured, by the name of a part."""


def measure(quick: bool, rounds: int, only: str = "") -> dict[str, Any]:
    """Everything, or one part, printed as it comes."""
    found: dict[str, Any] = {"machine": machine(4_000_000 if quick else 20_000_000, rounds)}
    print(kind(found["machine"]))
    for name, part in PARTS.items():
        if only in ("", name):
            print(name)
            found |= part(quick, rounds)
    return found


# --- ratios ------------------------------------------------------------------------------------------


def ratios_of(found: Mapping[str, Any]) -> dict[str, float]:
    """Every number that another machine of this kind should find again."""
    ratios: dict[str, float] = {}
    for row in found["elements"]:
        name = f"{row['element']} {row['law']} {_round(row['cells'])}"
        ratios[f"{name}: share of bandwidth bound"] = row["share_of_bound"]
    for row in found["phases"]:
        ratios[f"contact over elements, {row['cells']:.0f} cells"] = row["contact"] / row["elements"]
    for row in found["peers"]:
        if "ratio" in row:
            ratios[f"times {row['peer']}, {_round(row['cells'])} cells"] = row["ratio"]
    ratios["numpy law over compiled, whole step"] = found["numpy law"]["by components"]
    ratios["numpy law over compiled, alone"] = found["numpy law"]["alone"]
    ratios |= {f"exponent of {name}": value for name, value in found["exponents"].items()}
    for row in found["memory"]:
        ratios[f"bytes per cell, {row['element']} {row['law']}"] = row["bytes_per_cell"]
    call = found["overhead"]["python_call_us"]
    ratios["python calls that a step's overhead would buy"] = found["overhead"]["step_us"] / call
    return ratios


def _round(cells: int) -> str:
    """Meshes are about as large as wished."""
    return f"{round(cells, -int(np.log10(cells)) + 1):d}"


def losses(ratios: Mapping[str, float], baseline: Mapping[str, float]) -> dict[str, float]:
    """What lost more than `LOSS` against the baseline, and how much."""
    found = {}
    for name, now in ratios.items():
        before = baseline.get(name)
        if not before or not now:
            continue
        kept = before / now if any(word in name for word in LESS_IS_BETTER) else now / before
        if kept < 1.0 - LOSS:
            found[name] = 1.0 - kept
    return found


def show(ratios: Mapping[str, float], baseline: Mapping[str, float], lost: Mapping[str, float]) -> None:
    """One line for each ratio, its baseline and what was lost."""
    print(f"\n{'ratio':56s} {'now':>9s} {'baseline':>9s}")
    for name, now in ratios.items():
        before = f"{baseline[name]:9.3g}" if name in baseline else f"{'-':>9s}"
        mark = f"  <-- {lost[name]:.0%} lost" if name in lost else ""
        print(f"{name:56s} {now:9.3g} {before}{mark}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, compare, write the page; status 1 where something was lost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small sizes and few rounds")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", default="", choices=PARTS, help="measure this part alone")
    parser.add_argument("--update", action="store_true", help="keep the ratios, with machine and version")
    parser.add_argument(
        "--out", type=Path, default=Path("runs/bench"), help="folder of the page, its plots and numbers"
    )
    chosen = parser.parse_args(arguments)
    found = measure(chosen.quick, min(chosen.rounds, 5) if chosen.quick else chosen.rounds, chosen.only)
    if chosen.only:
        print(json.dumps(found, indent=1))
        return 0
    ratios = ratios_of(found)
    kept = baselines.load()
    before = baselines.like(kept, found["machine"])
    baseline = {} if before is None else before["ratios"]
    lost = losses(ratios, baseline)
    show(ratios, baseline, lost)
    against = f"version {before['version']} of {before['date']}" if before else ""
    print(f"\nCompared with {against}" if against else f"\nNothing to compare with: {baselines.no_like(kept)}")
    if chosen.update:
        told = subprocess.run(
            ["git", "log", "-1", "--format=%cs %h"], cwd=HERE, capture_output=True, text=True, check=True
        )
        date, commit = told.stdout.split()
        entry = {"machine": found["machine"], "date": date, "version": found["machine"]["software"]["contactlab"]}
        baselines.keep(kept, {**entry, "commit": commit, "ratios": ratios})
    chosen.out.mkdir(parents=True, exist_ok=True)
    (chosen.out / "benchmarks.json").write_text(json.dumps(found, indent=1))
    write_page(found, lost, against or baselines.no_like(kept), chosen.out)
    print(f"\nThe page is {chosen.out}/benchmarks.md")
    return 1 if lost and not chosen.update else 0


if __name__ == "__main__":
    sys.exit(main())
