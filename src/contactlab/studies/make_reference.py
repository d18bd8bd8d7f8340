"""Make a reference from the project's own runs on fine meshes, with an estimate of its error.

    python -m contactlab.studies.make_reference RECIPE --out FOLDER [--jobs N]

RECIPE is a study (`docs/scene-format.md`) that varies the level and whatever else should make no
difference: algorithms, slave and master. The pressure is the mean of the runs at the finest level, each
with edges where it ends as a square root followed to their roots, as no mesh does.
Its error is the largest of three: of each run from the mean of all others; of the mean from that at
the next coarser level; and what a method of first order leaves of the change before that one. (Edges
of contact limit the pressure to first order in h, so the distance between levels of ratio two
estimates what is left; with roots at the edges less is left, and the bound stays. Single changes may
be small by chance: an edge lies in a cell as it happens.)
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api import Floats, Record
from contactlab.errors import ContactlabError, RequestError
from contactlab.jobs.driver import Driver
from contactlab.jobs.rows import write_csv
from contactlab.results.results import ContactCurve
from contactlab.studies.combination import combination_plan
from contactlab.studies.gather import gather
from contactlab.studies.plan import Plan, make_plan
from contactlab.studies.profile import Profile, distance, norm
from contactlab.studies.reference import FOLDER
from contactlab.studies.root_edges import with_root_edges
from contactlab.studies.table import Row, Table

_POINTS_PER_SEGMENT = 4  # of the stored curve, so that storing adds nothing to the error
_ROOT = 4  # segments next to the ends of a run in which its own points are stored, too: dense where a root ends
_DIGITS = 7  # of what is stored


@dataclass(frozen=True)
class Curve:
    """A mean pressure: x (m,) [mm] and, at each, pressure, spread of the runs and change by refinement [MPa]."""

    x: Floats
    pressure: Floats
    spread: Floats
    refinement: Floats


def make_reference(recipe: str | Path, out: str | Path, jobs: int | None = None) -> Path:
    """Run the recipe, write NAME.csv and NAME.json into `out`, and return the path of the latter.

    Raises RequestError for a recipe with fewer than two levels or several answers, ContactlabError when a run fails.
    """
    bundled = FOLDER / f"{recipe}.toml"
    path = bundled if bundled.is_file() else Path(recipe)
    scene = _scene_of(path)
    plan = make_plan(path)
    with Driver(None, jobs, time_limit=plan.study.time_limit) as driver:
        done = driver.result(_all(plan))
    table = Table(gather(plan, done, None), plan.study, None, scene)
    if table.failed:
        failed = "; ".join(f"{row.name}: {row.status}: {row.reason}" for row in table.failed)
        raise ContactlabError(f"no reference from runs that fail: {failed}")
    levels = sorted({row.level for row in table.rows})
    if len(levels) < 2:
        raise RequestError(
            "one level gives no error estimate", where=str(path), got=levels, allowed="level = [COARSE, FINE]"
        )
    name = path.name.partition(".")[0]
    return reference_files(name, table, levels, mean_curve(table, levels), Path(out))


def reference_files(
    name: str, table: Table, levels: Sequence[int], found: tuple[Curve, float], folder: Path, origin: str = ""
) -> Path:
    """Write NAME.csv and NAME.json of a mean curve and its error; returns the path of the latter."""
    folder.mkdir(parents=True, exist_ok=True)
    curve, error = found
    columns = {
        "x_deformed_mm": curve.x, "p_MPa": curve.pressure, "p_spread_MPa": curve.spread,
        "p_refinement_MPa": curve.refinement,
    }  # fmt: skip
    rows = (dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True))
    write_csv(folder / f"{name}.csv", list(columns), rows, _DIGITS)
    target = folder / f"{name}.json"
    description = _description(name, table, levels, error)
    description |= {"origin": origin} if origin else {}
    target.write_text(json.dumps(description, indent=2) + "\n", encoding="utf-8")
    return target


def _scene_of(recipe: Path) -> Mapping[str, Any]:
    """The scene of a recipe with what it sets. Raises RequestError if its runs have different answers."""
    scenes = [job.scene.data for job in make_plan(recipe).jobs]
    answers = [holds_for(scene) for scene in scenes]
    differing = sorted({key for one in answers for key in one if one[key] != answers[0].get(key)})
    if differing:
        raise RequestError(
            "its runs have different answers", where=str(recipe), got=f"several values of {', '.join(differing)}",
            allowed="one value of each; only levels, algorithms, slaves and integrators may vary",
        )  # fmt: skip
    return scenes[0]


def _all(plan: Plan) -> Generator[Sequence[Any], Sequence[Any], dict[str, Record]]:
    done = yield [combination_plan(one, plan.study.repeat) for one in plan.jobs]
    return dict(zip((one.name for one in plan.jobs), done, strict=True))


# --- the pressure ----------------------------------------------------------------------------------


def mean_curve(table: Table, levels: Sequence[int]) -> tuple[Curve, float]:
    """The mean pressure at the finest level and its relative L2 error."""
    mirrored = table.scene.get("symmetry") == "x"
    runs = _profiles(table.rows, levels[-1], mirrored)
    fine = [profile for run in runs for profile in run]
    segment = min(float(np.diff(Profile.of_curve(curve).x).min()) for curve in _curves(table.rows, levels[-1]))
    x = _grid(fine, segment)
    # the multiplier ripples a little beyond an edge of contact that is no root; the pressure there is zero
    mean = np.where(_pressed(table.rows, levels[-1], mirrored, x), np.maximum(_mean(fine, x), 0.0), 0.0)
    spread = np.max([np.abs(p(x) - mean) for p in fine], axis=0)
    coarser = [
        Profile(x, _mean([p for run in _profiles(table.rows, level, mirrored) for p in run], x))
        for level in levels[:-1]
    ]
    profile = Profile(x, mean)
    differences = [distance(coarser[-1], profile), *_left_out(runs, x)]
    if len(levels) > 2:
        differences.append(distance(coarser[-2], coarser[-1]) * levels[-2] / levels[-1])
    return Curve(x, mean, spread, np.abs(coarser[-1].value - mean)), max(differences) / norm(profile)


def _left_out(runs: Sequence[Sequence[Profile]], x: Floats) -> list[float]:
    """Distance of each run from the mean of all others; none of a single run."""
    found = []
    for number, run in enumerate(runs):
        others = [profile for other, own in enumerate(runs) if other != number for profile in own]
        if others:
            found.append(max(distance(profile, Profile(x, _mean(others, x))) for profile in run))
    return found


def _profiles(rows: Sequence[Row], level: int, mirrored: bool) -> list[tuple[Profile, ...]]:
    """The pressure of each run at a level, and in a symmetric scene its mirror image next to it."""
    found = [with_root_edges(Profile.of_curve(curve)) for curve in _curves(rows, level)]
    return [(p, p.mirrored()) if mirrored else (p,) for p in found]


def _pressed(rows: Sequence[Row], level: int, mirrored: bool, x: Floats) -> np.ndarray:
    """Mask of points (m,) where any run has contact: up to its root, or where its nodal pressure is positive."""
    found = np.zeros(len(x), bool)
    for curve in _curves(rows, level):
        raw, nodal = Profile.of_curve(curve), Profile.of_curve(curve, "nodal_pressure")
        rooted = with_root_edges(raw)
        for part in (nodal,) if np.array_equal(rooted.x, raw.x) else (rooted, nodal):
            found |= part(x) > 0.0
            found |= mirrored and part.mirrored()(x) > 0.0
    return found


def _curves(rows: Sequence[Row], level: int) -> list[ContactCurve]:
    return [row.curve for row in rows if row.level == level and row.curve is not None]


def _mean(profiles: Sequence[Profile], x: Floats) -> Floats:
    return np.asarray(np.mean([p(x) for p in profiles], axis=0))


def _grid(profiles: Sequence[Profile], segment: float) -> Floats:
    """Even points where any profile is not zero, finer than a segment, and the profiles' points at the ends."""
    pressed = [p.x[np.flatnonzero(p.value)] for p in profiles]
    left, right = min(x[0] for x in pressed), max(x[-1] for x in pressed)
    count = 2 * int(np.ceil(0.5 * (right - left) / segment * _POINTS_PER_SEGMENT)) + 1
    even = np.linspace(left - segment, right + segment, count)
    reach = _ROOT * segment
    ends = [p.x[(np.abs(p.x - own[0]) < reach) | (np.abs(p.x - own[-1]) < reach)]
            for p, own in zip(profiles, pressed, strict=True)]  # fmt: skip
    # as stored: two points that are alike there are one
    return np.unique([float(f"{x:.{_DIGITS}g}") for x in np.concatenate([even, *ends])])


# --- scalars and description -----------------------------------------------------------------------


def limit(values: Sequence[float], levels: Sequence[int]) -> tuple[float, float]:
    """The limit of a sequence of levels and its error.

    Three levels of one ratio that converge from one side are extrapolated by the order they show
    (Aitken's rule), and the last step of that is the error; else the finest value counts, and its
    distance from the one before is the error.
    """
    last, step = values[-1], values[-1] - values[-2]
    if len(values) >= 3 and levels[-1] * levels[-3] == levels[-2] ** 2 and step != 0.0:
        ratio = (values[-2] - values[-3]) / step
        if ratio > 1.0:
            rest = step / (ratio - 1.0)
            return last + rest, abs(rest)
    return last, abs(step)


def common_limit(runs: Sequence[Mapping[int, float]]) -> tuple[float, float]:
    """Mean of the limits of runs (level -> value) and its error.

    That is the largest of the errors of the limits, of each against the mean of all others, and of what first order
    leaves of the change before the last.
    """
    limits = [limit([run[level] for level in sorted(run)], sorted(run)) for run in runs]
    values = np.array([found for found, _ in limits])
    others = (values.sum() - values) / max(len(values) - 1, 1)
    apart = float(np.abs(values - others).max()) if len(values) > 1 else 0.0
    return float(values.mean()), max(apart, *(own for _, own in limits), *map(_left_by_first_order, runs))


def _left_by_first_order(run: Mapping[int, float]) -> float:
    """Error that first order leaves of the last change but one, as the last may be small by chance; else 0."""
    levels = sorted(run)
    if len(levels) < 3:
        return 0.0
    a, b = levels[-3:-1]
    return abs(run[b] - run[a]) * a / b


def _reaction(table: Table) -> dict[str, Any]:
    runs: dict[tuple[str, str], dict[int, float]] = {}
    for row in table.rows:
        runs.setdefault((row.algorithm, row.slave), {})[row.level] = row["reaction"]
    value, error = common_limit(list(runs.values()))
    return {
        "value": round(value, 6),
        "error": float(f"{error:.2g}"),
        "meaning": "reaction of the driven support",
    }


def _description(name: str, table: Table, levels: Sequence[int], error: float) -> dict[str, Any]:
    algorithms = ", ".join(dict.fromkeys(row.algorithm for row in table.rows))
    slaves = ", ".join(dict.fromkeys(row.slave for row in table.rows))
    choices = dict.fromkeys(f"; {key} {value}" for row in table.rows for key, value in row.choices.items())
    more = "".join(choices)
    versions = ", ".join(f"{k} {v}" for k, v in table.rows[0].system.items() if k in ("contactlab", "numpy", "numba"))
    return {
        "format": 1,
        "name": name,
        "title": table.study.name,
        "curve": f"{name}.csv",
        "columns": {"x": "x_deformed_mm", "pressure": "p_MPa", "spread": "p_spread_MPa"},
        "mirror": False,
        "window": None,
        "level": levels[-1],
        "scalars": {"reaction": _reaction(table)},
        "error_estimate": {
            "pressure": float(f"{error:.2g}"),
            "meaning": f"relative L2 norm; the largest of a run at level {levels[-1]} against the mean of all others, "
            f"the change of the mean from level {levels[-2]}, and what first order leaves of the change before that",
        },
        "origin": f"This project's own runs at levels {', '.join(map(str, levels))}: {algorithms}; "
        f"slaves {slaves}{more}. Pressure: mean of the runs at level {levels[-1]}, followed to the roots at its edges. "
        f"Made with {versions} by python -m contactlab.studies.make_reference {name}.",
        "holds_for": holds_for(table.scene),
    }


def holds_for(scene: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a scene that its quasi-static answer depends on; meshes, algorithms and time do not count."""
    keys: dict[str, Any] = {}
    for name, material in scene["materials"].items():
        keys |= _flat(f"materials.{name}", _without(material, "density"))
    for name, body in scene["bodies"].items():
        geometry = {field: body[field] for field in ("material", "rotate", "shift")}
        keys |= _flat(f"bodies.{name}", {**geometry, "mesh": _without(body["mesh"], "cells", "grading")})
    for number, contact in enumerate(scene["contacts"]):
        pair = _without(contact, "algorithm", "swap", "name", "enforcement")
        keys |= _flat(f"contacts.{number}", {"friction": None, **pair})
    for number, support in enumerate(scene["supports"]):
        keys |= _flat(
            f"supports.{number}", {name: _end(support[name]) for name in ("on", "ux", "uy") if name in support}
        )
    for number, load in enumerate(scene.get("loads", ())):
        keys |= _flat(f"loads.{number}", _without(load, "name"))
    for number, effect in enumerate(scene.get("effects", ())):
        keys |= _flat(f"effects.{number}", effect)
    tables = ("contacts", "supports", "loads", "effects")
    return keys | {f"{table}.{len(scene.get(table, ()))}": None for table in tables}


def _without(table: Mapping[str, Any], *names: str) -> dict[str, Any]:
    return {name: value for name, value in table.items() if name not in names}


def _end(value: Any) -> Any:
    """Return the end value of a ramp; the loading path makes no difference to a quasi-static answer."""
    return {"to": value["to"]} if isinstance(value, Mapping) else value


def _flat(prefix: str, table: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in table.items():
        key = f"{prefix}.{name}"
        found |= _flat(key, value) if isinstance(value, Mapping) else {key: value}
    return found


def main() -> int:
    """Run the command line of this module."""
    parser = argparse.ArgumentParser(prog="python -m contactlab.studies.make_reference", description=__doc__)
    parser.add_argument("recipe", help="name of a bundled recipe, or a study file")
    parser.add_argument("--out", default=".", help="folder for NAME.csv and NAME.json")
    parser.add_argument("--jobs", type=int, help="runs at a time")
    options = parser.parse_args()
    try:
        print(make_reference(options.recipe, options.out, options.jobs))
    except ContactlabError as error:
        print(error, file=sys.stderr)
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())
