"""What conjugate contact forces cost beside published ones (docs/theory/contact-energy.md).

python benchmarks/studies/contact_cost.py [--level 1] [--algorithm mortar-p0] [--steps 1000] [--mu 0] [--element q1]

CPU time of the contact solve of disc-on-block by turns of a tenth of the steps; ratios of each turn, and their median.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import contactlab
from contactlab.model.build import build
from contactlab.run.prepare import prepare_run

TURNS = 10


class Timed:
    """A run that counts the CPU time of its contact solves, `spent` [s]."""

    def __init__(self, changes: dict[str, Any], forces: str) -> None:
        own = {"contacts.0.enforcement": {"use": "forward-increment", "forces": forces}}
        scene = contactlab.load_scene("disc-on-block").with_(changes | own)
        self.model, self.spent = build(scene, scene.registry), 0.0
        assert self.model.contact is not None
        self.solve: Callable[..., Any] = self.model.contact.solve
        self.model.contact.solve = self._timed  # type: ignore[method-assign]
        self.run = prepare_run(self.model, scene, scene.registry, None, False)
        self.advance = self.model.bound_integrator().step
        self.run.store_start()

    def _timed(self, *arguments: Any) -> Any:
        began = time.thread_time()
        done = self.solve(*arguments)
        self.spent += time.thread_time() - began
        return done

    def steps(self, count: int) -> float:
        """Go on by so many steps; CPU seconds of contact per step."""
        before = self.spent
        for _ in range(count):
            self.advance(self.run.schedule.dt)
            if self.model.state.step % 50 == 0:
                self.run.schedule.adapt()
        return (self.spent - before) / count


def main() -> None:
    """Print the ratios."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--level", type=int, default=1)
    arguments.add_argument("--algorithm", default="mortar-p0")
    arguments.add_argument("--steps", type=int, default=1000)
    arguments.add_argument("--mu", type=float, default=0.0)
    arguments.add_argument("--element", default="q1")
    given = arguments.parse_args()
    changes: dict[str, Any] = {"level": given.level, "contacts.0.algorithm": given.algorithm}
    changes |= {f"bodies.{body}.element": given.element for body in ("disc", "block")}
    if given.mu:
        changes["contacts.0.friction"] = {"use": "coulomb", "mu": given.mu}
    published, conjugate = Timed(changes, "frozen"), Timed(changes, "consistent")
    count = given.steps // TURNS
    for run in (published, conjugate):
        run.steps(count // 2)  # kernels are loaded meanwhile
    ratios, owns = [], []
    for _ in range(TURNS):
        own = published.steps(count)
        owns.append(own)
        ratios.append(conjugate.steps(count) / own)
    own = 1e6 * np.median(owns)
    print(*(f"{ratio:.2f}" for ratio in ratios), f"median {np.median(ratios):.2f}, published {own:.1f} us a step")


if __name__ == "__main__":
    main()
