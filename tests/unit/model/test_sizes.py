"""What cannot fit into the machine is refused before anything is allocated, with key, estimate and limit."""

from __future__ import annotations

import os
import resource
from types import SimpleNamespace
from typing import Any

import pytest

from contactlab.errors import RequestError
from contactlab.model import sizes
from contactlab.run import recorders
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene


def die(end: float) -> dict[str, Any]:
    line = [[0.0, -5.0], [end, -5.0]]
    return {"rigid": {"die": {"line": line, "segment": 0.5}}, "contacts.0.master": "die"}


TOO_LARGE: dict[str, dict[str, Any]] = {
    "cells, long": {"bodies.block.mesh.cells": [1_000_000_000, 1]},
    "cells, square": {"bodies.block.mesh.cells": [100_000, 100_000]},
    "level": {"level": 100_000},
    "rigid": {"rigid": {"die": {"line": [[0.0, -5.0], [1e9, -5.0]], "segment": 0.5}}, "contacts.0.master": "die"},
    "rigid, endless": {
        "rigid": {"die": {"line": [[0.0, -5.0], [1e30, -5.0]], "segment": 0.5}},
        "contacts.0.master": "die",
    },
    "cells, with matrices": {"integrator": "newton", "bodies.block.mesh.cells": [1500, 1000]},  # explicit: 1 GiB
    "cells, of more nodes": {"bodies.block.element": "q2-lagrange", "bodies.block.mesh.cells": [4000, 1000]},
    "threads": {"threads": 1_000_000_000},
}  # fmt: skip


@pytest.mark.parametrize("name", TOO_LARGE)
def test_too_large_a_scene_is_refused_in_words(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "machine_memory", lambda: 8.0 * 2**30)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(RequestError) as error:
        simulate(load_scene("disc-on-block").with_(TOO_LARGE[name]))
    text = str(error.value)
    key = {"level": "mesh.cells"}.get(name, name.partition(",")[0])
    assert key in text
    assert "got" in text
    assert "allowed" in text
    assert str(4 * (os.cpu_count() or 1)) in text if name == "threads" else "GiB" in text
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + 200 * 1024  # KiB


def test_what_fits_is_not_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run of a million cells takes 741 MiB, libraries included; the estimate is no more."""
    monkeypatch.setattr(sizes, "machine_memory", lambda: 741.0 * 2**20)
    scene = load_scene("disc-on-block").with_({"bodies.block.mesh.cells": [1000, 999], "time.end": 1e-6})
    sizes.check_sizes(scene, scene.registry)


def test_a_mesh_with_more_cells_than_its_counts_say_is_refused_when_it_is_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A disc of [20, 20] has five times 400 cells."""
    disc = {"use": "disc", "radius": 1.0, "cells": [20, 20]}
    scene = load_scene("disc-on-block").with_({"bodies.disc.mesh": disc, "supports.1.on": "disc.top"})
    enough = 1.1 * sizes.estimated_bytes(scene, scene.registry)
    monkeypatch.setattr(sizes, "machine_memory", lambda: enough)
    with pytest.raises(RequestError, match="more memory than there is") as error:
        simulate(scene)
    assert "bodies.disc.mesh" in str(error.value)
    assert "2000 cells" in str(error.value.got)


@pytest.mark.full
def test_room_is_made_for_no_more_frames_than_steps(tmp_path: Any) -> None:
    changes = {
        "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.step": 1e-8, "time.end": 4e-7,
        "record.frames": 10**18, "record.recorders": ["vtkhdf"],
    }  # fmt: skip
    sizes_seen: list[int] = []

    def look(fraction: float, step: int, time: float, error: float) -> None:
        sizes_seen.append((tmp_path / "run/results.vtkhdf").stat().st_size)

    results = simulate(load_scene("disc-on-block").with_(changes), tmp_path / "run", progress=look)
    assert len(results.frames) == 41
    assert max(sizes_seen) < 20e6  # it was 2 GB


def test_frames_that_cannot_be_kept_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A million frames of 91 nodes are a gigabyte; a tenth of the steps is not."""
    scene = load_scene("disc-on-block").with_(
        {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.end": 1.0, "time.step": 1e-8,
         "record.frames": 1_000_000}
    )  # fmt: skip
    monkeypatch.setattr(sizes, "machine_memory", lambda: 0.5 * 2.0**30)
    with pytest.raises(RequestError, match="more memory than there is") as error:
        simulate(scene)
    assert "record.frames" in str(error.value)
    assert error.value.got == "1000000 frames of 66 nodes: about 0.738 GiB"


@pytest.mark.full
def test_a_disk_that_is_too_small_is_told_before_the_run(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The estimate is the file before it is compressed, to a tenth: headers are counted by their number alone."""
    monkeypatch.setattr("contactlab.results.vtkhdf.pack", lambda path: None)
    scene = load_scene("disc-on-block").with_(
        {"bodies.disc.mesh.cells": [16, 4], "bodies.block.mesh.cells": [24, 4], "time.end": 2e-6, "record.frames": 100,
         "contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "record.recorders": ["vtkhdf"]}
    )  # fmt: skip
    disk = SimpleNamespace(free=0)
    monkeypatch.setattr(recorders.shutil, "disk_usage", lambda folder: disk)
    with pytest.raises(RequestError, match="not enough free disk space") as error:
        simulate(scene, tmp_path / "run")
    assert "record.frames" in str(error.value)
    assert "0 GiB" in str(error.value.allowed)
    assert not list((tmp_path / "run").iterdir())
    size, unit = str(error.value.got).split("about ")[1].split()[:2]
    wanted = float(size) * {"MiB": 2**20, "GiB": 2**30}[unit]
    disk.free = 1.01 * wanted  # three digits are told
    simulate(scene, tmp_path / "run")
    stored = (tmp_path / "run/results.vtkhdf").stat().st_size
    assert wanted == pytest.approx(stored, rel=0.1)
