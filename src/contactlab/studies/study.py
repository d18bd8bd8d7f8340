"""Studies: a scene, what to vary, what to measure and what to compare with."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from contactlab.errors import Location, RequestError, Where, below, did_you_mean
from contactlab.scene.fields import key
from contactlab.scene.reading import read_table
from contactlab.scene.toml_text import location, parse_value, read_toml
from contactlab.studies.columns import BY_NAME
from contactlab.studies.vary import checked_ties, combinations, expanded, is_range

FOLDER = Path(__file__).parent.parent / "data" / "studies"


FINEST = "finest"
"""Name of the reference that is made from runs on finer meshes."""


@dataclass(frozen=True)
class Pareto:
    """`[pareto]`: the levels at which error is plotted against cost."""

    levels: tuple[int, ...] = key((), least=1, says="mesh levels to run in addition")


MOST_RUNS = 10_000
"""Runs of one combination: a median of more is no better, and a plan holds each of them."""


def check_repeat(repeat: int | None, where: str) -> None:
    """Raise RequestError for a number of runs that no study allows; None leaves it to the study."""
    if repeat is not None and not 1 <= repeat <= MOST_RUNS:
        raise RequestError("no such number of runs", where=where, got=repeat, allowed=f"1 to {MOST_RUNS}")


@dataclass(frozen=True)
class Study:
    """A study file.

    `vary` maps scene keys to lists of values; every combination is run. See `contactlab.studies.vary`.
    """

    scene: str = key(says="the name of a bundled scene, or a scene file next to the study")
    format: Literal[1] = key(1, says="version of the study format")
    name: str = key("", says="heading of the report; not written: the name of the file")
    reference: str | None = key(
        None,
        says='reference to compare with: a name, a JSON or CSV file, or "finest"; else the first that fits',
    )
    measures: tuple[str, ...] = key((), says="columns of the printed table; not written: the usual ones")
    repeat: int = key(1, least=1, most=MOST_RUNS, says="runs of each combination; the costs shown are medians")
    time_limit: float | None = key(None, above=0.0, says="wall time that one run may take [s]; not written: any")
    contact: str = key("contacts.0", says="the contact whose pressure is compared")
    vary: Mapping[str, tuple[Any, ...]] = field(default_factory=dict, metadata={"hidden": True})
    pareto: Pareto = key(Pareto(), says="levels of the plot of error against cost")
    path: Path | None = field(default=None, metadata={"hidden": True})

    def combinations(self) -> list[dict[str, Any]]:
        """All combinations of the varied values, the first key slowest."""
        return combinations(self.vary)

    @property
    def folder(self) -> Path | None:
        """Folder from which relative paths in the study start."""
        return self.path.parent if self.path else None

    def as_data(self) -> dict[str, Any]:
        """The study as it could be written in a file."""
        data: dict[str, Any] = {"scene": self.scene, "contact": self.contact, "repeat": self.repeat}
        optional = {
            "name": self.name,
            "reference": self.reference,
            "measures": list(self.measures),
            "time_limit": self.time_limit,
        }
        data |= {name: value for name, value in optional.items() if value}
        data["vary"] = {name: list(values) for name, values in self.vary.items()}
        if self.pareto.levels:
            data["pareto"] = {"levels": list(self.pareto.levels)}
        return data


def bundled_studies() -> dict[str, Path]:
    """Paths of the bundled studies by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def is_study(data: Mapping[str, Any]) -> bool:
    """Return whether TOML data are a study rather than a scene."""
    return "scene" in data or "vary" in data


def read_study(path: Path, measures: Collection[str] = tuple(BY_NAME)) -> Study:
    """A study file; it may list these measures. Raises RequestError naming file, line and key."""
    data, lines = read_toml(path, str(path))
    return study_from(data, location(str(path), lines), path, measures)


def study_from(
    data: Mapping[str, Any], where: Location, path: Path | None = None, measures: Collection[str] = tuple(BY_NAME)
) -> Study:
    """Make a study from TOML data; it may list these measures. Raises RequestError."""
    tables = dict(data)
    vary = checked_vary(_flat(tables.pop("vary", {}), below(where, "vary")))
    tables.setdefault("name", path.stem if path else "")
    _check_measures(tables.get("measures", ()), measures, below(where, "measures"))
    return read_table(Study, tables, where, vary=vary, path=path)


def _flat(table: Any, where: Where) -> dict[str, tuple[Any, Where]]:
    """Dotted keys and their lists; nested tables and quoted dotted keys are the same."""
    if not isinstance(table, Mapping):
        raise RequestError("a table is needed here", where=where, got=table, allowed=_VARY)
    found: dict[str, tuple[Any, Where]] = {}
    for name, value in table.items():
        inner = below(where, name)
        if isinstance(value, Mapping) and not is_range(value):
            found |= {f"{name}.{rest}": item for rest, item in _flat(value, inner).items()}
        else:
            found[name] = (value, inner)
    return found


_VARY = "scene keys and lists of values, such as level = [1, 2], or ranges: { linspace = [0.0, 1.0, 5] }"


def checked_vary(vary: Mapping[str, tuple[Any, Where]]) -> dict[str, tuple[Any, ...]]:
    """Lists of values by scene key. Raises RequestError for other values, empty lists, or keys named twice."""
    lists = expanded(vary)
    found = {name: _checked_values(values, where) for name, (values, where) in lists.items()}
    checked_ties({name: (values, lists[name][1]) for name, values in found.items()})
    return found


def _as_list(values: Any) -> str:
    """Guess what was meant: a range that is written like a call or under another name, or a list of one value."""
    if isinstance(values, Mapping) and "use" not in values:
        three = next((list(v) for v in values.values() if isinstance(v, list | tuple) and len(v) == 3), [0.0, 1.0, 5])
        return f"{{ linspace = {three} }}"
    call = re.fullmatch(r"\s*(linspace|logspace)\s*\((.*)\)\s*", str(values))
    return f"{{ {call[1]} = [{call[2]}] }}" if call else f"[{values}]"


def _checked_values(values: Any, where: Where) -> tuple[Any, ...]:
    if not isinstance(values, list | tuple):
        raise RequestError("a list is needed here", where=where, got=values, allowed=_VARY, hint=_as_list(values))
    if not values:
        raise RequestError("the list is empty", where=where, got=values, allowed=_VARY)
    repeated = [value for k, value in enumerate(values) if value in values[:k]]
    if repeated:
        hint = "the key `repeat` of a study measures costs again"
        raise RequestError("a value is listed twice", where=where, got=repeated[0], hint=hint)
    return tuple(values)


def parse_vary(texts: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """`KEY=[V1, V2]` as typed on a command line; bare words are strings. Raises RequestError."""
    vary: dict[str, tuple[Any, Where]] = {}
    for text in texts:
        name, equals, values = text.partition("=")
        name = name.strip()
        where = f"--vary {name}"
        if not equals or not name:
            raise RequestError("no key is varied here", where="--vary", got=text, allowed="KEY=[V1, V2]")
        if name in vary:
            raise RequestError("the key is varied twice", where=where, hint="write one list with all values")
        vary[name] = (parse_value(values.strip(), where), where)
    return checked_vary(vary)


def _check_measures(measures: Any, known: Collection[str], where: Where) -> None:
    for name in measures if isinstance(measures, list | tuple) else ():
        if isinstance(name, str) and name not in known:
            raise RequestError(
                "no such measure", where=where, got=name, allowed=", ".join(known), hint=did_you_mean(name, known)
            )
