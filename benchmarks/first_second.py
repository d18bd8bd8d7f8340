"""Where the first second of a run goes: `contactlab run` in this process, its CPU time split by what is being done.

    python benchmarks/first_second.py [SCENE] [--set KEY=VALUE ...]

Prints the split as JSON. Every moment counts once: what is imported while a recording is written is an import.
"""

from __future__ import annotations

from time import process_time

BEGAN = process_time()  # of the interpreter, before anything of ours

import argparse  # noqa: E402
import builtins  # noqa: E402
import contextlib  # noqa: E402
import importlib  # noqa: E402
import io  # noqa: E402
import json  # noqa: E402
import tempfile  # noqa: E402
from collections.abc import Callable, Sequence  # noqa: E402
from functools import wraps  # noqa: E402
from typing import Any  # noqa: E402

SPANS = (
    "interpreter", "imports", "scene and parts", "building", "loading kernels", "steps", "recording", "report", "rest"
)  # fmt: skip
"""What is told apart, in the order of the table."""


class Split:
    """CPU seconds by what is being done: of nested spans the innermost counts."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(SPANS, 0.0)
        self.seconds["interpreter"] = BEGAN
        self._open = ["rest"]
        self._since = BEGAN

    def begin(self, name: str) -> None:
        """From now on time belongs to `name`."""
        self._pass()
        self._open.append(name)

    def end(self) -> None:
        """From now on time belongs to what was being done before."""
        self._pass()
        self._open.pop()

    def _pass(self) -> None:
        now = process_time()
        self.seconds[self._open[-1]] += now - self._since
        self._since = now

    def of(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, its time told as `name`; an import within an import, or a kernel, is not told anew."""

        @wraps(function)
        def timed(*arguments: Any, **named: Any) -> Any:
            if self._open[-1] == name:
                return function(*arguments, **named)
            self.begin(name)
            try:
                return function(*arguments, **named)
            finally:
                self.end()

        return timed


def watch(split: Split) -> None:
    """Have every part of a run tell its time."""
    builtins.__import__ = split.of("imports", builtins.__import__)
    importlib.import_module = split.of("imports", importlib.import_module)
    from contactlab.api.compiled import kernel
    from contactlab.commands import run as command
    from contactlab.reports import run as report
    from contactlab.run import prepare, simulation

    for module, name, span in (
        (command, "registry_with", "scene and parts"),
        (command, "load_scene", "scene and parts"),
        (simulation, "build", "building"),
        (simulation, "prepare_run", "building"),
        (simulation, "_guarded", "steps"),
        (report, "print_run", "report"),
        (kernel.Kernel, "compile", "loading kernels"),
    ):
        setattr(module, name, split.of(span, getattr(module, name)))
    opened = prepare.open_recordings

    def watched(*arguments: Any, **named: Any) -> Any:
        recordings = split.of("recording", opened)(*arguments, **named)
        for recording in recordings.values():
            for name in dir(recording):
                if not name.startswith("_") and callable(getattr(recording, name)):
                    setattr(recording, name, split.of("recording", getattr(recording, name)))
        return recordings

    prepare.open_recordings = watched


def measure(scene: str, settings: Sequence[str]) -> dict[str, float]:
    """CPU seconds of a run by what was being done."""
    split = Split()
    watch(split)
    from contactlab.cli import main

    words = [word for setting in settings for word in ("--set", setting)]
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        status = main(["run", scene, *words, "--out", f"{folder}/run"])
    split.begin("rest")
    if status:
        raise SystemExit(f"the run ended with {status}")
    return split.seconds


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", nargs="?", default="disc-on-block")
    parser.add_argument("--set", action="append", dest="settings", metavar="KEY=VALUE")
    asked = parser.parse_args()
    print(json.dumps(measure(asked.scene, asked.settings or ["level=1"])))
