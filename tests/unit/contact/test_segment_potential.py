"""Contact energies by formulas: closed forms, both derivatives, balance, plain Python, and what is refused."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import PotentialView, SegmentPotential, formula
from contactlab.contact.potential_pair import differences
from contactlab.testing.surfaces import Chains, chains, curved, pair_of


@dataclass(frozen=True)
class Layer(SegmentPotential):
    """A layer between two surfaces that pushes from afar, as the cube of what its thickness has lost."""

    modulus: float = 50.0
    thickness: float = 0.08
    passes_patch_test: ClassVar[bool] = True

    def begins(self, view: PotentialView) -> float:
        return self.thickness

    @formula
    def normal(own: Any, other: Any) -> Any:
        return own.edge().unit().turned()

    @formula
    def overlap(own: Any, other: Any) -> Any:
        return own.opposite(other)

    @formula
    def energy(gap: Any, p: Any) -> Any:
        return p.modulus * (p.thickness - gap) ** 3


def flat(gap: float) -> Chains:
    """Two sides of 2 mm, whose segments do not match."""
    at = (np.stack([x, 0.0 * x], axis=1) for x in (np.linspace(0.0, 2.0, count) for count in (6, 8)))
    return chains(*at).lifted((0.0, gap))


def test_a_uniform_gap_has_the_energy_and_the_forces_of_the_formula() -> None:
    part, at = Layer(), flat(0.03)
    view = pair_of(part, at)[0].view
    lost = part.thickness - 0.03
    assert part.energy(view, view.reference) == pytest.approx(2.0 * part.modulus * lost**3, rel=1e-13)
    force = -part.gradient(view, view.reference)
    assert force[:6, 1].sum() == pytest.approx(2.0 * 3.0 * part.modulus * lost**2, rel=1e-13)
    assert np.abs(force[:, 0]).max() < 1e-13 * force[:, 1].max()
    apart = pair_of(part, flat(0.09))[0].view
    assert part.energy(apart, apart.reference) == 0.0


def test_both_derivatives_are_those_of_the_energy_between_curved_sides() -> None:
    """Central differences, whose error is that of round-off over the step."""
    part, at = Layer(thickness=0.3), curved()
    view = pair_of(part, at)[0].view
    x, step = view.reference, 1e-6 * at.spacing
    gradient, hessian = part.gradient(view, x), part.hessian(view, x).toarray()
    assert np.abs(gradient).max() > 0.0
    by_energy = np.zeros(x.size)
    for number in range(x.size):
        pair = []
        for sign in (1.0, -1.0):
            moved = x.copy()
            moved.reshape(-1)[number] += sign * step
            pair.append(part.energy(view, moved))
        by_energy[number] = (pair[0] - pair[1]) / (2.0 * step)
    np.testing.assert_allclose(gradient.ravel(), by_energy, atol=1e-6 * np.abs(gradient).max())
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-13 * np.abs(hessian).max())
    np.testing.assert_allclose(hessian, differences(part.gradient, view, x, step), atol=1e-6 * np.abs(hessian).max())
    assert np.abs(gradient.sum(axis=0)).max() < 1e-13 * np.abs(gradient).max()
    moment = (x[:, 0] * gradient[:, 1] - x[:, 1] * gradient[:, 0]).sum()
    assert abs(moment) < 1e-12 * np.abs(gradient).max()


def test_it_runs_as_plain_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same numbers; second derivatives are left to the core's differences."""
    compiled, at = Layer(), flat(0.03)
    view = pair_of(compiled, at)[0].view
    energy, gradient = compiled.energy(view, view.reference), compiled.gradient(view, view.reference)
    monkeypatch.setenv("CONTACTLAB_PYTHON", "1")

    @dataclass(frozen=True)
    class InPython(Layer):
        pass

    part = InPython()
    assert part.hessian(view, view.reference) is None
    assert part.energy(view, view.reference) == pytest.approx(energy, rel=1e-14)
    np.testing.assert_allclose(part.gradient(view, view.reference), gradient, atol=1e-14 * np.abs(gradient).max())


def test_what_a_formula_cannot_have_is_refused() -> None:
    with pytest.raises(TypeError, match=r"Wrong.energy: got the argument speed, allowed: gap, p, stiffness"):

        class Wrong(SegmentPotential):
            @formula
            def energy(gap: Any, speed: Any) -> Any:
                return gap * speed

    with pytest.raises(ValueError, match=r"slip: got 0.0, allowed: above 0"):
        Layer(slip=0.0)
