"""What compiling costs, function by function: CPU seconds of its own, without those of the functions that it calls.

    python benchmarks/studies/kernel_times.py [--only TEXT] [--rows 30]

Runs of the demo take their first steps in this one process, with an empty cache, and every compilation of a dispatcher
is timed with the CPU time of its thread, so that it can be told on a machine that others use, too. Run it on one core
(`taskset -c 0`): with more, the longest kernels are compiled in other processes.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import defaultdict
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time, thread_time
from typing import Any

PATH = {"time.end": 1e-6}
RUNS: dict[str, dict[str, Any]] = {
    f"{algorithm}, {way}": {"contacts.0.algorithm": algorithm, "integrator": integrator, **more}
    for way, integrator, more in (("explicit", "central-difference", PATH), ("statics", "newton", {"level": 1}))
    for algorithm in ("mortar-p0", "mortar-p1", "node-on-segment")
}


class Clock:
    """Own CPU seconds and number of compilations by function, and the signatures of each."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.signatures: defaultdict[str, list[str]] = defaultdict(list)
        self.inner = [0.0]

    def watch(self) -> None:
        """Time every compilation from now on."""
        from numba.core.dispatcher import _FunctionCompiler

        compiled = _FunctionCompiler.compile

        def timed(compiler: Any, args: Any, return_type: Any) -> Any:
            began = thread_time()
            self.inner.append(0.0)
            try:
                return compiled(compiler, args, return_type)
            finally:
                spent = thread_time() - began
                function = compiler.py_func
                name = f"{function.__module__.removeprefix('contactlab')}.{function.__qualname__}"
                self.seconds[name] += spent - self.inner.pop()
                self.signatures[name].append(str(args))
                self.inner[-1] += spent

        _FunctionCompiler.compile = timed  # type: ignore[method-assign]


def run(changes: dict[str, Any]) -> None:
    """The first steps of a run, or the whole static one."""
    from contactlab.run.simulation import simulate
    from contactlab.scene.scene import load_scene

    simulate(load_scene("disc-on-block").with_({"record.recorders": [], **changes}))


def main() -> int:
    """Compile, and print the longest."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="runs whose name has this text")
    parser.add_argument("--rows", type=int, default=30)
    asked = parser.parse_args()
    clock = Clock()
    with TemporaryDirectory() as cache:
        os.environ["CONTACTLAB_CACHE"] = str(Path(cache))
        clock.watch()
        for name, changes in RUNS.items():
            if asked.only in name:
                before, began = sum(clock.seconds.values()), process_time()
                run(changes)
                compiling, spent = sum(clock.seconds.values()) - before, process_time() - began
                print(f"{name}: {compiling:.1f} of {spent:.1f} CPU s, load {os.getloadavg()[0]:.1f}", flush=True)
    print(f"\n{len(clock.seconds)} functions, {sum(map(len, clock.signatures.values()))} compilations")
    for name, seconds in sorted(clock.seconds.items(), key=lambda item: -item[1])[: asked.rows]:
        print(f"{seconds:6.2f}  {len(clock.signatures[name])} x  {name}")
    twice = {name: found for name, found in clock.signatures.items() if len(found) > 1}
    print(f"\ncompiled several times: {sum(clock.seconds[name] for name in twice):.1f} s")
    for name, found in sorted(twice.items(), key=lambda item: -clock.seconds[item[0]])[: asked.rows]:
        print(f"{clock.seconds[name]:6.2f}  {name}: {'; '.join(found)}"[:400])
    return 0


if __name__ == "__main__":
    sys.exit(main())
