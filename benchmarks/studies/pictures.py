"""What every stored picture of the docs shows, and whether it is older than that.

    python benchmarks/studies/pictures.py                  # pictures that are older than what they show
    python benchmarks/studies/pictures.py keep NAME ...    # those that were made anew, by the commands of their page

docs/pictures/shown.json has for each picture a hash of its file and one of what it shows: rows that a study keeps,
numbers of its page, or the command of its page and its scene.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from contactlab.scene.scene import bundled_scenes

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
KEPT = DOCS / "pictures" / "shown.json"
PAPER = ROOT / "benchmarks" / "studies" / "paper" / "page.md"


def demo_rows() -> str:
    """Rows of `make demo`."""
    return (ROOT / "benchmarks" / "studies" / "demo.csv").read_text(encoding="utf-8")


def numbers_of(page: str, heading: str) -> str:
    """All numbers in tables of a page from a heading on: words around them may change."""
    lines = (DOCS / page).read_text(encoding="utf-8").partition(heading)[2].splitlines()
    return " ".join(number for line in lines if line.startswith("|") for number in re.findall(r"\d[\d.e+-]*", line))


def measured(page: str) -> str:
    """The same between the marks of what was measured."""
    text = (DOCS / page).read_text(encoding="utf-8")
    inside = text.split("<!-- measured: begin -->")[1].split("<!-- measured: end -->")[0]
    lines = [line for line in inside.splitlines() if line.startswith("|")]
    return " ".join(number for line in lines for number in re.findall(r"\d[\d.e+-]*", line))


def figure(name: str) -> str:
    """Numbers of a figure of the paper's page."""
    found = json.loads((DOCS / "paper" / "numbers.json").read_text(encoding="utf-8"))
    return json.dumps(found[name], sort_keys=True)


def timeline(page: str | Path, scene: str, folder: str) -> str:
    """The command of a page that runs a scene into runs/FOLDER, and the scene without its comments."""
    text = (DOCS / page).read_text(encoding="utf-8").replace("\\\n", " ")
    (command,) = re.findall(rf"^contactlab (?:run|compare) (?:.*) --out runs/{folder}\b.*$", text, re.MULTILINE)
    lines = bundled_scenes()[scene].read_text(encoding="utf-8").splitlines()
    settings = [line.split(" #")[0].strip() for line in lines if line.strip() and not line.startswith("#")]
    return json.dumps([command.split(), settings])


_BENCHMARKS = partial(numbers_of, "benchmarks.md", "## Speed")
_STEP = partial(timeline, "find-the-step.md", "disc-on-block", "chatter")
_INSIDE = {"run": "rough", "comparison": "three", "statics": "statics"}
SHOWN: dict[str, Callable[[], str]] = {
    "pictures/comparison.png": demo_rows,
    "pictures/error-against-cost.png": demo_rows,
    "pictures/accuracy.svg": partial(measured, "accuracy.md"),
    **{f"pictures/benchmarks-{name}.png": _BENCHMARKS for name in ("updates", "phases", "contact")},
    **{f"pictures/chatter-{name}.png": _STEP for name in ("end", "first", "pair", "pair-begins")},
    **{
        f"pictures/timeline-{name}.png": partial(timeline, "look-inside-a-contact.md", "disc-on-block", folder)
        for name, folder in _INSIDE.items()
    },
    **{f"paper/figure-{n:02d}.svg": partial(figure, f"f{n:02d}") for n in range(7, 16)},
    "paper/figure-16.png": partial(figure, "f16"),
    "paper/figure-16-penetration.svg": partial(figure, "f16"),
    "paper/friction-with-depth.svg": partial(figure, "paths"),
    "paper/forging-timeline.png": partial(timeline, PAPER, "three-body-forging", "forging"),
}  # fmt: skip
"""Every stored picture by its name in docs, and what it shows."""


def stored() -> set[str]:
    """Names of all pictures in docs."""
    return {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*") if path.suffix in (".png", ".svg")}


def now(name: str) -> dict[str, str]:
    """Hashes of a picture and of what it shows."""
    return {"picture": _hash((DOCS / name).read_bytes()), "shows": _hash(SHOWN[name]().encode())}


def older() -> list[str]:
    """Pictures that are not in SHOWN, and those that were kept with another file or that show what has changed."""
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    strange = sorted(stored() ^ set(SHOWN))
    return strange + [name for name in SHOWN if name not in strange and kept.get(name) != now(name)]


def of_figure(name: str) -> list[str]:
    """Pictures that show numbers of a figure of the paper's page."""
    return [
        own
        for own, shows in SHOWN.items()
        if isinstance(shows, partial) and (shows.func, shows.args) == (figure, (name,))
    ]


def keep(names: list[str]) -> None:
    """Note that these pictures were made anew, and show what is there now."""
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.is_file() else {}
    kept |= {name: now(name) for name in names}
    KEPT.write_text(json.dumps(dict(sorted(kept.items())), indent=1) + "\n", encoding="utf-8")


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:32]


if __name__ == "__main__":
    if sys.argv[1:2] == ["keep"]:
        keep(sys.argv[2:])
    found = older()
    print("\n".join(found) or "no picture is older than what it shows")
    sys.exit(bool(found))
