"""Parts that follow the temperature of a scene: thermal strain, friction, a layer that hardens, a draught."""

from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import UNIT, Effect, FrictionBound, FrictionLaw, Material, NormalLaw, formula
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Heated(Material):
    """Linear elasticity of the strain less the thermal one, alpha T.

    young      [MPa]
    poisson    [-]
    expansion  [1/K] alpha
    density    [t/mm3]
    """

    young: float
    poisson: float
    expansion: float
    density: float
    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    stress_free: ClassVar[bool] = False

    @formula
    def stress(H, temperature, p):
        """Cauchy stress of small strains."""
        mu = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * mu * p.poisson / (1.0 - 2.0 * p.poisson)
        elastic = H.symmetric() - p.expansion * temperature * UNIT
        return lame * elastic.trace() * UNIT + 2.0 * mu * elastic


@dataclass(frozen=True)
class Softening(FrictionLaw):
    """Coulomb's coefficient at 0 K, which falls linearly to 0.

    mu    [-] coefficient at 0 K
    melt  [K] temperature at which nothing is left
    """

    mu: float
    melt: float
    needs: ClassVar[tuple[str, ...]] = ("temperature",)

    def bound(self, temperature):
        """Coulomb's bound with the coefficient of each multiplier."""
        return FrictionBound(self.mu * (1.0 - temperature / self.melt).clip(0.0), 0.0, 0.0)


@dataclass(frozen=True)
class CuringLayer(NormalLaw):
    """An elastic layer that is as stiff as it is hot, thick and old: rate * temperature * x * time.

    rate  [MPa/(mm^2 K s)] growth of the stiffness
    """

    rate: float
    needs: ClassVar[tuple[str, ...]] = ("temperature", "position", "time")

    @formula
    def pressure(gap, temperature, position, time, p):
        """Proportional to the overlap."""
        return max(0.0, -p.rate * temperature * position.x * time * gap)


@dataclass(frozen=True)
class Draught(Effect):
    """Lifts bodies by a force that is proportional to the temperature of their places.

    lift  [N/K] force on all of a body at a temperature of 1 K
    on    bodies or edge sets
    """

    lift: float
    on: tuple[str, ...]
    needs: ClassVar[tuple[str, ...]] = ("temperature",)
    conservative: ClassVar[bool] = True

    def bind(self, view):
        """Return a function that adds the forces at a time."""
        nodes, shares = view.shares(self.on)
        heat = view.fields["temperature"]

        def add(time, force):
            force[nodes, 1] += self.lift * shares * heat(time)[nodes]

        return add


@hookimpl
def contactlab_parts() -> list[Part]:
    """A material, a friction law, a pressure law and an effect."""
    return [
        Part("material", "heated", f"{__name__}:Heated", "linear elasticity with thermal strain"),
        Part("friction", "softening", f"{__name__}:Softening", "Coulomb, less with the temperature"),
        Part("enforcement", "curing-layer", f"{__name__}:CuringLayer", "as stiff as it is hot, thick and old"),
        Part("effect", "draught", f"{__name__}:Draught", "lifts what is hot"),
    ]
