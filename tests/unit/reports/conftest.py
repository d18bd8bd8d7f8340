"""A comparison of closed form: good runs, a run that did not settle, and one that left nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.jobs.system import system_facts
from contactlab.results.results import ContactCurve
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference
from contactlab.studies.shape import Shape
from contactlab.studies.study import Study
from contactlab.studies.table import Row, Table

X = np.linspace(-0.8, 0.8, 33)
EXACT = np.maximum(0.0, 1000.0 * (1.0 - (X / 0.5) ** 2))


def curve(factor: float) -> ContactCurve:
    zero, p = np.zeros_like(X), factor * EXACT
    return ContactCurve(X + 0.8, X, zero, p, zero, p, zero, (p > 0.0).astype(np.int32), np.zeros(len(X), np.int32))


def shape() -> dict[str, Shape]:
    """Two unit cells side by side."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return {"disc": Shape(np.stack([square, square + np.array([1.0, 0.0])]), np.array([10.0, 30.0]))}


def row(algorithm: str, slave: str, level: int, status: str = "finished", reason: str = "", error: float = 0.02) -> Row:
    left = status != "failed"
    measures = {"pressure_error": error, "cpu_s": 1.5 * level**3, "reaction": 666.7, "steps": 1000.0 * level}
    return Row(
        name=f"{algorithm}-{slave}-{level}",
        algorithm=algorithm,
        slave=slave,
        level=level,
        varied={"contacts.0.algorithm": algorithm, "contacts.0.swap": slave == "block", "level": level},
        status=status,
        reason=reason,
        measures=measures if left else {"cpu_s": math.nan},
        system=system_facts(),
        parts={"contact": algorithm},
        reference="exact" if left else "",
        curve=curve(1.0 + error) if left else None,
        shapes=shape() if left else {},
        refines=level != 2,
    )


@pytest.fixture
def table() -> Table:
    """For tests that may change it."""
    return made()


@pytest.fixture(scope="module")
def shared_table() -> Table:
    """The same for all tests of a file."""
    return made()


def made() -> Table:
    rows = [
        row("alpha", "disc", 2, "not-converged", "reactions differ by <3 %> & more", error=0.2),
        row("alpha", "block", 2, "failed", "the process was killed by SIGKILL, perhaps because memory ran out"),
        row("beta", "disc", 2, error=0.01),
        row("beta", "block", 2, error=0.03),
        row("beta", "disc", 4, error=0.005),
        row("beta", "block", 4, error=0.006),
    ]
    reference = Reference(
        "exact", "A parabola", "Closed form, <by hand>.", Profile(X, EXACT), np.zeros_like(X),
        scalars={"reaction": {"value": 666.667, "error": 0.5, "meaning": "integral of the parabola"}},
        error_estimate={"pressure": 0.001, "meaning": "none to speak of"},
    )  # fmt: skip
    study = Study(scene="made-up", name="Alpha & beta", vary={"contacts.0.algorithm": ("alpha", "beta")})
    scene = {"name": "made-up", "source": "nobody 2005", "units": "mm N s t"}
    return Table(rows, study, reference, scene, 'name = "made-up"\n', wall_s=12.0)
