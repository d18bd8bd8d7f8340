"""data/known_kernels.json: the kernels that runs call, for "compiling kernel 12 of 31" and for compiling them ahead.

    python tests/architecture/known_kernels.py

writes it by first steps of many scenes, each in a process of its own, with a cache that begins empty.
`test_help.py` compares them with runs.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contactlab.errors import SceneError
from contactlab.run.known_kernels import used_parts
from contactlab.scene.scene import Scene, bundled_scenes, load_scene

FILE = Path(__file__).parents[2] / "src" / "contactlab" / "data" / "known_kernels.json"
LONG = 0.7
"""A kernel that takes less to compile [s] is not worth a process beside the run."""

WITH_FORMULAS = "contactlab.formulas."
"""Loops that are compiled once for the formulas of each algorithm, not by their own name."""

STEPS = 4
"""Of a scene that cannot be cut to a few tiny steps; the end of a whole run is missing then."""

FURTHER: dict[str, tuple[str, dict[str, Any]]] = {
    "disc-on-block node-on-segment": ("disc-on-block", {"contacts.0.algorithm": "node-on-segment"}),
    "disc-on-block mortar-p1": ("disc-on-block", {"contacts.0.algorithm": "mortar-p1"}),
    "disc-on-block friction": ("disc-on-block", {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}),
    "disc-on-block newton": ("disc-on-block", {"integrator": "newton"}),
    "disc-on-block q2": ("disc-on-block", {"bodies.disc.element": "q2", "bodies.block.element": "q2"}),
}
"""Scenes that people make first."""


def scenes() -> dict[str, Scene]:
    """All whose kernels are known."""
    own = {name: load_scene(name) for name in bundled_scenes()}
    return own | {name: load_scene(scene).with_(changes) for name, (scene, changes) in FURTHER.items()}


def main() -> None:
    """Write the file."""
    known: dict[str, Any] = {}
    kernels: dict[str, Any] = {}
    with TemporaryDirectory() as cache:
        for name, scene in scenes().items():
            done = subprocess.run(
                [sys.executable, __file__, name], env={**os.environ, "CONTACTLAB_CACHE": cache}, capture_output=True,
                text=True, check=True,
            )  # fmt: skip
            called = json.loads(done.stdout.splitlines()[-1])
            known[name] = {"parts": sorted(used_parts(scene)), "kernels": [kernel for kernel, *_ in called]}
            new = {
                kernel: {"types": types, "seconds": s}
                for kernel, types, s in called
                if types and s > LONG and not kernel.startswith(WITH_FORMULAS)
            }
            kernels |= {kernel: facts for kernel, facts in new.items() if kernel not in kernels}
            print(name, len(called), *new, flush=True)
    data = {"scenes": known, "kernels": dict(sorted(kernels.items()))}
    FILE.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def called_kernels(scene: Scene) -> list[tuple[str, str, float]]:
    """Module and name of every kernel that first steps call, the types that it is called with, CPU seconds to compile.

    Types are empty where they are more than numbers and arrays; seconds are next to nothing for what is in the cache.
    """
    from contactlab.api.compiled import compiler
    from contactlab.jobs.perform import warm_up
    from contactlab.run.simulation import simulate

    called: list[tuple[str, str, float]] = []
    inner = compiler.Kernel.compile

    def compile_and_note(self: Any, types: Any) -> Any:
        before, outer = compiler.COMPILATION.seconds, not compiler.COMPILATION.depth
        made = inner(self, types)
        if outer:
            name = f"{self.py_func.__module__}.{self.py_func.__name__}"
            called.append((name, _text(types), round(compiler.COMPILATION.seconds - before, 1)))
        return made

    compiler.Kernel.compile = compile_and_note  # type: ignore[method-assign]
    try:
        try:
            warm_up(scene, lambda line: None)
        except SceneError:  # something in it begins later than a few tiny steps end
            with TemporaryDirectory() as folder:
                simulate(scene, out=Path(folder) / "run", work=STEPS)
    finally:
        compiler.Kernel.compile = inner  # type: ignore[method-assign]
    return called


def _text(types: Any) -> str:
    """Types of arguments as numba reads them, "i8, f8[:,::1]", or names of tables."""
    words = []
    for each in types:
        if table := getattr(each, "table", None):
            words.append(table.__name__)
            continue
        array = hasattr(each, "layout")
        letter = {"int64": "i8", "int32": "i4", "float64": "f8", "bool": "b1"}.get(str(each.dtype if array else each))
        if letter is None or (array and each.layout != "C"):
            return ""
        words.append(letter + (f"[{':,' * (each.ndim - 1)}::1]" if array else ""))
    return ", ".join(words)


if __name__ == "__main__":
    if sys.argv[1:]:
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # with one core nothing is compiled ahead
        print(json.dumps(called_kernels(scenes()[sys.argv[1]])))
    else:
        main()
