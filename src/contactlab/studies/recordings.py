"""Recordings of a comparison: its runs, titled by their differences."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from contactlab.api.recorder import Recorder
from contactlab.errors import ContactlabError, ContactlabWarning, RequestError, did_you_mean, one_line
from contactlab.parts.registry import Registry
from contactlab.results.inventory import flat
from contactlab.results.load import load_results
from contactlab.results.result_file import FILE
from contactlab.results.results import Results
from contactlab.run.recorders import at_work, recorders_of, when_over
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import parse_toml

RUNS = "runs"
SHOWN = 12
"""Runs that stand side by side on one timeline: more of them are slivers, and take long to open."""


def record_comparison(
    scene: Scene, registry: Registry, folder: Path, names: Iterable[str], for_good: bool = False
) -> None:
    """Let the recorders of `scene` gather the runs of these names in `folder`; what fails is a warning.

    Recorders that work on view do it only `for_good`: if the runs will not stay.
    """
    recorders = recorders_of(scene, registry)
    working = recorders if for_good else {**at_work(recorders), **when_over(recorders)}
    for name in recorders.keys() - working.keys():  # what was made before these runs
        (folder / recorders[name].shown_file).unlink(missing_ok=True)
    gathering = {name: r for name, r in working.items() if type(r).compared is not Recorder.compared}
    runs = titled_runs(runs_of(folder, set(names))) if gathering else {}
    for name, recorder in gathering.items():
        try:
            recorder.compared(folder, runs)
        except Exception as error:
            text = f"the recorder {name} could not gather the comparison: {one_line(error)}"
            warnings.warn(text, ContactlabWarning, stacklevel=2)


def side_by_side(algorithms: Mapping[str, str]) -> list[str]:
    """Names of the runs to show side by side, of runs whose algorithms are given by name.

    All of them, or of more than `SHOWN` the first with each algorithm.
    """
    if len(algorithms) <= SHOWN:
        return list(algorithms)
    first: dict[str, str] = {}
    for name, algorithm in algorithms.items():
        first.setdefault(algorithm, name)
    return list(first.values())[:SHOWN]


def main_runs_of(folder: Path) -> list[str]:
    """Names of the runs that a comparison shows side by side.

    Runs on finer meshes are not among them: they are there for the plot of error against cost.
    """
    table = folder / "table.json"
    rows = json.loads(table.read_text(encoding="utf-8"))["rows"] if table.is_file() else []
    known = {row["name"]: row for row in rows}
    places = [place for place in _places(folder) if not known.get(place.name, {}).get("refines")]
    if len(places) <= SHOWN:
        return [place.name for place in places]
    return side_by_side({p.name: known[p.name]["algorithm"] if p.name in known else _algorithms_of(p) for p in places})


def _algorithms_of(place: Path) -> str:
    """Algorithms of the run in a folder, as its scene names them; empty if that cannot be read."""
    try:
        scene = parse_toml((place / "scene.toml").read_text(encoding="utf-8"), "scene.toml")
        return ", ".join(str(contact["algorithm"]["use"]) for contact in scene["contacts"])
    except (OSError, ContactlabError, LookupError, TypeError):
        return ""


def is_comparison(folder: Path) -> bool:
    """Return whether runs are in a folder of their own below it; else they are side by side in the folder itself."""
    return (folder / RUNS).is_dir()


def left_out(folder: Path) -> str:
    """Return a note if a comparison has more runs than are shown, else an empty string."""
    shown, there = len(main_runs_of(folder)), len(_places(folder))
    if shown == there:
        return ""
    where = f" in {RUNS}" if is_comparison(folder) else ""
    return f"{shown} of {there} runs are shown; --runs NAME ... shows others, by the names of their folders{where}"


def checked_names(folder: Path, asked: Sequence[str]) -> list[str]:
    """Return the requested names of runs. Raises RequestError if the comparison has no run of a name."""
    names = [place.name for place in _places(folder)]
    for name in asked:
        if name not in names:
            raise RequestError(
                "the comparison has no such run", where="--runs", got=name, allowed=", ".join(names) or "none yet",
                hint=did_you_mean(name, names),
            )  # fmt: skip
    return list(asked)


def _places(folder: Path) -> list[Path]:
    """Folders of the runs that left results."""
    inside = folder / RUNS if is_comparison(folder) else folder
    return [place for place in sorted(inside.glob("*")) if (place / FILE).is_file()]


def runs_of(folder: Path, names: Iterable[str] | None = None) -> dict[str, Results]:
    """The runs of a comparison that left results, by the names of their folders; all, or the runs in `names`."""
    found = {}
    for place in _places(folder):
        if names is None or place.name in names:
            try:
                found[place.name] = load_results(place)
            except RequestError:
                continue  # killed before it had stored anything
    return found


def titled_runs(runs: Mapping[str, Results]) -> dict[str, Results]:
    """The runs by algorithm and slave, and by every other key of the scene in which they differ."""
    scenes = {name: flat(parse_toml(results.layout.scene, "scene.toml")) for name, results in runs.items()}
    keys = dict.fromkeys(key for scene in scenes.values() for key in scene)
    different = [key for key in keys if _differs(key, scenes.values())]
    titled: dict[str, Results] = {}
    for name, results in runs.items():
        title = _title(results, scenes[name], different)
        titled[title if title not in titled else f"{title} ({name})"] = results
    return titled


def _differs(key: str, scenes: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether runs differ in a key. A field of an algorithm counts among runs of algorithms that have it."""
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
