"""What cannot fit into the machine is refused before anything is allocated, with key, estimate and limit."""

from __future__ import annotations

import os
import resource
from typing import Any

import pytest

from contactlab.errors import RequestError
from contactlab.model import sizes
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
    "threads": {"threads": 1_000_000_000},
}


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
    """A million cells take 741 MiB; the estimate is no more."""
    monkeypatch.setattr(sizes, "machine_memory", lambda: 741.0 * 2**20)
    sizes.check_sizes(load_scene("disc-on-block").with_({"bodies.block.mesh.cells": [1000, 999]}))


def test_room_is_made_for_no_more_frames_than_steps(tmp_path: Any) -> None:
    changes = {
        "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.step": 1e-8, "time.end": 1e-6,
        "record.frames": 1_000_000, "record.recorders": ["vtkhdf"],
    }  # fmt: skip
    sizes_seen: list[int] = []

    def look(fraction: float, step: int, time: float, error: float) -> None:
        sizes_seen.append((tmp_path / "run/results.vtkhdf").stat().st_size)

    results = simulate(load_scene("disc-on-block").with_(changes), tmp_path / "run", progress=look)
    assert len(results.frames) == 101
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
