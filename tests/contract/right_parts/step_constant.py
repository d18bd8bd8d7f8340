# kind contact cls Constant
from dataclasses import dataclass

from contactlab.api import Overlap, SegmentContact, formula


@dataclass(frozen=True)
class Constant(SegmentContact):
    """Multipliers that are constant on the half segments beside each node."""

    @formula
    def overlap(slave, master):
        low, high = slave.between(slave.sees(master.start), slave.sees(master.end))
        return Overlap(low, high, slave.meets(master, low), slave.meets(master, high))

    @formula
    def basis(xi):
        if xi < 0.5:
            return 1.0, 0.0
        return 0.0, 1.0
