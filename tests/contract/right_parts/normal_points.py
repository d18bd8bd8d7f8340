# kind contact cls Projected
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import PointContact, formula


@dataclass(frozen=True)
class Projected(PointContact):
    """Points of the slave, three on each segment, along the slave's normal."""

    points: ClassVar[int] = 3
    passes_patch_test: ClassVar[bool] = False

    @formula
    def foot(x: Any, master: Any) -> Any:
        edge = master.edge()
        return (x.at - master.start).cross(x.normal) / edge.cross(x.normal)
