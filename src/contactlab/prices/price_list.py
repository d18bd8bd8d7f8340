"""Prices of one machine and one version, as they are kept in the user's cache.

The file is named by processor, cores and the versions of contactlab, numba and NumPy: another machine that shares the
folder, and another version, have files of their own.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from contactlab.api.compiled.cache import cache_root
from contactlab.errors import RequestError
from contactlab.parts.machine import processor_name

FORMAT = 2
LIBRARIES = ("contactlab", "numba", "numpy")
COMMAND = "contactlab calibrate"


class NoPricesError(RequestError):
    """There are no prices of this machine and version that could be used."""


@dataclass(frozen=True)
class PriceList:
    """Prices of this machine.

    made         date
    machine      processor and cores
    versions     of what makes the machine code
    units        CPU time [s] of each unit of work (`contactlab.prices.counts`)
    unknown      parts without a price, and why
    start_s      CPU time [s] of a run outside its steps: imports, building, loading kernels, closing files; by kinds
    process_mib  memory [MiB] of a run beside its arrays; by kinds (`contactlab.prices.start`)
    together     what explicit runs with many parts cost over what their units do
    step_mib     memory [MiB] of arrays that implicit steps make, per N log2 N of N nodes
    """

    made: str
    machine: str
    versions: Mapping[str, str]
    units: Mapping[str, float]
    unknown: Mapping[str, str]
    start_s: Mapping[str, float]
    process_mib: Mapping[str, float]
    step_mib: float
    together: float = 1.0
    format: int = FORMAT


def machine() -> str:
    """Processor and number of cores."""
    return f"{processor_name()}, {os.cpu_count()} cores"


def versions() -> dict[str, str]:
    """Versions that prices belong to."""
    return {name: version(name) for name in LIBRARIES}


def price_file() -> Path:
    """Where the prices of this machine and these versions are kept."""
    words = [machine(), *(f"{name} {number}" for name, number in versions().items())]
    return cache_root() / "prices" / f"{re.sub(r'[^A-Za-z0-9.]+', '-', '_'.join(words))}.json"


def load_prices() -> PriceList:
    """The prices of this machine and version. Raises NoPricesError, which says what to do."""
    file = price_file()
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        others = len(list(file.parent.glob("*.json"))) if file.parent.is_dir() else 0
        of_others = f" ({others} of other versions or machines cannot be used)" if others else ""
        raise NoPricesError(
            f"prices of this machine and version are not measured yet{of_others}", hint=COMMAND
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise NoPricesError(f"the file of prices cannot be read: {error}", where=str(file), hint=COMMAND) from error
    try:
        return checked(json.loads(text))
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise NoPricesError(
            f"the file of prices is broken: {error}", where=str(file), hint=f"{COMMAND} makes it anew"
        ) from error


def checked(data: Any) -> PriceList:
    """A price list from plain tables. Raises ValueError, TypeError or KeyError where they hold something else."""
    if not isinstance(data, Mapping) or data.get("format") != FORMAT:
        raise ValueError("it has another format")
    if other := foreign(data):
        raise ValueError(other)
    found = PriceList(**data)
    starts = [*found.start_s.values(), *found.process_mib.values()]
    numbers = [*found.units.values(), *starts, found.step_mib, found.together]
    if not found.units or not all(isinstance(value, int | float) and math.isfinite(value) for value in numbers):
        raise ValueError("a price is no number")
    if not starts or set(found.start_s) != set(found.process_mib):
        raise ValueError("costs of starts are missing")
    return found


def foreign(data: Mapping[str, Any]) -> str:
    """What is said of a file that was made elsewhere and copied under the name of one from here; empty for others."""
    for what, here in (("machine", machine()), ("versions", versions())):
        if data[what] != here:
            return f"it is of another machine or version: {data[what]}, and here is {here}"
    return ""


def store_prices(prices: PriceList) -> Path:
    """Keep prices, whole or not at all; the file. Raises RequestError where it cannot be written."""
    return write_whole(price_file(), asdict(prices), "the prices")


def write_whole(file: Path, data: Mapping[str, Any], what: str) -> Path:
    """Write a JSON file, whole or not at all. Raises RequestError, which says `what` could not be kept."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        part = file.with_suffix(f".{os.getpid()}.part")
        part.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        part.replace(file)
    except OSError as error:
        raise RequestError(
            f"{what} cannot be kept: {(error.strerror or str(error)).lower()}",
            where=str(file),
            hint="CONTACTLAB_CACHE names another folder",
        ) from error
    return file
