"""Variations of a study: lists of values, ranges and samples, keys that go together, and keys of all bodies."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from contactlab.errors import RequestError, Where, below

TIE = "&"
"""Separator of keys that take their values together."""
RANGES = ("linspace", "logspace")
_ALLOWED = (
    "a list of values; {linspace = [FIRST, LAST, COUNT]}; {logspace = [FIRST, LAST, COUNT]}; "
    "{sample = [LEAST, LARGEST], count = N, seed = S}"
)
MOST = 10_000
"""Values of one key: more is taken as an error in the study."""


def is_range(value: Any) -> bool:
    """Return whether a table describes how to make values, and is not a table of further keys."""
    return isinstance(value, Mapping) and any(name in value for name in (*RANGES, "sample"))


def expanded(vary: Mapping[str, tuple[Any, Where]]) -> dict[str, tuple[Any, Where]]:
    """Ranges as lists; keys with samples as one entry of keys that go together, by Latin hypercube or at random."""
    found: dict[str, tuple[Any, Where]] = {}
    sampled: dict[str, tuple[Mapping[str, Any], Where]] = {}
    for name, (value, where) in vary.items():
        if not is_range(value):
            found[name] = value, where
        elif "sample" in value:
            sampled[name] = value, where
        else:
            found[name] = _range(value, where), where
    if sampled:
        first = next(iter(sampled.values()))[1]
        values = _samples(sampled)
        found[f" {TIE} ".join(sampled)] = (values if len(sampled) > 1 else [row[0] for row in values]), first
    return found


def _range(value: Mapping[str, Any], where: Where) -> list[float] | list[int]:
    (kind, numbers), *rest = value.items()
    if rest or kind not in RANGES or not _numbers(numbers, 3) or numbers[2] != int(numbers[2]):
        raise RequestError("this is not a range", where=where, got=dict(value), allowed=_ALLOWED)
    first, last, count = float(numbers[0]), float(numbers[1]), int(numbers[2])
    if not 2 <= count <= MOST:
        raise RequestError("a range has at least 2 values", where=where, got=count, allowed=f"2 to {MOST}")
    if kind == "logspace" and not first * last > 0.0:
        raise RequestError(
            "both ends of a logarithmic range must have the same sign", where=where, got=[first, last],
            hint="logspace takes the ends themselves, not their powers: [0.01, 1.0, 5]",
        )  # fmt: skip
    made = np.linspace(first, last, count) if kind == "linspace" else np.geomspace(first, last, count)
    found = [_short(v) for v in made]
    if all(isinstance(end, int) for end in numbers[:2]) and all(v.is_integer() for v in found):
        return [int(v) for v in found]  # keys such as level take no others
    return found


def _samples(sampled: Mapping[str, tuple[Mapping[str, Any], Where]]) -> list[list[float]]:
    """Rows of values, one per key; all keys agree in count, seed and way."""
    settings = {}
    for name, (value, where) in sampled.items():
        unknown = set(value) - {"sample", "count", "seed", "by"}
        ends = value["sample"]
        if unknown or not _numbers(ends, 2) or not ends[0] < ends[1]:
            raise RequestError("this is not a sample", where=where, got=dict(value), allowed=_ALLOWED)
        settings[name] = (value.get("count"), value.get("seed", 0), value.get("by", "latin-hypercube"))
    (_, where), *_ = sampled.values()
    if len(set(settings.values())) > 1:
        raise RequestError(
            "keys that are sampled go together: they need one count, seed and way", where=where, got=settings
        )
    count, seed, way = next(iter(settings.values()))
    if not isinstance(count, int) or not 1 <= count <= MOST or not isinstance(seed, int):
        raise RequestError("count and seed of samples are whole numbers", where=below(where, "count"), got=count,
                           allowed=f"count = 1 to {MOST}, seed = any")  # fmt: skip
    if way not in ("latin-hypercube", "random"):
        raise RequestError(
            "no such way of sampling", where=below(where, "by"), got=way, allowed="latin-hypercube, random"
        )
    generator, width = np.random.default_rng(seed), len(sampled)
    if way == "random":
        places = generator.random((count, width))
    else:  # McKay, Beckman & Conover 1979: each of `count` equal parts of each key has one sample
        strata = np.stack([generator.permutation(count) for _ in range(width)], axis=1)
        places = (strata + generator.random((count, width))) / count
    ends = np.array([value["sample"] for value, _ in sampled.values()], float)
    made = ends[:, 0] + places * (ends[:, 1] - ends[:, 0])
    return [[_short(v) for v in row] for row in made]


def _numbers(values: Any, count: int) -> bool:
    return (
        isinstance(values, Sequence)
        and len(values) == count
        and all(isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) for v in values)
    )


def _short(value: float) -> float:
    """Six figures: what a table shows is what was run."""
    return float(f"{value:.6g}")


def checked_ties(vary: Mapping[str, tuple[Any, Where]]) -> None:
    """Raise RequestError unless keys that go together have as many values each time."""
    for name, (values, where) in vary.items():
        count = len(_keys(name))
        for value in values if count > 1 else ():
            if not isinstance(value, list | tuple) or len(value) != count:
                raise RequestError(
                    f"{count} keys go together here, and each entry needs a value for each of them", where=where,
                    got=value, allowed=f"lists of {count} values",
                )  # fmt: skip


def _keys(name: str) -> list[str]:
    return [part.strip() for part in name.split(TIE)]


def combinations(vary: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """All combinations of the varied values, the first key slowest; keys that go together count as one."""
    axes = []
    for name, values in vary.items():
        keys = _keys(name)
        rows = [[value] for value in values] if len(keys) == 1 else values
        axes.append([dict(zip(keys, row, strict=True)) for row in rows])
    return [{k: v for part in parts for k, v in part.items()} for parts in itertools.product(*axes)]


def without_star(varied: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """The changes with a key for each body, contact or other entry in the place of `*`. Raises RequestError."""
    return {full: value for key, value in varied.items() for full in _starred(key, data)}


def _starred(key: str, data: Any) -> list[str]:
    """A key for each entry in the place of each `*`."""
    found: list[tuple[list[str], Any]] = [([], data)]
    for name in key.split("."):
        found = [
            ([*path, each], _entry(inner, each))
            for path, inner in found
            for each in ([name] if name != "*" else _names(inner))
        ]
    if not found:
        raise RequestError("nothing matches *", where=key, got=key.partition("*")[0].rstrip(".") or "*",
                           allowed="a table or list of the scene: bodies.*.element, contacts.*.algorithm")  # fmt: skip
    return [".".join(path) for path, _ in found]


def _names(data: Any) -> list[str]:
    return [str(n) for n in range(len(data))] if isinstance(data, list) else list(data or ())


def _entry(data: Any, name: str) -> Any:
    if isinstance(data, list):
        data = {str(number): entry for number, entry in enumerate(data)}
    return data.get(name) if isinstance(data, Mapping) else None
