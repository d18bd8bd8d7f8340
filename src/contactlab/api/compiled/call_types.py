"""Types of calls that are looked up once within a function.

numba passes over a function until no type changes, and looks up the type of each operation each time: `a * b` of two
floats by asking one implementation after the other, hundreds of times in a long kernel.
"""

from __future__ import annotations

from typing import Any


class CallTypes:
    """numba's knowledge of types, which it asks for everything but calls that this function has made before."""

    def __init__(self, context: Any) -> None:
        self._context, self._found = context, dict[Any, Any]()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Signature of a call with arguments of these types; None where there is none."""
        call = func, args, tuple(kws.items())
        found = self._found.get(call)
        if found is None:
            found = self._found[call] = self._context.resolve_function_type(func, args, kws)
        return found
