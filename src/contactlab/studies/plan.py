"""Plan of a comparison: the list of runs of a request."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from contactlab.errors import RequestError
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.scene import Scene, load_scene
from contactlab.scene.toml_text import location, read_toml
from contactlab.studies.installed_measures import known_measures
from contactlab.studies.measure_run import body_of, sides
from contactlab.studies.study import Pareto, Study, bundled_studies, checked_vary, is_study, read_study, study_from
from contactlab.studies.varied_text import varied_text
from contactlab.studies.vary import without_star

Vary = Mapping[str, Sequence[Any]]

LONGEST = 60  # characters of a run's name for what varies in addition to algorithm, slave and level
RECORD = 3.0  # MB of the contact record of a run: there are many of them, and some hundred steps show a difference


@dataclass(frozen=True)
class Combination:
    """Combination of the varied values, and its run.

    name      of its folder
    scene     with the varied values set
    varied    scene keys and values that distinguish it from the others
    choices   `varied` without algorithm, slave and level
    partner   the values without the swap of slave and master: two that share it are a pair
    refines   True when it is only there for the plot of error against cost
    """

    name: str
    scene: Scene
    varied: Mapping[str, Any]
    choices: Mapping[str, Any]
    algorithm: str
    slave: str
    partner: str
    refines: bool


@dataclass(frozen=True)
class Plan:
    """All runs of a study, in the order in which they are made.

    scene    the common scene, nothing varied
    contact  number of the contact that is compared
    """

    study: Study
    scene: Scene
    contact: int
    jobs: Sequence[Combination]


def make_plan(
    request: Scene | Study | str | Path,
    vary: Vary | None = None,
    registry: Registry | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Plan:
    """Plan the runs for a scene, a study, the name of either, or a file of either.

    With `vary` the study's own lists and levels are replaced; `changes` sets keys of the common scene
    and stops a study from varying them. If nothing is varied, a scene is run with every
    installed contact algorithm and both choices of slave. Raises RequestError.
    """
    registry = registry or default_registry()
    changes = changes or {}
    study, scene = find_scene(request, registry, changes)
    if vary:
        given = checked_vary({name: (values, f"vary {name}") for name, values in vary.items()})
        study = replace(study, vary=given, pareto=Pareto())
    for key in changes if vary else ():
        if key in study.vary:
            raise RequestError(
                "this key is both set and varied", where=key, got=changes[key],
                hint=f"leave out --set {key}, or write its values as {key} = [...] in --vary alone",
            )  # fmt: skip
    contact = _contact_number(scene, study.contact)
    if not study.vary:
        study = replace(
            study,
            vary={
                f"contacts.{contact}.algorithm": tuple(registry.names("contact")),
                f"contacts.{contact}.swap": (False, True),
            },
        )
    study = replace(study, vary={key: values for key, values in study.vary.items() if key not in changes})
    jobs = _jobs(study, scene, contact)
    width = len(str(len(jobs)))  # of the numbers before names: folders sort as the table does
    jobs = [replace(job, name=f"{number:0{width}d}-{job.name}") for number, job in enumerate(jobs, start=1)]
    return Plan(study, scene, contact, jobs)


def find_scene(
    request: Scene | Study | str | Path, registry: Registry | None = None, changes: Mapping[str, Any] | None = None
) -> tuple[Study, Scene]:
    """Return the requested study, and its scene with the changes. Raises RequestError."""
    registry = registry or default_registry()
    if isinstance(request, Scene):
        return Study(scene=request.name, name=request.name), request.with_(changes)
    if isinstance(request, str | Path):
        request = _find_study(request, registry)
    beside = (request.folder or Path()) / request.scene
    scene = load_scene(beside if request.folder and beside.is_file() else request.scene, registry, changes)
    return (request if request.name else replace(request, name=scene.name)), scene


def _find_study(request: str | Path, registry: Registry) -> Study:
    """A bundled study, a study file, or else a scene that stands alone."""
    if isinstance(request, str) and request in bundled_studies():
        return read_study(bundled_studies()[request], known_measures(registry))
    path = Path(request)
    if path.is_file():
        data, lines = read_toml(path, str(path))
        if is_study(data):
            return study_from(data, location(str(path), lines), path, known_measures(registry))
    return Study(scene=str(request))


def _contact_number(scene: Scene, key: str) -> int:
    """The number in "contacts.0", or of the contact with the name in "contacts.NAME"."""
    if not scene.contacts:
        raise RequestError(
            "the scene has no contact to compare", where=scene.origin.file or scene.name, allowed="[[contacts]]"
        )
    names = {f"contacts.{i}": i for i in range(len(scene.contacts))}
    names |= {f"contacts.{c.name}": i for i, c in enumerate(scene.contacts) if c.name}
    if key not in names:
        raise RequestError("no such contact", where="contact", got=key, allowed=", ".join(names))
    return names[key]


def _jobs(study: Study, scene: Scene, contact: int) -> list[Combination]:
    combinations = study.combinations()
    asked = [_job(scene, varied, contact, refines=False) for varied in combinations]
    done = {(job.partner, job.slave, job.algorithm) for job in asked}
    further = []
    for level in sorted(study.pareto.levels):
        for varied in combinations:
            job = _job(scene, {**varied, "level": level}, contact, refines=True)
            if (job.partner, job.slave, job.algorithm) not in done:
                done.add((job.partner, job.slave, job.algorithm))
                further.append(job)
    return asked + further


def compared_scene(scene: Scene) -> Scene:
    """The scene of one run among others, with `record.budget` written out, so that a single run can resume it."""
    return scene if scene.record.budget is not None else scene.with_({"record.budget": RECORD})


def _job(base: Scene, varied: Mapping[str, Any], contact: int, refines: bool) -> Combination:
    scene = compared_scene(base.with_(without_star(varied, base.data)))
    compared = scene.data["contacts"][contact]
    algorithm = _algorithm_label(base, varied, contact, compared)
    slave = body_of(sides(compared)[0])
    swaps, algorithms = _names_of(base, contact, "swap"), tuple(_names_of(base, contact, "algorithm"))
    rest = {key: value for key, value in varied.items() if key not in swaps}
    choices = {key: value for key, value in rest.items() if key != "level" and not key.startswith(algorithms)}
    partner = json.dumps({**rest, "level": scene.level}, sort_keys=True, default=str)
    return Combination(
        _slug(algorithm, slave, scene.level, choices), scene, varied, choices, algorithm, slave, partner, refines
    )


def _algorithm_label(base: Scene, varied: Mapping[str, Any], contact: int, compared: Mapping[str, Any]) -> str:
    """The part's name, with the fields that the study itself sets."""
    name = str(compared["algorithm"]["use"])
    fields: dict[str, Any] = {}
    for key in _names_of(base, contact, "algorithm"):
        if isinstance(varied.get(key), Mapping):
            fields |= {field: value for field, value in varied[key].items() if field != "use"}
        fields |= {k.removeprefix(f"{key}."): value for k, value in varied.items() if k.startswith(f"{key}.")}
    fields.pop("use", None)
    return " ".join([name, *(f"{field}={value}" for field, value in fields.items())])


def _names_of(scene: Scene, contact: int, field: str) -> list[str]:
    """Both ways to write a key of the compared contact."""
    name = scene.contacts[contact].name
    return [f"contacts.{label}.{field}" for label in (contact, name, "*") if label is not None]


def _slug(algorithm: str, slave: str, level: int, choices: Mapping[str, Any]) -> str:
    """A name for folders: what is always there, and as much as has room of what else varies."""
    varied = re.sub(r"[^A-Za-z0-9.=-]+", "-", varied_text(choices))[:LONGEST]
    return re.sub(r"[^A-Za-z0-9.=-]+", "-", f"{algorithm}-{slave}-level-{level}-{varied}").strip("-")
