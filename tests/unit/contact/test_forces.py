"""Which forces explicit contact takes, and that the short ways to consistent ones lead where the long one does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

import contactlab
from contactlab.api import ExplicitEnforcement, FactoredGradients, FactoredRows, Floats, GapRows, Rows, Solve
from contactlab.api.compiled.gradient_products import conditions_moved, nodes_pushed
from contactlab.contact.consistent_system import ConsistentContactSystem
from contactlab.explanation.explain import explain
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.testing.gap_rows import direct_forces, operator

FINE = {"bodies.block.mesh.cells": [72, 12]}  # 2.7 times shorter than the disc's


def model_of(changes: dict[str, Any], forces: str | None = None, name: str = "disc-on-block") -> Model:
    own = {"contacts.0.enforcement": {"use": "forward-increment", "forces": forces}} if forces else {}
    scene = contactlab.load_scene(name).with_(changes | own)
    return build(scene, scene.registry)


@pytest.mark.parametrize(
    ("name", "changes", "consistent"),
    [
        ("dropped-block", {}, True),
        ("disc-on-block", {}, False),  # the paper's, which says so
        ("disc-on-block", {"integrator.forces": "auto"}, True),
        *(("disc-on-block", {"integrator.forces": key}, True) for key in ("consistent", "consistent")),
        *(("dropped-block", {"integrator.forces": key}, False) for key in ("frozen", "published")),
        # the contact's own key decides
        ("disc-on-block", {"contacts.0.enforcement": "forward-increment"}, True),
        ("dropped-block", {"contacts.0.enforcement": {"use": "forward-increment", "forces": "frozen"}}, False),
    ],
)
def test_forces_are_consistent_unless_a_scene_says_otherwise(
    name: str, changes: dict[str, Any], consistent: bool
) -> None:
    contact = model_of(changes, name=name).contact
    assert contact is not None
    assert isinstance(contact, ConsistentContactSystem) == contact.consistent == consistent
    scene = contactlab.load_scene(name).with_(changes)
    assert explain(scene, scene.registry).scene.contact_forces == ("consistent" if consistent else "frozen")


@pytest.mark.parametrize(("integrator", "in_time"), [("newton", False), ("implicit-dynamics", True)])
@pytest.mark.parametrize(("forces", "consistent"), [("auto", None), ("consistent", True), ("frozen", False)])
def test_steps_that_iterate_are_consistent_in_time(
    integrator: str, in_time: bool, forces: str, consistent: bool | None
) -> None:
    changes = {"integrator": integrator, "contacts.0.enforcement": {"use": "active-set", "forces": forces}}
    contact: Any = model_of(changes | {"time.end": 1e-3}).contact
    assert contact.consistent == (in_time if consistent is None else consistent)


@pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p0"])
def test_short_ways_lead_where_full_rows_do(algorithm: str) -> None:
    """Of closest points by columns, of mortar methods by ends; 200 steps with contact from the first on."""
    short, full = (model_of({"contacts.0.algorithm": algorithm}, "consistent") for _ in range(2))
    assert isinstance(short.contact, ConsistentContactSystem)
    assert isinstance(full.contact, ConsistentContactSystem)
    full.contact.reduced, full.contact.factored = (), None
    for model in (short, full):
        advance, dt = model.bound_integrator().step, 0.9 * model.stable_step()
        for _ in range(200):
            advance(dt)
    assert short.contact.factored is not None
    assert short.contact.factored.count > 0
    assert full.contact.rows.count > 0
    assert short.state["multipliers"].max() > 0.0
    largest = np.abs(short.state["displacement"]).max()
    # both solve to 1e-10 of a segment; by ends the stretch of the slave is left out, 1e-4 of the rest
    atol = 1e-4 if algorithm == "mortar-p0" else 1e-9
    np.testing.assert_allclose(
        short.state["displacement"] / largest, full.state["displacement"] / largest, rtol=0.0, atol=atol
    )


@pytest.mark.parametrize(
    ("algorithm", "forces", "atol"),
    # without small weights of full rows, by ends without the stretch of the slave
    [("mortar-p1", "frozen", 1e-12), ("node-on-segment", "consistent", 1e-9), ("mortar-p0", "consistent", 2e-3)],
)
def test_every_form_of_rows_is_one_matrix(algorithm: str, forces: str, atol: float) -> None:
    short, full = (model_of({"contacts.0.algorithm": algorithm}, forces) for _ in range(2))
    full.contact.reduced, full.contact.factored = (), None  # type: ignore[union-attr]
    for model in (short, full):
        model.bound_integrator().step(0.9 * model.stable_step())
    reduced: GapRows = next(one.rows for one in short.contact.reduced if one.rows.count)  # type: ignore[union-attr]
    rows, nodes = full.contact.rows, len(full.state["displacement"])  # type: ignore[union-attr]
    of_slot = {slot: i for i, slot in enumerate(reduced.slot[: reduced.count])}
    same = [of_slot[slot] for slot in rows.slot[: rows.count]]
    assert len(same) > 3
    matrix, rng = reduced.to_csr(nodes), np.random.default_rng(1)
    np.testing.assert_allclose(matrix[same].toarray(), rows.to_csr(nodes).toarray(), rtol=0.0, atol=atol)
    motion, y, compliance = rng.normal(size=(nodes, 2)), rng.normal(size=reduced.count), rng.uniform(size=(nodes, 2))
    dense = matrix.toarray()
    np.testing.assert_allclose(reduced.apply(motion), dense @ motion.ravel(), atol=1e-13)
    np.testing.assert_allclose(reduced.apply_transposed(y, nodes).ravel(), dense.T @ y, atol=1e-13)
    np.testing.assert_allclose(reduced.diagonal(compliance), np.diag(dense * compliance.ravel() @ dense.T), atol=1e-13)
    if isinstance(reduced, FactoredGradients):  # compiled products
        touched, out = reduced.nodes[: reduced.used[0]], np.zeros(reduced.count)
        nodal, turned, carried = motion[touched], np.zeros(reduced.used[1]), np.zeros((2, reduced.count))
        conditions_moved(reduced, reduced.count, nodal, turned, carried, out)
        np.testing.assert_allclose(out, reduced.apply(motion), atol=1e-12)
        nodes_pushed(reduced, y, nodal, turned, carried)
        np.testing.assert_allclose(nodal, reduced.apply_transposed(y, nodes)[touched], atol=1e-12)


@dataclass(frozen=True)
class ByMatrix(ExplicitEnforcement):
    """Takes rows of any form as a sparse matrix."""

    factored: ClassVar[bool] = True
    given: ClassVar[set[type]] = set()

    forces: str = "consistent"

    def solve(self, rows: GapRows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve:
        self.given.add(type(rows))
        multipliers[:] = 0.0
        if rows.count:
            weights = rows.to_csr(len(force)).toarray().reshape(-1, *force.shape)
            y = direct_forces(operator(weights, compliance), rows.gap[: rows.count])
            multipliers[0, rows.slot[: rows.count]] = y
            force[:] = rows.apply_transposed(y, len(force))
        else:
            force[:] = 0.0
        return Solve(1, 0.0, 0, float(np.abs(compliance * force).max()))


@dataclass(frozen=True)
class ByOlderName(ByMatrix):
    """Has a method for `FactoredRows`, as before `solve` took every form."""

    given: ClassVar[set[type]] = set()

    def solve_factored(self, rows: FactoredRows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve:
        return super().solve(rows, compliance, multipliers, force)


@dataclass(frozen=True)
class OfRowsAlone(ByMatrix):
    """Takes no rows but `Rows`."""

    factored: ClassVar[bool] = False
    given: ClassVar[set[type]] = set()


@pytest.mark.parametrize(
    ("part", "algorithm", "forces", "form"),
    [
        (ByMatrix, "mortar-p0", "consistent", FactoredGradients),
        (ByMatrix, "mortar-p0", "frozen", FactoredRows),
        (ByMatrix, "node-on-segment", "consistent", FactoredRows),
        (ByOlderName, "mortar-p0", "frozen", FactoredRows),
        (ByOlderName, "mortar-p0", "consistent", Rows),
        (OfRowsAlone, "mortar-p0", "frozen", Rows),
        (OfRowsAlone, "mortar-p0", "consistent", Rows),
    ],
)
def test_one_solve_takes_every_form(part: type[ByMatrix], algorithm: str, forces: str, form: type[GapRows]) -> None:
    own, shipped = (model_of({"contacts.0.algorithm": algorithm}, forces) for _ in range(2))
    assert own.contact is not None
    part.given.clear()
    own.contact = type(own.contact)(own.contact.passes, part(), own.state)
    for model in (own, shipped):
        advance, dt = model.bound_integrator().step, 0.9 * model.stable_step()
        for _ in range(50):
            advance(dt)
    assert form in part.given <= {form, Rows}
    assert shipped.state["multipliers"].max() > 0.0
    # by ends the stretch of the slave is left out, 1e-4 of the rest
    atol = (1e-4 if form is Rows and forces == "consistent" else 1e-9) * np.abs(shipped.state["displacement"]).max()
    np.testing.assert_allclose(own.state["displacement"], shipped.state["displacement"], rtol=0.0, atol=atol)


def test_newton_pushes_along_derivatives_of_gaps() -> None:
    """As explicit runs with the same forces, 3899.28 N (test_consistent_forces); frozen ones give 3896.2."""
    own = {
        "integrator": {"use": "newton", "steps": 5},
        "contacts.0.enforcement": {"use": "active-set", "forces": "consistent"},
    }
    results = contactlab.simulate(contactlab.load_scene("disc-on-block").with_(FINE | own))
    assert results.status == "finished"
    assert results.summary["reactions"]["block.bottom"][1] == pytest.approx(3899.28, abs=0.02)
