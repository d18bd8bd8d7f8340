"""Pictures and numbers of docs/find-the-step.md, from the run that the page describes.

python benchmarks/studies/find_the_step.py                 # the run (some seconds), four pictures, the page's table
python benchmarks/studies/find_the_step.py runs/chatter    # the same of a run that is there
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from filled import filled

from contactlab.reports.sheet import Sheet
from contactlab.results.load import load_results
from contactlab.results.results import Results

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "find-the-step.md"
IN_EVERY_STEP = 20  # steps in a row make a node that changes its segment in every step
PANEL = "master segment"


class Restless(NamedTuple):
    """A node that changes its segment while it touches: all such steps, and stretches with a change in every step."""

    node: int
    steps: np.ndarray
    stretches: list[tuple[int, int]]


def restless(run: Results) -> list[Restless]:
    """Nodes of the first contact that change their segment in every step for a while, the last to begin first."""
    rows, (contact, *_) = run.contact["contacts.0"].steps, run.layout.contacts
    changed = np.diff(rows["segment"].astype(int), axis=0) != 0
    changed &= (rows["state"][1:] > 0) & (rows["state"][:-1] > 0)
    found = []
    for column in np.flatnonzero(changed.any(axis=0)):
        steps = rows["step"][1:][changed[:, column]]
        parts = np.split(steps, np.flatnonzero(np.diff(steps) != 1) + 1)
        stretches = [(int(part[0]), int(part[-1])) for part in parts if len(part) >= IN_EVERY_STEP]
        if stretches:
            found.append(Restless(int(contact.slave_nodes[column]), steps, stretches))
    return sorted(found, key=lambda one: one.stretches[0], reverse=True)


def table(run: Results) -> str:
    """A row for each of them, from the end of the run backwards."""
    energy = run.steps["energy.contact"]
    rows = (
        [one.node, one.steps[0], len(one.steps), f"{first} to {last}", f"{energy[first - 1]:.2g}"]
        for one in restless(run)
        for first, last in one.stretches[:1]
    )
    heads = (
        "node", "first change of segment", "changes in all", "first in every step", "contact energy then, mJ/mm"
    )  # fmt: skip
    return Sheet(heads, rows).markdown()


def places(run: Results) -> dict[str, int]:
    """The step of each picture: the end, and where pairs of nodes begin to change in every step, back to the first."""
    begins = list(dict.fromkeys(one.stretches[0] for one in restless(run)))
    names = ("chatter-pair", "chatter-pair-begins", "chatter-first")
    if len(begins) != len(names):
        raise SystemExit(f"the page tells of {len(names)} places, the run has {len(begins)}: {begins}")
    return {"chatter-end": run.summary["steps"]} | {
        name: first + IN_EVERY_STEP for name, (first, _) in zip(names, begins, strict=True)
    }


def run_of_the_page(folder: Path) -> None:
    """Run the command of the page into `folder`."""
    (command,) = re.findall(r"^contactlab (run .*) --out runs/chatter$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    _command(*shlex.split(command), "--out", str(folder))


def draw(folder: Path, run: Results) -> None:
    """Write all pictures: the end as the whole view, the others as its panel of segments alone."""
    for name, step in places(run).items():
        panel = [] if name == "chatter-end" else ["--panel", PANEL]
        _command("view", str(folder), "--png", str(DOCS / "pictures" / f"{name}.png"), "--step", str(step), *panel)


def _command(*words: str) -> None:
    done = subprocess.run([sys.executable, "-m", "contactlab.cli", *words], stdout=subprocess.DEVNULL)
    if done.returncode not in (0, 1):  # 1: the run failed, as it should
        raise SystemExit(done.returncode)


def write(run: Results) -> None:
    """Put the table into the page."""
    PAGE.write_text(filled(PAGE, measured=f"\n{table(run)}\n"), encoding="utf-8")


def main(given: list[str]) -> None:
    """Make everything anew."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(given[0]) if given else Path(place) / "chatter"
        if not given:
            run_of_the_page(folder)
        run = load_results(folder)
        draw(folder, run)
        write(run)
        print(table(run))


if __name__ == "__main__":
    main(sys.argv[1:])
