"""Attempts at a run with `integrator = "auto"`: what came of the integrators before the present one, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from contactlab.api import RunWarning
from contactlab.errors import RequestError, SceneError, one_line
from contactlab.model.model import Model
from contactlab.parts.registry import Registry
from contactlab.run.schedule import SETTLED_KINETIC
from contactlab.scene.auto import is_auto
from contactlab.scene.fields import PartSpec
from contactlab.scene.scene import Scene

NEXT = ("not-converged", "diverged")
"""Ends of a run after which another integrator may get through; a full disk or a wrong part would stop that, too."""
FINISHED, REFUSED = "finished", "refused"
TOO_MUCH = 0.05
"""Share of the work that viscous forces of statics may take: bodies with inertia may leave such a jump elsewhere."""


@dataclass(frozen=True)
class Attempt:
    """A run that failed or gave a poor answer, or that could not begin.

    use      the integrator
    status   of its run; "refused" if the integrator does not take the scene
    reason   why another integrator is tried
    reached  time and share of the loading, as in `summary.json`; empty without a run
    cpu_s    CPU time of its steps [s]
    folder   its results, below the folder of the run; "" if there are none
    """

    use: str
    status: str
    reason: str
    reached: Mapping[str, Any] = field(default_factory=dict)
    steps: int = 0
    iterations: int = 0
    cpu_s: float = 0.0
    folder: str = ""

    @classmethod
    def of_error(cls, use: str, error: Exception) -> Attempt:
        """An attempt that ended before its first step."""
        if isinstance(error, RequestError):
            where = f" ({error.where})" if str(error.where) else ""
            return cls(use, REFUSED, f"{error.problem}{where}")
        return cls(use, getattr(error, "status", "failed"), getattr(error, "reason", one_line(error)))

    @property
    def brief(self) -> str:
        """The end of the attempt, and the first clause of the reason."""
        ended = "not accepted" if self.status == FINISHED else self.status
        cost = f" ({self.cpu_s:.2g} CPU s)" if self.reached else ""
        return f"{self.use} {ended}: {self.reason.partition(';')[0].partition(' (')[0]}{cost}"

    @property
    def progress(self) -> tuple[bool, float]:
        """Sort key of attempts by how far they got."""
        return self.status == FINISHED, float(self.reached.get("share", 0.0))


@dataclass
class Attempts:
    """The integrators of a scene in their order, and the attempts before the present run.

    order  as the scene gives it
    tried  all that did not get through, in their order
    cost   `cost` in the summary of the last of them, which includes those before
    """

    order: Sequence[PartSpec]
    tried: list[Attempt] = field(default_factory=list)
    cost: Mapping[str, Any] = field(default_factory=dict)

    @property
    def work(self) -> int:
        """Steps and iterations of all attempts."""
        return sum(attempt.steps + attempt.iterations for attempt in self.tried)

    @property
    def cpu_s(self) -> float:
        """CPU time of all attempts [s]."""
        return sum(attempt.cpu_s for attempt in self.tried)

    def add(self, use: str, summary: Mapping[str, Any], reason: str, folder: str) -> None:
        """Add the run of this summary, whose cost includes the attempts before it."""
        seconds = summary["cost"]["run_cpu_s"] - self.cpu_s
        counts = summary["steps"], summary["iterations"]
        self.tried.append(Attempt(use, summary["status"], reason, summary["reached"], *counts, seconds, folder))
        self.cost = summary["cost"]

    def take_up(self, summary: Mapping[str, Any]) -> None:
        """Go back to the attempts before a stored run."""
        found = summary.get("resolved", {}).get("integrator", {})
        self.tried = [Attempt(**attempt) for attempt in found.get("tried", ())]

    def resolved(self, use: str) -> dict[str, Any]:
        """Return the entry of integrator `use` in `summary.json`, under `resolved`."""
        order, tried = [dict(spec) for spec in self.order], [asdict(attempt) for attempt in self.tried]
        return {"use": use, "order": order, "tried": tried}

    def refuse_motion(self, model: Model, scene: Scene) -> None:
        """Raise SceneError for statics of a body that moves freely at the start if `time.end` is in seconds.

        A scene with `end = "auto"` asks for a state of rest, which statics may find.
        """
        if model.integrator.inertia or scene.time.end == "auto":
            return
        from contactlab.model.loading.held_bodies import hold, loose_motions

        if loose := loose_motions(model, pressed=False):  # type: ignore[arg-type]
            body, motions = next(iter(loose.items()))
            raise SceneError(
                f"time.end in seconds asks for the motion of {body}, which is free for {' and '.join(motions)}",
                where=scene.where(f"bodies.{body}"), got=", ".join(motions),
                allowed="in statics: bodies that supports, effects or contacts hold at the start",
                hint=hold(body, motions),
            )  # fmt: skip

    def warnings(self, model: Model) -> Sequence[RunWarning]:
        """Warn of bodies that move at an end in seconds, if the run of an integrator before came short."""
        ran = [attempt for attempt in self.tried if attempt.status != REFUSED]
        if not ran or not model.integrator.inertia or model.timing.end is None:
            return ()
        kinetic = model.kinetic_energy()
        share = kinetic / max(kinetic, float(abs(model.state["work"]).max()), 1e-300)
        if share <= SETTLED_KINETIC:
            return ()
        return (RunWarning(
            "not-at-rest", share, SETTLED_KINETIC, "time.end",
            f"bodies move at the end: kinetic energy is {share:.1%} of the largest work (limit {SETTLED_KINETIC:.1%}), "
            f"so the end is not an equilibrium, and {ran[0].use} did not find one; write a later time.end, or "
            'time.end = "auto" for a state of rest',
        ),)  # fmt: skip


def comes_short(summary: Mapping[str, Any]) -> str:
    """Return why another integrator should be tried; empty if the run is right, or another would not help."""
    if summary["status"] in NEXT:
        return str(summary["reason"])
    if summary["status"] != FINISHED:
        return ""
    took = summary.get("stabilisation", {})
    if abs(took.get("share", 0.0)) > TOO_MUCH:
        return f"stabilisation took {took['share']:.1%} of the work, in {took['steps']:.0f} load steps"
    return next((str(w["text"]) for w in summary.get("warnings", ()) if w["code"] == "leaning-forces"), "")


def as_taken(scene: Scene, summary: Mapping[str, Any]) -> Scene:
    """The scene with the integrator that its run of this summary took; as it is if it names one."""
    if not is_auto(scene.integrator):
        return scene
    found = summary["resolved"]["integrator"]
    return replace(scene, integrator=next(spec for spec in found["order"] if spec["use"] == found["use"]))


def candidates(scene: Scene) -> tuple[Scene, ...]:
    """The scene with each integrator of its order; of one that names its integrator, the scene alone."""
    if not is_auto(scene.integrator):
        return (scene,)
    return tuple(replace(scene, integrator=spec) for spec in scene.integrator["order"])


def first_that_fits(scene: Scene, registry: Registry) -> tuple[Scene, Attempts | None]:
    """The scene with the integrator that its run begins with, and the order, with those that refuse the scene.

    A scene that names its integrator is given back. Raises the first RequestError if every integrator refuses it.
    """
    if not is_auto(scene.integrator):
        return scene, None
    from contactlab.model.build import build

    attempts, errors = Attempts(scene.integrator["order"]), []
    for candidate in candidates(scene):
        try:
            attempts.refuse_motion(build(candidate, registry), candidate)
        except RequestError as error:
            errors.append(error)
            attempts.tried.append(Attempt.of_error(candidate.integrator["use"], error))
        else:
            return candidate, attempts
    raise errors[0]
