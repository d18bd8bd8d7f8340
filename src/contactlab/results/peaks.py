"""Largest reaction of each support and largest pressure of each contact, with step and time.

A peak may lie between stored frames: pressures are also read from the contact record, reactions of implicit runs
from the scalars of every step. Explicit reactions are not: a velocity prescribed without a ramp is a force m v / dt in
the first step, and they ring from step to step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import Layout
from contactlab.results.force_curve import THE_END_ONLY

Peak = dict[str, Any]
"""`value`, `step`, `time` and `share` of the loading or of time; of a force its `vector` as well."""

SINGLE = 1e-6
"""Relative precision of the contact record: what exceeds a frame by less is the same peak."""


class Peaks:
    """Follows a run, in any order of frames and steps. `as_data` is the entry `peaks` of `summary.json`."""

    def __init__(self, layout: Layout, explicit: bool) -> None:
        self.explicit = explicit
        columns = {name: number for number, name in enumerate(layout.steps)}
        self._columns = {on: (columns[f"{on}.fx"], columns[f"{on}.fy"]) for on in layout.supports}
        self._contacts = [contact.name for contact in layout.contacts]
        self.reactions: dict[str, Peak] = {}
        self.forces: dict[str, Peak] = {}
        self.pressures: dict[str, Peak] = {}
        self.recorded: dict[str, Peak] = {}

    def frame(self, row: Mapping[str, float]) -> None:
        """Look at a row of `history.csv`."""
        when = int(row["step"]), row["time"]
        for on in self._columns:
            _keep_force(self.reactions, on, (row[f"{on}.fx"], row[f"{on}.fy"]), *when)
        for name in self._contacts:
            _keep_force(self.forces, name, (row[f"{name}.fx"], row[f"{name}.fy"]), *when)
            _keep(self.pressures, name, row[f"{name}.max_pressure"], *when)

    def steps(self, block: Floats) -> None:
        """Look at the scalars (b, columns) of every step."""
        if self.explicit:
            return
        for on, (x, y) in self._columns.items():
            k = int(np.argmax(np.hypot(block[:, x], block[:, y])))
            force = float(block[k, x]), float(block[k, y])
            _keep_force(self.reactions, on, force, int(block[k, 0]), float(block[k, 1]))

    def contact_steps(self, block: Mapping[str, np.ndarray]) -> None:
        """Look at rows of the contact record, which is in single precision."""
        for name, rows in block.items():
            highest = rows["pressure"].max(axis=1, initial=0.0)
            k = int(np.argmax(highest))
            _keep(self.recorded, name, float(highest[k]), int(rows["step"][k]), float(rows["time"][k]))

    def restore(self, data: Mapping[str, Any]) -> None:
        """Look at peaks that `as_data` gave: the steps they are from may have been thinned since.

        One that a frame had is not above that frame by more than `SINGLE`, and changes nothing.
        """
        contacts = data.get("contacts", {})
        for found, peaks in (
            (self.reactions, data.get("reactions", {})),
            (self.recorded, {name: peak["pressure"] for name, peak in contacts.items()}),
        ):
            for name, peak in peaks.items():
                value = peak["value"]
                if value is not None and _keep(found, name, value, peak["step"], peak["time"]) and "vector" in peak:
                    found[name]["vector"] = peak["vector"]

    def as_data(self, share: Callable[[float], float]) -> dict[str, Any]:
        """Peaks by support, and the largest pressure and resultant of each contact; `share` of a time [s]."""

        def full(peak: Peak) -> Peak:
            return peak | {"share": share(peak["time"])}

        contacts = {n: {"pressure": full(self._pressure(n)), "force": full(self.forces[n])} for n in self.pressures}
        return {"reactions": {on: full(peak) for on, peak in self.reactions.items()}, "contacts": contacts}

    def _pressure(self, name: str) -> Peak:
        stored, recorded = self.pressures[name], self.recorded.get(name)
        between = recorded is not None and recorded["value"] > (1.0 + SINGLE) * stored["value"]
        return recorded if recorded is not None and between else stored


def _keep_force(found: dict[str, Peak], name: str, force: tuple[float, float], step: int, time: float) -> None:
    if _keep(found, name, math.hypot(*force), step, time):
        found[name]["vector"] = list(force)


def _keep(found: dict[str, Peak], name: str, value: float, step: int, time: float) -> bool:
    """Keep a value that is larger than the previous peak, or as large and earlier."""
    before = found.get(name)
    better = before is None or (value, -step) > (before["value"], -before["step"])
    if better:
        found[name] = {"value": value, "step": step, "time": time}
    return better


def peak_force(summary: Mapping[str, Any], on: str) -> Peak | None:
    """The largest reaction of a support, or resultant of a contact; None if the run left none.

    If only the final state is in equilibrium, the force at the end is returned.
    """
    peaks = summary.get("peaks", {})
    contact = peaks.get("contacts", {}).get(on, {}).get("force")
    peak = peaks.get("reactions", {}).get(on, contact)
    end = final_force(summary, on)
    if end is not None and _only_the_end(summary):
        return _at_the_end(summary, math.hypot(*end)) | {"vector": end}
    return _finite(peak)


def final_force(summary: Mapping[str, Any], on: str) -> list[float] | None:
    """The reaction of a support or the resultant of a contact at the end."""
    force = summary.get("reactions", {}).get(on, summary.get("contacts", {}).get(on, {}).get("resultant"))
    return None if force is None else [float(component) for component in force]


def peak_pressure(summary: Mapping[str, Any], contact: str) -> Peak | None:
    """The largest pressure of a contact on the way, as for `peak_force`."""
    end = summary.get("contacts", {}).get(contact, {}).get("max_pressure")
    if end is not None and _only_the_end(summary):
        return _at_the_end(summary, float(end))
    return _finite(summary.get("peaks", {}).get("contacts", {}).get(contact, {}).get("pressure"))


def _finite(peak: Peak | None) -> Peak | None:
    """The peak; None if its value is NaN, as in a run that diverged."""
    return None if peak is None or peak["value"] is None else peak


def _only_the_end(summary: Mapping[str, Any]) -> bool:
    return summary.get("status") == "finished" and summary.get("history", {}).get("curve") == THE_END_ONLY


def _at_the_end(summary: Mapping[str, Any], value: float) -> Peak:
    reached = summary.get("reached", {})
    return {"value": value, "step": summary["steps"], "time": reached.get("time"), "share": reached.get("share")}
