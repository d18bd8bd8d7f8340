"""What must not matter to the numbers of cases: numbering, orientation and units.

`test_invariance.py` holds the same of short runs of one scene with every algorithm and element; these are whole cases
of other kinds: statics with friction and without, impacts, and bodies that nothing holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.api import Case, Floats, Job, Record, Setup
from contactlab.cases.run_case import evaluated, run_case, run_job, scene_of, watches_of
from contactlab.jobs.record import record_of
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.testing.scenarios.invariance import Renumbering

SAME = 1e-6
"""Of each number, or of one: Newton's tolerance is 1e-8 of the forces, and errors are differences."""
IMPACT = 1e-7
"""Of the speed: contact is solved to 1e-10 of a segment in some thousand steps."""
NUMBERED = [
    ("patch", "mortar-p1", {}),
    ("pulled-block", "node-on-segment", {}),
    ("tresca-block", "mortar-p0", {"segments": 52}),
    ("incompressible", "mortar-p1", {"poisson": 0.3}),
    ("few-cells", "mortar-p0", {}),
    ("two-bars", "mortar-p0", {}),
]


def made(name: str, fields: Mapping[str, Any]) -> Case:
    case: Case = default_registry().make("case", {"use": name, **fields})
    return case


@pytest.mark.parametrize(
    ("name", "algorithm", "fields"), NUMBERED[:3] + [pytest.param(*one, marks=pytest.mark.full) for one in NUMBERED[3:]]
)
def test_numbering_does_not_matter(name: str, algorithm: str, fields: dict[str, Any]) -> None:
    """Nodes, cells and edges of every mesh in random order."""
    case = made(name, fields)
    setup = Setup(algorithm, element=case.elements[0], integrator=case.integrators[0])
    found = []
    for run in (run_job, renumbered):
        done = run_case(case, setup, run=run)[1]
        assert all(record.finished for record in done.values()), [record.reason for record in done.values()]
        found.append(evaluated(case, setup, done))
    assert found[0].keys() == found[1].keys()
    for measure, value in found[0].items():
        assert found[1][measure] == pytest.approx(value, rel=SAME, abs=SAME), measure


def renumbered(job: Job, scene: Scene) -> Record:
    watches = watches_of(job, scene.registry)
    return record_of(simulate(scene, registry=Renumbering(scene.registry), watch=watches, work=job.work), job)


def impact(algorithm: str) -> Job:
    """Two spinning discs that meet obliquely, with friction, until they have parted."""
    case = made("oblique-discs", {})
    (job,) = case.plan(Setup(algorithm, element="q1", integrator="central-difference"), {})
    return job


def outcome(job: Job) -> Record:
    record = run_job(job, scene_of(job))
    assert record.finished, record.reason
    return record


def velocities(record: Record) -> Floats:
    """Of the centres in the end (2, 2)."""
    found = record.watched["series"]
    return np.array([[found[f"velocity.{name}.{axis}"][-1] for axis in "xy"] for name in ("flying", "resting")])


@pytest.mark.parametrize("algorithm", some(["mortar-p1", "node-on-segment"], ["mortar-p1"]))
def test_a_turned_impact_gives_turned_velocities(algorithm: str) -> None:
    """By 30 degrees; the spin stays."""
    job = impact(algorithm)
    plain = outcome(job)
    angle = math.radians(30.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    data = dict(job.scene) if not isinstance(job.scene, str) else {}
    data["bodies"] = {name: turned(body, turn) for name, body in data["bodies"].items()}
    found = outcome(Job(job.name, data, watch=job.watch, work=job.work))
    wanted = velocities(plain) @ turn.T
    assert np.abs(velocities(found) - wanted).max() <= IMPACT * np.abs(wanted).max()


def turned(body: Mapping[str, Any], turn: Floats) -> dict[str, Any]:
    vectors = {key: (turn @ body[key]).tolist() for key in ("shift", "velocity") if key in body}
    return {**body, **vectors, "rotate": body.get("rotate", 0.0) + 30.0}


def test_other_units_give_the_same_impact() -> None:
    """mm, N, t to m, kN, t: lengths and speeds by 1e-3, stresses by 1e3, densities by 1e9."""
    job = impact("mortar-p0")
    plain = outcome(job)
    data = dict(job.scene) if not isinstance(job.scene, str) else {}
    law = data["materials"]["soft"]
    data["materials"] = {"soft": law | {"young": 1e3 * law["young"], "density": 1e9 * law["density"]}}
    data["bodies"] = {name: in_metres(body) for name, body in data["bodies"].items()}
    found = outcome(Job(job.name, data, watch=job.watch, work=job.work))
    wanted = velocities(plain)
    assert np.abs(1e3 * velocities(found) - wanted).max() <= IMPACT * np.abs(wanted).max()


def in_metres(body: Mapping[str, Any]) -> dict[str, Any]:
    vectors = {key: [1e-3 * value for value in body[key]] for key in ("shift", "velocity") if key in body}
    mesh = body["mesh"]
    return {**body, **vectors, "mesh": mesh | {"radius": 1e-3 * mesh["radius"]}}
