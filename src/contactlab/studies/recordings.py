"""What recorders make of a comparison: its runs by what tells them apart."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactlab.errors import RequestError, one_line
from contactlab.results.load import load_results
from contactlab.results.results import Results
from contactlab.results.stored_file import FILE
from contactlab.run.recorders import recorders_of
from contactlab.scene.toml_text import parse_toml

if TYPE_CHECKING:
    from contactlab.parts.registry import Registry
    from contactlab.scene.scene import Scene

RUNS = "runs"


def record_comparison(scene: Scene, registry: Registry, folder: Path, names: Iterable[str]) -> None:
    """Let the recorders of `scene` gather the runs of these names in `folder`; what fails is a warning."""
    recorders = recorders_of(scene, registry)
    runs = titled_runs({name: results for name, results in runs_of(folder).items() if name in set(names)})
    for name, recorder in recorders.items():
        try:
            recorder.compared(folder, runs)
        except Exception as error:
            text = f"the recorder {name} could not gather the comparison: {one_line(error)}"
            warnings.warn(text, RuntimeWarning, stacklevel=2)


def main_runs_of(folder: Path) -> dict[str, Results]:
    """The runs that a comparison shows side by side: not those on finer meshes for the plot of error against cost."""
    table = folder / "table.json"
    rows = json.loads(table.read_text(encoding="utf-8"))["rows"] if table.is_file() else []
    finer = {row["name"] for row in rows if row.get("refines")}
    return {name: results for name, results in runs_of(folder).items() if name not in finer}


def runs_of(folder: Path) -> dict[str, Results]:
    """The runs of a comparison that left results, by the names of their folders."""
    found = {}
    for place in sorted((folder / RUNS).glob("*")):
        if (place / FILE).is_file():
            try:
                found[place.name] = load_results(place)
            except RequestError:
                continue  # killed before it had stored anything
    return found


def titled_runs(runs: Mapping[str, Results]) -> dict[str, Results]:
    """The runs by algorithm and slave, and by every other key of the scene in which they differ."""
    scenes = {name: _flat(parse_toml(results.layout.scene, "scene.toml")) for name, results in runs.items()}
    keys = dict.fromkeys(key for scene in scenes.values() for key in scene)
    different = [key for key in keys if _differs(key, scenes.values())]
    titled: dict[str, Results] = {}
    for name, results in runs.items():
        title = _title(results, scenes[name], different)
        titled[title if title not in titled else f"{title} ({name})"] = results
    return titled


def _differs(key: str, scenes: Iterable[Mapping[str, Any]]) -> bool:
    """Whether runs differ in a key. A field of an algorithm counts among runs of algorithms that have it."""
    own = ".algorithm." in key and not key.endswith(".use")
    return len({str(scene.get(key)) for scene in scenes if key in scene or not own}) > 1


def _title(results: Results, scene: Mapping[str, Any], different: Iterable[str]) -> str:
    contacts = results.layout.contacts
    shown = [", ".join(dict.fromkeys(contact.algorithm for contact in contacts)) or "no contact"]
    for key in different:
        last = key.rpartition(".")[2]
        if not contacts and key.startswith("contacts"):
            continue
        if last == "swap":
            shown.append(f"slave {contacts[0].slave.partition('.')[0]}")
        elif ".algorithm.use" not in key and (key in scene or ".algorithm." not in key):
            name = key.removesuffix(".use").rpartition(".")[2]
            shown.append(f"{name} {scene.get(key, 'none')}")
    return ", ".join(shown)


def _flat(data: Any, key: str = "") -> dict[str, Any]:
    """Flatten nested tables to values by dotted key."""
    if isinstance(data, Mapping):
        return {k: v for name, value in data.items() for k, v in _flat(value, f"{key}.{name}".strip(".")).items()}
    if isinstance(data, list) and data and all(isinstance(item, Mapping) for item in data):
        return {k: v for i, item in enumerate(data) for k, v in _flat(item, f"{key}.{i}").items()}
    return {key: data}
