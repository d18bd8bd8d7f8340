"""What alternates from node to node, on pressures whose teeth are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from contactlab.api import ContactCurve, Floats, Ints
from contactlab.results.saw_tooth import largest_turn, pressed_depth, pressure_saw, saw_tooth

NODES = 41


def curve(pressure: Floats, state: Ints | None = None, y: Floats | None = None) -> ContactCurve:
    x = np.linspace(-1.0, 1.0, len(pressure))
    state = np.where(pressure > 0.0, 2, 0).astype(np.int32) if state is None else state
    chain = np.zeros(len(x), np.int32)
    return ContactCurve(x, x, 0.0 * x if y is None else y, pressure, 0.0 * x, pressure.clip(0.0), 0.0 * x, state, chain)


def hertz(width: float) -> Floats:
    x = np.linspace(-1.0, 1.0, NODES)
    return np.asarray(np.sqrt(np.maximum(0.0, 1.0 - (x / width) ** 2)))


@pytest.mark.parametrize("width", [0.2, 0.31, 0.5, 0.93])
def test_smooth_pressures_have_no_teeth(width: float) -> None:
    assert saw_tooth(curve(hertz(width)), hertz(width)) == 0.0
    slope = 1.0 + 0.5 * np.linspace(-1.0, 1.0, NODES) ** 3
    assert saw_tooth(curve(slope), slope) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("height", [0.003, 0.1])
def test_teeth_are_as_high_as_they_are(height: float) -> None:
    """Up and down by their height about a constant: the largest value is the mean and one of them."""
    teeth = 1.0 + height * (-1.0) ** np.arange(NODES)
    assert saw_tooth(curve(teeth), teeth) == pytest.approx(height / (1.0 + height), rel=0.05)


def test_few_nodes_have_no_teeth() -> None:
    """Three that came to rest one after the other keep the shear of their own moments: five between others speak."""
    teeth = 1.0 + 0.1 * (-1.0) ** np.arange(7)
    found = [saw_tooth(curve(teeth[:count]), teeth[:count], fewest=5) > 0.0 for count in (6, 7)]
    assert saw_tooth(curve(teeth[:5]), teeth[:5]) > 0.0
    assert found == [False, True]


def test_a_step_is_no_tooth() -> None:
    step = np.where(np.arange(NODES) < 12, 1.0, 0.7)
    assert saw_tooth(curve(step), step) == 0.0


def test_a_kink_between_sticking_and_slipping_nodes_is_no_tooth() -> None:
    x = np.linspace(-1.0, 1.0, NODES)
    state = np.where(np.abs(x) < 0.4, 1, 2).astype(np.int32)
    shear = np.where(state == 1, x, np.sign(x) * (0.2 + 0.2 * np.abs(x)))
    assert saw_tooth(curve(np.ones(NODES), state), shear) == pytest.approx(0.0, abs=1e-12)


def test_a_cusp_is_no_tooth_where_it_is_known() -> None:
    """Below the apex of a wedge the pressure is a logarithm: its best piecewise linear approximation overshoots."""
    x, fine = np.linspace(-1.0, 1.0, 21), np.linspace(-1.0, 1.0, 20001)[1:-1:2]
    hats = np.stack([np.interp(fine, x, hat) for hat in np.eye(len(x))], axis=1)
    wedge = np.linalg.lstsq(hats, np.arccosh(1.0 / np.maximum(np.abs(fine), 1e-9)), rcond=None)[0]
    apex = np.arange(len(x)) == 10
    assert saw_tooth(curve(wedge), wedge) > 0.01
    assert saw_tooth(curve(wedge), wedge, apex) < 0.001


def test_multipliers_that_overshoot_at_an_edge_are_no_teeth_but_alternating_nodal_pressures_are() -> None:
    nodal = hertz(0.52)
    overshoot = nodal.copy()
    first, second, third = np.flatnonzero(nodal)[:3]
    overshoot[[first, second, third]] += 0.1 * np.array([-0.6, 1.0, -1.0])
    assert pressure_saw(replace(curve(nodal), pressure=overshoot)) == 0.0
    teeth = np.where(nodal > 0.0, nodal + 0.05 * (-1.0) ** np.arange(NODES), 0.0).clip(0.0)
    assert pressure_saw(replace(curve(nodal), nodal_pressure=teeth)) == pytest.approx(0.05, rel=0.2)


def test_teeth_of_a_small_shear_are_judged_by_the_pressure() -> None:
    shear = 1e-3 * (-1.0) ** np.arange(NODES)
    assert saw_tooth(curve(np.ones(NODES)), shear) == pytest.approx(1.0, rel=0.1)
    assert saw_tooth(curve(np.ones(NODES)), shear, least=0.05) == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("every", [2, 3, 4, 7])
def test_nodes_that_alone_are_pressed_are_teeth(every: int) -> None:
    """Finer slaves that touch a curved master only at its nodes: every second or third carries all."""
    alone = np.zeros(NODES)
    alone[::every] = 1.0
    assert saw_tooth(curve(alone), alone) == pytest.approx(0.5)


def test_nodes_that_touch_at_uneven_distances_are_no_teeth() -> None:
    alone = np.zeros(NODES)
    alone[[3, 9, 24]] = 1.0
    assert saw_tooth(curve(alone), alone) == 0.0


def test_two_places_that_touch_are_no_teeth() -> None:
    places = np.zeros(NODES)
    places[[0, 10, 12, 30]] = 1.0
    assert saw_tooth(curve(places), places) == 0.0


def test_turns_and_depths_are_those_of_a_circle() -> None:
    radius, angle = 5.0, np.linspace(-0.2, 0.2, NODES)
    arc = curve(np.ones(NODES), y=radius * np.cos(angle))
    arc = ContactCurve(**{**vars(arc), "x": radius * np.sin(angle)})
    step = angle[1] - angle[0]
    assert largest_turn(arc) == pytest.approx(step, rel=1e-6)
    assert pressed_depth(arc) == pytest.approx(radius * (1.0 - np.cos(0.5 * step)), rel=1e-3)


def test_a_node_that_alone_is_pressed_turns_as_its_neighbours_do() -> None:
    """Both segments beside it may lie in one line, flattened or by chance; their other ends turn."""
    radius, angle = 5.0, np.linspace(-0.2, 0.2, NODES)
    alone = np.zeros(NODES)
    alone[20] = 1.0
    arc = curve(alone, y=radius * np.cos(angle))
    y = arc.y.copy()
    y[20] = 0.5 * (y[19] + y[21])
    flat = ContactCurve(**{**vars(arc), "x": radius * np.sin(angle), "y": y})
    assert largest_turn(flat) == pytest.approx(1.5 * (angle[1] - angle[0]), rel=1e-3)
    nothing = ContactCurve(**{**vars(flat), "nodal_pressure": np.zeros(NODES)})
    assert largest_turn(nothing) == 0.0
