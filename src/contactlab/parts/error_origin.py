"""Whose line an exception comes from: a part's author wants the line of that part, not a traceback through the core."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from traceback import walk_tb
from typing import TYPE_CHECKING

from contactlab.errors import ContactlabError, PartError, WrongAnswer, one_line

if TYPE_CHECKING:
    from contactlab.parts.registry import Registry


def part_at_fault(error: BaseException, registry: Registry) -> str:
    """File, line and method of the innermost call that is of a plugin; empty where no plugin had a hand in it."""
    packages = {offer.part.target.partition(":")[0].partition(".")[0] for offer in registry.parts()} - {"contactlab"}
    found = ""
    for frame, line in walk_tb(error.__traceback__):
        if str(frame.f_globals.get("__name__")).partition(".")[0] in packages:
            found = f"{frame.f_code.co_filename}, line {line}, in {frame.f_code.co_qualname}"
    return found


@contextmanager
def part_errors(registry: Registry) -> Iterator[None]:
    """What a part raises, or gives against the contract, becomes a PartError that tells where."""
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
        raise PartError(f"the part raised {one_line(error)}", where=place) from error
