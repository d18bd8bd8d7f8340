"""Prices of effects by version: what each effect costs in a step of two blocks, so that a dearer one is seen.

    python benchmarks/price_history.py          # measures (contactlab calibrate) and keeps a column
    python benchmarks/price_history.py --kept   # the column is of the prices that this machine has already

Columns are kept in `benchmarks/price_history.json`, one for each kind of machine and commit. An effect that costs a
fifth more than in the column before of the same kind of machine is printed, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parent / "kernels"))

import baselines
from baselines import Entry
from machine import machine

from contactlab import __version__
from contactlab.parts.registry import default_registry
from contactlab.prices.foreseen import bill_of
from contactlab.prices.price_list import PriceList
from contactlab.prices.samples import base_scene, cells

HERE = Path(__file__).resolve().parent
FILE = HERE / "price_history.json"
DEARER = 0.2  # of a price: less is the scatter of two calibrations
LEAST = 2.0  # us per step: prices below it are not judged
STEPS = 1000
SIZE = (24, 12)  # cells along the contact and across it, of each block
HEAD = """# Prices of effects by version

CPU time of each effect per step [µs]: of a time step of two blocks of 24 by 12 cells, and of a load step of \
them. They follow from the prices that `contactlab calibrate` finds ([prices](prices.md)); `python \
benchmarks/price_history.py` adds a column and writes this page. Only columns of one kind of machine compare; those of \
one kind still scatter by a tenth, more where others used the machine, and by several µs for what costs little.
"""


def costs(prices: PriceList) -> dict[str, float]:
    """CPU time [us] per step of the two blocks and of each effect that they have or lack."""
    registry = default_registry()
    scene = base_scene(registry).with_({**cells(*SIZE), "record": {"frames": 20}})
    explicit = scene.with_({"time.end": 1e-4})
    found = {}
    statics = [n for n in registry.names("integrator") if not registry.part_class("integrator", n).inertia]
    for kind, one in (("time step", explicit), ("load step", scene.with_({"integrator": statics[0]}))):
        bill = bill_of(one, prices)
        found[f"{kind}: whole"] = 1e6 * bill.whole.cpu_s / bill.whole.steps
        for effect in bill.effects:
            if not effect.reason:
                found[f"{kind}: {effect.effect}"] = 1e6 * effect.cpu_s / bill.whole.steps
    return found


def dearer(before: Mapping[str, float], now: Mapping[str, float]) -> dict[str, float]:
    """Effects that cost more than before by `DEARER` of that, and how much."""
    return {
        name: value / before[name] - 1.0
        for name, value in now.items()
        if before.get(name, 0.0) > LEAST and value > (1.0 + DEARER) * before[name]
    }


def new_entry(prices: PriceList, machine: dict[str, Any]) -> Entry:
    """A column of the present commit."""
    told = subprocess.run(["git", "log", "-1", "--format=%cs %h"], cwd=HERE, capture_output=True, text=True, check=True)
    date, commit = told.stdout.split()
    return {"machine": machine, "date": date, "version": __version__, "commit": commit, "ratios": costs(prices)}


def page(entries: Sequence[Entry]) -> str:
    """The page of the columns that are kept."""
    return baselines.page(entries, HEAD, "effect")


def main(words: Sequence[str] | None = None) -> int:
    """Measure, keep and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kept", action="store_true", help="use the prices that this machine has")
    chosen = parser.parse_args(words)
    lost = _keep(chosen.kept)
    for name, share in lost.items():
        print(f"  {name}: {share:.0%} dearer")
    return 1 if lost else 0


def _keep(kept: bool) -> dict[str, float]:
    """Add a column; what became dearer since the one before."""
    from contactlab.prices.calibrate import calibrate
    from contactlab.prices.price_list import load_prices, store_prices

    if kept:
        prices = load_prices()
    else:
        prices = calibrate(default_registry())
        store_prices(prices)
    entries, entry = baselines.load(FILE), new_entry(prices, machine())
    before = baselines.like(entries, entry["machine"])
    baselines.keep(entries, entry, FILE)
    print(json.dumps(entry["ratios"], indent=1))
    return dearer(before["ratios"], entry["ratios"]) if before is not None else {}


if __name__ == "__main__":
    sys.exit(main())
