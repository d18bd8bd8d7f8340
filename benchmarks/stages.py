"""From a fresh clone to the whole demo, each stage timed: installation, first compilation, the first second of a run.

    python benchmarks/stages.py [--rounds 5] [--only demo ...] [--keep] [--note TEXT]
    python benchmarks/stages.py --page          # writes what is kept into docs/from-a-fresh-clone.md

Needs git, make and Python 3.11 alone: what is measured is installed into a clone of what is committed here. Kernel
caches are empty at first, but that of warm runs is not. Stages that install or compile are run once, others `--rounds`
times. CPU seconds count all processes. `--keep` adds a row to `stages.json`.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from time import perf_counter, sleep
from typing import Any

from machine import kind

HERE = Path(__file__).resolve().parent
FILE = HERE / "stages.json"
PAGE = HERE.parent / "docs" / "from-a-fresh-clone.md"
BEGIN, END = "<!-- stages -->", "<!-- end of stages -->"
WARM = "warm run"
SPLIT = "of it "
PROBE = "import first_second as f; print(json.dumps(f.measure('disc-on-block', ['level=1'])))"
LOOKED = 0.1
"""Wall seconds between two looks at what a demo has written."""
STAGES = ("demo", "first compilation", WARM)
Rows = dict[str, list[float]]
"""Values by the name of a stage with its unit in brackets."""


@dataclass
class Place:
    """A clone with an environment of its own, and folders beside it."""

    folder: Path
    rows: Rows = field(default_factory=dict)

    @property
    def clone(self) -> Path:
        """The working tree."""
        return self.folder / "clone"

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.clone / ".venv" / "bin" / "python"

    @property
    def run(self) -> list[str]:
        """The command that is measured."""
        return [str(self.python.with_name("contactlab")), "run", "disc-on-block", "--set", "level=1", "--out"]

    def add(self, name: str, value: float) -> None:
        """One more value of a stage."""
        self.rows.setdefault(name, []).append(value)


def main() -> int:
    """Measure and print, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="warm runs (5)")
    parser.add_argument("--only", nargs="+", default=STAGES, choices=STAGES, help="after the installation")
    parser.add_argument("--keep", action="store_true", help="add a row to stages.json")
    parser.add_argument("--note", default="", help="what else the machine did meanwhile, kept with the row")
    parser.add_argument("--page", action="store_true", help="write docs/from-a-fresh-clone.md from what is kept")
    asked = parser.parse_args()
    kept: list[dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else []
    if asked.page:
        text = PAGE.read_text(encoding="utf-8")
        before, after = text.partition(BEGIN)[0], text.partition(END)[2]
        PAGE.write_text(f"{before}{BEGIN}\n\n{page(kept)}\n{END}{after}", encoding="utf-8")
        return 0
    with tempfile.TemporaryDirectory(prefix="stages-") as folder:
        entry = measured(Place(Path(folder)), asked.rounds, asked.only, asked.note)
    print("\n".join(described(entry)))
    if asked.keep:
        FILE.write_text(json.dumps([*kept, entry], indent=1) + "\n", encoding="utf-8")
    return 0


def measured(place: Place, rounds: int, only: Sequence[str], note: str) -> dict[str, Any]:
    """All stages, with the machine and its load before and after."""
    load = [os.getloadavg()[0]]
    install(place)
    if "demo" in only:
        demo(place)
    if "first compilation" in only:
        first_compilation(place)
    if WARM in only:
        warm_runs(place, rounds)
    load.append(os.getloadavg()[0])
    commit = subprocess.run(
        ["git", "-C", str(HERE), "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    return {
        "machine": asked_of_clone(place, "import machine; print(json.dumps(machine.machine()))"),
        "date": datetime.now(UTC).date().isoformat(), "commit": commit, "load": load, "note": note,
        "stages": {name: {"median": median(v), "least": min(v), "largest": max(v), "rounds": len(v)}
                   for name, v in place.rows.items()},
    }  # fmt: skip


# --- stages -----------------------------------------------------------------------------------------------


def install(place: Place) -> None:
    """Clone what is committed, and what `make demo` installs."""
    subprocess.run(["git", "clone", "-q", str(HERE.parent), str(place.clone)], check=True)
    told(place, "installation", ["make", ".venv/runnable"])
    place.add("installed [MB]", size_mb(place.clone / ".venv"))


def demo(place: Place) -> None:
    """`make demo`: when its page is there first, when all of it is, and when the rest is done."""
    page, rest = (place.clone / "runs" / name for name in ("demo-accuracy/accuracy.html", "demo"))
    marks = {"demo: first table and picture [s]": page.exists, "demo: its first page is whole [s]": rest.exists}
    told(place, "demo", ["make", "demo"], empty_cache=True, marks=marks)
    place.add("demo [MB]", size_mb(rest) + size_mb(page.parent))


def first_compilation(place: Place) -> None:
    """A run that finds no kernels."""
    told(place, "run without kernels", [*place.run, str(place.folder / "cold")], empty_cache=True)


def warm_runs(place: Place, rounds: int) -> None:
    """Runs that find all kernels, after one that does not count; in turn with runs that tell where time goes."""
    for number in range(rounds + 1):
        rows = place.rows if number else {}
        one = Place(place.folder, rows)
        told(one, WARM, [*place.run, str(place.folder / f"warm-{number}")])
        found = asked_of_clone(place, PROBE)
        for name, seconds in found.items():
            one.add(f"{WARM}, {SPLIT}{name} [CPU s]", seconds)


# --- measuring --------------------------------------------------------------------------------------------


def told(
    place: Place, name: str, command: Sequence[str], empty_cache: bool = False,
    marks: Mapping[str, Callable[[], bool]] | None = None,
) -> None:  # fmt: skip
    """Run a command in the clone; add wall and CPU seconds, and wall seconds until each mark is there."""
    waiting = dict(marks or {})
    before, began = os.times(), perf_counter()
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryFile("w+") as output:
        own = cache if empty_cache else str(place.folder / "kernels")
        process = subprocess.Popen(
            command, cwd=place.clone, env=environment(own), stdout=output, stderr=subprocess.STDOUT
        )
        running = True
        while running:
            running = process.poll() is None
            for mark in [mark for mark, there in waiting.items() if there()]:
                del waiting[mark]
                place.add(mark, perf_counter() - began)
            if running:
                sleep(LOOKED if waiting else 0.01)
        wall, after = perf_counter() - began, os.times()
        if process.returncode or waiting:
            output.seek(0)
            raise SystemExit(
                f"{' '.join(command)}: exit {process.returncode}; not there: {list(waiting)}\n{output.read()}"
            )
    place.add(f"{name} [s]", wall)
    user, system = (getattr(after, kind) - getattr(before, kind) for kind in ("children_user", "children_system"))
    place.add(f"{name} [CPU s]", user + system)


def environment(cache: str) -> dict[str, str]:
    """One thread a run, kernels in this folder, modules kept compiled, nothing of this process's own packages."""
    own = {name: text for name, text in os.environ.items() if name not in ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH")}
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    return {**own, **one, "CONTACTLAB_CACHE": cache}


def asked_of_clone(place: Place, program: str) -> Any:
    """What a program prints that the clone's interpreter runs, which finds the modules of benchmarks."""
    paths = [str(place.clone / "benchmarks"), str(place.clone / "benchmarks" / "kernels")]
    found = subprocess.run(
        [str(place.python), "-c", f"import json, sys; sys.path[:0] = {paths}; {program}"],
        env=environment(str(place.folder / "kernels")), capture_output=True, text=True, check=False,
    )  # fmt: skip
    if found.returncode:
        raise SystemExit(found.stderr)
    return json.loads(found.stdout)


def size_mb(folder: Path) -> float:
    """Bytes of all files in a folder, in millions."""
    return 1e-6 * sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())


# --- telling ----------------------------------------------------------------------------------------------


def described(entry: Mapping[str, Any]) -> Iterator[str]:
    """A row in Markdown: the machine, and a table of its stages."""
    software = entry["machine"]["software"]
    yield f"{kind(entry['machine'])}; " + ", ".join(f"{name} {value}" for name, value in software.items()) + "."
    before, after = entry["load"]
    note = f"; {entry['note']}" if entry["note"] else ""
    yield f"{entry['date']}, commit {entry['commit']}, load {before:.1f} before and {after:.1f} after{note}."
    yield ""
    yield "| stage | median | spread | rounds |"
    yield "|---|---|---|---|"
    for name, found in entry["stages"].items():
        what, _, unit = name.removesuffix("]").rpartition(" [")
        spread = f"{shown(found['least'])} to {shown(found['largest'])}" if found["rounds"] > 1 else ""
        yield f"| {what} | {shown(found['median'])} {unit} | {spread} | {found['rounds']} |"


def shown(value: float) -> str:
    """Three figures."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def page(kept: Sequence[Mapping[str, Any]]) -> str:
    """The newest row of each kind of machine and choice of stages."""
    newest = {(kind(entry["machine"]), tuple(entry["stages"])): entry for entry in kept}
    return "\n\n".join("\n".join(described(entry)) for entry in newest.values()) + "\n"


if __name__ == "__main__":
    sys.exit(main())
