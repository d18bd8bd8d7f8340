"""How well `contactlab explain` foresees the bill of `contactlab compare --effects`, over all bundled scenes.

    python benchmarks/studies/foreseen_prices.py               # all scenes, to foreseen_prices.csv; some 20 minutes
    python benchmarks/studies/foreseen_prices.py dropped-block # rows of this scene anew
    python benchmarks/studies/foreseen_prices.py --again       # foresees the kept runs anew, without running any
    python benchmarks/studies/foreseen_prices.py page          # writes docs/prices.md from the rows

Needs the prices of this machine (`contactlab calibrate`). Each run of a bill is made in this process, one at a time,
after one that is thrown away; where the machine is not quiet its CPU time is divided by how much slower a fixed piece
of work is meanwhile (`contactlab.prices.quiet`).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from time import sleep

import kept_rows
import numpy as np
from kept_rows import Row

from contactlab.errors import RequestError
from contactlab.parts.registry import default_registry
from contactlab.parts.scenes_and_commands import core_scenes
from contactlab.prices.foreseen import SPREAD, Price, price_of
from contactlab.prices.price_list import PriceList, load_prices
from contactlab.prices.quiet import Quiet
from contactlab.studies.cost_breakdown import plan_breakdown
from contactlab.studies.plan import Job

HERE = Path(__file__).parent
STORED, SOURCE = HERE / "foreseen_prices.csv", HERE / "foreseen_prices.md"
PAGE = HERE.parents[1] / "docs" / "prices.md"
WARM, NAP = "disc-on-block", 3.0  # a scene with explicit and static runs; s
LONG, MOST = 2.0, 30.0  # s: a longer run is made once, not at all
WITHIN = 0.15
TINY = 0.05  # of the run: an effect that costs less is within the scatter of times
KEYS = (
    "scene", "run", "kind", "foreseen_steps", "steps", "iterations", "foreseen_s", "least_s", "most_s", "measured_s",
    "slower", "foreseen_mib", "mib", "ended",
)  # fmt: skip


def measure(scene: str, prices: PriceList, quiet: Quiet) -> Iterator[Row]:
    """A row for each run of the bill of one scene."""
    jobs = plan_breakdown(scene).jobs
    for number, job in enumerate(jobs):
        row = _foreseen(scene, job, prices)
        if not number:
            _measured(job, quiet)  # imports and kernels
        foreseen = float(row.get("foreseen_s", 0.0))
        if foreseen > MOST:
            yield row | {"ended": "too long"}
            continue
        long = foreseen > LONG
        yield row | _measured(job, quiet, 1 if long else 3)


def _warm_up(quiet: Quiet) -> None:
    """Import what runs import beside their steps, and wait for it."""
    for job in plan_breakdown(WARM).jobs:
        _measured(job, quiet)
    sleep(NAP)


def _foreseen(scene: str, job: Job, prices: PriceList) -> Row:
    row = {"scene": scene, "run": job.choices["effect"], "kind": kind_of(job)}
    try:
        return row | _figures(price_of(job.scene, prices))
    except RequestError:
        return row


def _figures(price: Price) -> Row:
    return {
        "foreseen_steps": f"{price.steps:.0f}",
        "foreseen_s": f"{price.cpu_s:.4g}",
        "least_s": f"{price.least_s:.4g}",
        "most_s": f"{price.most_s:.4g}",
        "foreseen_mib": f"{price.arrays_mib:.3g}",
    }


def kind_of(job: Job) -> str:
    """By what the length of a run is known: "fixed", "settles" (explicit) or "load steps"."""
    if not job.scene.registry.part_class("integrator", job.scene.integrator["use"]).inertia:
        return "load steps"
    return "settles" if job.scene.time.end == "auto" else "fixed"


def _measured(job: Job, quiet: Quiet, tries: int = 1) -> Row:
    try:
        timed = quiet.timed(job.scene, tries)
    except RequestError as error:
        return {"ended": str(error)[:60]}
    run = timed.run
    return {
        "steps": f"{run.length.steps:.0f}", "iterations": f"{run.length.iterations:.0f}",
        "measured_s": f"{run.cpu_s:.4g}", "slower": f"{timed.slower:.3g}", "mib": f"{run.arrays_mib:.3g}",
        "ended": "finished",
    }  # fmt: skip


def again(rows: list[Row], prices: PriceList) -> list[Row]:
    """The rows with what is foreseen now."""
    jobs = {
        (scene, job.choices["effect"]): job
        for scene in {r["scene"] for r in rows}
        for job in plan_breakdown(scene).jobs
    }
    return [row | _foreseen(row["scene"], jobs[row["scene"], row["run"]], prices) for row in rows]


# --- what came out -------------------------------------------------------------------------------------


class Effect:
    """A line of a bill, foreseen and measured [s]; `run_s` is the dearer of its two runs as measured."""

    def __init__(self, base: Row, other: Row) -> None:
        self.scene, self.name = base["scene"], other["run"]
        self.kind = "load steps" if "load steps" in (base["kind"], other["kind"]) else base["kind"]
        sign = 1.0 if self.name.startswith("without") else -1.0
        self.measured_s = sign * (float(base["measured_s"]) - float(other["measured_s"]))
        self.foreseen_s = sign * (float(base["foreseen_s"]) - float(other["foreseen_s"]))
        self.run_s = max(float(base["measured_s"]), float(other["measured_s"]))

    @property
    def of_bill(self) -> float:
        """Error over the cost of the dearer run."""
        return (self.foreseen_s - self.measured_s) / self.run_s

    @property
    def of_itself(self) -> float:
        """Error over the measured price of the effect."""
        return (self.foreseen_s - self.measured_s) / abs(self.measured_s)


def effects(rows: list[Row]) -> list[Effect]:
    """The lines of all bills whose two runs finished."""
    found = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        base, *others = (row for row in rows if row["scene"] == scene)
        done = [row for row in (base, *others) if row["measured_s"] and row["foreseen_s"]]
        found += [Effect(base, row) for row in others if row in done and base in done]
    return found


def _share(errors: list[float]) -> str:
    values = np.abs(errors)
    if not len(values):
        return "none"
    return (
        f"{100.0 * float((values <= WITHIN).mean()):.0f} % of {len(values)} within 15 %, half within "
        f"{100.0 * float(np.quantile(values, 0.5)):.0f} %, "
        f"nine in ten within {100.0 * float(np.quantile(values, 0.9)):.0f} %"
    )


def findings(rows: list[Row]) -> Iterator[tuple[str, str]]:
    """What is told of all rows, by what it is about."""
    runs = [row for row in rows if row["measured_s"] and row["foreseen_s"]]
    found = effects(rows)
    yield "lines of the bills, errors over the cost of the run", _share([one.of_bill for one in found])
    yield "lines of the bills, errors over the line itself", _share([one.of_itself for one in found])
    dear = [one for one in found if abs(one.measured_s) > TINY * one.run_s]
    yield "the same for lines above 5 % of the run", _share([one.of_itself for one in dear])
    yield "costs of runs", _share([_error(row) for row in runs])
    for kind in ("fixed", "settles", "load steps"):
        own = [row for row in runs if row["kind"] == kind]
        yield f"costs of runs, {NAMES[kind]}", _share([_error(row) for row in own])
        inside = [float(row["least_s"]) <= float(row["measured_s"]) <= float(row["most_s"]) for row in own]
        if inside:
            yield f"of these between the bounds, {NAMES[kind]}", f"{100.0 * float(np.mean(inside)):.0f} % of {len(own)}"
    memory = [float(row["foreseen_mib"]) / float(row["mib"]) - 1.0 for row in runs]
    yield "memory of arrays", _share(memory)


NAMES = {"fixed": "explicit with a fixed end", "settles": "explicit until it settles", "load steps": "load steps"}


def _error(row: Row) -> float:
    return float(row["foreseen_s"]) / float(row["measured_s"]) - 1.0


def page(rows: list[Row]) -> str:
    """docs/prices.md."""
    text = SOURCE.read_text(encoding="utf-8")
    text = text.replace("<!-- spread -->", f"{100.0 * SPREAD:.0f}")
    told = [f"| {what} | {share} |" for what, share in findings(rows)]
    text = text.replace("<!-- findings -->", "\n".join(["| of | |", "|---|---|", *told]))
    wrong = sorted((one for one in effects(rows) if abs(one.of_bill) > WITHIN), key=lambda one: -abs(one.of_bill))
    lines = ["| scene | effect | foreseen, s | measured, s | error, % of the run |", "|---|---|---|---|---|"]
    for one in wrong:
        name = one.name.removeprefix("without ").removeprefix("with ")
        lines.append(
            f"| {one.scene} | {name} | {one.foreseen_s:.3g} | {one.measured_s:.3g} | {100.0 * one.of_bill:+.0f} |"
        )
    text = text.replace("<!-- wrong -->", "\n".join(lines) if wrong else "None.")
    return text.replace("<!-- runs -->", "\n".join(_runs(rows)))


def _runs(rows: list[Row]) -> Iterator[str]:
    head = "scene, run, steps foreseen, steps, CPU s foreseen, between, CPU s, error in %, MiB foreseen, MiB, "
    yield f"| {' | '.join(head.split(', '))} |"
    yield "|---" * 11 + "|"
    for row in rows:
        error = f"{100.0 * _error(row):+.0f}" if row["measured_s"] and row["foreseen_s"] else ""
        between = f"{row['least_s']} to {row['most_s']}" if row["foreseen_s"] else "refused"
        cells = (
            row["scene"], row["run"], row["foreseen_steps"], row["steps"], row["foreseen_s"], between,
            row["measured_s"], error, row["foreseen_mib"], row["mib"], ended_of(row),
        )  # fmt: skip
        yield f"| {' | '.join(cells)} |"


def ended_of(row: Row) -> str:
    """How a run without a bill ended; empty where it finished."""
    return "" if row["ended"] == "finished" else row["ended"].replace("|", "/")


def stored() -> list[Row]:
    """Rows that are kept."""
    return kept_rows.read(STORED)


def main() -> None:
    """Measure what is asked for, keep the rows, print what came out and write the page."""
    asked, rows = sys.argv[1:], stored()
    if asked == ["--again"]:
        rows = again(rows, load_prices())
        kept_rows.write(STORED, KEYS, rows)
    elif asked != ["page"]:
        prices, quiet, scenes = load_prices(), Quiet(default_registry()), list(core_scenes())
        _warm_up(quiet)
        for scene in asked or scenes:
            rows = [row for row in rows if row["scene"] != scene] + list(measure(scene, prices, quiet))
            rows.sort(key=lambda row: scenes.index(row["scene"]))
            kept_rows.write(STORED, KEYS, rows)
            print(f"{scene}: done", flush=True)
    rows = stored()
    for what, share in findings(rows):
        print(f"{what}: {share}")
    for one in effects(rows):
        if abs(one.of_bill) > WITHIN:
            print(f"  {one.scene}, {one.name}: foreseen {one.foreseen_s:.3g} s, measured {one.measured_s:.3g} s")
    if SOURCE.exists():
        PAGE.write_text(page(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
