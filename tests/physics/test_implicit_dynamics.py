"""Implicit dynamics: impacts with closed forms in steps far beyond the stable one, energy, momentum, order. Forces on a
wall, two beams and a block that comes to rest are cells of the quick matrix (test_hard_cases.py).

Scenes are those of `benchmarks/studies/statics/bars.py`.
"""

from __future__ import annotations

import numpy as np
import pytest
from statics.bars import (
    BAR,
    CELLS,
    ENERGY,
    LENGTH,
    SPEED,
    Record,
    bouncing_bar,
    run,
    scene,
    strip,
    wall_impact,
)
from tiers import some


@pytest.mark.parametrize(("courant", "phase"), some([(1.0, 0.5), (5.0, 0.0), (5.0, 0.5)], [(5.0, 0.0), (5.0, 0.5)]))
def test_contact_takes_the_energy_of_the_node_and_gives_none(courant: float, phase: float) -> None:
    """The stopped node is 1/2N of the bar. Arrival half-way through a step stops what a wave reaches in it as well:
    (1 + courant^2)^(1/2) nodes, from the impedance of a chain under the trapezoidal rule."""
    record = wall_impact(courant, phase=phase)
    assert np.diff(record.energy).max() < 1e-9 * ENERGY
    nodes = 1.0 if phase == 0.0 else np.sqrt(1.0 + courant**2)
    assert 1.0 - record.energy[-1] / ENERGY == pytest.approx(nodes * 0.5 / CELLS, rel=1e-6)
    assert record.ledger == pytest.approx(0.0, abs=1e-9 * ENERGY)
    assert np.all(record.force >= 0.0)


def test_loss_vanishes_with_the_mesh() -> None:
    coarse, fine = (1.0 - wall_impact(1.0, cells=cells).energy[-1] / ENERGY for cells in (10, 40))
    assert coarse / fine == pytest.approx(4.0, rel=1e-3)


def test_bouncing_bar() -> None:
    """First contact: 300 + 300 t for 2/3 s, impulse 800/3. Energy never rises, and two impacts take about a node
    mass each. Back at the top after 16/3 s: within 1.5 % of the period, which the rule lengthens."""
    record, period = bouncing_bar(CELLS, 2.0, 1.0), 16.0 / 3.0
    dt, start = float(record.time[0]), 10.0 * LENGTH * 5.0
    first = (record.time > 0.95) & (record.time < 2.0)
    assert record.force[first].sum() * dt == pytest.approx(800.0 / 3.0, rel=5e-3)
    inside = (record.time > 1.15) & (record.time < 1.6)
    exact = 300.0 + 300.0 * (record.time[inside] - 1.0 - 0.5 * dt)
    # a ripple of a few newtons follows the front
    np.testing.assert_allclose(record.force[inside], exact, rtol=0.03)
    assert record.force[inside].mean() == pytest.approx(exact.mean(), rel=2e-3)
    assert np.diff(record.energy).max() < 1e-9 * start
    assert 0.5 < -record.energy[-1] / start / (0.5 / CELLS) / 2.0 < 1.5
    assert abs(record.momentum[-1, 0]) / LENGTH < 10.0 * 0.015 * period


def test_free_pair_keeps_its_momentum() -> None:
    """Two bars of 1 and 2 lengths: exchange within 2 %, sum of momenta to round-off."""
    bodies = {
        "long": strip((0.0, 20.0), (0.0, 1.0), [50, 1], shift=[0.5, 0.0]),
        "short": strip((-10.0, 0.0), (0.0, 1.0), [25, 1], velocity=[SPEED, 0.0]),
    }
    contact = {"slave": "long.left", "master": "short.right", "algorithm": "mortar-p1"}
    supports = [{"on": "long", "uy": 0.0}, {"on": "short", "uy": 0.0}]
    record = run(scene(bodies, BAR, contacts=[contact], supports=supports), 75, 2.0 / 75)
    np.testing.assert_allclose(record.momentum.sum(axis=1), LENGTH * SPEED, rtol=1e-12)
    assert record.momentum[-1, 1] == pytest.approx(0.0, abs=0.02 * LENGTH * SPEED)
    assert np.diff(record.energy).max() < 1e-9 * ENERGY


# --- order, dissipation ----------------------------------------------------------------------------


def swinging_strip(steps: int, **integrator: float) -> Record:
    """A clamped neo-Hookean strip pushed sideways and let go: large rotations, smooth in time, no contact."""
    push = {"on": "body.right", "ty": {"ramp": "table", "to": 30.0, "points": [[0.0, 0.0], [0.2, 1.0], [0.4, 0.0]]}}
    return run(
        scene(
            {"body": strip((0.0, 4.0), (0.0, 1.0), [8, 2])},
            {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1.0},
            supports=[{"on": "body.left", "ux": 0.0, "uy": 0.0}],
            loads=[push],
            integrator={"use": "implicit-dynamics", **integrator},
        ),
        steps,
        0.8 / steps,
        axis=1,
    )


def test_second_order_without_contact() -> None:
    """Quartered errors at halved steps; measured against a run with four times as many."""
    ends = [swinging_strip(steps).end for steps in (80, 160, 320)]
    rate = np.log2(np.linalg.norm(ends[0] - ends[2]) / np.linalg.norm(ends[1] - ends[2]))
    # against a finer run of the same order, itself 1/16 off: log2((1 - 1/16)/(1/4 - 1/16)) = 2.32
    assert rate == pytest.approx(2.32, abs=0.2)


def test_dissipation_is_declared() -> None:
    """None without the field; with it the ledger still closes, and what is lost stands there."""
    plain, damped = swinging_strip(40), swinging_strip(40, dissipation=0.3)
    highest = float(plain.energy.max())
    for record in (plain, damped):
        # to the tolerance of the iteration times the work done
        assert record.ledger == pytest.approx(0.0, abs=1e-8 * highest)
    free = slice(21, None)  # no load any more
    # the rule keeps energies of linear bodies; this one turns by a good part of a radian
    assert np.ptp(plain.energy[free]) < 0.02 * highest
    assert damped.energy[-1] < 0.95 * plain.energy[-1]
