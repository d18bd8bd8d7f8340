"""What the figures share: runs, curves, colours, files, and numbers for the page."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from kept_runs import run
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import contactlab
from contactlab.api import ContactCurve, Record
from contactlab.api.drawing.colours import REFERENCE, STATES, styles
from contactlab.reports.figures import house_style
from contactlab.studies.measures import mutual_difference
from contactlab.studies.profile import Profile, integral
from contactlab.studies.reference import load_reference

ROOT = Path(__file__).parents[3]
PICTURES = ROOT / "docs" / "paper"
COLOURS = {name: style.colour for name, style in styles(["node-on-segment", "mortar-p0", "mortar-p1"]).items()}
SHORT = {"node-on-segment": "node on segment", "mortar-p0": "P0", "mortar-p1": "P1"}
STATE_COLOURS, GREY = STATES, REFERENCE
DEEP = 0.1581
RINGS = ("P0", "Q1", "disc is slave")

Numbers = dict[str, Any]


@cache
def _disc(changes: str) -> Record:
    return run(contactlab.load_scene("disc-on-block").with_(json.loads(changes)))


def disc(
    algorithm: str | dict[str, str], *, swap: bool = False, mu: float = 0.0, element: str = "q1", level: int = 2,
    depth: float = DEEP, steps: int = 10, explicit: bool = False, frames: int = 1,
) -> Record:  # fmt: skip
    """A run of disc-on-block; static unless `explicit`, which follows the way where `frames` of it are wanted."""
    changes: dict[str, Any] = {
        "level": level, "contacts.0.algorithm": algorithm, "contacts.0.swap": swap, "supports.1.uy.to": -depth,
        "bodies.disc.element": element, "bodies.block.element": element, "record.frames": frames,
    }  # fmt: skip
    if not explicit:
        changes["integrator"] = {"use": "newton", "steps": steps}
    elif frames > 1:
        changes["time.history"] = True
    if mu:
        changes["contacts.0.friction"] = {"use": "coulomb", "mu": mu}
    return _disc(json.dumps(changes, sort_keys=True))


def curve(results: Record, contact: str = "contacts.0") -> ContactCurve:
    """The contact at the end of a run."""
    return results.curve(contact)


def profile(results: Record, column: str = "pressure", contact: str = "contacts.0") -> Profile:
    """A column of the contact at the end over the deformed x."""
    return Profile.of_curve(curve(results, contact), column)


def shear(results: Record) -> Profile:
    """Shear on the upper body as a function of x: slaves below run the other way."""
    found = curve(results)
    x, value = np.asarray(found.x), np.asarray(found.shear)
    return Profile.of_nodes(x, value)


def reaction(results: Record, support: str = "block.bottom") -> float:
    """Vertical reaction [N/mm]."""
    return float(results.summary["reactions"][support][1])


def deep_reference() -> Any:
    """The reference of disc-on-block at the paper's depth."""
    return load_reference("disc-on-block-deep")


def difference(a: Profile, b: Profile) -> float:
    """2 ||a - b|| / (||a|| + ||b||)."""
    return mutual_difference(a, b)


def draw(axes: Axes, shape: Profile, colour: str, label: str, **style: Any) -> None:
    """A profile as its nodes and straight lines."""
    # where two lie on each other both are seen: small dots inside large rings
    ring = {"markersize": 5.0, "markerfacecolor": "none", "markeredgewidth": 0.8}
    given = {"marker": "o", "markersize": 2.4, "linewidth": 1.0} | (ring if label in RINGS else {}) | style
    axes.plot(shape.x, shape.value, color=colour, label=label, **given)


def picture(name: str, rows: int, columns: int, fill: Callable[[Figure, Any], None], size: tuple[float, float]) -> None:
    """Make docs/paper/NAME.svg; `fill` draws into a figure of axes."""
    with house_style():
        figure = Figure(figsize=size, layout="constrained")
        fill(figure, figure.subplots(rows, columns, squeeze=False))
        PICTURES.mkdir(parents=True, exist_ok=True)
        figure.savefig(PICTURES / f"{name}.svg", metadata={"Date": None}, dpi=70)


def area(x: Any, cells: Any) -> float:
    """Of quadrilaterals by their diagonals; where mid nodes follow the corners, with what their parabolas add."""
    a, b, c, d = (x[cells[:, i]] for i in range(4))
    total = 0.5 * cross(c - a, d - b).sum()
    if cells.shape[1] > 4:
        for edge in range(4):
            start, end, middle = (x[cells[:, i]] for i in (edge, (edge + 1) % 4, 4 + edge))
            total += 2.0 / 3.0 * cross(middle - start, end - start).sum()
    return float(total)


def cross(p: Any, q: Any) -> Any:
    """Of vectors (n, 2), one by one."""
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]


def percent(value: float, digits: int = 2) -> str:
    """0.0123 as "1.2 %", rounded to two figures or as told."""
    return f"{100.0 * value:.{digits}g} %" if abs(value) < 0.1 else f"{100.0 * value:.3g} %"


__all__ = [
    "COLOURS", "DEEP", "GREY", "PICTURES", "ROOT", "SHORT", "STATE_COLOURS", "Numbers", "area", "cross", "curve",
    "deep_reference", "difference", "disc", "draw", "integral", "percent", "picture", "profile", "reaction", "run",
    "shear",
]  # fmt: skip
