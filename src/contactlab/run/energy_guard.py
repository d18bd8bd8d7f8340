"""Stops a run that has more energy than was put in, whether the bodies or their contact have made it."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats, RunWarning
from contactlab.model.energy import EnergyGain, energy_gain, stored_energy
from contactlab.model.model import Model
from contactlab.results.strain_scale import energy_of_strain
from contactlab.run.stopping import stop

UNEXPLAINED = 0.01  # energy stored without work, over the largest that was there, was supplied or is to come
IN_A_STEP = 1e-3  # of it, in one step of an implicit run: a longer step is cut, whose error falls with its cube
UPHILL = 0.6  # of all energy, in one load step: trapezoids are off by a half at most where forces rise steadily
GAIN = 0.1  # the same for energy that contact makes: weak conditions on coarse meshes make some per cent
MADE = 0.01  # energy that contact has made in all, whatever damping took of it since: a warning
TOO_MUCH_MADE = 0.1  # and the run is stopped
LOST = 0.05  # energy that springs and potentials took and did not give back: rebounds are off by some per cent
IMPACTS = 0.03  # energy that impacts of nodes took: rebounds are 3 to 10 % slower
LASTING = 100  # steps that either must last: sharp impacts borrow some energy for a few
OVERSHOOT = 100.0  # kinetic over all energy: 1/(1 - (w dt/2)^2) at most in a mode that leapfrog follows; 99 % of 2/w
AT_THE_END = 5.0  # times these limits: more at the end of a run stops it whether it lasted or not
SAMPLES, LEAST = 65, 1e-3  # times at which the loading is looked at; of it, what counts as a beginning
ROUND = 1e-7  # strains that are round-off: energies of laws, quadratic in them, are differences of numbers near one


class EnergyGuard:
    """Checks the energy of one run.

    largest  [mJ] largest energy that was there or was supplied so far
    since    (3,) steps since which energies are too high: stored without work, gained, made by contact; -1 if not
    pushed   [mJ] what contact gave to push out the weak overlaps of the start
    unexplained, spent  [mJ] energy stored without work, and stored or dissipated, at the end of the last implicit step
    """

    def __init__(self, model: Model, shorter: str, wave_speed: float) -> None:
        self.model, self.shorter, self.work = model, shorter, model.state["work"]
        self.since = np.full(3, -1.0)
        # energies of smaller strains are round-off
        self.largest = max(model.initial_energy, float(model.mass.sum()) * (ROUND * wave_speed) ** 2)
        pairs = model.contact.passes if model.contact is not None else ()
        # an overlap of the start is pushed out: energy that the scene lets contact put in
        self.judges_contact = bool(pairs) and not any(pair.pushes_overlaps_out for pair in pairs)
        self.judges_gain = self.judges_contact or not pairs
        self.come = _come(model) if "velocity" in model.state else None
        gaps: list[Any] = [(pair, pair.start_gaps) for pair in pairs if pair.start_gaps is not None]
        self.facets = [each for each in gaps if each[1].by_facets]
        self.pushed, self.rate, self.counted = 0.0, 0.0, 0.0
        self.scale, self.unexplained, self.spent = self.largest, 0.0, 0.0
        store: Any = getattr(model.contact, "store", None)
        if store is not None and store.beginning > 0.0:
            self._pressed_at_the_start(store)

    def check(self, last: bool = False) -> None:
        """Stop if energy has appeared for many steps; at the `last` step also if there is very much more."""
        if "velocity" not in self.model.state:
            return
        energy, gained, unexplained = self._measure()
        self._push_facets()
        gained -= self.pushed
        self._overshoot()
        if self._too_much(0, unexplained, UNEXPLAINED, last):
            stop(
                self.model,
                f"the bodies hold {unexplained:.3g} more energy than work was done on them, {self._share(unexplained)} "
                f"(allowed {UNEXPLAINED:.0%}), since step {self.since[0]:.0f}; {self._fastest_body()}",
                f"the step is too long: try {self.shorter}",
            )
        if self.judges_gain and self._too_much(1, gained, GAIN, last):
            stop(
                self.model,
                f"the energy {energy:.3g} is {gained:.3g} above the initial energy plus the external work, "
                f"{self._share(gained)} (allowed {GAIN:.0%}), since step {self.since[1]:.0f}; "
                f"{self._fastest_body()}",
                f"contact has made {float(self.work[3]):.3g}: {_cure(self.model, self.shorter)}",
            )
        if self.judges_contact:
            assert self.model.contact is not None
            made = float(self.work[3]) + self.model.contact.stored_since_start - self.pushed
            self._made_by_contact(made, last)
            if last and made < -LOST * self.scale and self._gives_back():
                self._lost_by_contact(-made)
            if last and made < -IMPACTS * self.scale and self._stops_nodes():
                self._lost_in_impacts(-made)

    def step_made_energy(self) -> bool:
        """Return whether the last step alone stored more energy than it may: stresses change too much in it."""
        if self.come is None:
            return self._uphill()
        before, (_, _, self.unexplained) = self.unexplained, self._measure()
        return self.unexplained - before > IN_A_STEP * self.scale

    def _uphill(self) -> bool:
        """Return whether a load step jumped to an equilibrium with more energy than its forces can have supplied.

        A step that unloads the bodies is judged by what they gave back.
        """
        if self.model.integrator.inertia or not self.model.way_followed:
            return False
        before, start, (stored, self.unexplained) = self.unexplained, self.spent, stored_energy(self.model)
        self.spent = float(self.work[0]) + self.unexplained
        scale = max(stored, start, self.spent, energy_of_strain(self.model, ROUND))
        return self.unexplained - before > UPHILL * scale

    def _measure(self) -> EnergyGain:
        found = energy_gain(self.model)
        self.largest = max(self.largest, abs(found.energy), abs(float(self.work[1])))
        # what was supplied so far grows with the square of the loading
        # how much of its loading the run has seen, above 0 and up to 1
        assert self.come is not None
        loaded = float(np.interp(self.model.state.time, *self.come))
        self.scale = max(self.largest, abs(float(self.work[1])) / loaded**2)
        return found

    def _push_facets(self) -> None:
        """Forces times the weak overlaps of the start that came to count since the last check."""
        if not self.facets:
            return
        forces = self.model.state["multipliers"][0]
        rate = -sum(p.share * float(forces[p.own] @ own.value) for p, own in self.facets)
        counted = self.facets[0][1].ramp(self.model.state.time)
        self.pushed += 0.5 * (self.rate + rate) * (counted - self.counted)
        self.rate, self.counted = rate, counted

    def _made_by_contact(self, made: float, last: bool) -> None:
        """Normal forces of surfaces that touch and part can only take energy; what they have given is the method's."""
        share, cure = made / self.scale, _cure(self.model, self.shorter)
        if share > MADE:
            self.model.warnings.add(
                RunWarning(
                    "contact-energy", share, MADE, "contacts.0.enforcement",
                    f"contact has made {made:.3g} of energy, {self._share(made)} (allowed {MADE:.0%}); {cure}",
                )
            )  # fmt: skip
        if self._too_much(2, made, TOO_MUCH_MADE, last):
            stop(
                self.model,
                f"contact has made {made:.3g} of energy, {self._share(made)} (allowed {TOO_MUCH_MADE:.0%}), "
                f"since step {self.since[2]:.0f}; {self._fastest_body()}",
                cure,
            )

    def _pressed_at_the_start(self, store: Any) -> None:
        """Pressure laws that press surfaces as they are placed throw bodies apart, if steps follow the motion."""
        held, others, model = store.beginning, self.largest, self.model
        self.largest += held
        if model.integrator.inertia and not model.explicit and held > LOST * others:
            model.warnings.add(
                RunWarning(
                    "pressed-start", held / others, LOST, "contacts.0.enforcement",
                    f"{type(store.law).__name__} presses surfaces before the run: they store {held:.3g}, "
                    f"{held / others:.3g} times the energy of the bodies (allowed {LOST:.0%}), and are thrown apart; "
                    "leave a gap at which the law begins",
                )
            )  # fmt: skip

    def _gives_back(self) -> bool:
        """Return whether all contact forces derive from energies: multipliers and laws with history may dissipate."""
        contact: Any = self.model.contact
        if _softly(contact):  # what its springs hold is not known
            return not self.model.state["contact_force"].any()
        store = getattr(contact, "store", None)
        return all(pair.by_energy for pair in contact.passes) or (store is not None and not store.law.named())

    def _lost_by_contact(self, lost: float) -> None:
        key, what = self.shorter.split()[-1], f"its forces change too much in a step; try {self.shorter}"
        if _softly(self.model.contact):
            key, what = "contacts.0.enforcement", (
                "its springs follow the step; a pressure law gives energy back: write contacts.0.enforcement = "
                '{ use = "linear-pressure", stiffness = ... }, in MPa/mm'
            )  # fmt: skip
        self.model.warnings.add(
            RunWarning(
                "contact-energy", -lost / self.scale, -LOST, key,
                f"contact has lost {lost:.3g} of energy, {self._share(lost)} (allowed {LOST:.0%}), although it should "
                f"store all of it: {what}",
            )
        )  # fmt: skip

    def _stops_nodes(self) -> bool:
        """Return whether nodes stop at once where they meet a surface, and no damping takes their motion anyway."""
        contact: Any = self.model.contact
        held = _softly(contact) or getattr(contact, "store", None) is not None
        return not held and not any(pair.by_energy for pair in contact.passes) and self.model.damping == 0.0

    def _lost_in_impacts(self, lost: float) -> None:
        self.model.warnings.add(
            RunWarning(
                "impact-loss", lost / self.scale, IMPACTS, "level",
                f"impacts have taken {lost:.3g} of energy, {self._share(lost)} (allowed {IMPACTS:.0%}): nodes stop at "
                "once where they meet the other side, and the kinetic energy of their mass is lost, so that bodies "
                "rebound slower by one to three times this share; take finer cells (level): half the size loses half",
            )
        )  # fmt: skip

    def _overshoot(self) -> None:
        """Above the stable step leapfrog keeps its energy, too: what is stored becomes as negative as kinetic grows."""
        share = self.model.kinetic_energy() / self.largest
        if not share <= OVERSHOOT:
            stop(
                self.model,
                f"the kinetic energy is {share:.3g} times the energy supplied (allowed {OVERSHOOT:.0f}); "
                f"{self._fastest_body()}",
                f"the step is above the stable step: try {self.shorter}, and check the material's wave speeds and "
                "stiffening",
            )

    def _too_much(self, which: int, energy: float, limit: float, last: bool) -> bool:
        """Return whether an energy has long been above its limit, or is far above it at the end of the run."""
        step, share = self.model.state.step, energy / self.scale
        self.since[which] = -1.0 if share <= limit else step if self.since[which] < 0.0 else self.since[which]
        if not share > limit:
            return False
        if last and share <= AT_THE_END * limit:
            self.model.warnings.add(_energy_warning(step, share, limit, self.shorter))
        return bool(step - self.since[which] >= LASTING or (last and share > AT_THE_END * limit))

    def _share(self, energy: float) -> str:
        return f"{energy / self.scale:.1%} of the largest energy of the run, expected or reached"

    def _fastest_body(self) -> str:
        v, mass = self.model.state["velocity"], self.model.mass
        squares = mass * (v[:, 0] ** 2 + v[:, 1] ** 2)
        shares = {b.name: float(squares[b.first : b.first + b.count].sum()) for b in self.model.bodies}
        name = max(shares, key=lambda body: shares[body])
        return f"body {name} has {shares[name] / max(float(squares.sum()), 1e-300):.0%} of the kinetic energy"


def _softly(contact: Any) -> bool:
    """Return whether springs that should give energy back hold surfaces, and no law says how much they store."""
    return bool(getattr(contact.enforcement, "stores", False))


def _come(model: Model) -> tuple[Floats, Floats]:
    """Times [s], and the share of the loading that has come by then: of motions or of loads, whichever is behind.

    Both count by the largest value so far, also if it decreases later.
    """
    times, prescribed = np.linspace(0.0, model.timing.last, SAMPLES), model.prescribed
    moved, loaded = np.zeros(SAMPLES), np.zeros(SAMPLES)
    force, scale = np.zeros_like(model.reference), np.abs(prescribed.scale)
    for number, time in enumerate(times.tolist()):
        moved[number] = (scale * np.abs(prescribed.values(time)[prescribed.ramp])).max(initial=0.0)
        if model.external_force(time, force):
            loaded[number] = np.abs(force).max()
    share = [np.maximum.accumulate(size) / size.max() for size in (moved, loaded) if size.max() > 0.0]
    return times, np.maximum(np.min([np.ones(SAMPLES), *share], axis=0), LEAST)


def _cure(model: Model, shorter: str) -> str:
    """Return advice against energy that contact makes."""
    others = f"try the other side as slave, another algorithm, or {shorter}"
    if getattr(model.contact, "consistent", True) or not model.integrator.inertia:
        return others
    use = model.integrator.default_enforcement
    return f'{others}; contacts.0.enforcement = {{ use = "{use}", forces = "consistent" }} makes none'


def _energy_warning(step: int, share: float, limit: float, shorter: str) -> RunWarning:
    return RunWarning(
        "energy-at-end", share, limit, shorter.split()[-1],
        f"step {step}, the last: unexplained energy is {share:.1%} of the largest so far (allowed {limit:.0%}); run "
        f"longer to see whether it stays, or try {shorter}",
    )  # fmt: skip
