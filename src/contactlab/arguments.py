"""Arguments of the functions that programs call, looked at before anything is done with them."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar, cast

from contactlab.errors import RequestError
from contactlab.outside_files import usable

F = TypeVar("F", bound=Callable[..., Any])

NAME = (str, Path)
WORDS = {str: "a string", Path: "a path", bool: "true or false", Integral: "a whole number", Real: "a number"}


def arguments(**kinds: type | tuple[type, ...]) -> Callable[[F], F]:
    """Have a function refuse arguments that are of none of these types: RequestError with the argument's name.

    None is right where it is the default. A boolean is no number here, and what names a file must be a name of one.
    """

    def checking(function: F) -> F:
        shape = signature(function)

        @wraps(function)
        def call(*given: Any, **named: Any) -> Any:
            for name, value in shape.bind(*given, **named).arguments.items():
                if name in kinds:
                    _check(f"{function.__name__}, argument {name}", value, kinds[name], shape.parameters[name])
            return function(*given, **named)

        return cast(F, call)

    return checking


def _check(where: str, value: Any, kinds: type | tuple[type, ...], parameter: Parameter) -> None:
    wanted = kinds if isinstance(kinds, tuple) else (kinds,)
    if value is None and parameter.default is None:
        return
    if not isinstance(value, wanted) or (isinstance(value, bool) and bool not in wanted):
        words = [WORDS.get(kind, f"a {kind.__name__}") for kind in wanted]
        words += ["None"] if parameter.default is None else []
        raise RequestError("the argument is of the wrong type", where=where, got=value, allowed=" or ".join(words))
    if isinstance(value, str | Path) and (wanted == NAME or (isinstance(value, Path) and Path in wanted)):
        usable(Path(value), where)
