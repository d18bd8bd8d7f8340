"""How well `contactlab explain` foresees the bill of `contactlab compare --effects`, over all bundled scenes.

    python benchmarks/studies/foreseen_prices.py               # all scenes, to foreseen_prices.csv; some 20 minutes
    python benchmarks/studies/foreseen_prices.py dropped-block # rows of this scene anew
    python benchmarks/studies/foreseen_prices.py --again       # foresees the kept runs anew, without running any

Needs the prices of this machine (`contactlab calibrate`), and compares trials of the scenes too where there are some
(`contactlab calibrate all`, runs of their own, made before or after). Each run of a bill is made in this process, one
at a time, after one that is thrown away; where the machine is not quiet its CPU time is divided by how much slower a
fixed piece of work is meanwhile (`contactlab.prices.quiet`).
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
from contactlab.prices.kept_trials import Trials, load_trials, trial_key
from contactlab.prices.price import SPREAD, Price, price_of
from contactlab.prices.price_list import PriceList, load_prices
from contactlab.prices.quiet import Quiet
from contactlab.prices.tried import Pricing
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.cost_breakdown import BASE, plan_breakdown
from contactlab.studies.plan import Combination
from contactlab.studies.removable import variants

HERE = Path(__file__).parent
STORED, SOURCE = HERE / "foreseen_prices.csv", HERE / "foreseen_prices.md"
WARM, NAP = "disc-on-block", 3.0  # a scene with explicit and static runs; s
LONG, MOST = 2.0, 30.0  # s: a longer run is made once, not at all
TIMES = 3  # that a shorter run is made: the median counts
WITHIN = 0.15
TINY = 0.05  # of the run: an effect that costs less is within the scatter of times
KEYS = (
    "scene", "run", "kind", "foreseen_steps", "steps", "iterations", "foreseen_s", "least_s", "most_s", "measured_s",
    "least_measured_s", "most_measured_s", "slower", "foreseen_mib", "mib", "ended", "tried_s",
    "tried_least_s", "tried_most_s", "tried",
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
        yield row | _measured(job, quiet, 1 if foreseen > LONG else TIMES)


def _warm_up(quiet: Quiet) -> None:
    """Import what runs import beside their steps, and wait for it."""
    for job in plan_breakdown(WARM).jobs:
        _measured(job, quiet)
    sleep(NAP)


def _foreseen(scene: str, job: Combination, prices: PriceList) -> Row:
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


def kind_of(job: Combination) -> str:
    """By what the length of a run is known: "fixed", "settles" (explicit) or "load steps"."""
    if not job.scene.registry.part_class("integrator", job.scene.integrator["use"]).inertia:
        return "load steps"
    return "settles" if job.scene.time.end == "auto" else "fixed"


def _measured(job: Combination, quiet: Quiet, times: int = 1) -> Row:
    """The run of median cost."""
    try:
        made = sorted((quiet.timed(job.scene, tries=1) for _ in range(times)), key=lambda one: one.run.cpu_s)
    except RequestError as error:
        return {"ended": str(error)[:60]}
    timed = made[times // 2]
    run = timed.run
    return {
        "steps": f"{run.length.steps:.0f}", "iterations": f"{run.length.iterations:.0f}",
        "measured_s": f"{run.cpu_s:.4g}", "slower": f"{timed.slower:.3g}", "mib": f"{run.arrays_mib:.3g}",
        "least_measured_s": f"{made[0].run.cpu_s:.4g}", "most_measured_s": f"{made[-1].run.cpu_s:.4g}",
        "ended": "finished",
    }  # fmt: skip


def again(rows: list[Row], prices: PriceList, trials: Trials) -> list[Row]:
    """The rows with what is foreseen now, by counted work and by trials."""
    found = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        jobs = {job.choices["effect"]: job for job in plan_breakdown(scene).jobs}
        tried = _tried(load_scene(scene), prices, trials)
        for row in rows:
            if row["scene"] == scene:
                found.append(row | _foreseen(scene, jobs[row["run"]], prices) | tried.get(row["run"], NOT_TRIED))
    return found


NOT_TRIED = {"tried_s": "", "tried_least_s": "", "tried_most_s": "", "tried": ""}


def _tried(scene: Scene, prices: PriceList, trials: Trials) -> dict[str, Row]:
    """By the names of runs: what `contactlab explain` tells from trials."""
    if trial_key(scene) not in trials:
        return {}
    pricing, found = Pricing(scene, prices, trials), {}
    for name, one in ((BASE, scene), *((v.label, scene.with_(v.changes)) for v in variants(scene))):
        trial = trials.get(trial_key(one))
        if trial is None or trial.failed:
            found[name] = NOT_TRIED | {"tried": trial.ended[:60] if trial is not None else ""}
            continue
        price = pricing.price(one)
        bounds = {"tried_least_s": f"{price.least_s:.4g}", "tried_most_s": f"{price.most_s:.4g}"}
        found[name] = {"tried_s": f"{price.cpu_s:.4g}", **bounds, "tried": trial.ended or "end"}
    return found


# --- what came out -------------------------------------------------------------------------------------


class Effect:
    """A line of a bill, foreseen and measured [s]; `run_s` is the dearer of its two runs as measured.

    column  "foreseen_s" (by counted work) or "tried_s" (by trials)
    """

    def __init__(self, base: Row, other: Row, column: str) -> None:
        self.scene, self.name = base["scene"], other["run"]
        self.kind = "load steps" if "load steps" in (base["kind"], other["kind"]) else base["kind"]
        sign = 1.0 if self.name.startswith("without") else -1.0
        self.measured_s = sign * (float(base["measured_s"]) - float(other["measured_s"]))
        self.foreseen_s = sign * (float(base[column]) - float(other[column]))
        self.run_s = max(float(base["measured_s"]), float(other["measured_s"]))

    @property
    def of_bill(self) -> float:
        """Error over the cost of the dearer run."""
        return (self.foreseen_s - self.measured_s) / self.run_s

    @property
    def of_itself(self) -> float:
        """Error over the measured price of the effect."""
        return (self.foreseen_s - self.measured_s) / abs(self.measured_s)


def effects(rows: list[Row], column: str = "foreseen_s") -> list[Effect]:
    """The lines of all bills whose two runs finished and were foreseen."""
    found = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        base, *others = (row for row in rows if row["scene"] == scene)
        done = [row for row in (base, *others) if row["measured_s"] and row[column]]
        found += [Effect(base, row, column) for row in others if row in done and base in done]
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


def findings(rows: list[Row], column: str = "foreseen_s") -> Iterator[tuple[str, str]]:
    """What is told of all rows, by what it is about; by counted work, or with the column "tried_s" by trials."""
    least, most = BOUNDS[column]
    runs = [row for row in rows if row["measured_s"] and row[column]]
    found = effects(rows, column)
    yield "lines of the bills, errors over the cost of the run", _share([one.of_bill for one in found])
    yield "lines of the bills, errors over the line itself", _share([one.of_itself for one in found])
    dear = [one for one in found if abs(one.measured_s) > TINY * one.run_s]
    yield "the same for lines above 5 % of the run", _share([one.of_itself for one in dear])
    yield "costs of runs", _share([_error(row, column) for row in runs])
    for kind in ("fixed", "settles", "load steps"):
        own = [row for row in runs if row["kind"] == kind]
        yield f"costs of runs, {NAMES[kind]}", _share([_error(row, column) for row in own])
        inside = [float(row[least]) <= float(row["measured_s"]) <= float(row[most]) for row in own]
        if inside:
            yield f"of these between the bounds, {NAMES[kind]}", f"{100.0 * float(np.mean(inside)):.0f} % of {len(own)}"
    if column == "foreseen_s":
        yield "memory of arrays", _share([float(row["foreseen_mib"]) / float(row["mib"]) - 1.0 for row in runs])
    else:
        cut = sum(row["tried"] == "cut" for row in runs)
        yield "trials that were cut", f"{cut} of {len(runs)}"


BOUNDS = {"foreseen_s": ("least_s", "most_s"), "tried_s": ("tried_least_s", "tried_most_s")}
NAMES = {"fixed": "explicit with a fixed end", "settles": "explicit until it settles", "load steps": "load steps"}


def _error(row: Row, column: str = "foreseen_s") -> float:
    return float(row[column]) / float(row["measured_s"]) - 1.0


def page(rows: list[Row]) -> str:
    """The page of these rows."""
    text = SOURCE.read_text(encoding="utf-8")
    text = text.replace("<!-- spread -->", f"{100.0 * SPREAD:.0f}")
    for name, column in (("findings", "foreseen_s"), ("tried", "tried_s")):
        told = [f"| {what} | {share} |" for what, share in findings(rows, column)]
        text = text.replace(f"<!-- {name} -->", "\n".join(["| of | |", "|---|---|", *told]))
    for name, column in (("wrong", "foreseen_s"), ("wrong by trials", "tried_s")):
        text = text.replace(f"<!-- {name} -->", "\n".join(_wrong(rows, column)))
    return text.replace("<!-- runs -->", "\n".join(_runs(rows)))


def _wrong(rows: list[Row], column: str) -> Iterator[str]:
    """The lines of bills that are off by more than they should, the worst first."""
    wrong = sorted((e for e in effects(rows, column) if abs(e.of_bill) > WITHIN), key=lambda one: -abs(one.of_bill))
    if not wrong:
        yield "None."
        return
    yield "| scene | effect | foreseen, s | measured, s | error, % of the run |"
    yield "|---|---|---|---|---|"
    for one in wrong:
        name = one.name.removeprefix("without ").removeprefix("with ")
        yield f"| {one.scene} | {name} | {one.foreseen_s:.3g} | {one.measured_s:.3g} | {100.0 * one.of_bill:+.0f} |"


def _runs(rows: list[Row]) -> Iterator[str]:
    head = "scene, run, steps foreseen, steps, CPU s foreseen, between, CPU s, error in %, by its trial, error in %, "
    head += "MiB foreseen, MiB, "
    yield f"| {' | '.join(head.split(', '))} |"
    yield "|---" * 13 + "|"
    for row in rows:
        between = f"{row['least_s']} to {row['most_s']}" if row["foreseen_s"] else "refused"
        tried = f"{row['tried_s']}{' (cut)' if row['tried'] == 'cut' else ''}"
        cells = (
            row["scene"], row["run"], row["foreseen_steps"], row["steps"], row["foreseen_s"], between,
            row["measured_s"], _percent(row, "foreseen_s"), tried, _percent(row, "tried_s"), row["foreseen_mib"],
            row["mib"], ended_of(row),
        )  # fmt: skip
        yield f"| {' | '.join(cells)} |"


def _percent(row: Row, column: str) -> str:
    return f"{100.0 * _error(row, column):+.0f}" if row["measured_s"] and row[column] else ""


def ended_of(row: Row) -> str:
    """How a run without a bill ended; empty where it finished."""
    return "" if row["ended"] == "finished" else row["ended"].replace("|", "/")


def stored() -> list[Row]:
    """Rows that are kept."""
    return kept_rows.read(STORED)


def main() -> None:
    """Measure what is asked for, keep the rows and print what came out."""
    asked, rows = sys.argv[1:], stored()
    if asked == ["--again"]:
        rows = again(rows, load_prices(), load_trials())
        kept_rows.write(STORED, KEYS, rows)
    else:
        prices, quiet, scenes = load_prices(), Quiet(default_registry()), list(core_scenes())
        _warm_up(quiet)
        for scene in asked or scenes:
            made = again(list(measure(scene, prices, quiet)), prices, load_trials())
            rows = [row for row in rows if row["scene"] != scene] + made
            rows.sort(key=lambda row: scenes.index(row["scene"]))
            kept_rows.write(STORED, KEYS, rows)
            print(f"{scene}: done", flush=True)
    rows = stored()
    for column, how in (("foreseen_s", "by counted work"), ("tried_s", "by trials")):
        print(f"{how}:")
        for what, share in findings(rows, column):
            print(f"  {what}: {share}")
        for one in effects(rows, column):
            if abs(one.of_bill) > WITHIN:
                print(f"    {one.scene}, {one.name}: foreseen {one.foreseen_s:.3g} s, measured {one.measured_s:.3g} s")


if __name__ == "__main__":
    main()
