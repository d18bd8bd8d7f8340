"""Small runs with the part under check in its place: an arc pushed on a block, explicitly and in statics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import numpy as np

from contactlab.api import ExplicitEnforcement, ExplicitIntegrator, Floats, NormalLaw, Potential
from contactlab.errors import PartError, SceneError
from contactlab.model.build import build
from contactlab.model.loading.scene_fields import fields_needed
from contactlab.parts.registry import Registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.assertions import NotApplicable, require
from contactlab.testing.partners import usual_flow, usual_law
from contactlab.testing.points import FIELD
from contactlab.testing.subject import Subject

Mode = Literal["explicit", "statics"]
FILES: Mapping[Mode, str] = {"explicit": "pressed.toml", "statics": "pressed-in-statics.toml"}
CELL, STEP, END = 0.2, 4e-8, 4e-6  # mm and s, of the scene
STEPS = 100  # of the explicit run
COURANT = 0.4  # of its steps, by the dilatational speed
TOP = "upper.top"
TOP_MOVES = {"ux": 0.006, "uy": -0.02}  # mm, of the scene
YIELDING = {"young": 7000.0, "poisson": 0.3, "yield_stress": 60.0, "hardening": 700.0, "density": 2.7e-9}
SHORTER = 10  # times as short under normal laws, whose slopes explicit steps have to follow
LONGER = 5  # times as many steps as the scene wishes


def modes_of(subject: Subject) -> tuple[Mode, ...]:
    """Modes of runs that can have the part."""
    cls = subject.part_class
    if subject.kind == "integrator":
        return ("explicit",) if issubclass(cls, ExplicitIntegrator) else ("statics",)
    if subject.kind == "enforcement" and issubclass(cls, NormalLaw):
        return ("statics",) if "traction" in cls.needs else ("explicit", "statics")
    if subject.kind == "enforcement":
        return ("explicit",) if issubclass(cls, ExplicitEnforcement) else ("statics",)
    if subject.kind == "contact" and issubclass(cls, Potential):
        return ("statics",)
    if subject.kind == "contact" and cls.explicit_only:
        return ("explicit",)
    if subject.kind == "effect" and not _stands_in_statics(subject):
        return ("explicit",)
    return ("explicit", "statics")


def _stands_in_statics(subject: Subject) -> bool:
    """Return whether an effect accepts statics: False if building the scene refuses it."""
    if "statics" not in subject.results:
        scene = pressed(subject, "statics")
        try:
            build(scene, scene.registry)
        except SceneError as error:  # the effect refuses by a ValueError; any other error is a failure
            subject.results["statics"] = error
            return False
        subject.results["statics"] = simulate(scene)
    return not isinstance(subject.results["statics"], SceneError)


def pressed(subject: Subject, mode: Mode, changes: Mapping[str, Any] | None = None) -> Scene:
    """The scene with the part in its place. Raises NotApplicable if other parts of it are not installed."""
    path = Path(str(files("contactlab") / "data" / "checks" / FILES[mode]))
    try:
        placed = {**_placed(subject, mode), **_fields(subject), **(changes or {})}
        return load_scene(path, subject.registry, placed)
    except PartError as error:
        raise NotApplicable(f"the scene needs parts that are not installed: {error.problem} ({error.got})") from error


def needs_of(subject: Subject) -> tuple[str, ...]:
    """Return the names that the part needs; an integrator needs no names but a class of equations."""
    return () if subject.kind == "integrator" else getattr(subject.part_class, "needs", ())


def _fields(subject: Subject) -> dict[str, Any]:
    """Fields of the scene that the part needs, which rise with time."""
    needed = fields_needed(subject.part_class) if needs_of(subject) else ()
    return {"fields": {name: {"value": {"ramp": "linear", "to": FIELD}} for name in needed}} if needed else {}


def _placed(subject: Subject, mode: Mode) -> dict[str, Any]:
    """Return the changes that put the part into the scene."""
    spec = subject.spec
    match subject.kind:
        case "contact":
            rubs = not issubclass(subject.part_class, Potential) or subject.part_class.rubs
            placed = {"contacts.0.algorithm": spec, **({} if rubs else {"contacts.0.friction": None})}
            if half_passes(subject):
                placed |= {"contacts.0.enforcement": {"use": usual_law(subject.registry)}, **_shorter(mode)}
            return placed
        case "friction" | "enforcement":
            return {
                f"contacts.0.{subject.kind}": spec,
                **(_shorter(mode) if issubclass(subject.part_class, NormalLaw) else {}),
            }
        case "element":
            timed = {"time.step": STEP / subject.part_class.degree**2} if mode == "explicit" else {}
            return {"bodies.upper.element": spec, "bodies.lower.element": spec, **timed}
        case "material":
            return {"materials.soft": spec, **_timed(subject, mode)}
        case "integrator":
            return {"integrator": spec, **_dynamic(subject)}
        case "effect":
            return {"effects": [spec]}
        case "recorder":
            return {"record.recorders": [spec], "record.frames": 4}
    raise NotApplicable(f"a part of kind {subject.kind} does not occur in this scene")


def half_passes(subject: Subject) -> bool:
    """Return whether the part is an algorithm of two half passes, which press by laws and balance approximately."""
    return subject.kind == "contact" and subject.make().half_pass() is not None


def _shorter(mode: Mode) -> dict[str, Any]:
    """Steps that follow the slopes of pressure laws."""
    return {"time.step": STEP / SHORTER} if mode == "explicit" else {}


def _timed(subject: Subject, mode: Mode) -> dict[str, Any]:
    """Steps by the law's own speed, so that the push is as fast against it as against any other."""
    if mode == "statics":
        return {}
    step = COURANT * CELL / subject.make().wave_speeds()[0]
    return {"time.step": step, "time.end": STEPS * step}


def turning_back(subject: Subject) -> dict[str, Any]:
    """Return changes for an integrator: a law with history, and a top that turns back, so that slip reverses."""
    end = END if subject.part_class.inertia else 1.0
    ramp = {"ramp": "table", "points": [[0.0, 0.0], [0.6 * end, 1.0], [end, 0.8]]}
    top = {f"supports.1.{axis}": {**ramp, "to": to} for axis, to in TOP_MOVES.items()}
    return {"materials.soft": {"use": usual_flow(subject.registry), **YIELDING}, **top}


def _dynamic(subject: Subject) -> dict[str, Any]:
    """Integrators with inertia take the time of the explicit scene, in steps of their own."""
    cls = subject.part_class
    if issubclass(cls, ExplicitIntegrator) or not cls.inertia:
        return {}
    return {"time.end": END, "time.step": LONGER * STEP}


def run(subject: Subject, scene: Scene, what: str, registry: Registry | None = None) -> Results:
    """The results of a scene, run once for each `what`; a run that does not finish has failed the check."""
    if what not in subject.results:
        subject.results[what] = simulate(scene, registry=registry)
    results: Results = subject.results[what]
    require(results.status == "finished", f"{what}: the run ended as {results.status}: {results.reason}")
    return results


def plain(subject: Subject, mode: Mode) -> Results:
    """The run without any changes."""
    return run(subject, pressed(subject, mode), mode)


@dataclass(frozen=True)
class Answers:
    """Answers of a run, independent of numbering: the force at the top (2,), and pressures and shears (m,)."""

    reaction: Floats
    pressure: Floats
    shear: Floats

    @classmethod
    def of(cls, results: Results) -> Answers:
        """Return the answers at the end of a run."""
        curve = results.contact["contacts.0"].last
        return cls(np.array(results.summary["reactions"][TOP]), curve.pressure, curve.shear)

    def turned(self, by: Floats) -> Answers:
        """Return the answers in a frame turned by a matrix (2, 2)."""
        return Answers(by @ self.reaction, self.pressure, self.shear)

    def in_units(self, stress: float) -> Answers:
        """Return the answers with stresses times `stress`, and a length unit that keeps force per thickness."""
        return Answers(self.reaction, self.pressure * stress, self.shear * stress)


def same(found: Answers, wanted: Answers, within: float, what: str) -> None:
    """Raise AssertionError if answers differ by more than `within` of the largest."""
    for name, unit in (("reaction", "N/mm"), ("pressure", "MPa"), ("shear", "MPa")):
        one, other = getattr(found, name), getattr(wanted, name)
        require(one.shape == other.shape, f"{what}: {len(one)} values of the {name}, expected {len(other)}")
        # shears are bounded by friction: shears small against the pressure have its round-off
        scale = float(np.abs(wanted.pressure if name == "shear" else other).max(initial=0.0))
        off = float(np.abs(one - other).max(initial=0.0))
        require(
            off <= within * scale,
            f"{what}: the {name} differs by {off:.2e} {unit}, allowed {within:.0e} of {scale:.4g} {unit}",
        )
