"""Studies: every combination of some choices, accuracy against cost.

The package is callable, `contactlab.compare(scene, vary=...)`, because its name is also the name
of what it does; see `contactlab.compare.runner.compare`.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _CallablePackage(ModuleType):
    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """See `contactlab.compare.runner.compare`."""
        from contactlab.compare.runner import compare

        return compare(*arguments, **options)


sys.modules[__name__].__class__ = _CallablePackage
