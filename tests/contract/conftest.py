"""What it means that a check catches a wrong part."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from contactlab.testing import run_check
from contactlab.testing.assertions import Check

sys.path.insert(0, str(Path(__file__).parent))  # strangers

Catch = Callable[..., None]


@pytest.fixture
def caught() -> Catch:
    """caught(check, part): the check must fail on the part, and say why; `raises` where the part itself raises."""

    def assert_caught(check: Check, part: Any, *, raises: bool = False) -> None:
        outcome = run_check(check, part)
        assert outcome.status == "failed", f"{outcome.check} lets a wrong part pass: {outcome}"
        assert outcome.reason.startswith("the part raised") == raises, outcome.reason
        assert len(outcome.reason) > 20, "a failure must say what is wrong"
        assert outcome.says.endswith((".", ":"))

    return assert_caught
