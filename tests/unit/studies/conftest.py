"""Runs that need no simulation: functions for the worker processes, and curves of closed form."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from inline import runs_inline

from contactlab.api import ContactCurve
from contactlab.jobs import driver
from contactlab.jobs.processes import ProcessDiedError

FAKE_RUNS = """
    import os
    import numpy as np
    from contactlab.api import ContactCurve, Record
    from contactlab.jobs.record import ended, to_bytes
    from contactlab.jobs.system import machine

    def die():
        os._exit(3)

    def perform(run, folder, report):
        scene = run.scene
        chosen = scene.contacts[0]
        report("begun")
        report((0.5, 10))
        if chosen.algorithm["use"] == "node-on-segment":
            if chosen.swap:
                raise ZeroDivisionError("a part divides by nothing")
            die()
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
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
            "machine": machine(), "process_s": 2.6, "calibration_s": 0.1,
        }
        status, reason = {
            9: ("diverged", "it blew up"), 2: ("not-converged", "it never came to rest")
        }.get(scene.level, ("finished", ""))
        return to_bytes(Record(status, reason, summary, curves={"contacts.0": [curve]}))
"""


@pytest.fixture(scope="session")
def fake_source() -> str:
    """The module of functions that stand for runs, for processes that find it by themselves."""
    return textwrap.dedent(FAKE_RUNS)


@pytest.fixture
def fake_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """node-on-segment dies or raises; others give a parabola, unsettled at level 2, diverged at level 9."""
    place = tmp_path / "fakes"
    place.mkdir()
    (place / "fake_runs.py").write_text(textwrap.dedent(FAKE_RUNS))
    monkeypatch.syspath_prepend(str(place))
    monkeypatch.delitem(sys.modules, "fake_runs", raising=False)
    import fake_runs

    def die() -> None:
        raise ProcessDiedError("the process stopped with exit status 3 before the run ended")

    monkeypatch.setattr(fake_runs, "die", die)
    monkeypatch.setattr(driver, "perform", fake_runs.perform)
    with runs_inline():
        yield fake_runs


@pytest.fixture
def curve_of() -> Callable[..., ContactCurve]:
    """A curve from x and pressure."""

    def make(x: np.ndarray, pressure: np.ndarray) -> ContactCurve:
        zero = np.zeros_like(x)
        state = (pressure > 0.0).astype(np.int32)
        chain = np.zeros_like(state)
        return ContactCurve(x - x[0], x, zero, pressure, zero, np.maximum(pressure, 0.0), zero, state, chain)

    return make
