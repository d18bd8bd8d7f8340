"""`contactlab archive`: what was run before, here and elsewhere."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contactlab.commands.common import console
from contactlab.errors import RequestError
from contactlab.jobs.archive import CHOICES, FILE, Archive, in_words
from contactlab.jobs.rows import finite
from contactlab.jobs.system import machine
from contactlab.reports.sheet import Sheet

DAMAGED = 1
"""Exit status if a part of an archive is damaged."""
ENDS = ("CPU s", "made", "machine")
"""Last columns of both lists."""


def archive(options: argparse.Namespace) -> int:
    """List, merge or export an archive of runs, as the arguments say."""
    return {"list": _list, "merge": _merge, "export": _export}[options.action](options.paths)


def _opened(words: list[str], most: int) -> list[Path]:
    if len(words) > most:
        raise RequestError("too many archives", where="archive", got=" ".join(words), allowed=f"at most {most}")
    found = [Path(word) / FILE if Path(word).is_dir() else Path(word) for word in words or ["."]]
    for path in found:
        if not path.is_file():
            raise RequestError(
                "there is no archive", where="archive", got=str(path), allowed="archive.sqlite or a folder with one"
            )
    return found


def _list(words: list[str]) -> int:
    (path,) = _opened(words, 1)
    with Archive(path, write=False) as kept:
        damage = _told(kept)
        cells = Sheet(
            (*CHOICES, "verdict", *ENDS), ([*(c[n] for n in CHOICES), c["verdict"], *_ends(c)] for c in kept.cells())
        )
        heads = ("scene", "algorithm", "slave", "level", "name", "status")
        rows = Sheet((*heads, *ENDS), ([*(str(row[name]) for name in heads), *_ends(row)] for row in kept.rows()))
        runs = sum(1 for _ in kept.runs())
    for found, what in ((cells, "cells"), (rows, "rows of comparisons")):
        if found.rows:
            console().print(found)
        console().print(f"{len(found.rows)} {what}", highlight=False)
    console().print(f"{runs} runs", highlight=False)
    return DAMAGED if damage else 0


def _told(kept: Archive) -> bool:
    """Warn of entries that did not pass the check; returns whether there are any."""
    if kept.damage:
        print(f"contactlab: warning: {kept.path}: {in_words(kept.damage)}; skipped", file=sys.stderr)
    return bool(kept.damage)


def _ends(entry: Mapping[str, Any]) -> tuple[str, str, str]:
    cpu = "" if entry["cpu_s"] is None else f"{entry['cpu_s']:.2f}"
    return cpu, entry["made"], "here" if entry["machine"] == machine() else entry["machine"]


def _merge(words: list[str]) -> int:
    """Copy everything of the second archive into the first."""
    if len(words) != 2:
        raise RequestError("merge needs two archives", where="archive merge", got=len(words), allowed="A B")
    into, other = _opened(words, 2)
    with Archive(into) as kept:
        damage = _told(kept)
        came, lost = kept.take(other)
    if lost:
        damage = True
        print(f"contactlab: warning: {other}: {in_words(lost)}; not merged", file=sys.stderr)
    told = ", ".join(f"{count} {name}" for name, count in came.items())
    console().say(f"from {other} into {into}: {told}")
    return DAMAGED if damage else 0


def _export(words: list[str]) -> int:
    """All cells, rows and runs, without their records, as JSON on standard output."""
    (path,) = _opened(words, 1)
    with Archive(path, write=False) as kept:
        damage = _told(kept)
        data = finite({"format": 1, "cells": list(kept.cells()), "runs": list(kept.runs()), "rows": list(kept.rows())})
    json.dump(data, sys.stdout, indent=1)
    sys.stdout.write("\n")
    return DAMAGED if damage else 0
