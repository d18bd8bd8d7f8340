"""Is what `contactlab choose` chooses good? Against all other configurations of each scene, measured more finely.

    python benchmarks/studies/choices.py [--out runs/choices] [--only WORD]   # all that has no row yet
    python benchmarks/studies/choices.py page                                 # the section of docs/accuracy.md

For each scene of choice_scenes.py the search is run as the command does it. Then every algorithm, slave, element and
integrator that it could have taken is run at LEVELS, up to DEAREST times the cost of the chosen one, and all are
measured against a reference that is refined further than the search's own. The best is the cheapest run that meets
the error, and whose finer runs do. Both are timed again, and the least of REPEAT times counts: on a machine with other
work the same run takes up to 1.7 times as long.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path

import choice_scenes
import kept_rows
from choice_scenes import Asked

from contactlab.accuracy.choose import Chosen, Wish, choose_plan, first_meeting, integrators_for
from contactlab.accuracy.finer_reference import finer_plan
from contactlab.accuracy.lines import Line, lines_of
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import GROWTH, Accuracy, run_accuracy
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.jobs.driver import Driver
from contactlab.parts.registry import Registry
from contactlab.reports.progress import progress_of
from contactlab.scene.toml_text import write_toml
from contactlab.studies.find_reference import matching_reference

HERE = Path(__file__).parent
STORED = HERE / "choices.csv"
PAGE = HERE.parents[1] / "docs" / "accuracy.md"
BEGIN, END = "<!-- choices: begin -->\n", "<!-- choices: end -->"
KEYS = ("scene", "what", "asked", "chosen", "level", "error", "known", "cost", "best", "best_level", "best_cost",
        "trials", "search_s", "why")  # fmt: skip
WISH = Wish(budget=30.0, search=60.0)
LEVELS = (1, 2, 3, 4, 6)
REPEAT = 5
LEAST_LIMIT = 1.0
"""CPU time [s] that every run may take."""
DEAREST = 1.1 * 2.0**GROWTH
"""Costs of the chosen run that every run may take: lines of one point are expected to cost eight times as much at level
2, and a smaller limit would leave out those whose level 1 costs as much as it. Dearer runs only tell whether the error
stays met."""
JUDGED = 0.05
"""Uncertainty of the judging reference over the error, or the finest that there is."""


def measure(asked: Asked, folder: Path) -> dict[str, str]:
    """The row of a scene."""
    folder.mkdir(parents=True, exist_ok=True)
    with Driver(folder, 1) as driver:
        found = driver.result(
            choose_plan(asked.scene, replace(WISH, error=asked.error), asked.scene.registry, folder, print)
        )
    file, known = _judge(asked, folder)
    lines = _all(asked, found, folder, file)
    chosen = _point(lines, found)
    if found.settings and chosen is None:
        raise RuntimeError(f"{asked.scene.name}: the chosen {found.name}, level {found.level} was not judged")
    best = _best(lines, asked.error)
    least = _timed(asked, folder, file, [point for point in (chosen, best and best[1]) if point is not None])
    # what the archive knew took no time now: its run did
    spent = sum(point.spent or point.cost for point in found.tried if point.cpu)
    row = {
        "scene": asked.scene.name, "what": asked.what, "asked": f"{asked.error:g}", "known": f"{known:.2g}",
        "trials": str(len(found.tried)), "search_s": f"{spent:.3g}", "why": "" if found.settings else found.why,
    }  # fmt: skip
    if chosen is not None:
        row |= {"chosen": found.name, "level": str(found.level), "error": f"{chosen.error:.3g}",
                "cost": f"{least[0]:.3g}"}  # fmt: skip
    if best is not None:
        line, point = best
        row |= {"best": line.name, "best_level": str(point.level), "best_cost": f"{least[-1]:.3g}"}
    return row


def _judge(asked: Asked, folder: Path) -> tuple[str, float]:
    """File of the reference that judges (none for an installed one), and what it is known to."""
    scene, registry = asked.scene, asked.scene.registry
    installed = matching_reference(scene.data, registry)
    if installed is not None:
        return "", installed.pressure_uncertainty
    integrator = integrators_for(scene, registry)[0]
    with Driver(folder, 1) as driver:
        made = driver.result(
            finer_plan(scene, integrator, JUDGED * asked.error, 150.0, folder / "judge", registry, print)
        )
    return made.file, math.nan if made.reference is None else made.reference.pressure_uncertainty


def _all(asked: Asked, found: Chosen, folder: Path, reference: str) -> list[Line]:
    """Every line that the search could have taken, up to DEAREST times the cost of the run that it took, and that."""
    registry = asked.scene.registry
    declared = {body["element"]["use"] for body in asked.scene.data["bodies"].values()}
    elements = ["", *(name for name in registry.names("element") if name not in declared)]
    contenders = [
        Contender(str(each["use"] if isinstance(each, dict) else each), element, each, algorithm)
        for each in integrators_for(asked.scene, registry)
        for element in elements
        for algorithm in registry.names("contact")
    ]
    if found.settings and found.level not in LEVELS:
        own = found.name.removesuffix(", exchanged")
        contenders = [replace(one, levels=(*LEVELS, found.level)) if one.label == own else one for one in contenders]
    limit = max(LEAST_LIMIT, DEAREST * found.cost[0]) if found.settings else WISH.budget
    study = CaseStudy((_case(asked, folder, reference),), tuple(contenders), levels=LEVELS, join=False, limit=limit)
    return lines_of(_ran(study, registry, folder))


def _case(asked: Asked, folder: Path, reference: str) -> CaseChoice:
    path = folder / "scene.toml"
    if not path.exists():  # the search ended before its trials
        path.write_text(write_toml(asked.scene.data), encoding="utf-8")
    return CaseChoice(scene=str(path.resolve()), name=asked.scene.name, reference=reference)


def _timed(asked: Asked, folder: Path, reference: str, points: list[Point]) -> list[float]:
    """The least CPU time [s] of each of these points in REPEAT runs."""
    found = []
    for point in points:
        algorithm, *element, integrator = point.contender.split()
        (spec,) = (each for each in integrators_for(asked.scene, asked.scene.registry)
                   if (each["use"] if isinstance(each, dict) else each) == integrator)  # fmt: skip
        contender = Contender(integrator, " ".join(element), spec, algorithm)
        study = CaseStudy((_case(asked, folder, reference),), (contender,), levels=(point.level,), join=False,
                          limit=WISH.budget, repeat=REPEAT)  # fmt: skip
        again = _ran(study, asked.scene.registry, folder).points
        (own,) = (each for each in again if each.slave == point.slave)
        found.append(min(own.cpu, default=math.nan))
    return found


def _point(lines: list[Line], found: Chosen) -> Point | None:
    """The chosen run, as the judging reference sees it."""
    for line in lines:
        for point in line.finished:
            if line.name == found.name and point.level == found.level:
                return point
    return None


def _best(lines: list[Line], error: float) -> tuple[Line, Point] | None:
    met = [(line, point) for line in lines if (point := first_meeting(line, error, math.inf)) is not None]
    return min(met, key=lambda pair: pair[1].cost, default=None)


def _ran(study: CaseStudy, registry: Registry, folder: Path) -> Accuracy:
    with Driver(folder, 1, progress=progress_of(show=True)) as driver:
        return run_accuracy(study, registry, driver)


# --- the section -----------------------------------------------------------------------------------


def meets(row: dict[str, str]) -> bool:
    """Whether the chosen run meets the error, or nothing does and the search says so."""
    return float(row["error"]) <= float(row["asked"]) if row["chosen"] else not row["best"]


def ratio(row: dict[str, str]) -> float:
    """Cost of the chosen run over that of the best; nan where there is no choice or no best."""
    return float(row["cost"]) / float(row["best_cost"]) if row["chosen"] and row["best"] else math.nan


def section(rows: list[dict[str, str]]) -> str:
    """Shares first, then a row per scene."""
    met, near = sum(map(meets, rows)), sum(ratio(row) <= 2.0 for row in rows)
    own = sum(row["scene"] != "disc-on-block" for row in rows)
    head = [
        f"{len(rows)} scenes, {own} of them without an installed reference and in no archive: {met} choices meet the "
        f"error that was asked for, {near} cost at most twice the best of an exhaustive search.",
        "",
        "| scene | asked, % | chosen | error, % (known to) | CPU s | best of all | CPU s | ratio | trials, CPU s |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    return "\n".join([*head, *map(_row, rows), ""])


def _row(row: dict[str, str]) -> str:
    percent = {key: f"{100.0 * float(row[key]):.2g}" if row[key] else "" for key in ("asked", "error", "known")}
    chosen = f"{row['chosen']}, level {row['level']}" if row["chosen"] else f"cannot: {row['why']}"
    best = f"{row['best']}, level {row['best_level']}" if row["best"] else "none"
    error = f"{percent['error']} ({percent['known']})" if row["chosen"] else ""
    shown = "" if math.isnan(ratio(row)) else f"{ratio(row):.2g}"
    cells = (f"`{row['scene']}`: {row['what']}", percent["asked"], chosen, error, row["cost"], best, row["best_cost"],
             shown, f"{row['trials']}, {row['search_s']}")  # fmt: skip
    return f"| {' | '.join(cells)} |"


def stored() -> list[dict[str, str]]:
    """Rows that are kept."""
    return kept_rows.read(STORED)


def page(rows: list[dict[str, str]]) -> str:
    """docs/accuracy.md with the section of these rows."""
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN, 1)
    return head + BEGIN + section(rows) + END + rest.split(END, 1)[1]


def main() -> None:
    """Measure what has no row yet, or write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="?", default="all")
    parser.add_argument("--only", default="")
    parser.add_argument("--out", type=Path, default=Path("runs/choices"))
    options = parser.parse_args()
    rows = {row["scene"]: row for row in stored()}
    if options.what == "page":
        PAGE.write_text(page(stored()), encoding="utf-8")
        return
    every = choice_scenes.asked()
    for asked in every:
        name = asked.scene.name
        if (options.only in name) if options.only else (name not in rows):
            rows[name] = measure(asked, options.out / name)
            print(rows[name], flush=True)
            order = [each.scene.name for each in every]
            kept_rows.write(STORED, KEYS, (rows[name] for name in order if name in rows))


if __name__ == "__main__":
    main()
