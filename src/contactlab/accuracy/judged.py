"""Results of a run that are compared: contact pressures along a line, and forces where pressures cannot be judged."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from contactlab.api import ContactCurve, Floats, Record
from contactlab.jobs.mean_forces import MEANS
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.profile import FoldedSurfaceError, Profile, Window, bearing, distance, norm
from contactlab.studies.root_edges import stretches, with_root_edges

COUNTS = 0.02
"""Norm of a contact's pressure over the largest of all contacts from which on it is judged."""
EDGE = 0.05
"""Part of a contact's length next to its ends in which the highest pressure is one below an edge."""
SMOOTH, SINGULAR, BEST = 0.5, 0.2, 1.5
"""Orders of convergence: the least of pressures that end as a square root and of those below a sharp edge; the best."""
NOTHING = 1e-3
"""Force at the end over the largest mean in time below which it is none."""


@dataclass(frozen=True)
class Line:
    """A coordinate along a contact: "x", "y", or "angle" about `centre` [mm]."""

    axis: str
    centre: tuple[float, float] = (0.0, 0.0)

    def profile(self, curve: ContactCurve) -> Profile:
        """The pressure along it. Raises FoldedSurfaceError if the pressed part turns back."""
        pressure = np.nan_to_num(np.asarray(curve.pressure, float))
        x, y = np.asarray(curve.x, float), np.asarray(curve.y, float)
        if self.axis != "angle":
            return Profile.of_nodes(x if self.axis == "x" else y, pressure)
        angle = np.arctan2(y - self.centre[1], x - self.centre[0])
        begin = int(np.argmin(angle))
        rolled, values = np.roll(angle, -begin), np.roll(pressure, -begin)
        if np.count_nonzero(np.diff(rolled) < 0.0) > len(rolled) // 2:  # clockwise: from the largest on down
            begin = int(np.argmax(angle))
            rolled, values = np.roll(angle, -begin), np.roll(pressure, -begin)
        return Profile.of_nodes(rolled, values)


def line_of(curve: ContactCurve) -> Line | None:
    """The first line along which the pressure of a curve is a function; None without one or without pressure."""
    pressed = np.flatnonzero(bearing(np.nan_to_num(np.asarray(curve.pressure, float))))
    if len(pressed) == 0:
        return None
    x, y = np.asarray(curve.x, float), np.asarray(curve.y, float)
    flat = np.ptp(x[pressed]) >= np.ptp(y[pressed])
    axes = ("x", "y") if flat else ("y", "x")
    centre = 0.5 * float(x.min() + x.max()), 0.5 * float(y.min() + y.max())
    for line in (Line(axes[0]), Line(axes[1]), Line("angle", centre)):
        try:
            if norm(line.profile(curve)) > 0.0:
                return line
        except FoldedSurfaceError:
            continue
    return None


Pressures = Mapping[int, Profile]
"""Pressures by the number of their contact."""


class Judge:
    """Reads pressures of all runs of a scene along the same lines, which the first run with pressures fixes."""

    def __init__(self, window: Window | None = None) -> None:
        self.lines: dict[int, Line] = {}
        self.window = window

    def pressures(self, record: Record) -> Pressures:
        """Pressures at the end of a run of the contacts that are judged; empty if it is none that can be."""
        curves = {int(name.partition(".")[2]): found[-1] for name, found in record.curves.items() if len(found)}
        if not self.lines:
            lines = {number: line for number, curve in curves.items() if (line := line_of(curve))}
            size = {number: norm(line.profile(curves[number])) for number, line in lines.items()}
            self.lines = {n: line for n, line in lines.items() if size[n] >= COUNTS * max(size.values())}
        found = {}
        for number, line in self.lines.items():
            try:
                profile = line.profile(curves[number])
            except (FoldedSurfaceError, KeyError):
                return {}
            if not norm(profile) > 0.0:
                return {}
            found[number] = profile
        return found

    def apart(self, found: Pressures, other: Pressures) -> float:
        """Distance in L2 over the norm of the other, the largest of all contacts."""
        return max(self._apart(found[number], profile) for number, profile in other.items())

    def _apart(self, found: Profile, other: Profile) -> float:
        low, high = common_window([found, other])
        if self.window is not None:
            low, high = max(low, self.window[0]), min(high, self.window[1])
        return distance(found, other, (low, high)) / norm(other, (low, high))


def forces_of(record: Record, exchanged: Collection[int] = ()) -> Floats:
    """Reactions and contact forces [N] at the end of a run; their means in time if nothing is pressed any more.

    Forces of contacts count on the slave: those of exchanged contacts (numbers) are turned round.
    """
    contacts = record.summary.get("contacts", {})
    sign = np.array([-1.0 if number in exchanged else 1.0 for number in range(len(contacts))])[:, None]
    forces = [*record.summary.get("reactions", {}).values()]
    forces += list(sign * np.array([facts["resultant"] for facts in contacts.values()], float).reshape(-1, 2))
    final = np.array(forces, float).ravel()
    if MEANS not in record.watched:
        return final
    means = np.concatenate([record.watched[MEANS]["reaction"], (sign * record.watched[MEANS]["contact"]).ravel()])
    return means if np.abs(final).max(initial=0.0) <= NOTHING * np.abs(means).max(initial=0.0) else final


def moves(scene: Scene, registry: Registry) -> bool:
    """Return whether runs of a scene may end with nothing pressed, so that means in time of forces are compared."""
    inertia = registry.part_class("integrator", scene.integrator["use"]).inertia
    return bool(inertia) and scene.data["time"].get("end") != "auto"


def highest_at_an_end(pressure: Profile) -> bool:
    """Return whether a pressure is highest where a stretch of contact ends, as below a sharp edge."""
    peak = int(pressure.value.argmax())
    first, last = next((ends for ends in stretches(pressure.value) if ends[0] <= peak <= ends[1]), (peak, peak))
    begin, place, end = pressure.x[[first, peak, last]]
    return bool(min(place - begin, end - place) <= EDGE * (end - begin))


class PressuresJudged:
    """Compares pressures of runs."""

    what = "contact pressure in L2"
    safety = 1.0
    """Times the error that the fitted order leaves: what counts as uncertain."""

    def __init__(self, judge: Judge) -> None:
        self.apart = judge.apart

    @staticmethod
    def value(pressures: Pressures, forces: Floats) -> Pressures:
        """Return what is compared of a run; empty if it has none."""
        return pressures

    @staticmethod
    def orders(found: Pressures) -> Floats:
        """Orders of convergence to try, from a run on a fine mesh; an edge of contact within a cell gives 1 in L2."""
        return _even(SINGULAR if any(map(highest_at_an_end, found.values())) else SMOOTH)

    @staticmethod
    def sharpened(found: Pressures) -> Pressures:
        """The same with edges of contact followed to their roots."""
        return {number: with_root_edges(profile) for number, profile in found.items()}

    @staticmethod
    def mean(all_of: Sequence[Pressures], weights: Floats) -> Pressures:
        """Mean pressure of several runs, with weights."""
        return {number: mean_profile([each[number] for each in all_of], weights) for number in all_of[0]}


class ForcesJudged:
    """Compares reactions and contact forces of runs."""

    what = "forces only"
    safety = 1.25
    """A few numbers may be close on three meshes by chance (Roache 1994, for an order found by three meshes)."""

    @staticmethod
    def value(pressures: Pressures, forces: Floats) -> Floats:
        """Return what is compared of a run; empty if it has none."""
        return forces

    @staticmethod
    def orders(found: Floats) -> Floats:
        """Orders of convergence to try."""
        return _even(SINGULAR)

    @staticmethod
    def sharpened(found: Floats) -> Floats:
        """Return the forces."""
        return found

    @staticmethod
    def mean(all_of: Sequence[Floats], weights: Floats) -> Floats:
        """Mean forces of several runs, with weights."""
        return np.asarray(np.average(all_of, axis=0, weights=weights))

    @staticmethod
    def apart(found: Floats, other: Floats) -> float:
        """Distance over the size of the other; inf if they are not of the same kind."""
        size = float(np.linalg.norm(other))
        if found.shape != other.shape or size == 0.0:
            return float("inf")
        return float(np.linalg.norm(found - other)) / size


def _even(least: float) -> Floats:
    return np.linspace(least, BEST, round((BEST - least) / 0.05) + 1)


Judged = PressuresJudged | ForcesJudged
"""Compares results of runs: `value` of a run, `sharpened` to what no mesh follows, `mean` of several, `apart`."""

NEAR = 1e-5
"""Distance of nodes, over the span of a curve, at which they are one."""


def common_window(profiles: Sequence[Profile]) -> Window:
    """Return the range in which piecewise linear functions are compared, without what lies between jumps at their ends.

    Where contact reaches the end of a body pressure jumps to zero, at the last node of the slave, whichever side that
    is. The ends of two bodies move apart: by d, far less than a segment, and the jump would make an error of the order
    of d^(1/2) that no mesh takes away. Ends within half a segment of each other count as the same place.
    """
    low = _end([(p.x[0], p.value[0], p.spacing_at(p.x[0])) for p in profiles], max, min)
    high = _end([(p.x[-1], p.value[-1], p.spacing_at(p.x[-1])) for p in profiles], min, max)
    return low, high


def _end(ends: Sequence[tuple[float, float, float]], inner: Callable[..., float], outer: Callable[..., float]) -> float:
    """The innermost of positions if values jump at all of them, within half a segment; else the outermost."""
    places, values, segments = zip(*ends, strict=True)
    same = all(values) and max(places) - min(places) <= 0.5 * min(segments)
    return float(inner(places) if same else outer(places))


def mean_profile(profiles: Sequence[Profile], weights: Floats | None = None) -> Profile:
    """The mean of piecewise linear functions in their common window, on their nodes: of near ones the first."""
    low, high = common_window(profiles)
    x = np.unique(np.clip(np.concatenate([profile.x for profile in profiles]), low, high))
    near = NEAR * (high - low)
    x = x[np.r_[True, np.diff(x) > near]]
    return Profile(x, np.asarray(np.average([profile(x) for profile in profiles], axis=0, weights=weights)))
