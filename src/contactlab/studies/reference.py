"""Reference solutions: a pressure with its error estimate, its scalars, its origin, and the scenes it holds for.

A reference is a JSON file next to the CSV of its curve, in `data/references/` or anywhere else:

    name, title, origin   what it is and where it comes from
    curve, columns        the CSV file and its columns for x, pressure and spread
    mirror                true when the curve shows x >= 0 of a symmetric pressure
    window                [x0, x1] [mm] over which pressures are compared; absent: everywhere
    level                 of the own runs that it is made of: it holds for coarser meshes alone; absent: for all
    scalars               {"reaction": {"value": .., "error": .., "meaning": ..}, ..}
    error_estimate        {"pressure": relative L2 error of the curve, "meaning": ..}
    holds_for             scene keys and their values; null: the key must be absent
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.errors import RequestError, Where, did_you_mean
from contactlab.outside_files import text_outside
from contactlab.studies.profile import Profile, Window, norm

FOLDER = Path(__file__).parent.parent / "data" / "references"

_ABSENT = object()


@dataclass(frozen=True)
class Reference:
    """A reference solution of a scene: curves, forces, and where they come from.

    profile         pressure [MPa] over deformed x [mm]
    spread          of the runs behind it [MPa], at the nodes of `profile`
    window          where pressures are compared, None for everywhere
    scalars         name -> {"value", "error", "meaning"}
    error_estimate  {"pressure": relative L2 error, "meaning": how it was estimated}
    holds_for       scene keys and the values they must have
    level           of the runs that it is made of, None if it is not made of own runs
    """

    name: str
    title: str
    origin: str
    profile: Profile
    spread: Floats
    window: Window | None = None
    scalars: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    error_estimate: Mapping[str, Any] = field(default_factory=dict)
    holds_for: Mapping[str, Any] = field(default_factory=dict)
    level: int | None = None

    @property
    def pressure_uncertainty(self) -> float:
        """Relative L2 error of the pressure, nan when unknown."""
        return float(self.error_estimate.get("pressure", math.nan))

    def scalar(self, name: str) -> float:
        """A scalar's value, nan when the reference has none of that name."""
        return float(self.scalars.get(name, {}).get("value", math.nan))

    @cached_property
    def pressed_range(self) -> Window:
        """Range of x with a pressure above zero [mm]."""
        pressed = self.profile.x[self.profile.value > 0.0]
        return float(pressed[0]), float(pressed[-1])

    def at(self, scene: Mapping[str, Any]) -> Reference:
        """Itself: what a file holds is the same for every scene that it holds for."""
        return self

    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Return why the reference does not hold for a scene (its TOML data); empty if it holds."""
        for key, wanted in self.holds_for.items():
            found = value_at(scene, key)
            if not _agree(found, wanted):
                return f"{key} is {_shown(found)}, {_shown(wanted)} in the reference"
        if self.level is not None and scene.get("level", 1) >= self.level:
            return f"it is made of runs at level {self.level}, allowed: scenes at lower levels"
        return ""


def value_at(data: Any, key: str) -> Any:
    """The value at a dotted key of nested tables and arrays; a private marker if the key is absent."""
    for name in key.split("."):
        try:
            data = data[int(name)] if isinstance(data, list | tuple) else data[name]
        except (LookupError, TypeError, ValueError):
            return _ABSENT
    return data


def _agree(found: Any, wanted: Any) -> bool:
    if wanted is None:
        return found is _ABSENT or not found
    if isinstance(wanted, int | float) and isinstance(found, int | float):
        # Values are compared as written; the tolerance only forgives decimal rounding.
        return math.isclose(found, wanted, rel_tol=1e-9)
    if isinstance(found, Mapping) and isinstance(wanted, str):
        return bool(found.get("use") == wanted and len(found) == 1)
    return bool(found == wanted)


def _shown(value: Any) -> str:
    return "absent" if value is _ABSENT or value is None else repr(value)


def bundled() -> dict[str, Path]:
    """Paths of the bundled references by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.json"))}


def load_reference(
    name: str, *, beside: Path | None = None, where: Where = "reference", known: Sequence[str] = ()
) -> Reference:
    """A reference by bundled name, or by the path of its JSON file (relative to `beside`).

    Raises RequestError if it does not exist, with the `known` names added, or the file is not a reference.
    """
    path = bundled().get(name) or (beside or Path()) / name
    known = sorted({*known, *bundled()})
    if not path.is_file():
        raise RequestError(
            "there is no such reference",
            where=where,
            got=name,
            allowed="the path of a reference's JSON file or one of " + ", ".join(known),
            hint=did_you_mean(name, known),
        )
    return _bare(path) if path.suffix.lower() == ".csv" else _read(path)


def _bare(path: Path) -> Reference:
    """A reference from a CSV file alone, for any scene: columns x and p (or pressure), and spread if it has one.

    Without a spread it is taken as exact. Headings may go on after these words: x_mm, p_MPa.
    """
    try:
        names = next(csv.reader(_lines(path)), [])
        columns = {c: _heading(names, c) for c in ("x", "p", "spread")}
        if not columns["x"] or not columns["p"]:
            raise ValueError(f"its columns are {', '.join(names)}")
        wanted = {"x": columns["x"], "pressure": columns["p"], "spread": columns["spread"]}
        profile, spread = _read_curve(path, wanted, mirror=False)
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise RequestError(
            "the reference cannot be read", where=str(path), got=f"{type(error).__name__}: {error}",
            allowed="a CSV file whose first line names columns x and p, and perhaps spread, with x increasing",
        ) from error  # fmt: skip
    known = norm(Profile(profile.x, spread)) / norm(profile)
    meaning = "the spread in the file" if columns["spread"] else "taken as exact: the file has no spread"
    return Reference(
        path.stem, path.name, f"{path}.", profile, spread, error_estimate={"pressure": known, "meaning": meaning}
    )


def _lines(path: Path) -> list[str]:
    return text_outside(path, str(path), "a CSV file").splitlines(keepends=True)


def _heading(names: Sequence[str], word: str) -> str:
    """The column whose heading begins with a word; empty if no heading does."""
    plain = {name: name.strip().lower().replace("pressure", "p") for name in names}
    fitting = [
        name for name, text in plain.items() if text == word or text.startswith((f"{word}_", f"{word} ", f"{word}["))
    ]
    return fitting[0] if fitting else ""


def _read(path: Path) -> Reference:
    try:
        data = json.loads(text_outside(path, str(path), "a reference in JSON"))
        profile, spread = _read_curve(path.parent / data["curve"], data["columns"], data.get("mirror", False))
        return Reference(
            name=data["name"],
            title=data["title"],
            origin=data["origin"],
            profile=profile,
            spread=spread,
            window=tuple(data["window"]) if data.get("window") else None,
            scalars=data.get("scalars", {}),
            error_estimate=data.get("error_estimate", {}),
            holds_for=data.get("holds_for", {}),
            level=data.get("level"),
        )
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise RequestError(
            "the reference cannot be read",
            where=str(path),
            got=f"{type(error).__name__}: {error}",
            allowed="JSON with name, title, origin, curve, columns and the CSV file that `curve` names",
            hint="compare it with " + str(FOLDER),
        ) from error


def _read_curve(path: Path, columns: Mapping[str, str], mirror: bool) -> tuple[Profile, Floats]:
    rows = list(csv.DictReader(_lines(path)))
    if len(rows) < 2:
        raise ValueError(f"{path.name}: {len(rows)} rows, needed: at least two")
    x, pressure = (np.array([float(row[columns[c]]) for row in rows]) for c in ("x", "pressure"))
    named = columns.get("spread")
    spread = np.array([float(row[named]) for row in rows]) if named else np.zeros(len(x))
    if mirror:
        left = slice(None, 0, -1) if x[0] == 0.0 else slice(None, None, -1)
        x = np.concatenate([-x[left], x])
        pressure, spread = (np.concatenate([v[left], v]) for v in (pressure, spread))
    if np.any(np.diff(x) <= 0.0) or not np.all(np.isfinite(pressure)):
        raise ValueError(f"{path.name}: x must increase and pressures must be finite")
    return Profile(x, pressure), spread
