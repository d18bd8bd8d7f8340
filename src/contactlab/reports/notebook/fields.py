"""Fields of a run by name, one value per cell, at any stored frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import XX, YY, ZZ, Floats
from contactlab.api.drawing.units import Units
from contactlab.api.frame import Frame
from contactlab.errors import RequestError, did_you_mean
from contactlab.results.results import Results
from contactlab.studies.shape import von_mises

STRESSES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")
VECTORS = ("displacement", "displacement_x", "displacement_y", "velocity", "velocity_x", "velocity_y")


class Moment(NamedTuple):
    """One instant of a run.

    time       [s], nan at the end of a run without files
    position   (N, 2) [mm]; displacement (N, 2) [mm]; velocity (N, 2) [mm/s] or (0, 2)
    cells      per body: "stress" (n, 4) and every other field that its law has (n,)
    """

    time: float
    position: Floats
    displacement: Floats
    velocity: Floats
    cells: Mapping[str, Mapping[str, Floats]]


def moment_of(results: Results, frame: int = -1) -> Moment:
    """A stored frame; the last one of a run without files is its end. Raises RequestError where there is none."""
    count = len(results.frames)
    if count:
        if not -count <= frame < count:
            raise RequestError("there is no such frame", got=frame, allowed=f"{-count} to {count - 1}")
        return _of_frame(results, results.frames[frame])
    if frame != -1:
        raise RequestError(
            "only the end of a run without files is known", got=f"frame {frame}",
            hint='give simulate a folder: simulate(scene, out="runs/mine")',
        )  # fmt: skip
    cells = {}
    for body, stress in results.stress.items():
        variables = {name: values.mean(axis=1) for name, values in results.internal_variables.get(body, {}).items()}
        cells[body] = {"stress": stress.mean(axis=1), "von_mises": von_mises(stress).mean(axis=1), **variables}
    if not cells:
        raise RequestError("the run stored nothing that could be shown", got=f"{results.status}: {results.reason}")
    time = float(results.history["time"][-1]) if len(results.history.get("time", ())) else float("nan")
    return Moment(time, results.nodes + results.displacement, results.displacement, results.velocity, cells)


def _of_frame(results: Results, frame: Frame) -> Moment:
    position = results.nodes + frame.displacement
    return Moment(frame.time, position, frame.displacement, frame.velocity, frame.cells)


def names_of(moment: Moment) -> list[str]:
    """All fields that can be shown."""
    own = dict.fromkeys(name for cells in moment.cells.values() for name in cells if name != "stress")
    vectors = VECTORS if len(moment.velocity) else VECTORS[:3]
    return [*own, "pressure", *STRESSES, *vectors]


def values_of(results: Results, moment: Moment, name: str) -> dict[str, Floats]:
    """The field (n,) of each body that has it. Raises RequestError with the nearest name."""
    known = names_of(moment)
    if name not in known:
        raise RequestError("there is no such field", got=name, allowed=", ".join(known), hint=did_you_mean(name, known))
    if name in VECTORS:
        field = name.partition("_")[0]
        nodal = _component(moment.displacement if field == "displacement" else moment.velocity, name)
        return {body: nodal[cells[:, :4]].mean(axis=1) for body, cells in results.cells.items()}
    if name == "pressure":
        return {body: -c["stress"][:, [XX, YY, ZZ]].mean(axis=1) for body, c in moment.cells.items()}
    if name in STRESSES:
        return {body: c["stress"][:, STRESSES.index(name)] for body, c in moment.cells.items()}
    return {body: cells[name] for body, cells in moment.cells.items() if name in cells}


def _component(vectors: Floats, name: str) -> Floats:
    return vectors[:, "xy".index(name[-1])] if name[-2:] in ("_x", "_y") else np.hypot(vectors[:, 0], vectors[:, 1])


def title_of(name: str, units: Units) -> str:
    """What to write beside the colours."""
    words = {"von_mises": "von Mises stress", "pressure": "hydrostatic pressure"}.get(name, name.replace("_", " "))
    stress = name in ("von_mises", "pressure", *STRESSES)
    speed = f"{units.length}/{units.time}" if units.length else ""
    unit = units.pressure if stress else units.length if name.startswith("disp") else speed if "velo" in name else ""
    return f"{words} [{unit}]" if unit else words
