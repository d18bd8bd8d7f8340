"""Two rings that stick to each other under a pressure that varies around them: pressure and shear, both exact.

All loads grow together, so that nothing slips where |q| < mu p holds in the end. With the finer side as slave
multipliers follow the kinks of the coarser one's displacements (`two_rings.py`): what the coarser side carries has
no such kinks. At the planes of symmetry normals belong to one segment: they lean by half of its turn, so that a part
of the pressure shows as shear at the last node. The shear is therefore compared away from them, and reported to the
ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import error, reported, within
from contactlab_cases.nested import STEEL, around, nested_rings, relative, squeeze
from contactlab_cases.rings import SOURCE, TwoRings
from contactlab_cases.statics import HELD_BY_FRICTION, projected

RADII = (0.2, 0.6, 1.0)  # mm
CELLS = 6  # of the coarser ring on a quarter, at level 1
SIZES = {"coarse": 4, "fine": 8}
ITERATIONS = 150  # of a run: the finer side as slave takes 90 if friction is high


@dataclass(frozen=True)
class StuckRings(Case):
    """Tractions between two rings under the pressure 1 + wave cos 2t.

    ratio  cells along the outer ring's inner edge over cells along the inner ring's outer edge
    wave   amplitude of cos 2t over the mean
    stiff  modulus of the inner ring over the outer ring's
    mu     of Coulomb's law, more than any |q|/p
    """

    ratio: float = 2.0
    wave: float = 0.5
    stiff: float = 4.0
    mu: float = 10.0

    title: ClassVar[str] = "two rings that stick to each other"
    source: ClassVar[str] = SOURCE
    family: ClassVar[str] = "smooth"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "ratio": (0.5, 2.0, 5.0),
        "stiff": (1.0, 4.0),
        "mu": (2.0, 10.0, 100.0),
    }
    demands: ClassVar[frozenset[str]] = frozenset({"implicit", "friction"})
    proves: ClassVar[frozenset[str]] = frozenset({"pressure", "friction", "order"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Two meshes, one twice as fine, the finer one if the coarser finished."""
        if any(not record.finished for record in done.values()):
            return ()
        a, b, c = RADII
        contact = {
            "start": {"gap": "zero"}, "friction": {"use": "coulomb", "mu": self.mu},
            "enforcement": HELD_BY_FRICTION,
        }  # fmt: skip
        left = [name for name in SIZES if name not in done]
        return [
            replace(
                nested_rings(
                    setup, ((a, b), (b, c)), self._cells(SIZES[name], setup.level), [self._inner(), STEEL], contact,
                    loads=[squeeze("ring1.outer", 1.0, self.wave)], name=name,
                ),
                work=ITERATIONS,
            )
            for name in left[:1]
        ]  # fmt: skip

    def _inner(self) -> tuple[float, float]:
        return STEEL[0] * self.stiff, STEEL[1]

    def _cells(self, size: int, level: int) -> tuple[int, int]:
        """Cells of the inner and of the outer ring along the quarter."""
        n = CELLS * size * level
        return (n, round(n * self.ratio)) if self.ratio >= 1.0 else (round(n / self.ratio), n)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Bound errors on the finer mesh, and orders of convergence."""
        why = "second order: bilinear rings of 48 cells a quarter"
        return [
            error("L2 of the carried pressure", 0.002, why, order=2.0, codes=("patch-test",)),
            error("L2 of the carried shear over that of the pressure, inside", 0.002, why, order=2.0),
            within("order of the carried pressure", 1.8, 2.6, "two of bilinear elements; coarse meshes are beyond it"),
            within("order of the carried shear, inside", 1.7, 2.6, "1.77 from 24 to 48 cells, 1.88 to 96: from below"),
            reported("order of the carried shear to the ends"),
            reported("largest shear over the pressure"),
        ]

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare with the closed form over the quarter."""
        mean, wave, shear = TwoRings(*RADII, self._inner(), STEEL).bonded(1.0, self.wave)
        if "fine" not in done:
            return {}
        p, q, ends = {}, {}, {}
        for name, record in done.items():
            coarser = min(self._cells(SIZES[name], setup.level))
            # points lie evenly in the cells of both sides: sums then see nothing of what alternates from node to node
            at = np.linspace(0.0, 0.5 * np.pi, 60 * coarser + 1)
            exact = mean + wave * np.cos(2.0 * at), shear * np.sin(2.0 * at)
            found = [projected(at, around(record, column)(at), coarser) for column in ("pressure", "shear")]
            side = np.sign(float(found[1] @ exact[1]))  # which way shear counts as positive is the surface's choice
            p[name] = relative(found[0], exact[0])
            off = exact[0] + side * found[1] - exact[1]
            inside = slice(len(at) // 5, -(len(at) // 5))
            q[name], ends[name] = relative(off[inside], exact[0][inside]), relative(off, exact[0])
        return {
            "L2 of the carried pressure": p["fine"],
            "L2 of the carried shear over that of the pressure, inside": q["fine"],
            "order of the carried pressure": float(np.log2(p["coarse"] / p["fine"])),
            "order of the carried shear, inside": float(np.log2(q["coarse"] / q["fine"])),
            "order of the carried shear to the ends": float(np.log2(ends["coarse"] / ends["fine"])),
            "largest shear over the pressure": float(np.abs(exact[1] / exact[0]).max()),
        }
