"""Quadrilaterals at finite strain: energy, objectivity, volume, and work of forces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contactlab_quads.q1 import Q1
from contactlab_quads.q1_fbar import Q1Fbar
from contactlab_quads.q1_reduced import Q1Reduced
from contactlab_quads.q2 import Q2
from contactlab_quads.q2_lagrange import Q2Lagrange
from contactlab_solids.hypoelastic import Hypoelastic
from contactlab_solids.linear_elastic import LinearElastic
from contactlab_solids.neo_hookean import NeoHookean
from contactlab_solids.power_law import PowerLaw

from contactlab.api import Element, Floats, Material, Mesh
from contactlab.kernels.cells import element_kernels, midpoint
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.bodies.tangent import Tangent

ELEMENTS: tuple[Element, ...] = (Q1(), Q1Fbar(), Q1Reduced(), Q2(), Q2Lagrange())
HYPO = Hypoelastic(7000.0, 0.3, 1.0)
NEO = NeoHookean(7000.0, 0.3, 1.0)
POWER = PowerLaw(70000.0, 0.3, 1.0, 348.0, 0.02, 0.03)
CELLS = 7


def names(part: object) -> str:
    return type(part).__name__


class Cells:
    """Separate distorted cells of one element with a law, moved at will."""

    def __init__(self, element: Element, law: Material, *, trial: bool = False, cells: int = CELLS) -> None:
        a = len(element.nodes)
        random = np.random.default_rng(4)
        x = element.nodes + random.uniform(-0.08, 0.08, (cells, a, 2))
        self.x = np.ascontiguousarray(x.reshape(-1, 2))
        mesh = Mesh(self.x, np.arange(cells * a, dtype=np.int32).reshape(cells, a), {})
        self.u, self.du, self.force = (np.zeros_like(self.x) for _ in range(3))
        self.position = self.x.copy()
        body = Body("cells", element, law, mesh, 0, len(self.x), mesh.cells)
        geometry, field = {
            "small": (self.x, self.u),
            "finite": (self.position, self.x),
            "rate": (self.position, self.du),
        }[law.kinematics]
        history = np.zeros(body.history_shape())
        trial_history = np.zeros_like(history) if trial else None
        self.forces = BodyForces(body, geometry, field, self.force, history, trial_history, (self.x, self.u))

    def move(self, displacement: Floats) -> Floats:
        """Nodal forces after a step to `displacement`."""
        np.subtract(displacement, self.u, out=self.du)
        self.u[:] = displacement
        np.add(self.x, self.u, out=self.position)
        self.force[:] = 0.0
        for call in self.forces.calls:
            call(1.0)
        return self.force.copy()

    def energy(self) -> float:
        return self.forces.stored_energy() + self.forces.numerical_energy()


def bump(cells: Cells, size: float, seed: int) -> Floats:
    return np.random.default_rng(seed).uniform(-size, size, cells.x.shape)


@pytest.mark.parametrize("law", [LinearElastic(7000.0, 0.3, 1.0), NEO], ids=names)
@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_forces_are_the_derivative_of_the_energy(element: Element, law: Material) -> None:
    """Also with averaged dilatation, and with hourglass energy counted as numerical."""
    cells = Cells(element, law)
    base, way, step = bump(cells, 0.15, 5), bump(cells, 1.0, 6), 1e-5
    force = cells.move(base)
    energies = []
    for factor in (1.0, -1.0):
        cells.move(base + factor * step * way)
        energies.append(cells.energy())
    derivative = (energies[0] - energies[1]) / (2.0 * step)
    # central differences: (step / 0.15)^2 = 4e-9
    assert derivative == pytest.approx(float(np.vdot(force, way)), rel=1e-7)


@pytest.mark.parametrize("steps", [1, 10, 100])
@pytest.mark.parametrize("law", [HYPO, NEO, POWER], ids=names)
@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_a_prestressed_cell_turns_with_its_forces(element: Element, law: Material, steps: int) -> None:
    """Turned by 90 degrees in 1, 10 or 100 steps, nodal forces turn and change in nothing else."""
    cells = Cells(element, law)
    base = bump(cells, 0.1, 7)
    before = cells.move(base)
    for angle in np.linspace(0.0, 0.5 * math.pi, steps + 1)[1:]:
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        after = cells.move((cells.x + base) @ turn.T - cells.x)
    expected = np.stack([-before[:, 1], before[:, 0]], axis=1)
    # round-off of each step, from gradients of order one
    np.testing.assert_allclose(after, expected, atol=1e-12 * np.abs(before).max() * math.sqrt(steps))


@pytest.mark.parametrize("kinematics", ["finite", "rate", "small"])
def test_fbar_gives_all_points_the_volume_of_the_centre(kinematics: str) -> None:
    law = {"finite": NEO, "rate": HYPO, "small": LinearElastic(7000.0, 0.3, 1.0)}[kinematics]
    averaged, plain = Cells(Q1Fbar(), law), Cells(Q1Reduced(), law)
    displacement = bump(averaged, 0.15, 8)
    averaged.move(displacement)
    plain.move(displacement)

    def volume(cells: Cells) -> Floats:
        xx, xy, yx, yy = cells.forces.blocks[0].gradient.reshape(4, -1, CELLS)
        if kinematics == "small":
            return np.asarray(xx + yy)
        if kinematics == "finite":
            return np.asarray(xx * yy - xy * yx)
        # mid-step gradient L: the step's deformation gradient is (I + L/2)(I - L/2)^-1
        grown = (1 + 0.5 * xx) * (1 + 0.5 * yy) - 0.25 * xy * yx
        return np.asarray(grown / ((1 - 0.5 * xx) * (1 - 0.5 * yy) - 0.25 * xy * yx))

    np.testing.assert_allclose(volume(averaged), np.broadcast_to(volume(plain), (4, CELLS)), atol=1e-13)


@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_work_of_a_plastic_cell_is_stored_or_dissipated(element: Element) -> None:
    """Work of the nodal forces on a path into plasticity = stored + plastic + hourglass energy."""
    cells = Cells(element, POWER)
    path, steps, work = bump(cells, 0.05, 9), 4000, 0.0
    before = cells.move(np.zeros_like(cells.x))
    for n in range(1, steps + 1):
        after = cells.move(path * (n / steps))
        work += float(np.vdot(0.5 * (before + after), path / steps))
        before = after
    assert cells.forces.dissipated_energy() > 0.05 * cells.forces.stored_energy() > 0.0
    accounted = cells.energy() + cells.forces.dissipated_energy()
    assert work == pytest.approx(accounted, rel=1e-5)  # trapezoidal rule over the kinks at first yield


@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_increments_add_up_to_the_whole(element: Element) -> None:
    """Stretching a square by increments of the rate law gives Hencky's logarithmic strain."""
    law = Hypoelastic(7000.0, 0.0, 1.0)
    a = len(element.nodes)
    kernels, conn = element_kernels(element, "rate"), np.arange(a, dtype=np.int32)[:, None]
    points = len(element.quadrature().weights)
    x, stress, history = element.nodes.copy(), np.zeros((4, points)), np.zeros((4, points))
    gradient, scratch = np.empty((4, points)), np.zeros((6 * a + 6, 1))
    steps = 200
    for _ in range(steps):
        old = x.copy()
        x[:, 0] *= 1.5 ** (1.0 / steps)
        kernels.gradient(x, x - old, conn, gradient, scratch)
        midpoint(gradient)
        law.stress(gradient, history, 1.0, stress, history)
    # midpoint rule for ln: relative error (ln 1.5 / steps)^2 / 12 = 3e-7
    np.testing.assert_allclose(stress[0], 7000.0 * math.log(1.5), rtol=1e-6)


@pytest.mark.parametrize("law", [LinearElastic(7000.0, 0.3, 1.0), NEO, HYPO, POWER], ids=names)
@pytest.mark.parametrize("element", ELEMENTS, ids=names)
def test_stiffness_is_the_derivative_of_the_forces(element: Element, law: Material) -> None:
    """What Newton solves with, of every element and law together; symmetric wherever an energy exists."""
    cells = Cells(element, law, trial=True, cells=2)
    base, step = bump(cells, 0.05, 5), 1e-6
    size = base.size

    def force(displacement: Floats) -> Floats:
        cells.u[:] = 0.0  # trials of one step from the undeformed state
        return cells.move(displacement).ravel()

    force(base)
    stiffness = Tangent(len(cells.x), (cells.forces,)).assemble(1.0).toarray()
    expected = np.empty((size, size))
    for j in range(size):
        unit = np.zeros(size)
        unit[j] = step
        expected[:, j] = (force(base + unit.reshape(-1, 2)) - force(base - unit.reshape(-1, 2))) / (2.0 * step)
    scale = np.abs(expected).max()
    # differences of forces of order E with step 1e-6: 1e-10, and (step / yield strain)^2 where points yield
    np.testing.assert_allclose(stiffness, expected, atol=1e-7 * scale)
    if law is not HYPO:
        np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-7 * scale)
