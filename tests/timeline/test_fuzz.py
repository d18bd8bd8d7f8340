"""Some hundred scenes, mesh files and stored runs that are wrong or strange; `make fuzz` tries ten thousand."""

from __future__ import annotations

import pytest
from fuzz import MACHINE, fuzz

from contactlab.meshing import room
from contactlab.model import sizes

CASES, SEED = 500, 20
# most are refused while they are read: these take milliseconds
QUICK = {"large scene": 0.01, "mild scene": 0.04, "wrong scene": 0.6, "mesh file": 0.15, "stored run": 0.2}


@pytest.mark.timeout(900)
def test_what_is_wrong_or_strange_works_or_is_refused_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (sizes, room):
        monkeypatch.setattr(module, "machine_memory", lambda: MACHINE)
    tried = fuzz(CASES, SEED, 120.0, bases=("explicit",), shares=QUICK)
    assert not tried.bad
    came = {kind: sum(counts.values()) for kind, counts in tried.counts.items()}
    assert sum(came.values()) == CASES
    assert min(came.values()) >= 3
    assert tried.counts["large scene"]["ran"] > 0
    used = tried.used["large scene"]
    assert max(used) > 0.4  # the estimate is a bound, and no wild guess
    assert tried.counts["mild scene"]["past 20 steps"] >= 5
    assert tried.counts["wrong scene"]["refused"] >= CASES // 4
    assert tried.counts["mesh file"]["refused"] >= CASES // 30
    assert tried.counts["stored run"]["as before"] < came["stored run"]
