"""All checks of one part, with a reason for each."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Literal

from contactlab.api.part import KINDS
from contactlab.testing.assertions import Check, NotApplicable


@dataclass(frozen=True)
class Outcome:
    """One check of one part: `says` is what it proves, `reason` why it failed or was left out."""

    check: str
    says: str
    status: Literal["passed", "failed", "not applicable"]
    reason: str = ""


def checks_for(kind: str) -> tuple[Check, ...]:
    """The checks of a kind; none for what is no kind of part."""
    if kind not in KINDS:
        return ()
    checks: tuple[Check, ...] = importlib.import_module(f"contactlab.testing.{kind}").CHECKS
    return checks


def run_checks(kind: str, part: object) -> list[Outcome]:
    """Every check of the kind on one part. Parts that raise anything have failed the check."""
    return [run_check(check, part) for check in checks_for(kind)]


def run_check(check: Check, part: object) -> Outcome:
    """One check on one part."""
    name = getattr(check, "__name__", str(check))
    says = (check.__doc__ or name).strip().partition("\n")[0]
    try:
        check(part)
    except NotApplicable as reason:
        return Outcome(name, says, "not applicable", str(reason))
    except AssertionError as failure:
        return Outcome(name, says, "failed", str(failure))
    except Exception as error:
        return Outcome(name, says, "failed", f"the part raised {type(error).__name__}: {error}")
    return Outcome(name, says, "passed")
