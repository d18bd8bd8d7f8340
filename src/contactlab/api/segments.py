"""Arguments of contact formulas: points and segments of the slave, segments of the master or of any side, overlaps."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.mathematics import copysign, nan, sqrt
from contactlab.api.tensors import Number, Vector

BEYOND = 0.1  # of a segment that a side's end may lie beyond the end of the other side


class MasterSegment(NamedTuple):
    """A master segment; the body lies on its left.

    start, end  [mm] positions of its nodes; a point is at(eta), eta from 0 to 1
    """

    start: Vector
    end: Vector

    def edge(self) -> Vector:
        """Vector from its start to its end [mm]."""
        return self.end - self.start

    def at(self, eta: Number) -> Vector:
        """Return the point at eta [mm]."""
        return self.start + eta * self.edge()  # type: ignore[no-any-return]

    def normal(self) -> Vector:
        """Return the outward unit normal."""
        return self.edge().turned().unit()


class SlavePoint(NamedTuple):
    """A point of the slave: a node, or a Gauss point of a segment.

    at      [mm] its position
    normal  outward normal of the slave there, the average of the segments that meet at a node, linear between nodes
    """

    at: Vector
    normal: Vector


class SlaveSegment(NamedTuple):
    """A slave segment and the normals of its nodes, each the average of the segments that meet there.

    start   [mm] its first node; a point is at(xi), xi from 0 to 1
    edge    [mm] from its first to its second node
    normal  outward unit normal of its first node
    turn    change of the normal from the first to the second node
    """

    start: Vector
    edge: Vector
    normal: Vector
    turn: Vector

    def at(self, xi: Number) -> Vector:
        """Return the point at xi [mm]."""
        return self.start + xi * self.edge  # type: ignore[no-any-return]

    def normal_at(self, xi: Number) -> Vector:
        """Return the normal at xi, linear between its nodes and a little shorter than 1 there."""
        return self.normal + xi * self.turn  # type: ignore[no-any-return]

    def sees(self, point: Vector) -> Number:
        """Return xi whose normal meets a point, the root that continues the flat case, also beyond 0 to 1; or NaN."""
        x, y = self.start.x - point.x, self.start.y - point.y
        constant = x * self.normal.y - y * self.normal.x
        linear = (self.edge.x * self.normal.y - self.edge.y * self.normal.x) + (x * self.turn.y - y * self.turn.x)
        square = self.edge.x * self.turn.y - self.edge.y * self.turn.x
        root = linear * linear - 4.0 * square * constant
        if root < 0.0:
            return nan
        return -2.0 * constant / (linear + copysign(sqrt(root), linear))

    def between(self, first: Number, second: Number) -> tuple[Number, Number]:
        """Return the part of the segment between two xi in any order: low and high; low > high without one."""
        low: Number = 1.0
        high: Number = 0.0
        if first == first and second == second:
            low, high = max(0.0, min(first, second)), min(1.0, max(first, second))
        return low, high

    def meets(self, master: MasterSegment, xi: Number) -> Number:
        """Return eta at which the normal at xi meets the line of a master segment, 0 at its start and 1 at its end."""
        normal, edge, point = self.normal_at(xi), master.edge(), self.at(xi)
        x, y = point.x - master.start.x, point.y - master.start.y
        return (x * normal.y - y * normal.x) / (edge.x * normal.y - edge.y * normal.x)


class SideSegment(NamedTuple):
    """A segment of either side; its body lies on its left if it is `own`, on its right if it is `other`.

    start, end    [mm] positions of its ends; a point is at(xi), xi from 0 to 1
    length        [mm] undeformed
    begins, ends  whether the side begins at its start, and ends at its end
    """

    start: Vector
    end: Vector
    length: float
    begins: bool
    ends: bool

    def edge(self) -> Vector:
        """Return the vector from its start to its end [mm]."""
        return self.end - self.start

    def at(self, xi: Number) -> Vector:
        """Return the point at xi [mm]."""
        return self.start + xi * (self.end - self.start)  # type: ignore[no-any-return]

    def foot(self, point: Vector) -> Number:
        """Return xi of the point of its line that is next to a point."""
        edge = self.end - self.start
        return ((point - self.start) @ edge) / (edge @ edge)

    def opposite(self, other: SideSegment) -> tuple[Number, Number]:
        """Return the part between the feet of the other's ends, low and high; it is none if low is not below high.

        Where both sides end within a tenth of a segment of each other, they end together.
        """
        first, last = self.foot(other.start), self.foot(other.end)
        spare = BEYOND * (last - first)
        if self.begins and other.begins:
            first = first - spare
        if self.ends and other.ends:
            last = last + spare
        return max(0.0, first), min(1.0, last)

    def back(self) -> SideSegment:
        """Return the segment from its end to its start."""
        return SideSegment(self.end, self.start, self.length, self.ends, self.begins)


class Overlap(NamedTuple):
    """The part of a slave segment that overlaps a master segment.

    low, high          xi of its start and end: no overlap if low is not below high
    eta_low, eta_high  eta on the master segment at these; between them eta is linear in xi
    """

    low: Number
    high: Number
    eta_low: Number
    eta_high: Number


class Covered(NamedTuple):
    """The overlap of a slave segment with all masters together: xi from `low` to `high`."""

    low: Number
    high: Number
