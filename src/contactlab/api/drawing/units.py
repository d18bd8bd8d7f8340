"""Names of units for tables and plots, from the label that a scene carries."""

from __future__ import annotations

from dataclasses import dataclass

_PRESSURES = {("mm", "N"): "MPa", ("m", "N"): "Pa", ("m", "kN"): "kPa", ("mm", "kN"): "GPa", ("m", "MN"): "MPa"}
_ENERGIES = {("mm", "N"): "mJ", ("m", "N"): "J", ("m", "kN"): "kJ", ("mm", "kN"): "J", ("m", "MN"): "MJ"}


@dataclass(frozen=True)
class Units:
    """Unit names: `length`, `force`, `time`, and what follows from them.

    Forces and energies of plane problems are per unit of thickness.
    """

    length: str
    force: str
    time: str

    @classmethod
    def of_label(cls, label: str | None) -> Units:
        """Return names from "mm N s t" (length, force, time, mass); blank names for labels of another form."""
        words = (label or "").split()
        return cls(*words[:3]) if len(words) >= 3 else cls("", "", "")

    @property
    def pressure(self) -> str:
        """Unit of a force per area, of pressures for instance."""
        return _PRESSURES.get((self.length, self.force), f"{self.force}/{self.length}²" if self.force else "")

    @property
    def line_force(self) -> str:
        """Unit of a force per thickness of the plane body."""
        return f"{self.force}/{self.length}" if self.force else ""

    @property
    def line_energy(self) -> str:
        """Unit of an energy per thickness of the plane body."""
        energy = _ENERGIES.get((self.length, self.force), f"{self.force} {self.length}")
        return f"{energy}/{self.length}" if self.force else ""

    def __getitem__(self, kind: str) -> str:
        """Return the name by kind: "length", "pressure", "line_force" ..., or the kind itself."""
        return str(getattr(self, kind, kind))
