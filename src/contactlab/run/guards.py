"""Divergence detectors: they stop a run with the step, the place, the value and what to try."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, RunWarning, Step
from contactlab.errors import NotFiniteError, SimulationFailure
from contactlab.kernels.watch import deepest, smallest_jacobian, status_changes
from contactlab.model.bodies.body import BodyForces
from contactlab.model.energy import energy_gain
from contactlab.model.model import Model
from contactlab.run.judgement import judge

if TYPE_CHECKING:
    from contactlab.model.contact.pair import ContactPair
    from contactlab.results.sample import Sample

EVERY = 50  # steps between looks at the whole model
SELDOM = 4 * EVERY  # steps between looks at the stored energy, which costs the laws another pass
LOOSE = 1e-6  # natural residual of a contact solve that counts as not converged
PATIENCE = 50  # consecutive steps with a loose residual before the run is stopped
FLICKER = 0.3  # share of the conditions whose status changes within a step
FEWEST = 4  # conditions below which a share means nothing: a corner's one or two alternate by nature
CHATTER = 100  # consecutive steps that flicker before the run is stopped
UNEXPLAINED = 0.01  # energy stored without work, over the largest that was there or was supplied
GAIN = 0.1  # the same for energy that contact makes: weak conditions on coarse meshes make some per cent
MADE = 0.01  # energy that contact has made in all, whatever damping took of it since: told
TOO_MUCH_MADE = 0.1  # and the run is stopped
LASTING = 100  # steps that either must last: sharp impacts borrow some energy for a few
OVERSHOOT = 100.0  # kinetic over all energy: 1/(1 - (w dt/2)^2) at most in a mode that leapfrog follows; 99 % of 2/w
AT_THE_END = 5.0  # times these limits: more at the end of a run stops it whether it lasted or not
ROUND = 1e-7  # strains that are round-off: energies of laws, quadratic in them, are differences of numbers near one
TOO_DEEP = 0.5  # segment lengths
FAR_SIDE = 2.0  # segment lengths beyond which a node is on the far side of a thin body


class Guards:
    """Watches one run. `after_step` is called every step, `look` every `EVERY` steps and at every frame."""

    def __init__(self, model: Model, step: float | None = None) -> None:
        """`step` [s] is the length that the scene fixes, if it does: only then advice is to change that."""
        self.model, self.work = model, model.state["work"]
        self.shorter = shorter_steps(model.explicit, step)
        self.loose = self.flickering = 0
        self.since = np.full(3, -1.0)  # steps at which energies became too high
        speeds = np.hypot(*model.state["velocity"].T) if "velocity" in model.state else np.zeros(1)
        self.input_speed = float(speeds.max(initial=0.0))
        self.driven = model.prescribed.dof  # by component: a node held in one is free in the other
        self.wave_speed = max(body.material.wave_speeds()[0] for body in model.bodies)
        # energies of smaller strains are round-off
        self.largest_energy = max(model.initial_energy, float(model.mass.sum()) * (ROUND * self.wave_speed) ** 2)
        self.pairs: tuple[ContactPair, ...] = tuple(model.contact.pairs) if model.contact is not None else ()
        self.forces = model.state["multipliers"][0] if self.pairs else np.zeros(0)
        self.pressed = np.zeros(len(self.forces), np.bool_)
        self.closed = self.pressed.copy()  # what pressed at any time
        # an overlap of the start is pushed out: energy that the scene lets contact put in
        self.eased = any(pair.easing is not None for pair in self.pairs)
        self.slopes = [_slopes(forces) for forces in model.forces]

    def memory(self) -> dict[str, Floats]:
        """Everything that changes while the run goes on."""
        numbers = (self.loose, self.input_speed, self.flickering, self.largest_energy, *self.since)
        return {"guards": np.array(numbers, np.float64), "guards.pressed": self.pressed + 2.0 * self.closed}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Back to where `memory` was taken."""
        loose, self.input_speed, flickering, self.largest_energy, *self.since[:] = memory["guards"].tolist()
        self.loose, self.flickering = int(loose), int(flickering)
        self.pressed[:] = memory["guards.pressed"] % 2.0 == 1.0
        self.closed[:] = memory["guards.pressed"] >= 2.0

    def _stop(self, what: str, hint: str, status: str = "diverged") -> None:
        raise SimulationFailure(status, f"step {self.model.state.step}: {what}; {hint}")

    def _node(self, node: int) -> str:
        for body in self.model.bodies:
            if body.first <= node < body.first + body.count:
                return f"node {node - body.first} of body {body.name}"
        surface = next(s for s in self.model.supports if node in s.nodes)
        return f"node {node - surface.nodes[0]} of {surface.on}"

    # --- every step -----------------------------------------------------------------------------

    def after_step(self, step: Step) -> None:
        """Stop at the first step without a number, and when contact was not solved or flickered for many steps."""
        if not math.isfinite(self.work[0]):
            self._finite()
            raise NotFiniteError("failed", f"step {self.model.state.step}: the work of the stresses is not a number")
        self.loose = self.loose + 1 if step.residual > LOOSE else 0
        if self.loose >= PATIENCE:
            self._not_solved(step.residual)
        if self.pairs:
            self._flicker()

    def _not_solved(self, residual: float) -> None:
        self._stop(
            f"the contact solve left a residual of {residual:.1e} segment lengths (allowed {LOOSE:.0e}) in {PATIENCE} "
            f"consecutive steps{self._worst_condition()}",
            "make the lighter or finer side the slave, or allow more sweeps",
            "not-converged",
        )

    def _worst_condition(self) -> str:
        """Where contact conditions hold least: pressed ones off the surface, or open ones behind it."""
        found = []
        for pair in self.pairs:
            gaps = pair.snapshot(self.model.state, self.model.position).gaps
            pressed = self.forces[pair.first_slot : pair.first_slot + pair.slots] > 0.0
            slot = int(np.argmax(np.where(pressed, np.abs(gaps), -gaps)))
            found.append((abs(float(gaps[slot])), pair, slot))
        if not found:
            return ""
        gap, pair, slot = max(found, key=lambda worst: worst[0])
        return f", worst in {pair.name} at {self._slave_node(pair, slot)}, {gap:.1e} off"

    def _slave_node(self, pair: ContactPair, slot: int) -> str:
        return self._node(int(pair.slave.nodes[slot % len(pair.slave.nodes)]))

    def _flicker(self) -> None:
        changes, conditions, last = status_changes(self.forces, self.pressed)
        if changes:
            self.closed |= self.pressed
        flickers = conditions >= FEWEST and changes > FLICKER * conditions
        self.flickering = self.flickering + 1 if flickers else 0
        if self.flickering >= CHATTER:
            pair = next(p for p in reversed(self.pairs) if p.first_slot <= last)
            self._stop(
                f"{pair.name} chatters: {changes} of {conditions} contact conditions opened or closed in the last "
                f"step, more than {FLICKER:.0%} in each of {CHATTER} steps, among them that of "
                f"{self._slave_node(pair, last - pair.first_slot)}",
                f"try {self.shorter}, some damping, or the other side as slave",
            )

    # --- now and then ---------------------------------------------------------------------------

    def look(self) -> None:
        """Raise SimulationFailure("diverged") at the first sign that the numbers mean nothing any more."""
        self.look_at_positions()
        step = self.model.state.step
        if step % EVERY or step % SELDOM == 0:  # at every frame between the looks, and in every fourth look
            self._energy()

    def look_at_positions(self) -> None:
        """The part of `look` that one step alone decides: numbers, speeds, cells and surfaces at its end."""
        self._finite()
        if self.pairs:
            self._examine()
        self._speed()
        self._folded()
        self._penetration()

    def _finite(self) -> None:
        for name in ("velocity", "displacement", "internal_force"):
            if name not in self.model.state or math.isfinite(self.model.state[name].sum()):
                continue
            values = self.model.state[name]
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
            if len(bad):
                raise NotFiniteError(
                    "diverged",
                    f"step {self.model.state.step}: {self._node(int(bad[0]))} has the {name.replace('_', ' ')} "
                    f"({values[bad[0], 0]:g}, {values[bad[0], 1]:g}), the first of {len(bad)} nodes where it is not "
                    f"finite; try {self.shorter}, and look at the material there",
                )

    def _examine(self) -> None:
        """Raise WrongAnswer for a contact algorithm whose answer is no number: its contact would vanish."""
        from contactlab.model.examination import examine_pair

        for pair in self.pairs:
            examine_pair(pair)

    def _speed(self) -> None:
        if "velocity" not in self.model.state:
            return
        velocity = self.model.state["velocity"]
        speed = np.hypot(*velocity.T)
        # what supports and rigid surfaces are told to do goes in
        told = float(np.abs(velocity.ravel()[self.driven]).max(initial=0.0))
        self.input_speed = max(self.input_speed, told)
        limit = max(10.0 * self.input_speed, self.wave_speed)
        worst = int(np.argmax(speed))
        if not speed[worst] <= limit:
            self._stop(
                f"{self._node(worst)} moves at {speed[worst]:.3g}, above {limit:.3g} (ten times the fastest that goes "
                "in, or the speed of sound)",
                f"the step is too long or contact pushes without limit: try {self.shorter}",
            )

    def _folded(self) -> None:
        for forces, slopes in zip(self.model.forces, self.slopes, strict=True):
            begin = 0
            for block in forces.blocks:
                jacobian, cell, point = smallest_jacobian(forces.geometry, block.connectivity, slopes)
                if not jacobian > 0.0:
                    own = block.connectivity[:, cell : cell + 1]
                    undeformed = smallest_jacobian(self.model.reference, own, slopes[point : point + 1])[0]
                    self._stop(
                        f"cell {begin + cell} of body {forces.body.name} is folded over, det F = "
                        f"{jacobian / undeformed:.3g}",
                        "try a finer mesh there, a slower load or the other side as slave",
                    )
                begin += block.connectivity.shape[1]

    def _penetration(self) -> None:
        for pair in self.pairs:
            if pair.near is None:
                continue
            position, near = self.model.position, pair.near.candidates
            depth, place, side = deepest(
                position[pair.slave.nodes], pair.slave.segments, position[pair.master.nodes], pair.master.segments,
                near.start, near.master, FAR_SIDE * pair.size,
            )  # fmt: skip
            if depth > TOO_DEEP * pair.size:
                surface = (pair.slave, pair.master)[side]
                self._stop(
                    f"{pair.name}: {self._node(int(surface.nodes[place]))} of the {('slave', 'master')[side]} lies "
                    f"{depth:.3g} deep in the other side, {depth / pair.size:.0%} of a segment (allowed "
                    f"{TOO_DEEP:.0%})",
                    f"try the other side as slave, a finer slave, or {self.shorter}",
                )

    def at_the_end(self) -> None:
        """Look for the last time: energy that has not lasted long enough to stop a run is told, much more stops it."""
        self.look()
        self._energy(last=True)

    def judge(self, sample: Sample | None) -> None:
        """What a finished run says of itself, by its last sample; see `contactlab.run.judgement`."""
        judge(self.model, sample, self.closed)

    def _energy(self, last: bool = False) -> None:
        if "velocity" not in self.model.state:
            return
        energy, gained, unexplained = energy_gain(self.model)
        self.largest_energy = max(self.largest_energy, abs(energy), abs(float(self.work[1])))
        self._overshoot()
        if self._too_much(0, unexplained, UNEXPLAINED, last):
            self._stop(
                f"the bodies hold {unexplained:.3g} more energy than work was done on them, {self._share(unexplained)} "
                f"(allowed {UNEXPLAINED:.0%}), since step {self.since[0]:.0f}; {self._fastest_body()}",
                f"the step is too long for what happens: try {self.shorter}",
            )
        if not self.eased and self._too_much(1, gained, GAIN, last):
            self._stop(
                f"the energy {energy:.3g} is {gained:.3g} above that of the start and the work done from outside, "
                f"{self._share(gained)} (allowed {GAIN:.0%}), since step {self.since[1]:.0f}; "
                f"{self._fastest_body()}",
                f"contact has made {float(self.work[3]):.3g}: {_cure(self.model, self.shorter)}",
            )
        if self.pairs and not self.eased:
            self._made_by_contact(float(self.work[3]), last)

    def _made_by_contact(self, made: float, last: bool) -> None:
        """Normal forces of surfaces that touch and part can only take energy; what they have given is the method's."""
        share, cure = made / self.largest_energy, _cure(self.model, self.shorter)
        if share > MADE:
            self.model.warnings.add(
                RunWarning(
                    "contact-energy", share, MADE, "contacts.0.enforcement",
                    f"contact has made {made:.3g} of energy, {self._share(made)} (allowed {MADE:.0%}); {cure}",
                )
            )  # fmt: skip
        if self._too_much(2, made, TOO_MUCH_MADE, last):
            self._stop(
                f"contact has made {made:.3g} of energy, {self._share(made)} (allowed {TOO_MUCH_MADE:.0%}), above that "
                f"since step {self.since[2]:.0f}; {self._fastest_body()}",
                cure,
            )

    def _overshoot(self) -> None:
        """Above the stable step leapfrog keeps its energy, too: what is stored becomes as negative as kinetic grows."""
        share = self.model.kinetic_energy() / self.largest_energy
        if not share <= OVERSHOOT:
            self._stop(
                f"the kinetic energy is {share:.3g} times all that was supplied (allowed {OVERSHOOT:.0f}); "
                f"{self._fastest_body()}",
                f"the step is above the stable one: try {self.shorter}, and look whether the material's wave "
                "speeds and stiffening are right",
            )

    def _too_much(self, which: int, energy: float, limit: float, last: bool) -> bool:
        """Whether an energy has been above its limit for long, or is far above it at the end of the run."""
        step, share = self.model.state.step, energy / self.largest_energy
        self.since[which] = -1.0 if share <= limit else step if self.since[which] < 0.0 else self.since[which]
        if not share > limit:
            return False
        if last and share <= AT_THE_END * limit:
            self.model.warnings.add(_energy_warning(step, share, limit, self.shorter))
        return bool(step - self.since[which] >= LASTING or (last and share > AT_THE_END * limit))

    def _share(self, energy: float) -> str:
        return f"{energy / self.largest_energy:.1%} of the largest energy so far"

    def _fastest_body(self) -> str:
        v, mass = self.model.state["velocity"], self.model.mass
        squares = mass * (v[:, 0] ** 2 + v[:, 1] ** 2)
        shares = {b.name: float(squares[b.first : b.first + b.count].sum()) for b in self.model.bodies}
        name = max(shares, key=lambda body: shares[body])
        return f"body {name} has {shares[name] / max(float(squares.sum()), 1e-300):.0%} of the kinetic energy"


def _cure(model: Model, shorter: str) -> str:
    """What to try against energy that contact makes, in words."""
    others = f"try the other side as slave, another algorithm, or {shorter}"
    conjugate = getattr(getattr(model.contact, "enforcement", None), "conjugate", True)
    if conjugate or not model.explicit:
        return others
    return f'{others}; contacts.0.enforcement = {{ use = "forward-increment", forces = "conjugate" }} makes none'


def _energy_warning(step: int, share: float, limit: float, shorter: str) -> RunWarning:
    return RunWarning(
        "energy-at-end", share, limit, shorter.split()[-1],
        f"at step {step}, the last one, there is {share:.1%} more energy than is accounted for, of the largest so far "
        f"(allowed {limit:.0%}); run on to see whether it stays, or try {shorter}",
    )  # fmt: skip


def shorter_steps(explicit: bool, step: float | None) -> str:
    """What makes the steps of a run shorter, in words; `step` [s] is the length that its scene fixes, if it does."""
    if step is not None:
        return "a smaller time.step"
    return "a smaller time.fraction" if explicit else "more integrator.steps"


def _slopes(forces: BodyForces) -> Floats:
    element = forces.body.element
    return np.ascontiguousarray(element.shape(element.quadrature().points).gradient)
