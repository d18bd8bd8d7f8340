"""The strong cone: each multiplier has a gap of its own, weighed by its own function."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1

import contactlab
from contactlab.testing.contact_derivatives import derivatives_are_right
from contactlab.testing.surfaces import Chains, chains, conditions, dense, pair_of

BOTH = pytest.mark.parametrize("kind", [MortarP0, MortarP1])


def shifted() -> Chains:
    """Flat surfaces whose nodes do not meet, the slave's partly beyond the master's."""
    slave, master = np.array([0.0, 0.3, 1.0, 1.4, 2.0]), np.array([0.1, 0.6, 1.1, 2.3])
    return chains(*(np.stack([x, np.zeros(len(x))], axis=1) for x in (slave, master)))


@BOTH
def test_weights_are_means_over_the_multipliers_own_function(kind: Any) -> None:
    """None is negative, where inverses of T have both signs; forces and moments balance, which lines do."""
    at, signs = shifted(), {}
    for cone in ("weak", "strong"):
        rows = conditions(kind(cone=cone), at)
        weights = dense(rows, rows.normal_weight, len(at.nodes))[..., 1]
        np.testing.assert_allclose(weights[:, :5].sum(axis=1), 1.0, atol=1e-14)
        np.testing.assert_allclose(weights @ np.stack([at.nodes[:, 0], np.ones(9)], axis=1), 0.0, atol=1e-14)
        signs[cone] = max(-weights[:, :5].min(), weights[:, 5:].max())
    assert signs["strong"] < 1e-14
    assert signs["weak"] > 0.01


@BOTH
def test_multipliers_are_pressures_where_covers_are_partial(kind: Any) -> None:
    """The force of a multiplier is that of its function, also where the master begins within a segment."""
    pair, _ = pair_of(kind(cone="strong"), shifted())
    draw = np.random.default_rng(3).uniform(1.0, 2.0, pair.slots)
    np.testing.assert_allclose(pair.tractions(draw * pair.cover), draw[pair.coupling.owner], atol=1e-13)
    assert pair.cover.sum() == pytest.approx(1.9)  # from 0.1 to 2.0


@BOTH
@pytest.mark.parametrize("multipliers", ["nodes", "vertices"])
def test_derivatives_are_central_differences(kind: Any, multipliers: str) -> None:
    derivatives_are_right(kind(multipliers, cone="strong"))


def test_no_node_of_a_disc_pulls_beside_the_edge_of_contact() -> None:
    """Where weak ones swing by several per cent of the largest pressure; the forces agree within the mesh's error."""
    lowest, force = {}, {}
    changes = {"integrator": {"use": "newton", "steps": 2}, "supports.1.uy.to": -0.1, "record.recorders": []}
    for cone in ("weak", "strong"):
        algorithm = {"use": "mortar-p1", "cone": cone}
        keys = {"level": 1, "contacts.0.algorithm": algorithm, **changes}
        results = contactlab.simulate(contactlab.load_scene("disc-on-block").with_(keys))
        assert results.status == "finished"
        pressure = results.contact["contacts.0"].last.pressure
        lowest[cone] = np.nanmin(pressure) / np.nanmax(pressure)
        force[cone] = results.history["contacts.0.fy"][-1]
    assert lowest["strong"] >= 0.0
    assert lowest["weak"] < -0.01
    assert force["strong"] == pytest.approx(force["weak"], rel=5e-3)
