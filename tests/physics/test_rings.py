"""Two rings: the closed form by itself, and the order of the pressure with either side as slave."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_cases.rings import TwoRings
from contactlab_cases.two_rings import RADII, STEEL
from tiers import some

from contactlab.api import Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate


def test_the_closed_form_is_consistent_with_itself() -> None:
    """A ring cut in two at any radius is one ring: the pressure at the cut is Lame's, with its waves as without."""
    whole = TwoRings(*RADII, STEEL, STEEL)
    mean, _ = whole.pressure(1.0, 0.0)
    a, b, c = RADII
    # Lame, one ring a..c under the pressure 1 at c: s_r(b) = -c^2/(c^2 - a^2) (1 - a^2/b^2)
    assert mean == pytest.approx(c**2 / (c**2 - a**2) * (1.0 - a**2 / b**2), rel=1e-12)
    # far stiffer inside: the outer ring stands on a rigid core, which carries more than the load
    rigid = TwoRings(*RADII, (1e12, 0.3), STEEL)
    nu = 0.3
    # u(b) = 0 and s_r(c) = -1: A (1 - 2 nu) b + B/b = 0
    matrix = [[(1.0 - 2.0 * nu) * b, 1.0 / b], [1.0, -1.0 / c**2]]
    A, B = np.linalg.solve(matrix, [0.0, -1.0])
    assert rigid.pressure(1.0, 0.0)[0] == pytest.approx(-(A - B / b**2), rel=1e-6)


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_the_carried_pressure_has_second_order_with_the_finer_side_as_slave(algorithm: str) -> None:
    """The coarser one as slave is a cell of the quick matrix (test_hard_cases.py)."""
    case = default_registry().make("case", "two-rings")
    setup = Setup(algorithm, True, "q1", "newton")
    _, done = run_case(case, setup)
    found = evaluated(case, setup, done)
    assert found["order of the carried pressure"] > 1.8
    assert abs(found["L2 of the carried pressure"]) < 2e-4
    # what multipliers report follows the coarser side's kinks, which are first order
    assert found["order of the reported pressure"] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("mean", some([1e-2, 1e-4], [1e-4]))
@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_a_small_load_is_solved_as_exactly_as_a_large_one(algorithm: str, mean: float) -> None:
    """Displacements are 1e-6 of a segment, and below: gaps of 1e-8 of a segment are then much of the contact force.

    Measured against segments alone, the error was 0.38 % (P0) and 0.49 % (P1), forty times that of the mesh.
    """
    case = default_registry().make("case", {"use": "two-rings", "mean": mean})
    setup = Setup(algorithm, False, "q1", "newton")
    _, done = run_case(case, setup)
    found = evaluated(case, setup, done)
    # 1.0e-4 is the mesh's own error under the load of the case, which it falls to with second order
    assert abs(found["L2 of the carried pressure"]) < 1.5e-4
    assert found["order of the carried pressure"] > 1.8


def test_the_distance_before_the_run_counts_as_none_and_is_told() -> None:
    """Two unlike polygons of the same circle touch without a pressure until they are loaded."""
    case = default_registry().make("case", "two-rings")
    (job, _) = case.plan(Setup("mortar-p1", False, "q1", "newton"), {})
    from contactlab.cases.run_case import scene_of

    scene = scene_of(job).with_({"loads.0.pressure.to": 0.0})
    results = simulate(scene)
    told = results.summary["contacts"]["contacts.0"]
    assert told["max_pressure"] == 0.0
    least, most = told["start_distance"]
    # both corners and facets lie within the depth of the coarser facets, R (1 - cos(half an angle))
    depth = 0.6 * (1.0 - np.cos(0.5 * 0.5 * np.pi / 24.0))
    assert max(-least, most) > 0.1 * depth
    assert max(-least, most) <= depth * (1.0 + 1e-9)
