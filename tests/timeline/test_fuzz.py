"""A hundred and fifty scenes, files, words, calls and stored runs, wrong or strange; `make fuzz` tries 15 000."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

SEED = 20
FUZZ = Path(__file__).parents[1] / "abuse" / "fuzz.py"


@pytest.mark.timeout(900)
@pytest.mark.parametrize("cases", [150, pytest.param(500, marks=pytest.mark.full)])
def test_what_is_wrong_or_strange_works_or_is_refused_in_words(cases: int) -> None:
    """In a process of its own: what other tests left in memory is no part of a scene's peak."""
    words = [sys.executable, str(FUZZ), "--quick", "--json", "--cases", str(cases), "--seed", str(SEED)]
    told = subprocess.run([*words, "--seconds", "120"], stdout=subprocess.PIPE, text=True)
    tried = json.loads(told.stdout.splitlines()[-1])
    assert not tried["bad"]
    assert told.returncode == 0
    counts = tried["counts"]
    came = {kind: sum(counts[kind].values()) for kind in counts}
    assert sum(came.values()) == cases
    assert min(came.values()) >= 2
    assert counts["large scene"].get("ran", 0) > 0
    used = tried["used"]["large scene"]
    assert max(used) > 0.4  # the estimate is a bound, and no wild guess
    assert counts["mild scene"].get("past 20 steps", 0) >= 5
    for kind in ("keys", "text", "words", "program", "call", "file beside"):
        assert counts[kind].get("refused", 0) >= came[kind] // 3
