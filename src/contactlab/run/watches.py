"""The watches of one run, the limit of its work, and a substitute for guards if there are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from contactlab.api import Floats, Memory, Step, Watch
from contactlab.errors import RequestError, SimulationFailure
from contactlab.model.model import Model
from contactlab.results.sample import Sample
from contactlab.results.summary import Counts
from contactlab.run.step_view import ModelView


class Watching:
    """All watches of a run with their memory, which is part of the run's checkpoint."""

    def __init__(self, model: Model, watches: Mapping[str, Watch]) -> None:
        self.watches, self.view = dict(watches), ModelView(model)
        self.memories: dict[str, Memory] = {}
        for name, watch in self.watches.items():
            if not isinstance(watch, Watch):
                allowed = "objects derived from contactlab.api.Watch"
                raise RequestError("not a watch", where=f"watch.{name}", got=watch, allowed=allowed)
            try:
                found = watch.begin(self.view)
            except LookupError as error:
                reason = f"the watch {name} needs something that the scene does not have: {error}"
                raise RequestError(reason, where="watch") from error
            self.memories[name] = {key: np.array(values, np.float64) for key, values in found.items()}

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """Callbacks after each accepted step."""
        return (self._call_watches,)

    def _call_watches(self, step: Step, dt: float) -> None:
        self.view.took(step, dt)
        for name, watch in self.watches.items():
            watch.step(self.view, self.memories[name])

    def saved(self) -> dict[str, Floats]:
        """Everything that changes during the run."""
        return {f"watch.{name}.{key}": a for name, own in self.memories.items() for key, a in own.items()}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to where `memory` was saved."""
        for name, values in self.saved().items():
            values[...] = memory[name]

    def found(self) -> dict[str, dict[str, Floats]]:
        """Gather what the watches have found, by their names."""
        return {
            name: {key: np.array(values) for key, values in watch.end(self.memories[name]).items()}
            for name, watch in self.watches.items()
        }


class WorkLimit:
    """Ends a run after so many steps and iterations: counted, so that it ends there on any machine."""

    def __init__(self, counts: Counts, most: float) -> None:
        self.counts, self.most = counts, most

    def __call__(self, step: Step, dt: float) -> None:
        """Check the counts after a step."""
        self.check()

    def check(self) -> None:
        """Raise SimulationFailure("timed-out") if there were too many."""
        if self.counts.steps + self.counts.iterations > self.most:
            raise SimulationFailure(
                "timed-out",
                f"stopped after {self.counts.steps} steps with {self.counts.iterations} iterations (limit "
                f"{self.most:.0f} in all)",
            )


class NoGuards:
    """In place of guards, for a run that means to do what they stop."""

    def after_step(self, step: Step) -> None:
        """Do nothing, whatever the step was."""

    def check(self) -> None:
        """Do nothing, whatever the state is."""

    def check_positions(self) -> None:
        """Do nothing, wherever the nodes are."""

    def step_made_energy(self) -> bool:
        """Whatever a step makes, it is kept."""
        return False

    def at_the_end(self) -> None:
        """Do nothing at the end of the run."""

    def judge(self, sample: Sample | None, largest_force: float, largest_work: float) -> None:
        """Do not judge the finished run."""

    def saved(self) -> dict[str, Floats]:
        """Nothing that a checkpoint would keep."""
        return {}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Do nothing: nothing was saved."""
