"""Result folders of runs, comparisons and matrices, with the data that distinguishes them."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactlab.scene.toml_text import read_toml

KINDS = {"table.json": "comparison", "matrix.csv": "matrix", "accuracy.csv": "accuracy", "scene.toml": "run"}
"""File that only a folder of this kind has; the first that exists counts."""

FINISHED = "finished"


@dataclass(frozen=True)
class Folder:
    """A result folder.

    date     of the last change, seconds since 1970
    scene    name of the scene or study
    changes  keys that differ from the bundled scene, or from the first run of this scene in the list
    status   of a run; "4 of 6 finished" of a comparison
    bytes    size with everything inside
    """

    path: Path
    kind: str
    date: float
    scene: str
    changes: Mapping[str, Any]
    status: str
    bytes: int

    @property
    def finished(self) -> bool:
        """Return whether everything in the folder finished."""
        done, of, total = self.status.partition(" of ")
        return done == total.partition(" ")[0] if of else self.status == FINISHED


def folders_in(places: Sequence[Path], bundled: Callable[[str], Mapping[str, Any] | None]) -> list[Folder]:
    """The result folders directly below the places, the oldest first; `bundled` gives a bundled scene by its name."""
    found = [path for place in places for path in _inside(place) if _kind(path)]
    found.sort(key=_date)
    first: dict[str, Mapping[str, Any]] = {}
    return [_read(path, _kind(path), bundled, first) for path in found]


def _inside(place: Path) -> Iterator[Path]:
    if _kind(place):
        yield place
    elif place.is_dir():
        yield from (path for path in place.iterdir() if path.is_dir())


def _kind(path: Path) -> str:
    return next((kind for name, kind in KINDS.items() if (path / name).is_file()), "")


def _date(path: Path) -> float:
    return max((file.stat().st_mtime for file in path.iterdir() if file.is_file()), default=path.stat().st_mtime)


def _read(
    path: Path,
    kind: str,
    bundled: Callable[[str], Mapping[str, Any] | None],
    first: dict[str, Mapping[str, Any]],
) -> Folder:
    size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
    try:
        scene, changes, status = _READERS[kind](path)
    except (OSError, ValueError, KeyError, TypeError) as error:
        scene, changes, status = "", {}, f"unreadable: {type(error).__name__}"
    if kind == "run" and changes:
        own = bundled(scene)
        base = flat(own) if own is not None else first.setdefault(scene, changes)
        changes = differences(changes, base)
    return Folder(path, kind, _date(path), scene, changes, status, size)


def _run(path: Path) -> tuple[str, Mapping[str, Any], str]:
    data, _ = read_toml(path / "scene.toml", "scene.toml")
    summary = path / "summary.json"
    status = json.loads(summary.read_text(encoding="utf-8"))["status"] if summary.is_file() else "interrupted"
    return str(data["name"]), flat(data), str(status)


def _comparison(path: Path) -> tuple[str, Mapping[str, Any], str]:
    data = json.loads((path / "table.json").read_text(encoding="utf-8"))
    study = data["study"]
    done = sum(row["status"] == FINISHED for row in data["rows"])
    return str(study["scene"]), dict(study.get("vary", {})), f"{done} of {len(data['rows'])} finished"


def _cells(path: Path) -> tuple[str, Mapping[str, Any], str]:
    name = next(name for name in ("matrix.csv", "accuracy.csv") if (path / name).is_file())
    with (path / name).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    counts = Counter(row.get("verdict") or row.get("status") or "" for row in rows)
    return path.name, {}, ", ".join(f"{count} {word}" for word, count in counts.most_common(3))


_READERS: dict[str, Callable[[Path], tuple[str, Mapping[str, Any], str]]] = {
    "run": _run, "comparison": _comparison, "matrix": _cells, "accuracy": _cells,
}  # fmt: skip


def flat(data: Any, key: str = "") -> dict[str, Any]:
    """Flatten nested tables to values by dotted key."""
    if isinstance(data, Mapping):
        return {k: v for name, value in data.items() for k, v in flat(value, f"{key}.{name}".strip(".")).items()}
    if isinstance(data, list | tuple) and data and all(isinstance(item, Mapping) for item in data):
        return {k: v for i, item in enumerate(data) for k, v in flat(item, f"{key}.{i}").items()}
    return {key: list(data) if isinstance(data, tuple) else data}


def differences(own: Mapping[str, Any], base: Mapping[str, Any]) -> dict[str, Any]:
    """Values of `own` that differ from `base`, None for what it lacks; another part's name stands for its fields."""
    found = {key: value for key, value in own.items() if key not in base or base[key] != value}
    found |= {key: None for key in base if key not in own}
    changed = {key.removesuffix("use") for key in found if key.endswith(".use")}
    within = [key for key in found if not key.endswith(".use") and any(key.startswith(part) for part in changed)]
    return {key.removesuffix(".use"): value for key, value in found.items() if key not in within}
