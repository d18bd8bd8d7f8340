"""Runs that need no simulation: functions for the worker processes, and curves of closed form."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from contactlab.results.results import ContactCurve
from contactlab.studies import run_job

FAKE_RUNS = """
    import os
    import numpy as np
    from contactlab.studies.run_job import Outcome
    from contactlab.results.results import ContactCurve

    def warm_up(scene, report):
        raise RuntimeError("nothing to warm up")

    def run(scene, folder, contact, repeat, report):
        chosen = scene.contacts[contact]
        report((0.5, 10))
        if chosen.algorithm["use"] == "node-on-segment":
            if chosen.swap:
                raise ZeroDivisionError("a part divides by nothing")
            os._exit(3)
        if folder is not None:
            folder.mkdir(parents=True)
        x = np.linspace(-0.8, 0.8, 16 * scene.level + 1)
        p = np.maximum(0.0, 100.0 * (1.0 - (x / 0.4) ** 2)) * (1.01 if chosen.swap else 0.99)
        zero = np.zeros_like(x)
        curve = ContactCurve(x + 0.8, x, zero, p, zero, p, zero, (p > 0).astype(np.int32), np.zeros(len(x), np.int32))
        summary = {
            "steps": 100, "contact_sweeps": 300, "parts": {"contact": "fake"},
            "cost": {"run_cpu_s": 2.5, "run_wall_s": 3.0, "compile_s": 0.5},
            "reactions": {"block.bottom": [0.0, 50.0], "disc.top": [0.0, -50.0]},
            "contacts": {"contacts.0": {"resultant": [1e-6, 50.0], "max_pressure": float(p.max()),
                         "pressure_integral": [0.0, -50.5 if chosen.swap else 50.5], "max_penetration": 1e-5}},
            "balance": {"kinetic": 1e-3, "internal": 10.0},
        }
        if scene.level == 9:
            return Outcome("diverged", "it blew up", summary, curve)
        if scene.level == 2:
            return Outcome("not-converged", "it never came to rest", summary, curve)
        return Outcome("finished", "", summary, curve)
"""


@pytest.fixture(scope="session")
def fake_source() -> str:
    """The module of functions that stand for runs, for processes that find it by themselves."""
    return textwrap.dedent(FAKE_RUNS)


@pytest.fixture
def fake_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """node-on-segment dies or raises; others give a parabola, unsettled at level 2, diverged at level 9."""
    place = tmp_path / "fakes"
    place.mkdir()
    (place / "fake_runs.py").write_text(textwrap.dedent(FAKE_RUNS))
    monkeypatch.syspath_prepend(str(place))
    monkeypatch.delitem(sys.modules, "fake_runs", raising=False)
    import fake_runs

    monkeypatch.setattr(run_job, "run", fake_runs.run)
    monkeypatch.setattr(run_job, "warm_up", fake_runs.warm_up)
    return fake_runs


@pytest.fixture
def curve_of() -> Callable[..., ContactCurve]:
    """A curve from x and pressure."""

    def make(x: np.ndarray, pressure: np.ndarray) -> ContactCurve:
        zero = np.zeros_like(x)
        state = (pressure > 0.0).astype(np.int32)
        chain = np.zeros_like(state)
        return ContactCurve(x - x[0], x, zero, pressure, zero, np.maximum(pressure, 0.0), zero, state, chain)

    return make
