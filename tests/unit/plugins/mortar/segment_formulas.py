"""Contact algorithms of formulas, as an author writes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import Overlap, SegmentContact, formula


@dataclass(frozen=True)
class AlongNormals(SegmentContact):
    """Segments that see each other along the slave's normals."""

    passes_patch_test: ClassVar[bool] = True

    @formula
    def overlap(slave: Any, master: Any) -> Any:
        """From where the normals meet one end of the master to where they meet the other."""
        low, high = slave.between(slave.sees(master.start), slave.sees(master.end))
        return Overlap(low, high, slave.meets(master, low), slave.meets(master, high))


@dataclass(frozen=True)
class Linear(AlongNormals):
    """Hats."""

    @formula
    def basis(xi: Any) -> Any:
        """Linear between nodes."""
        return 1.0 - xi, xi


@dataclass(frozen=True)
class Dual(AlongNormals):
    """Biorthogonal to hats on what is covered."""

    @formula
    def basis(xi: Any, covered: Any) -> Any:
        """Linear, of a slope that grows as less is covered."""
        middle, width = 0.5 * (covered.low + covered.high), covered.high - covered.low
        tilt = 12.0 * middle * (1.0 - middle) * (xi - middle) / (width * width)
        return 1.0 - middle - tilt, middle + tilt


@dataclass(frozen=True)
class Leaning(AlongNormals):
    """Hats with a part of the other one."""

    lean: float = 0.0

    @formula
    def basis(xi: Any, p: Any) -> Any:
        """By a field of the part."""
        return 1.0 - xi + p.lean * xi, xi + p.lean * (1.0 - xi)
