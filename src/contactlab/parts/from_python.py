"""`contactlab.use`: parts of a program or a notebook, without a package."""

from __future__ import annotations

import re
from pathlib import Path

from contactlab.api.part import Part
from contactlab.arguments import NAME, arguments
from contactlab.errors import PartError
from contactlab.parts.contract import BASES
from contactlab.parts.registry import default_registry


@arguments(part=(type, *NAME), name=str)
def use(part: type | str | Path, name: str = "") -> str:
    """Offer a part to all scenes that this program loads from now on, and return its name in scenes.

    part  a class of one of the kinds of `contactlab.api`, or a Python file with hooks, as `--with` takes it
    name  of a class; by default its own, in lower-case words joined by "-"

    Comparisons run in separate processes, which import a class from its module: a class that was typed into a notebook
    works in runs only. Raises PartError if the part does not keep the contract, or the name is taken.
    """
    if not isinstance(part, type):
        default_registry().add_file(part)
        return Path(part).stem
    kinds = [kind for kind, bases in BASES.items() if issubclass(part, bases)]
    if not kinds or "." in part.__qualname__:
        raise PartError(
            f"{part.__qualname__} cannot be used as a part",
            where=part.__module__,
            allowed="a class at the top of its module that derives from one of the kinds of contactlab.api",
        )
    name = name or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", part.__name__).lower()
    says = (part.__doc__ or "").strip().partition("\n")[0].rstrip(".")
    default_registry().add_class(Part(kinds[0], name, f"{part.__module__}:{part.__name__}", says), part)  # type: ignore[arg-type]
    return name
