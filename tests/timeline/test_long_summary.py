"""A summary may be of any length: a scene of hundreds of bodies has one of megabytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import contactlab
from contactlab.api.recorder import Recorder
from contactlab.results.load import load_checkpoint
from contactlab.run.simulation import simulate


@pytest.mark.full
def test_summary_of_any_length_is_saved(
    small_scene: Callable[..., Any], recorder: Callable[[str], Recorder], tmp_path: Path, monkeypatch: Any
) -> None:
    """Read as it lies, without a last word of the run: what a kill leaves."""
    monkeypatch.setattr("contactlab.results.vtkhdf.pack", lambda path: None)
    recorded = simulate(small_scene(), tmp_path)
    recording = recorder("vtkhdf").resume(tmp_path, recorded.layout, recorded)
    saved = load_checkpoint(tmp_path)
    assert saved is not None
    for length in (10, 70_000, 1_000_000, 300):
        summary = {
            "status": "interrupted",
            "reason": "",
            "reactions": {f"body{i:07}.left": [0.5, -1.0] for i in range(length // 30)},
        }
        recording.save(saved[1].memory, summary)
        results = contactlab.load_results(tmp_path)
        assert results.summary == summary
        taken_up = load_checkpoint(tmp_path)
        assert taken_up is not None
        assert taken_up[1].memory.keys() == saved[1].memory.keys()
    recording.close(recorded.summary)
    assert contactlab.load_results(tmp_path) == recorded
