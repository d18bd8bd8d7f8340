"""A driver without processes: runs are made here, one after the other, by a function that stands for them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from inline import Inline

from contactlab.api import Job, Record
from contactlab.jobs import driver
from contactlab.jobs.far_end import BEGUN
from contactlab.jobs.record import to_bytes
from contactlab.jobs.run import Run
from contactlab.scene.scene import Scene, load_scene

Made = list[str]


def record_with(value: float, status: str = "finished") -> Record:
    """A record with one number."""
    summary = {
        "status": status, "machine": driver.machine(), "process_s": 0.5, "calibration_s": 0.1, "value": value,
        "cost": {"run_cpu_s": 0.5, "compile_s": 0.1}, "steps": 3,
    }  # fmt: skip
    return Record(status, "", summary, {"time": np.array([value])})


@pytest.fixture
def record() -> Callable[..., Record]:
    """A record with one number, and a status."""
    return record_with


@pytest.fixture
def scene() -> Scene:
    """Any scene."""
    return load_scene("two-bars")


@pytest.fixture
def run_of(scene: Scene) -> Callable[..., Run]:
    """A run by its value, which is the end of its time."""

    def make(value: float, **others: Any) -> Run:
        return Run(Job(f"run {value:g}", ""), scene.with_({"time.end": value}), f"run {value:g}", **others)

    return make


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> Made:
    """Names of the runs that are made, in order; each gives a record with its value."""
    names: Made = []

    def perform(run: Run, folder: Path | None, report: Callable[[Any], None]) -> bytes:
        report(BEGUN)
        report((0.5, 10))
        names.append(run.name)
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        return to_bytes(record_with(float(run.scene.data["time"]["end"])))

    monkeypatch.setattr(driver, "perform", perform)
    monkeypatch.setattr(driver, "open_pool", lambda *request: Inline())
    return names
