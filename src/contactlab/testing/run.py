"""All checks of one part, with a reason for each."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from traceback import walk_tb
from typing import Any, Literal

from contactlab.api import Potential
from contactlab.api.part import KINDS
from contactlab.errors import RequestError, one_line
from contactlab.testing.assertions import Check, Expected, NotApplicable, Undeclared

LIBRARIES = ("numpy", "scipy", "numba")
"""Libraries for whose errors the line of the part is reported."""

Status = Literal["passed", "failed", "not applicable", "expected"]


@dataclass(frozen=True)
class Outcome:
    """Result of one check: `says` is what it proves, `reason` why it failed, was not applicable or was expected to
    fail; after a pass, what the part could declare."""

    check: str
    says: str
    status: Status
    reason: str = ""


def checks_for(kind: str, cls: type | None = None) -> tuple[Check, ...]:
    """The checks of a kind; none for any other string. Potentials set no conditions and have their own."""
    if kind not in KINDS:
        return ()
    room = "potential" if cls is not None and issubclass(cls, Potential) else kind
    checks: tuple[Check, ...] = importlib.import_module(f"contactlab.testing.{room}").CHECKS
    return checks


def run_checks(kind: str, part: object) -> list[Outcome]:
    """Every check of the kind on one part. Parts that raise anything have failed the check."""
    return [run_check(check, part) for check in checks_for(kind, type(part))]


def run_check(check: Check, part: object) -> Outcome:
    """Run one check on one part; returns what it found."""
    name = getattr(check, "__name__", str(check))
    says = " ".join((check.__doc__ or name).strip().partition("\n\n")[0].split())
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", Undeclared)
        status, reason = _ended(check, part)
    if status == "passed":
        reason = "; ".join(str(fact.message) for fact in told)
    return Outcome(name, says, status, reason)


def _ended(check: Callable[[Any], None], part: object) -> tuple[Status, str]:
    try:
        check(part)
    except NotApplicable as reason:
        return "not applicable", str(reason)
    except Expected as reason:
        return "expected", str(reason)
    except RequestError as error:
        return "failed", f"the part was refused: {one_line(error, name=False)}"
    except (Exception, SystemExit) as error:
        if isinstance(error, AssertionError) and _packages(error)[-1] == "contactlab":
            return "failed", str(error)
        said = f": {error}" if str(error) else ""
        return "failed", f"the part raised {type(error).__name__}{_place(error)}{said}"
    return "passed", ""


def _packages(error: BaseException) -> list[str]:
    """The package of each frame that the error came through, outermost first."""
    return [str(frame.f_globals.get("__name__")).partition(".")[0] for frame, _ in walk_tb(error.__traceback__)]


def _place(error: BaseException) -> str:
    """File and line of the last frame before library frames; empty if it belongs to the core."""
    places = [(frame.f_code.co_filename, line) for frame, line in walk_tb(error.__traceback__)]
    packages = _packages(error)
    own = [n for n, package in enumerate(packages) if package not in ("contactlab", *LIBRARIES)]
    if not own:
        return ""
    file, line = places[own[-1]]
    return f" in {Path(file).name}, line {line}"
