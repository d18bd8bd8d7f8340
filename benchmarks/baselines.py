"""Ratios kept by kind of machine and version: what `make bench` compares with, and a page of them over versions."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from machine import kind

from contactlab.reports.sheet import Sheet

HERE = Path(__file__).resolve().parent
FILE = HERE / "baselines.json"
Entry = dict[str, Any]
"""`machine` (as `machine.machine` gives it, None where nobody noted it), `date`, `version`, `commit`, `ratios`."""


def load(file: Path = FILE) -> list[Entry]:
    """All that are kept, the oldest first."""
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else []


def like(entries: Sequence[Entry], here: Mapping[str, Any]) -> Entry | None:
    """The newest of a machine of the same kind; None where there is none."""
    own = [entry for entry in entries if entry["machine"] is not None and kind(entry["machine"]) == kind(dict(here))]
    return own[-1] if own else None


def no_like(entries: Sequence[Entry]) -> str:
    """Say why nothing is compared."""
    kinds = dict.fromkeys("one not noted" if e["machine"] is None else kind(e["machine"]) for e in entries)
    return f"no baseline of this kind of machine is kept, but of {'; '.join(kinds) or 'none'}"


def keep(entries: Sequence[Entry], new: Entry, file: Path = FILE) -> None:
    """Add one; that of the same kind of machine and the same commit is replaced."""
    kept = [
        entry
        for entry in entries
        if entry["machine"] is None
        or kind(entry["machine"]) != kind(new["machine"])
        or entry["commit"] != new["commit"]
    ]
    ratios = {name: float(f"{value:.4g}") for name, value in new["ratios"].items()}
    file.write_text(json.dumps([*kept, {**new, "ratios": ratios}], indent=1) + "\n", encoding="utf-8")


HEAD = """# Performance over versions

Ratios of `make bench` (what they are: [benchmarks](benchmarks.md)), kept by \
`python benchmarks/bench.py --update`. Only columns of one kind of machine compare.
"""


def page(entries: Sequence[Entry], head: str = HEAD, what: str = "ratio") -> str:
    """Markdown: a `head`, and a table of `what` is kept for each kind of machine, with a column for each version."""
    return head + "\n".join(_lines(entries, what)) + "\n"


def _lines(entries: Sequence[Entry], what: str) -> Iterable[str]:
    groups: dict[str, list[Entry]] = {}
    for entry in entries:
        name = "Machine not noted" if entry["machine"] is None else kind(entry["machine"])
        groups.setdefault(name, []).append(entry)
    for name, own in groups.items():
        yield from ["", f"## {name}", ""]
        yield from (f"- {_column(entry)}: {_software(entry)}" for entry in own)
        yield ""
        rows = (
            [name, *(f"{entry['ratios'][name]:.3g}" if name in entry["ratios"] else "" for entry in own)]
            for name in dict.fromkeys(name for entry in own for name in entry["ratios"])
        )
        yield Sheet([what, *map(_column, own)], rows).markdown()


def _column(entry: Entry) -> str:
    return f"{entry['version']}, {entry['date']}"


def _software(entry: Entry) -> str:
    if entry["machine"] is None:
        return "neither processor nor versions of compilers were noted"
    told = entry["machine"]["software"]
    return ", ".join(f"{name} {value}" for name, value in told.items() if name != "contactlab")
