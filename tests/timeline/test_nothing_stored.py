"""A run without files does no work for them: no call in a step, no array, no import; its bits are those of any run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import json, sys
from collections import Counter
from pathlib import Path

import numpy as np

from contactlab.model.held_arrays import held_arrays
from contactlab.run import simulation
from contactlab.scene.scene import load_scene

DT = 1e-8
models, prepare = [], simulation.prepare_run
def kept(model, *others):
    models.append(model)
    return prepare(model, *others)
simulation.prepare_run = kept
calls = Counter()
def count(frame, event, argument):
    name = frame.f_globals.get("__name__", "")
    if event == "call" and name.startswith("contactlab"):
        calls[name] += 1
def ran(steps, out=None, recorders=()):
    scene = load_scene("disc-on-block").with_({
        "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.step": DT, "time.end": steps * DT,
        "record.frames": 1, "record.recorders": list(recorders),
    })
    return simulation.simulate(scene, out)
def counted(steps):
    calls.clear()
    sys.setprofile(count)
    ran(steps)
    sys.setprofile(None)
    return dict(calls)
ran(80)  # loads kernels
imported = sorted(sys.modules)
found = {"imported": imported, "short": counted(80), "long": counted(120)}
ran(120, sys.argv[1], ["vtkhdf"])
alone, stored = models[-2:]
found["stored"] = "contactlab.results.checksums" in sys.modules
found["bits"] = {name: bool(np.array_equal(field, stored.state[name])) for name, field in alone.state.fields.items()}
found["arrays"] = [[array.name, array.shape] for array in held_arrays(alone)]
found["stored arrays"] = [[array.name, array.shape] for array in held_arrays(stored)]
print(json.dumps(found))
"""
# what belongs to files, archives, warnings and the record of contact; h5py and SQLite are only there for the first two
KEPT_OUT = (
    "h5py", "sqlite3", "contactlab.jobs.archive", "contactlab.results.checksums", "contactlab.results.vtkhdf",
    "contactlab.results.steps", "contactlab.results.record_plan", "contactlab.results.contact_sampler",
    "contactlab.kernels.contact.record", "contactlab.kernels.step_scalars",
)  # fmt: skip
MORE = 40  # steps of the longer run
ROOMS = ("contactlab.results", "contactlab.jobs.archive", "contactlab.missing_effects", "contactlab.api.warning")


@pytest.mark.full
def test_a_run_without_files_does_no_work_for_them(tmp_path: Path) -> None:
    """Between 80 and 120 steps lie no frame, no save and no look of the guards (every 50 steps, at 50 and at 100)."""
    command = [sys.executable, "-c", PROGRAM, str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert not [name for name in found["imported"] if name.startswith(KEPT_OUT)]
    assert found["stored"]  # the other run does import them
    short, long = ({k: n for k, n in found[run].items() if k.startswith(ROOMS)} for run in ("short", "long"))
    # the end of a run is told by some of these, with as many calls as its intervals of contact have numbers
    more = {name: long.get(name, 0) - short.get(name, 0) for name in short | long}
    assert max(map(abs, more.values())) < MORE / 2
    steps = "contactlab.model.model"
    assert found["long"][steps] - found["short"][steps] >= MORE  # the steps themselves are counted
    assert all(found["bits"].values())
    # rows that frames with files look at may come on top
    assert not [array for array in found["arrays"] if array not in found["stored arrays"]]
