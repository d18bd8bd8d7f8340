"""A process that runs scenes in children of its own: they begin at once, compiled, and may be killed.

Reads lines of JSON from standard input: [scene TOML, folder, resume, lives, largest, saves]. A child that
does not live for ever (0) dies after so many seconds of processor time, at once and without a chance to tidy
up, as by kill -9; unlike the clock on the wall that does not depend on what else the machine does. With
`largest` no file may become larger than so many bytes: to a program that is a full disk. With `saves` it is
killed right after it has saved its state for the so manieth time.
Answers: "pid N", "frame" whenever one was stored, "cpu SECONDS" and "exit STATUS".
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import traceback
import warnings
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

from contactlab.run import run as one_run
from contactlab.run.interruption import Interrupted
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import parse_toml

SAVE_EVERY = 0.01  # seconds: some ten saved states in a run, so that it is killed while it writes them, too


def tell(*words: object) -> None:
    """One line to the test, at once."""
    sys.stdout.write(" ".join(str(word) for word in words) + "\n")
    sys.stdout.flush()


def run(text: str, folder: str, resume: bool, lives: float, largest: int, saves: int) -> int:
    """Simulate; the exit status is that of the command line."""
    warnings.simplefilter("ignore")
    one_run.SAVE_EVERY, one_run.SAVE_SHARE = 0.0 if saves else SAVE_EVERY, 0.0
    if saves:
        die_after_saving(saves)
    signal.setitimer(signal.ITIMER_PROF, lives)
    if largest:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))
    scene = Scene.from_data(parse_toml(text, "scene.toml"))
    try:
        results = simulate(scene, Path(folder), progress=lambda *_: tell("frame"), resume=resume)
    except Interrupted:
        return 130
    return 0 if results.status == "finished" else 1


def die_after_saving(times: int) -> None:
    """Have this process killed right after it has saved its state so often."""
    save, left = one_run.Run.save, [times]

    def save_and_die(self: one_run.Run) -> None:
        save(self)
        left[0] -= 1
        if not left[0]:
            os.kill(os.getpid(), signal.SIGKILL)

    one_run.Run.save = save_and_die  # type: ignore[method-assign]


@cache
def warm_up(text: str) -> None:
    """Let the kernels of the scene be loaded here, so that children find them loaded."""
    scene = Scene.from_data(parse_toml(text, "scene.toml"))
    steps = {"integrator.steps": 2} if "steps" in scene.integrator else {"time.end": 1e-7}
    with TemporaryDirectory() as folder:
        simulate(scene.with_(steps), folder)


def main() -> None:
    """Serve until standard input ends."""
    for line in sys.stdin:
        warm_up(json.loads(line)[0])
        child = os.fork()
        if child == 0:
            status = 3
            try:
                status = run(*json.loads(line))
            except Exception:
                traceback.print_exc()
            finally:
                tell("cpu", process_time())
                os._exit(status)
        tell("pid", child)
        _, status = os.waitpid(child, 0)
        tell("exit", os.waitstatus_to_exitcode(status))


if __name__ == "__main__":
    main()
