"""Contact by potentials: forces that are the gradient of an energy of node positions.

A `Potential` sees the nodes and segments of both surfaces, no body and no scene. It sets no constraints and has no
multipliers: implicit integrators add its forces and stiffness to the bodies' forces, and take no correction beyond its
`largest_step`. Explicit integrators refuse it.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

from contactlab.api.arrays import Floats, Ints
from contactlab.api.contact import ContactMethod
from contactlab.api.friction import FrictionBound
from contactlab.api.surface import Surface


class PotentialView(NamedTuple):
    """All data of a contact that a potential may see, for one step. Read-only.

    Nodes are numbered through both surfaces: first the slave, then the master, n in all.

    slave, master  the surfaces
    edges          (e, 2) int32 all segments, start and end by these numbers; the first len(slave.segments) the slave's
    reference      (n, 2) [mm] undeformed positions
    length         (n,) [mm] half the undeformed length of the segments at each node
    modulus        (n,) [MPa] stiffness of the material behind each node, density times squared speed of its
                   dilatational waves; inf on rigid surfaces
    stiffness      (n,) [MPa/mm] modulus over the depth of the cells behind the node; inf on rigid surfaces
    start          (n, 2) [mm] positions at the start of the step
    lagged         (n, 2) [mm] positions that normal forces of friction belong to: the start of the step, then the
                   last iteration that converged
    friction       the bound of the contact's law; None without friction
    pace           [-] length of the step over a tenth of the loading or the time, at most 1. Friction that grows with
                   the slip of a step up to a distance takes this distance times `pace`: its speed of slip is the same
                   for all steps then, and more steps do not weaken it
    """

    slave: Surface
    master: Surface
    edges: Ints
    reference: Floats
    length: Floats
    modulus: Floats
    stiffness: Floats
    start: Floats
    lagged: Floats
    friction: FrictionBound | None
    pace: float = 1.0


class NodalForces(NamedTuple):
    """Forces on the slave's nodes, (m, 2) [N] each: from the energy, and from friction. Their sums act."""

    push: Floats
    rub: Floats


class Pressures(NamedTuple):
    """Stresses on slave nodes, (m,) [MPa] each, over the tributary lengths of the deformed surface.

    Their integrals are the contact forces. Shear is positive along the slave's direction.
    """

    pressure: Floats
    shear: Floats


class Potential(ContactMethod):
    """Base of contact energies of node positions. Subclasses are frozen dataclasses; their fields are the TOML keys.

    Positions (n, 2) [mm] and all results follow the numbers of the `PotentialView`. Surfaces that are too close
    may give numbers that are not finite: the integrator then takes a shorter correction.

    rubs     True if it has `friction_gradient`; contacts with friction refuse it otherwise
    adheres  True if it takes friction bounds beyond a coefficient; contacts with such laws (Tresca) refuse it otherwise
    """

    rubs: ClassVar[bool] = False
    adheres: ClassVar[bool] = False

    def clearance(self, view: PotentialView) -> float:
        """Return the distance [mm] that surfaces need before the run, 0 if they may touch.

        If it is positive, surfaces must never intersect: the core opens touching surfaces to this distance by moving
        slave nodes of the undeformed mesh, warns by how much, and refuses surfaces that intersect.
        """
        return 0.0

    @abstractmethod
    def energy(self, view: PotentialView, positions: Floats) -> float:
        """Return the energy [mJ per mm of thickness]; inf at positions that are not allowed."""

    @abstractmethod
    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Return the derivative (n, 2) [N] of the energy by the positions: minus the contact forces."""

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Return the second derivative, SciPy sparse (2n, 2n) [N/mm]. By default None: differences of gradients.

        It need not be positive definite; the exact one converges best.
        """
        return None

    def largest_step(self, view: PotentialView, positions: Floats, displacement: Floats) -> float:
        """Return the largest fraction, 0 to 1, of a displacement (n, 2) [mm] that the integrator may take.

        By default 1. Nodes move along straight lines.
        """
        return 1.0

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Return minus the friction forces (n, 2) [N], by slip since `view.start` and normal forces at `view.lagged`.

        The core repeats the iteration until the normal forces belong to the end of the step.
        """
        raise NotImplementedError(f"{type(self).__name__} has no friction")

    def friction_hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Return the derivative of `friction_gradient` by the positions, as `hessian`; by default None: differences."""
        return None

    def nodal_forces(self, view: PotentialView, positions: Floats) -> NodalForces | None:
        """Return forces for tables, curves and errors at accepted positions, divided by tributary lengths.

        By default None: forces of `pressures`.
        """
        return None

    def pressures(self, view: PotentialView, positions: Floats, normal: Floats, length: Floats) -> Pressures | None:
        """Return stresses that replace `nodal_forces`, along nodal normals.

        By default None: the forces that act, minus the gradients, over lengths.

        normal  (m, 2) outward unit normals of the slave, averaged at nodes
        length  (m,) [mm] tributary lengths
        """
        return None
