"""Origin of an exception in a plugin: its author wants the file and line, not a traceback through the core."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from traceback import walk_tb

from contactlab.api.formulas import members_of
from contactlab.errors import ContactlabError, PartError, WrongAnswer, one_line
from contactlab.parts.registry import Registry


def part_at_fault(error: BaseException, registry: Registry) -> str:
    """File, line and function of the innermost plugin frame, or "" if there is none."""
    packages = {offer.part.target.partition(":")[0].partition(".")[0] for offer in registry.parts()} - {"contactlab"}
    found = ""
    for frame, line in walk_tb(error.__traceback__):
        if str(frame.f_globals.get("__name__")).partition(".")[0] in packages:
            found = f"{frame.f_code.co_filename}, line {line}, in {frame.f_code.co_qualname}"
    return found


@contextmanager
def part_errors(registry: Registry) -> Iterator[None]:
    """Turn what a part raises, or gives against the contract, into a PartError with file and line."""
    try:
        yield
    except ContactlabError:
        raise
    except WrongAnswer as error:
        raise PartError(str(error)) from error
    except (Exception, SystemExit) as error:
        place = part_at_fault(error, registry)
        if not place:
            raise
        kind = type(getattr(error, "obj", None))
        known = members_of(kind) if issubclass(kind, tuple) and kind.__module__.startswith("contactlab.api.") else ""
        raise PartError(f"the part raised {one_line(error)}", where=place, allowed=known) from error
