"""A deformed body as a picture needs it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats, Record
from contactlab.api.arrays import XX, XY, YY, ZZ
from contactlab.results.results import Results


@dataclass(frozen=True)
class Shape:
    """Cells of a body with the stress in them.

    corners    (n, 4, 2) [mm] deformed corners of each cell
    von_mises  (n,) [MPa] mean over the points of each cell
    """

    corners: Floats
    von_mises: Floats


def shapes_of(record: Record | Results) -> dict[str, Shape]:
    """The bodies of a run at its last frame; none if the record has no fields."""
    position = record.nodes + record.displacement
    return {
        name: Shape(position[cells[:, :4]], von_mises(record.stress[name]).mean(axis=1))
        for name, cells in record.cells.items()
    }


def von_mises(stress: Floats) -> Floats:
    """Von Mises stress [MPa] of stresses (..., 4) with components xx, yy, zz, xy."""
    xx, yy, zz, xy = (stress[..., component] for component in (XX, YY, ZZ, XY))
    return np.asarray(np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * xy**2))


def outline(corners: Floats) -> Floats:
    """The sides (k, 2, 2) that belong to one only of the cells with these corners (n, c, 2)."""
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    # Cells share nodes, so the two copies of an inner side have bitwise equal ends, in opposite order.
    ends = {(*side[0], *side[1]) for side in sides}
    return sides[[(*side[1], *side[0]) not in ends for side in sides]]
