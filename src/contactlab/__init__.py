"""A bench for finite-element contact algorithms.

    import contactlab
    scene = contactlab.load_scene("disc-on-block").with_({"contacts.0.algorithm": "mortar-p0", "level": 2})
    results = contactlab.simulate(scene, out="runs/disc")

Names are imported when they are first used, so that `contactlab --help` answers immediately.
"""

from __future__ import annotations

TYPE_CHECKING = False  # the module typing takes longer to import than a program may be deaf to signals
if TYPE_CHECKING:
    from typing import Any

    from contactlab.comparison import compare
    from contactlab.errors import ContactlabError
    from contactlab.laboratory import check, choose, error_budget, explain, matrix
    from contactlab.meshing.arrays import mesh
    from contactlab.parts.from_python import use
    from contactlab.results.load import load_results
    from contactlab.results.results import Results
    from contactlab.run.interruption import Interrupted
    from contactlab.run.simulation import simulate
    from contactlab.scene.scene import Scene, load_scene
    from contactlab.studies.load_table import load_table
    from contactlab.studies.table import Table

__version__ = "0.1.0"

__all__ = [
    "ContactlabError",
    "Interrupted",
    "Results",
    "Scene",
    "Table",
    "__version__",
    "check",
    "choose",
    "compare",
    "error_budget",
    "explain",
    "load_results",
    "load_scene",
    "load_table",
    "matrix",
    "mesh",
    "simulate",
    "use",
]

_HOMES = {
    "ContactlabError": "contactlab.errors",
    "Interrupted": "contactlab.run.interruption",
    "Results": "contactlab.results.results",
    "Scene": "contactlab.scene.scene",
    "Table": "contactlab.studies.table",
    "check": "contactlab.laboratory",
    "choose": "contactlab.laboratory",
    "compare": "contactlab.comparison",
    "error_budget": "contactlab.laboratory",
    "explain": "contactlab.laboratory",
    "load_results": "contactlab.results.load",
    "load_scene": "contactlab.scene.scene",
    "load_table": "contactlab.studies.load_table",
    "matrix": "contactlab.laboratory",
    "mesh": "contactlab.meshing.arrays",
    "simulate": "contactlab.run.simulation",
    "use": "contactlab.parts.from_python",
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'contactlab' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
