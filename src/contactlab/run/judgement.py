"""Checks at the end of a run: contacts that never closed, and forces that do not agree."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, cast

import numpy as np

from contactlab.api import Floats, RunWarning
from contactlab.api.arrays import Flags
from contactlab.errors import SimulationFailure
from contactlab.meshing.curves import facet_depths
from contactlab.model.model import Model
from contactlab.results.invariants import NO_STRAIN, invariants, judged_from
from contactlab.results.sample import Sample
from contactlab.results.slips import slips_of
from contactlab.results.strain_scale import energy_of_strain
from contactlab.run.breaches import breach
from contactlab.run.coordinates import coordinates
from contactlab.run.end_lengths import end_lengths
from contactlab.run.resolution import coarse_facets, few_nodes, nearest_points, warn_of_kept_gaps

if TYPE_CHECKING:
    from contactlab.contact.implicit_system import ImplicitContactSystem
    from contactlab.contact.pair import ContactPair
    from contactlab.model.implicit_model import ImplicitModel
    from contactlab.results.contact_report import ContactReport

JUMP = 0.2  # of the largest work: a disc pressed by a fifth of its radius in one step has 0.05, others below 0.02
WRONG = 0.25  # of the contact force: the pressure belongs to another force
WITHIN = 0.1  # of the largest force of the run: pressing a side out of the other would take as much
BEYOND = 0.05  # of a segment: the gap that weak constraints leave, by which contact forces have a torque
NEARLY = 1e-9  # of a force: round-off
STUCK = 1e-8  # segments: the tolerance of sticking
ENOUGH = 3  # pressed conditions: one or two in the middle of a symmetric pair may have no shear


def judge(
    model: Model, sample: Sample | None, closed: Flags, largest_force: float = 0.0, largest_work: float = 0.0
) -> None:
    """Add warnings to the warnings of a finished run.

    sample  the last one; closed (k,)  multipliers that pressed at any time with more than round-off;
    largest_force [N] and largest_work [mJ] of the run. Raises SimulationFailure("not-converged") if the integral of a
    pressure is not the contact force.
    """
    if sample is None:
        return
    for one in invariants(model, sample, largest_force):
        if one.broken:
            model.warnings.add(breach(one, model))
    model.warnings.add(*_jumps(model, sample, largest_work))
    curved, failing = [], []
    for pair in model.contact.pairs if model.contact is not None else ():
        report = sample.contacts[pair.name]
        force = model.state["multipliers"][0]  # fits without a load touch with round-off
        if not any(closed[one.own].any() or (force[one.own] > 0.0).any() for one in (pair, pair.points) if one):
            model.warnings.add(_never_closed(model, pair, report))
        elif not report.largest > judged_from(model, pair, largest_force):
            model.warnings.add(*_open_within(model, pair, report, largest_force))
        else:
            model.warnings.add(*coarse_facets(model, pair, report.curve), *few_nodes(model, pair, report))
            _judge_friction(model, pair)
            model.warnings.add(*end_lengths(model, pair), *_outside_cover(model, pair, report.resultant))
            # on flat sides that do not match, distances of nodes are no error: their averages are zero
            sides = pair.slave, pair.master
            judged = not model.integrator.inertia and pair.start_distance is None
            if not (model.integrator.inertia or pair.half or pair.method.passes_patch_test):
                failing.append(pair)
            if judged and any(facet_depths(side, model.reference).any() for side in sides):
                curved.append(pair)
            pressed = model.state["multipliers"][0, pair.own] > 0.0
            if np.count_nonzero(pressed) >= ENOUGH:  # of one or two conditions the force alone is known
                _judge_pressure(pair.name, report.force_error(report.covered_integral), sample.step)
    if failing:
        from contactlab.run.patch_error import patch_errors

        model.warnings.add(*patch_errors(cast("ImplicitModel", model), failing))
    if curved:
        model.warnings.add(*warn_of_kept_gaps(model, curved, sample.energies["stored"] + sample.energies["plastic"]))


def _jumps(model: Model, sample: Sample, largest_work: float) -> Iterator[RunWarning]:
    """Warn if load steps of elastic bodies were too long to follow the equilibrium path: work is not stored energy.

    largest_work  [mJ] of the run: if it ends unloaded, works that cancel are known to a part of that
    """
    energies, elastic = sample.energies, not any(body.material.history_size for body in model.bodies)
    if model.integrator.inertia or not (elastic and model.way_followed):
        return
    apart = abs(energies["internal"] - energies["stored"])
    scale = max(largest_work, abs(energies["internal"]) + abs(energies["external"]))
    if scale > energy_of_strain(model, NO_STRAIN) and apart > JUMP * scale:
        yield RunWarning(
            "jump", apart / scale, JUMP, "integrator.steps",
            f"load steps jumped: the work of the stresses over them and the stored energy differ by "
            f"{apart / scale:.0%} of the largest work (limit {JUMP:.0%}), so the end may not be on the equilibrium "
            "path of the loads; take three times as many integrator.steps, or implicit-dynamics",
        )  # fmt: skip


def _never_closed(model: Model, pair: ContactPair, report: ContactReport) -> RunWarning:
    if report.max_penetration > 0.0 and pair.start_distance is None:
        return RunWarning(
            "open-contact", -report.max_penetration, 0.0, pair.name,
            f"{pair.name}: no force in any step, yet the {report.penetrating_side} lies up to "
            f"{report.max_penetration:.4g} within the other side at the end: facets overlap where the algorithm has no "
            "condition that closes; try finer cells, or another algorithm",
        )  # fmt: skip
    apart, _ = nearest_points(model.position[pair.slave.nodes], model.position[pair.master.nodes])
    place = coordinates(model, model.position[pair.slave.nodes[apart.argmin()]])
    return RunWarning(
        "open-contact", float(apart.min()), 0.0, pair.name,
        f"{pair.name}: no force in any step; the nearest nodes of both sides are {apart.min():.4g} apart at the "
        f"end, at {place}; check the direction and size of displacements by supports and loads, or remove "
        "the contact",
    )  # fmt: skip


def _open_within(model: Model, pair: ContactPair, report: ContactReport, largest_force: float) -> Iterator[RunWarning]:
    """Warn of statics whose contact closed and carries nothing at the end, although one side lies within the other.

    largest_force  [N] of the run. Facets of curves that do not touch may overlap by their depth.
    """
    if model.integrator.inertia or pair.start_distance is not None or pair.by_energy:
        return
    depth = report.max_penetration
    depth -= sum(float(facet_depths(side, model.reference).max(initial=0.0)) for side in (pair.slave, pair.master))
    conditions = cast("ImplicitContactSystem", model.contact).conditions
    stiffness = conditions.stiffness[pair.own][conditions.present[pair.own]]
    if not len(stiffness) or not depth * float(stiffness.min()) > WITHIN * largest_force:
        return
    yield RunWarning(
        "open-contact", -report.max_penetration, 0.0, pair.name,
        f"{pair.name}: it carries no force at the end, yet the {report.penetrating_side} lies up to "
        f"{report.max_penetration:.4g} within the other side: its conditions, at points or in the mean over segments, "
        "do not see so small a part of them; halve the cells of both sides there, or exchange slave and master (swap)",
    )  # fmt: skip


def _outside_cover(model: Model, pair: ContactPair, resultant: Floats) -> Iterator[RunWarning]:
    """Warn if the line of a contact's resultant (2,) [N] passes beside the place where both sides face each other.

    Pressures have their resultant between the ends of what they act on; nodal forces may lie beyond them, where the end
    of the master covers a part of a segment, and hold a body that tips. Slave nodes on which other contacts act as well
    are not judged.
    """
    x, force = model.position[pair.slave.nodes], model.state["contact_force"][pair.slave.nodes]
    size, total = float(np.hypot(*resultant)), force.sum(axis=0)
    if not np.hypot(*(total - resultant)) < NEARLY * size:
        return
    up = total / size
    along = np.array([up[1], -up[0]])
    pressed = np.hypot(*force.T) > NEARLY * size
    at = float((x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0]).sum()) / size
    spread = float(np.abs(force @ along).sum() * np.ptp(x[pressed] @ up)) / size
    sides = [model.position[side.nodes] @ along for side in (pair.slave, pair.master)]
    first, last = max(float(side.min()) for side in sides), min(float(side.max()) for side in sides)
    beyond = (max(first - at, at - last) - spread) / pair.size
    if beyond > BEYOND:
        yield RunWarning(
            "outside-cover", beyond, BEYOND, f"{pair.name}.algorithm",
            f"{pair.name}: the resultant of its forces acts {beyond * pair.size:.3g} beyond the end of the surfaces "
            f"that face each other, {beyond:.0%} of a segment (limit {BEYOND:.0%}), which no pressure can do: a body "
            "that should tip may stand; halve the cells there, or put nodes of the slave at the ends of the master",
        )  # fmt: skip


def _judge_pressure(name: str, share: float, step: int) -> None:
    """`share` of the nodal forces on the slave that the integral of its tractions over what is covered lacks.

    Multipliers of segments that a rim covers in part are shown on whole segments: that is warned of. A run is wrong
    where even the integral over the covered part is another force.
    """
    if share > WRONG:
        raise SimulationFailure(
            "not-converged",
            f"step {step}: {name}: integrated contact pressure and contact force differ by {share:.0%} (allowed "
            f"{WRONG:.0%}); try finer cells, the other side as slave (swap), or another algorithm",
        )


def _judge_friction(model: Model, pair: ContactPair) -> None:
    """Friction that is declared and that enforcement or algorithm do not deliver: surfaces slip without any force.

    Like bodies that are pressed straight stick without a force, and do not slip.
    """
    if pair.sliding is None or not pair.sliding.of(slice(None))[:2].any():
        return
    normal, tangential = model.state["multipliers"][:2, pair.own]
    pressed = int(np.count_nonzero(normal > 0.0))
    if pressed >= ENOUGH and not np.any(tangential) and np.any(_slips(model, pair)[normal > 0.0]):
        parts = f"{type(pair.method).__name__} and {type(model.contact.enforcement).__name__}"  # type: ignore[union-attr]
        raise SimulationFailure(
            "failed",
            f"step {model.state.step}: {pair.name}: friction is declared, and {parts} gave no tangential force in any "
            f"of {pressed} pressed conditions; remove friction from the contact, or use an enforcement and an "
            "algorithm that support it",
        )


def _slips(model: Model, pair: ContactPair) -> Floats:
    """Slips (k,) [mm] of the last step; 0 if an iteration cannot distinguish them from sticking."""
    conditions = getattr(model.contact, "conditions", None)
    if conditions is None:
        return slips_of(model)[pair.own]
    slips: Floats = conditions.slip[pair.own]
    return np.where(np.abs(slips) > STUCK * pair.size, slips, 0.0)
