"""Words after the program's name, and calls from Python, as nobody should make them."""

from __future__ import annotations

import contextlib
import io
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from made_up import TEXTS, entry, strange

import contactlab
from contactlab.cli import main
from contactlab.scene.scene import Scene

COMMANDS = (
    "run", "compare", "explain", "scenes", "parts", "check", "matrix", "choose", "error-budget", "archive", "view",
    "plot",
    "new-plugin", "new-scene", "cite", "runs", "doctor", "calibrate", "x",
)  # fmt: skip
ALWAYS_WRONG = {"check": "no-such-part", "matrix": "no-such-case", "doctor": "x", "calibrate": "x"}
"""A word for commands that work for long when they are right."""
OPTIONS = (
    "--set", "--with", "--out", "--resume", "--vary", "--reference", "--repeat", "--jobs", "--time-limit",
    "--scheduler",
    "--json", "--png", "--step", "--runs", "--error", "--budget", "--kind", "--from", "--against", "--contact",
    "--level",
    "--quiet", "--verbose", "--keep", "--remove", "-h", "--x", "--", "-",
)  # fmt: skip
LONG = "n" * 300


def words(folder: Path, chance: random.Random) -> list[str]:
    """What stands behind the program's name. Nothing of it is right enough to run for long."""
    command = chance.choice(COMMANDS)
    made = [command, *([ALWAYS_WRONG[command]] if command in ALWAYS_WRONG else ())]
    for _ in range(chance.choice((0, 1, 1, 2, 3))):
        made.append(chance.choice(OPTIONS) if chance.random() < 0.5 else _word(folder, chance))
    return made


def _word(folder: Path, chance: random.Random) -> str:
    kind = chance.choice(("text", "file", "setting", "number", "long"))
    if kind == "file":
        return str(_odd_file(folder, chance))
    if kind == "setting":
        place, new = entry({}, chance)
        return f"{place}={new!r}"
    if kind == "number":
        return chance.choice(("0", "-1", "1e400", "nan", "9" * 5000, "1e9", "0.5%", "s", "1s"))
    return LONG if kind == "long" else str(chance.choice(TEXTS))


def _odd_file(folder: Path, chance: random.Random) -> Path:
    name = chance.choice(
        ("scene.toml", "table.json", "matrix.csv", "archive.sqlite", "results.vtkhdf", "summary.json", "f")
    )
    path, kind = (
        folder / name,
        chance.choice(("empty", "noise", "text", "folder", "pipe", "link", "loop", "device", "deep")),
    )
    if os.path.lexists(path):
        return path
    if kind in ("empty", "noise", "text", "deep"):
        contents = {"empty": b"", "noise": chance.randbytes(400), "text": b"name = 1\n", "deep": b"[" * 100_000}
        path.write_bytes(contents[kind])
    elif kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "link":
        path.symlink_to(folder / "nowhere")
    elif kind == "loop":
        path.symlink_to(path)
    else:
        return Path(chance.choice(("/dev/zero", "/dev/full", "/dev/null", "/proc/self/mem", "/dev/stdin")))
    return path if chance.random() < 0.7 else folder


def program(folder: Path, chance: random.Random) -> tuple[str, str]:
    """Call the program in `folder`; what came, and its words."""
    typed, out, err, before = words(folder, chance), io.StringIO(), io.StringIO(), Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(typed)
    except SystemExit as left:
        status = int(left.code or 0) if isinstance(left.code, int | None) else 99
    finally:
        os.chdir(before)
    told = out.getvalue() + err.getvalue()
    shown = f"{[word[:80] for word in typed]}: status {status}: {told[-300:]!r}"
    if any(ord(c) < 32 and c not in "\n\t\r" for c in told.replace("\x1b[K", "")):
        return "control characters", shown
    if status == 2 and not err.getvalue().strip():
        return "refused without a word", shown
    return {0: "ran", 1: "ran", 2: "refused"}.get(status, "traceback"), shown


def call(scene: Scene, folder: Path, chance: random.Random) -> tuple[Callable[[], Any], str]:
    """A call from Python with one argument or two that are none, and its words."""

    def any_of() -> Any:
        return strange(chance, outside=True)

    name = chance.choice(
        ("load_scene", "with_", "from_data", "simulate", "compare", "load_results", "load_table", "mesh")
    )
    odd = any_of()
    if name == "with_":
        place, _ = entry(scene.data, chance)
        changes = chance.choice((odd, {place: odd}, {odd if isinstance(odd, str | int | tuple | None) else "x": 1}))
        return lambda: scene.with_(changes), f"with_({changes!r:.300})"
    if name == "from_data":
        data = chance.choice((odd, {**scene.data, chance.choice(list(scene.data)): odd}))
        return lambda: Scene.from_data(data), f"from_data({odd!r:.300})"
    if name == "simulate":
        field = chance.choice(("scene", "out", "registry", "resume", "watch", "work", "guards"))
        given = {"scene": scene, "work": 3, "out": folder / "run", field: odd}
        if field == "out" and isinstance(odd, str | Path):
            given["out"] = str(folder / "x") + str(odd)
        return lambda: contactlab.simulate(**given), f"simulate({field}={odd!r:.300})"
    if name == "compare":
        field = chance.choice(
            ("scene_or_study", "vary", "jobs", "changes", "time_limit", "repeat", "reference", "keep")
        )
        given = {"scene_or_study": scene, "vary": {"no.such": [1]}, field: odd}
        return lambda: contactlab.compare(**given), f"compare({field}={odd!r:.300})"
    if name == "mesh":
        given = {"points": [[0, 0], [1, 0], [1, 1], [0, 1]], "cells": [[0, 1, 2, 3]]}
        field = chance.choice(("points", "cells", "sets", "scale"))
        value = {"a": odd} if field == "sets" and chance.random() < 0.6 else odd
        return lambda: contactlab.mesh(**{**given, field: value}), f"mesh({field}={value!r:.300})"
    function = getattr(contactlab, name)
    return lambda: function(odd), f"{name}({odd!r:.300})"
