"""The gallery: bundled scenes and cases with pictures, what they show, cost, TOML and timeline, run for the page."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import contactlab
from contactlab.api import Case
from contactlab.cases.run_case import scene_of
from contactlab.errors import ContactlabError
from contactlab.parts.registry import Registry, default_registry
from contactlab.results.results import Results
from contactlab.scene.scene import Scene, bundled_scenes, load_scene
from contactlab.studies.measure_run import without_compilation
from contactlab.verdicts.plan import Request, plan

MOST_STEPS = 40_000
"""Of a run for the gallery: longer ones are shown as far as they came, and say so."""
LARGEST_TIMELINE = 4 * 2**20  # bytes; larger ones are left to who makes the run


@dataclass(frozen=True)
class Entry:
    """One figure of the gallery: a scene, what it shows, its TOML, and the command that makes it."""

    name: str
    scene: Scene
    words: str
    toml: str
    command: str
    more: str = ""
    guards: bool = True


def gallery(folder: Path, runs: bool, scenes: Sequence[str], cases: Sequence[str]) -> str:
    """The page with these scenes and cases; pictures and timelines go into `folder`, pictures/gallery of the site."""
    folder.mkdir(parents=True)
    bundled, registry = bundled_scenes(), default_registry()
    of_scenes = _grid([_scene_entry(name, bundled[name]) for name in scenes], folder, runs)
    of_cases = _grid([_case_entry(name, registry) for name in cases], folder, runs)
    return (
        "# Gallery\n\nEvery bundled scene and every case, before and after, as it was run for this page. "
        "`contactlab run NAME` makes a run and its timeline, `contactlab view` opens it (or a timeline from here), "
        "`contactlab new-scene mine --from NAME` begins one of your own.\n\n"
        f"## Scenes\n\n{of_scenes}\n\n## Cases\n\nQuestions with known answers. Pictures are of the first run of each, "
        "with one algorithm: `contactlab matrix NAME` puts the whole case to every contact algorithm, "
        f"[and these are the answers](cases.md).\n\n{of_cases}\n"
    )


def _scene_entry(name: str, path: Path) -> Entry:
    scene, text = load_scene(name), path.read_text(encoding="utf-8")
    said = re.match(r"(?:# .*\n)*", text)
    shows = " ".join(line.removeprefix("# ") for line in said[0].splitlines()) if said else ""
    words = f"{shows} {scene.source}" if shows else scene.source
    return Entry(name, scene, words, text, f"contactlab run {name}")


def _case_entry(name: str, registry: Registry) -> Entry:
    """The first run of the quick cell with mortar-p1, or with the first algorithm that the case is made for."""
    asked = [(cell.case(registry), cell.setup) for cell in plan(Request([name]), registry)]
    case, setup = next(pair for pair in sorted(asked, key=_mortar_first) if not pair[0].applies(pair[1]))
    job = case.plan(setup, {})[0]
    scene = scene_of(job, registry)
    part = registry.offer("case", name).part
    more = f'<a href="cases.html#{_anchor(case)}">all its numbers</a>'
    words = f"{part.summary}. {part.reference}"
    return Entry(f"case-{name}", scene, words, scene.toml(), f"contactlab matrix {name}", more, job.guards)


def _mortar_first(pair: tuple[Case, Any]) -> bool:
    return not str(pair[1].algorithm).startswith("mortar-p1")


def _anchor(case: Case) -> str:
    """The heading of a case on the page of cases, as the site names it."""
    return re.sub(r"[^\w\- ]", "", case.title.lower()).strip().replace(" ", "-")


def _grid(entries: list[Entry], folder: Path, runs: bool) -> str:
    figures = "\n".join(_figure(entry, folder, runs) for entry in entries)
    return f'<div class="gallery" markdown="0">\n{figures}\n</div>'


def _figure(entry: Entry, folder: Path, runs: bool) -> str:
    title = entry.name.removeprefix("case-")
    entry.scene.plot().savefig(folder / f"{entry.name}.png", dpi=90)
    pictures = [_picture(f"{entry.name}.png", f"{title}: meshes and contacts")]
    said, link = "", ""
    if runs:
        results, link = _run(entry, folder)
        pictures += _end_of(results, folder / f"{entry.name}-end.png")
        said = cost(results)
    rest = [entry.more, link, f"<code>{escape(entry.command)}</code>"]
    toml = f"<details><summary>TOML</summary><pre>{escape(entry.toml)}</pre></details>"
    words = f"<p><b>{title}</b>: {escape(entry.words[:1].upper() + entry.words[1:])}</p>" + (
        f"<p>{said}</p>" if said else ""
    )
    return (
        f'<figure id="{entry.name}">{"".join(pictures)}<figcaption>{words}{toml}'
        f"<p>{'<br>'.join(text for text in rest if text)}</p></figcaption></figure>"
    )


def _picture(file: str, words: str) -> str:
    return f'<img loading="lazy" src="pictures/gallery/{file}" alt="{escape(words)}">'


def _run(entry: Entry, folder: Path) -> tuple[Results, str]:
    """The run, and a link to its timeline where it is small enough to be loaded."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "run"
        scene = entry.scene.with_({"record.recorders": ["rerun"]})
        results = contactlab.simulate(scene, out=out, work=MOST_STEPS, guards=entry.guards)
        timeline = out / "timeline.rrd"
        if not timeline.is_file() or timeline.stat().st_size > LARGEST_TIMELINE:
            return results, ""
        shutil.copy(timeline, folder / f"{entry.name}.rrd")
    size = (folder / f"{entry.name}.rrd").stat().st_size / 2**20
    file = f"{entry.name}.rrd"
    link = f'<a href="pictures/gallery/{file}" download>open in the viewer</a> ({size:.1f} MiB): contactlab view {file}'
    return results, link


def _end_of(results: Results, file: Path) -> list[str]:
    try:
        results.plot().savefig(file, dpi=90)
    except ContactlabError:
        return []
    return [_picture(file.name, "von Mises stress at the end")]


def cost(results: Results) -> str:
    """What the run took with its timeline, once compiled, and whether it is all of the scene's."""
    seconds, count = without_compilation(results.summary["cost"], "run_cpu_s"), int(results.summary["steps"])
    steps = f"{count:,} step{'' if count == 1 else 's'}".replace(",", " ")
    stopped = {"finished": "", "timed-out": ", stopped there"}.get(results.status, f", {results.status}")
    return f"{steps}{stopped}; {seconds:.2g} s of one core"
