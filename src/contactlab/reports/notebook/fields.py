"""Fields of a run by name, per cell or per node, at any stored frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from contactlab.api.arrays import XX, YY, ZZ, Floats
from contactlab.api.drawing.units import Units
from contactlab.api.frame import Frame
from contactlab.errors import RequestError, did_you_mean
from contactlab.results.nodal import corners_of, nodal_values, principal_stresses
from contactlab.results.results import Results
from contactlab.studies.shape import von_mises

STRESSES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")
PRINCIPAL = ("principal_1", "principal_2", "principal_3")
"""The largest first."""
OF_STRESS = ("von_mises", "pressure", *STRESSES, *PRINCIPAL)
VECTORS = ("displacement", "displacement_x", "displacement_y", "velocity", "velocity_x", "velocity_y")


class Moment(NamedTuple):
    """State of a run at an instant.

    time       [s], NaN at the end of a run without files; share of the loading (statics) or of time, 0 to 1
    position   (N, 2) [mm]; displacement (N, 2) [mm]; velocity (N, 2) [mm/s] or (0, 2)
    cells      per body: "stress" (n, 4) and every other field that its law has (n,)
    """

    time: float
    position: Floats
    displacement: Floats
    velocity: Floats
    cells: Mapping[str, Mapping[str, Floats]]
    share: float = float("nan")


def moment_of(results: Results, frame: int = -1) -> Moment:
    """A stored frame; the last frame of a run without files is its end. Raises RequestError if there is none."""
    count = len(results.frames)
    if count:
        if not -count <= frame < count:
            raise RequestError("there is no such frame", got=frame, allowed=f"{-count} to {count - 1}")
        return _of_frame(results, results.frames[frame])
    if frame != -1:
        raise RequestError(
            "a run without files has no frames but the end", got=f"frame {frame}",
            hint='give simulate a folder: simulate(scene, out="runs/mine")',
        )  # fmt: skip
    cells = {}
    for body, stress in results.stress.items():
        variables = {name: values.mean(axis=1) for name, values in results.internal_variables.get(body, {}).items()}
        cells[body] = {"stress": stress.mean(axis=1), "von_mises": von_mises(stress).mean(axis=1), **variables}
    if not cells:
        raise RequestError("the run stored no fields", got=f"{results.status}: {results.reason}")
    time = float(results.history["time"][-1]) if len(results.history.get("time", ())) else float("nan")
    share = float(results.history["share"][-1]) if len(results.history.get("share", ())) else float("nan")
    return Moment(time, results.nodes + results.displacement, results.displacement, results.velocity, cells, share)


def _of_frame(results: Results, frame: Frame) -> Moment:
    position = results.nodes + frame.displacement
    share = frame.scalars.get("share", float("nan"))
    return Moment(frame.time, position, frame.displacement, frame.velocity, frame.cells, share)


def names_of(moment: Moment) -> list[str]:
    """All fields that can be shown."""
    own = dict.fromkeys(name for cells in moment.cells.values() for name in cells if name != "stress")
    vectors = VECTORS if len(moment.velocity) else VECTORS[:3]
    return [*own, "pressure", *STRESSES, *PRINCIPAL, *vectors]


def values_of(results: Results, moment: Moment, name: str) -> dict[str, Floats]:
    """The field (n,) at the cells of each body that has it. Raises RequestError with the nearest name."""
    _checked(moment, name)
    if name in VECTORS:
        nodal = _vector(moment, name)
        return {body: nodal[corners_of(cells)].mean(axis=1) for body, cells in results.cells.items()}
    found = {}
    for body, cells in moment.cells.items():
        if name in OF_STRESS:  # the mean of von Mises stresses is stored in addition to the mean stress
            found[body] = cells[name] if name in cells else of_stress(cells["stress"], name)
        elif name in cells:
            found[body] = cells[name]
    return found


def nodal_values_of(results: Results, moment: Moment, name: str) -> dict[str, Floats]:
    """The field (N,) at the nodes of each body that has it, NaN at others. Raises RequestError with the nearest name.

    Von Mises, principal stresses and pressure are computed from the nodal stress.
    """
    _checked(moment, name)
    found = {}
    for body, own in moment.cells.items():
        cells = results.cells[body]
        if name in VECTORS:
            found[body] = _vector(moment, name)
        elif name in OF_STRESS:
            found[body] = of_stress(nodal_values(moment.position, cells, own["stress"]), name)
        elif name in own:
            least, most = own[name].min(), own[name].max()
            # a plane may leave the range of a field that begins somewhere, such as plastic strain
            found[body] = np.clip(nodal_values(moment.position, cells, own[name][:, None])[:, 0], min(least, 0.0), most)
    return found


def of_stress(stress: Floats, name: str) -> Floats:
    """A scalar of stresses (..., 4)."""
    if name == "von_mises":
        return von_mises(stress)
    if name == "pressure":
        return np.asarray(-stress[..., [XX, YY, ZZ]].mean(axis=-1))
    if name in PRINCIPAL:
        return np.asarray(principal_stresses(stress)[..., PRINCIPAL.index(name)])
    return np.asarray(stress[..., STRESSES.index(name)])


def _checked(moment: Moment, name: str) -> None:
    known = names_of(moment)
    if name not in known:
        raise RequestError("there is no such field", got=name, allowed=", ".join(known), hint=did_you_mean(name, known))


def _vector(moment: Moment, name: str) -> Floats:
    return _component(moment.displacement if name.startswith("displacement") else moment.velocity, name)


def _component(vectors: Floats, name: str) -> Floats:
    return vectors[:, "xy".index(name[-1])] if name[-2:] in ("_x", "_y") else np.hypot(vectors[:, 0], vectors[:, 1])


def title_of(name: str, units: Units) -> str:
    """Label of the colour bar."""
    words = {"von_mises": "von Mises stress", "pressure": "hydrostatic pressure"}.get(name, name.replace("_", " "))
    words = words.replace("principal", "principal stress")
    stress = name in OF_STRESS
    speed = f"{units.length}/{units.time}" if units.length else ""
    unit = units.pressure if stress else units.length if name.startswith("disp") else speed if "velo" in name else ""
    return f"{words} [{unit}]" if unit else words
