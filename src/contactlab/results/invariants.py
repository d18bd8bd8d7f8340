"""Invariants that no run may break: a run warns by them at its end, and every cell of a matrix is judged by them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contactlab.api import WORK, Floats
from contactlab.model.model import Model
from contactlab.results.chain_ends import angle_at_ends, turn_at_ends
from contactlab.results.facets import cusps
from contactlab.results.reaction_balance import reaction_sum
from contactlab.results.sample import Sample
from contactlab.results.saw_tooth import largest_turn, pressed_depth, pressure_saw, saw_tooth
from contactlab.results.strain_scale import (
    contact_force_of_strain,
    energy_of_strain,
    force_of_strain,
    round_off_of_reactions,
)

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair
    from contactlab.contact.potential_pair import PotentialPair
    from contactlab.results.contact_report import ContactReport

ROUND = 1e-6  # of the largest: what tolerances of solvers and sums over many steps leave
NO_STRAIN = 1e-7  # whose energy counts as zero: the energy of smaller strains is round-off of load steps
GIVES = 1e-8  # segments: a pull that moves surfaces by less counts as zero; in slender bodies up to 1e-4 of the force
RESOLVED = 0.01  # of the largest reaction: what round-off of positions in a stiff body may leave uncertain
EXACT = 1e-9  # of the largest: sums that are zero by construction
UNLIKE = 0.01  # of the sum of magnitudes: what two half passes may differ by, as the pressures of the finest discs do
STEPWISE = 0.02  # load steps: work between two of them is a trapezoid; steps that follow their loads keep 1e-3
SPREAD = 0.01  # nodes on segments: forces act along the master's normals, pressures along the slave's
PARTLY = 0.05  # multipliers beyond an edge of cover stand for less length than their segments have
SMALL_SHEAR = 0.05  # of the pressure: teeth of a smaller shear are judged by that
NOTHING = 1e-12  # strain of the round-off of positions, as for reactions
PLAIN = 1e-5  # of a contact force: what is left on nearly flat sides whose segments or tractions differ
AT_ENDS = 1.1  # times the angle there: chords for arcs, and the master bends next to the end
END_TURNS = 0.5  # of that angle at the end of a chain: linear multipliers take a quarter of it, constant ones a sixth
TURNS = 4.0  # times the square of the angle between segments: an eighth of it for equal ones, more where lengths differ
DEEP = 0.05  # segments: gap that weak conditions leave between non-matching nodes, in addition to the depth of facets
SEEN = 5  # nodes: of three that came to rest one after the other each keeps the shear of its own moment
SAW, SHEAR_SAW = 0.01, 0.05  # sound runs stay below 0.7 % and 4.1 %; a pressure that is wrong by some per cent has 2 %
KEPT = 1e-3  # of the work of the stresses: forces are then off by less than that
GIVE = 0.02  # of it, where springs press in statics: what drives or yields under a load is off by half of that
CREEP = 0.02  # of the motion of the surfaces: at 0.015 numbers are off by some per cent, at 0.14 by a third
MIRRORED = 1e-3  # of the largest displacement: contact that closes a step later on one side


@dataclass(frozen=True)
class Invariant:
    """A number that a run is judged by, at its last frame.

    name   in words, as in the tables
    code   of the warning that is given if it is broken; `docs/warnings.md` lists all
    where  "contacts.0", or "" for the whole run
    value  result, and `limit`: the largest value that the method promises; inf if it promises nothing
    why    the reason of the limit
    """

    name: str
    code: str
    where: str
    value: float
    limit: float
    why: str

    @property
    def broken(self) -> bool:
        """Return whether the value exceeds the limit; NaN does."""
        return not self.value <= self.limit

    def as_data(self) -> dict[str, Any]:
        """Return the invariant for `summary.json`, with null for no limit."""
        return asdict(self) | {"limit": self.limit if math.isfinite(self.limit) else None}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Invariant:
        """Read a row of `summary.json`; null stands for a value of NaN and for no limit."""
        value = math.nan if data["value"] is None else float(data["value"])
        limit = math.inf if data["limit"] is None else float(data["limit"])
        return cls(**{**data, "value": value, "limit": limit})


def invariants(model: Model, sample: Sample, largest_force: float = 0.0) -> list[Invariant]:
    """All invariants of a run at its last `sample`: energy, momenta, symmetry, and each contact separately.

    largest_force  [N] of the run, compared with which forces at its end may be round-off
    """
    scale = max(largest_force, force_of_strain(model, NOTHING))
    found = [*_energy(model, sample), *_momentum(model, scale), *_symmetry(model)]
    for pair in model.contact.pairs if model.contact is not None else ():
        found += _contact(model, pair, sample.contacts[pair.name], scale)
        found += [*_creep(pair, sample.contacts[pair.name]), *_kept_overlap(model, pair, sample)]
    return found


def judged_from(model: Model, pair: ContactPair, largest_force: float) -> float:
    """Return the force [N] up to which all that a contact carries is round-off, given the largest one of the run."""
    return max(ROUND * largest_force, contact_force_of_strain(model, pair, NOTHING))


# --- the whole run ----------------------------------------------------------------------------------


def _energy(model: Model, sample: Sample) -> Iterator[Invariant]:
    energies = sample.energies
    known = ("internal", "external", "kinetic") if model.way_followed else ("kinetic",)
    odd = sum(not np.isfinite(energies[name]) for name in known)
    yield Invariant("numbers that are not finite", "not-finite", "", float(odd), 0.0, "a finished run has none")
    error = abs(energies["error"])
    felt = max(energies["kinetic"], np.abs(model.state["work"]).max()) > energy_of_strain(model, NO_STRAIN)
    if model.integrator.inertia:
        if not (model.explicit or felt):
            return  # steps that iterate end in equilibrium to the round-off of positions, which is all there is
        why = "works and energies of the scheme balance up to round-off over all steps"
        yield Invariant("error of the energy ledger", "ledger", "", error, ROUND, why)
        return
    if model.way_followed and felt:
        why = "the work of a load step uses the mean of the forces at both its ends"
        yield Invariant("error of the energy ledger", "ledger", "", error, STEPWISE, why)
    mismatch, largest = reaction_sum(model)
    if np.isfinite(mismatch):
        uncertain = round_off_of_reactions(model) / largest
        yield Invariant(
            "support reactions out of balance", "unbalanced-reactions", "", mismatch / largest,
            max(ROUND, min(uncertain, RESOLVED)),
            "load steps end in equilibrium to 1e-8 of the largest force, and to the round-off of positions",
        )  # fmt: skip


def _momentum(model: Model, scale: float) -> Iterator[Invariant]:
    """Judge momenta: contact acts equally on both sides, and without external forces momenta are constant."""
    if model.contact is not None:
        force, x = model.state["contact_force"], model.position
        total = float(np.hypot(*force.T).sum())
        if total > ROUND * scale:
            arm = total * max(pair.size for pair in model.contact.pairs)
            torque = float((x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0]).sum())
            yield Invariant(
                "sum of all contact forces", "linear-momentum", "", float(np.hypot(*force.sum(axis=0))) / total,
                *_balance(model, EXACT, "forces on slave and master are equal and opposite"),
            )  # fmt: skip
            yield Invariant(
                "torque of all contact forces in segments", "angular-momentum", "", abs(torque) / arm, DEEP,
                "forces act along the line between the surfaces, except for the gap that weak conditions leave",
            )  # fmt: skip
    yield from _kept(model)


def _kept(model: Model) -> Iterator[Invariant]:
    if not model.integrator.inertia or model.loading.loads or model.damping or not model.start.momentum[3] > 0.0:
        return
    held = set((model.prescribed.dof % 2).tolist())
    now = model.momenta()
    scale = float(max(model.start.momentum[3], now[3]))
    change = np.abs(now - model.start.momentum)[:3]
    for axis in {0, 1} - held:
        yield Invariant(
            f"change of the momentum along {'xy'[axis]}", "linear-momentum", "", float(change[axis] / scale),
            *_balance(model, EXACT, "no external forces"),
        )  # fmt: skip
    if not held:
        arm = scale * float(np.ptp(model.reference, axis=0).max())
        limit = ROUND if model.explicit or _kept_by_steps(model) else math.inf
        yield Invariant(
            "change of the angular momentum", "angular-momentum", "", float(change[2] / arm),
            *_balance(
                model, limit, "no external forces; steps that iterate promise it with consistent forces alone"
            ),
        )  # fmt: skip


def _kept_by_steps(model: Model) -> bool:
    """Return whether steps that iterate conserve angular momentum as exactly as they are solved."""
    turn = all(body.material.kinematics != "small" for body in model.bodies)
    paired = model.contact is None or (model.contact.consistent and model.integrator.inertia)
    return turn and paired and model.state["work"][WORK.index("numerical")] == 0.0


def _balance(model: Model, limit: float, why: str) -> tuple[float, str]:
    """A limit of momenta and its reason; of half passes one for what meshes resolve."""
    if model.contact is None or not any(pair.half for pair in model.contact.pairs):
        return limit, why
    return max(limit, UNLIKE), "half passes press each side by its own gaps, which agree as far as the meshes resolve"


def _symmetry(model: Model) -> Iterator[Invariant]:
    mirror = model.mirror
    if mirror is None:
        return
    u = model.state["displacement"]
    size = float(np.hypot(*u.T).max(initial=0.0))
    off = np.hypot(*(u - u[mirror] * (-1.0, 1.0)).T)[mirror >= 0]
    if size > 0.0 and len(off):
        yield Invariant(
            "asymmetry of the displacement", "asymmetry", "", float(off.max()) / size, MIRRORED,
            "the scene declares it symmetric; contact may close a step later on one side",
        )  # fmt: skip


# --- one contact ------------------------------------------------------------------------------------


def _contact(model: Model, pair: ContactPair, report: ContactReport, scale: float) -> Iterator[Invariant]:
    """Judge one contact; `scale` [N] is the largest force of the run."""
    curve, largest, sharp = report.curve, report.largest, cusps(pair, model.reference)
    pull = max(0.0, report.cone_violation * largest - _unresolved(model, pair)) / max(largest, scale)
    yield Invariant(
        "pull of a contact node over the largest push", "contact-pull", pair.name, pull, max(ROUND, pair.lagged),
        "nodal forces push and friction keeps its bound, up to residuals (for potentials, of lagged friction)",
    )  # fmt: skip
    if not largest > judged_from(model, pair, scale):
        return  # residuals of the solver only
    if np.any(report.resultant):
        limit, why = _promised(pair, report)
        apart = report.force_error(report.covered_integral)
        yield Invariant("resultant against integral of the pressure", "pressure-integral", pair.name, apart, limit, why)
    depth = report.max_penetration / pair.size
    # the largest overlap of the start that counts as a gap of zero all the time
    distance = pair.start_distance
    overlap = 0.0 if distance is None else max(0.0, -float(distance.min(initial=0.0)))
    # the deepest overlap that a pressure law of the scene implies
    pressed = report.curve.pressure > 0.0
    by_law = max(0.0, -float(np.nanmin(report.curve.gap[pressed], initial=0.0))) if _has_law(model) else 0.0
    allowed = DEEP + (pressed_depth(curve) + overlap + by_law) / pair.size
    yield Invariant(
        "largest penetration of either side in segments", "penetration", pair.name, depth, allowed,
        "facets, overlaps of the start or of a pressure law, and gaps that weak conditions leave between nodes",
    )  # fmt: skip
    yield Invariant(
        "saw-tooth of the pressure", "pressure-saw", pair.name, pressure_saw(curve, sharp), SAW,
        "a pressure that alternates from node to node is a numerical error",
    )  # fmt: skip
    if pair.friction is not None and np.any(curve.shear):
        least = SMALL_SHEAR * float(curve.pressure.max())
        teeth = saw_tooth(curve, curve.shear, sharp, least, fewest=SEEN)
        yield Invariant(
            "saw-tooth of the shear", "shear-saw", pair.name, teeth, SHEAR_SAW,
            "a shear that alternates from node to node where all stick or all slip is a numerical error",
        )  # fmt: skip


def _unresolved(model: Model, pair: ContactPair) -> float:
    """Force [N] below which steps that iterate cannot decide whether a condition is closed."""
    conditions = getattr(model.contact, "conditions", None)
    if conditions is None:
        return 0.0
    own = np.flatnonzero(conditions.present[pair.own]) + pair.own.start
    return GIVES * float((conditions.stiffness[own] * conditions.size[own]).max(initial=0.0))


def _creep(pair: ContactPair, report: ContactReport) -> Iterator[Invariant]:
    """Slip with which friction of a potential holds nodes that stick."""
    if pair.by_energy and report.sticking:
        slip = cast("PotentialPair", pair).creep(report.curve.state)
        yield Invariant(
            "slip of sticking nodes over the motion of the surfaces", "creep", pair.name, slip, CREEP,
            "friction of a potential grows with the slip of each step, and gives way where bodies move as little",
        )  # fmt: skip


def _kept_overlap(model: Model, pair: ContactPair, sample: Sample) -> Iterator[Invariant]:
    """Overlaps that forces leave: springs by nature, forces that give no energy if they came in an instant."""
    contact = model.contact
    assert contact is not None  # a pair belongs to one
    if pair.by_energy or not contact.enforcement.exact:
        if not _has_law(model) and not model.integrator.inertia:
            yield from _kept_by_springs(model, pair, sample)
        return
    # in statics, and with frozen forces in steps that iterate, pressed nodes have no overlaps
    stored = abs(sample.energies["internal"])
    if contact.consistent and model.integrator.inertia and stored > 0.0:
        yield Invariant(
            "overlaps of pressed nodes times their forces over the work of the stresses", "kept-overlap", pair.name,
            sample.contacts[pair.name].kept_work / stored, KEPT,
            "gaps jump if a segment comes within the search distance; forces without energy keep the overlap",
        )  # fmt: skip


def _kept_by_springs(model: Model, pair: ContactPair, sample: Sample) -> Iterator[Invariant]:
    """Judge overlaps and gaps of all contacts, which add up in series, at the contact that has most of them."""
    stored = sample.energies["stored"] + sample.energies["plastic"]
    if stored <= energy_of_strain(model, NOTHING):
        return
    kept = {name: report.kept_work for name, report in sample.contacts.items()}
    if pair.name == max(kept, key=lambda name: kept[name]):
        yield Invariant(
            "work that would open all pressed nodes over that of the stresses", "kept-overlap", pair.name,
            sum(kept.values()) / stored, GIVE,
            "springs yield to the pressure, so bodies overlap more than under exact conditions",
        )  # fmt: skip


def _has_law(model: Model) -> bool:
    """Return whether the scene has a pressure law of the gap."""
    return model.contact is not None and hasattr(model.contact.enforcement, "law")


def _promised(pair: ContactPair, report: ContactReport) -> tuple[float, str]:
    """Allowed difference between the integral of the pressure and the forces, and its reason.

    Pressures act along each segment's normal, forces along averaged normals: they differ by the square of the angle
    between segments; at the end of a chain, where forces act along the master's normal, by the angle of the surfaces.
    """
    curve = report.curve
    angle = angle_at_ends(curve, pair.at.master, pair.master.segments)
    turn = max(PLAIN, TURNS * largest_turn(curve) ** 2, END_TURNS * turn_at_ends(curve), AT_ENDS * angle)
    # whether some multiplier stands for less length than its node has
    apart: Floats = report.pressure_integral - report.covered_integral
    differs = bool(np.hypot(*apart) > ROUND * np.hypot(*report.resultant))
    if np.any(np.isnan(curve.gap) & (curve.pressure != 0.0)) or differs:
        return max(PARTLY, turn), "multipliers of partly covered segments are shown on whole segments"
    if pair.by_energy or not pair.method.passes_patch_test:
        return max(SPREAD + angle, turn), "nodal forces act along normals of the master, or of both, also at corners"
    return turn, "both use the same multipliers, but normals that differ by the turn of a segment"
