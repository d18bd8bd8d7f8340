"""Result folders of all commands, with the data that distinguishes them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactlab.scene.toml_text import read_toml

KINDS = {
    "table.json": "comparison", "matrix.json": "matrix", "accuracy.json": "accuracy", "choose.json": "choice",
    "error-budget.json": "error budget", "scene.toml": "run", "archive.sqlite": "interrupted",
}  # fmt: skip
"""File that only a folder of this kind has; the first that exists counts. An archive alone: nothing has ended yet."""

FINISHED = "finished"

Found = tuple[str, Mapping[str, Any], str, bool]
"""Scene, changes, status, and whether all finished."""


@dataclass(frozen=True)
class Folder:
    """A result folder.

    date     of the last change, seconds since 1970
    scene    name of the scene or study
    changes  keys that differ from the bundled scene, or from the first run of this scene in the list
    status   of a run; "4 of 6 finished" of a comparison; number of cells by verdict of a matrix
    finished whether the command did all that it was asked for, and every run of a comparison finished
    bytes    size with everything inside
    """

    path: Path
    kind: str
    date: float
    scene: str
    changes: Mapping[str, Any]
    status: str
    finished: bool
    bytes: int


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
        scene, changes, status, finished = _READERS[kind](path)
    except (OSError, ValueError, KeyError, TypeError) as error:
        scene, changes, status, finished = "", {}, f"unreadable: {type(error).__name__}", False
    if kind == "run" and changes:
        own = bundled(scene)
        base = flat(own) if own is not None else first.setdefault(scene, changes)
        changes = differences(changes, base)
    return Folder(path, kind, _date(path), scene, changes, status, finished, size)


def _run(path: Path) -> Found:
    data, _ = read_toml(path / "scene.toml", "scene.toml")
    summary = path / "summary.json"
    status = _json(summary)["status"] if summary.is_file() else "interrupted"
    return str(data["name"]), flat(data), str(status), status == FINISHED


def _comparison(path: Path) -> Found:
    data = _json(path / "table.json")
    study, rows = data["study"], data["rows"]
    done = sum(row["status"] == FINISHED for row in rows)
    return str(study["scene"]), dict(study.get("vary", {})), f"{done} of {len(rows)} finished", done == len(rows)


def _matrix(path: Path) -> Found:
    return path.name, {}, _counted(cell["verdict"] for cell in _json(path / "matrix.json")["cells"]), True


def _accuracy(path: Path) -> Found:
    data = _json(path / "accuracy.json")
    return path.name, {}, _counted(point["status"] for point in data["points"]), not data["interrupted"]


def _choice(path: Path) -> Found:
    data = _json(path / "choose.json")
    return path.name, dict(data["choice"]), str(data["verdict"]), True


def _budget(path: Path) -> Found:
    status = str(_json(path / "error-budget.json")["status"])
    return path.name, {}, status, status == FINISHED


def _interrupted(path: Path) -> Found:
    return path.name, {}, "interrupted", False


def _json(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8"))


def _counted(words: Iterable[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in Counter(words).most_common())


_READERS: dict[str, Callable[[Path], Found]] = {
    "run": _run, "comparison": _comparison, "matrix": _matrix, "accuracy": _accuracy, "choice": _choice,
    "error budget": _budget, "interrupted": _interrupted,
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
