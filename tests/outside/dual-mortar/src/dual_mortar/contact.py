"""A mortar method with biorthogonal multipliers: T is diagonal, so each multiplier has a gap of its own."""

from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Overlap, SegmentContact, formula


@dataclass(frozen=True)
class DualMortar(SegmentContact):
    """Multipliers that are biorthogonal to the hats of the slave on what is covered of it (Wohlmuth 2000)."""

    biorthogonal: ClassVar[bool] = True

    @formula
    def overlap(slave, master):
        """What the slave sees of the master along its normals."""
        low, high = slave.between(slave.sees(master.start), slave.sees(master.end))
        return Overlap(low, high, slave.meets(master, low), slave.meets(master, high))

    @formula
    def basis(xi, covered):
        """2 - 3 xi and 3 xi - 1 on a segment that is covered all along."""
        middle, width = 0.5 * (covered.low + covered.high), covered.high - covered.low
        tilt = 12.0 * middle * (1.0 - middle) * (xi - middle) / (width * width)
        return 1.0 - middle - tilt, middle + tilt
