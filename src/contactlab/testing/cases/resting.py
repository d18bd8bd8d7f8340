"""Blocks: a stack at rest, one that bounces until it rests, one that is pressed again and again."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.cases.figures import Figure, near
from contactlab.testing.cases.watched import WatchedRun

WEIGHT = 1e-9 * 10.0 * 10.0 * 9810.0  # N, of a block
STACK = 10
SEGMENT = 10.0 / 3.0  # mm, the longest of the stack
FALL = 0.5  # mm, of the dropped block
FEW = 200  # steps for which two stacks are compared


def stack_at_rest(algorithm: str, full: bool) -> list[Figure]:
    """Ten blocks that come under their weight slowly, and then lie still."""
    scene = load_scene("stack").with_({f"contacts.{k}.algorithm": algorithm for k in range(STACK)})
    ramp, steps = (0.1, 100_000) if full else (0.05, 1500)
    scene = scene.with_({"effects.0.ramp": ramp, "time.end": 10.0})
    rest = _Rest(scene, ramp, steps)
    turned = _Rest(_relabelled(scene), ramp, FEW)
    return [
        Figure("force under each block, largest error", rest.force_error, most=1e-3),
        Figure("sideways drift [segments]", rest.drift, most=1e-6),
        Figure("kinetic energy of the second half over that of the first", rest.growth, most=1.05),
        Figure(
            "bodies in another order, largest change of a force",
            _difference(rest.forces[:FEW], turned.forces),
            most=1e-6,
        ),
        Figure("sweeps per step", rest.sweeps),
        Figure("most sweeps of a step", float(rest.run.most_sweeps)),
    ]


class _Rest:
    """A stack from the time on when its weight is there."""

    def __init__(self, scene: Scene, begin: float, steps: int) -> None:
        self.run = run = WatchedRun(scene)
        run.until(begin)
        begun, sweeps, places, kinetic, forces = run.state.step, run.sweeps, self._places(), [], []
        while run.state.step < begun + steps:
            run.step()
            kinetic.append(run.model.kinetic_energy())
            forces.append(self._forces())
        self.sweeps = (run.sweeps - sweeps) / steps
        self.growth = float(np.mean(kinetic[steps // 2 :]) / np.mean(kinetic[: steps // 2]))
        self.drift = float(np.abs(self._places() - places).max()) / SEGMENT
        self.forces = np.array(forces)
        self.force_error = float(np.abs(self.forces.mean(axis=0) / WEIGHT / np.arange(STACK, 0, -1) - 1.0).max())

    def _places(self) -> Floats:
        return np.array([self.run.mean(self.run.state["displacement"], f"block{k}")[0] for k in range(STACK)])

    def _forces(self) -> Floats:
        """Force under every block, by its number: what carries it and all above it."""
        own = [float(self.run.force_on(f"block{k}")[1]) for k in range(STACK)]
        return np.cumsum(own[::-1])[::-1]


def _difference(first: Floats, second: Floats) -> float:
    return float(np.abs(first / second - 1.0).max())


def _relabelled(scene: Scene) -> Scene:
    """The same stack with bodies in the opposite order and contacts shuffled."""
    data = scene.data
    data["bodies"] = dict(reversed(data["bodies"].items()))
    data["contacts"] = data["contacts"][1::2] + data["contacts"][::2]
    return Scene.from_data(data, registry=scene.registry)


def dropped_block(algorithm: str, full: bool) -> list[Figure]:
    """A block bounces until it rests, and another is pressed and released many times.

    Forces of the mortar methods act along normals averaged on the slave. Beside a node that has been let go
    they lean, so that they work on what slides there: energy may rise a little, by an amount of first order in
    the segment length. Node-on-segment takes the normal of the plane, and keeps the energy to round-off.
    """
    scene = load_scene("dropped-block").with_({"contacts.0.algorithm": algorithm})
    if full:
        scene = scene.with_({"bodies.block.mesh.cells": [10, 8]})
    run = _Bounces(scene)
    return [
        near("force at rest [N]", float(run.force_on("block")[1]), WEIGHT, 1e-3),
        Figure("largest rise of energy in a step, over that of the fall", run.rise / (WEIGHT * FALL), most=1e-9),
        Figure("largest pull of a contact node over the weight", run.pull / WEIGHT, most=0.0),
        Figure("conditions that opened or closed before rest", float(sum(run.changes[: -run.last]))),
        Figure("changes per 100 steps at rest", 100.0 * sum(run.changes[-run.last :]) / run.last, most=1.0),
        *_pressed_again_and_again(algorithm, 100 if full else 20),
    ]


class _Bounces(WatchedRun):
    """A run to its end with its changes of contact in every step; the last fifth is taken as rest."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.changes: list[int] = []
        self.pushed: list[float] = []
        self.stored: list[float] = []
        self.rise, self.pull = 0.0, 0.0
        self._closed, self._work = np.zeros(self.contact.multipliers.shape[1], np.bool_), 0.0
        self.until(float(scene.time.end), self._look)
        self.last = len(self.changes) // 5

    def _look(self) -> None:
        y, work = self.contact.multipliers[0], float(self.state["work"][3])
        closed = y > 0.0
        self.changes.append(int(np.count_nonzero(closed != self._closed)))
        self.rise, self.pull = max(self.rise, work - self._work), max(self.pull, float(-y.min()))
        self.pushed.append(float(y.sum()))
        self.stored.append(float(self.state["work"][0]))
        self._closed, self._work = closed, work


def _pressed_again_and_again(algorithm: str, cycles: int) -> list[Figure]:
    """The top of the block goes down by 0.2 below touching and up by as much above it, slowly."""
    scene, period = load_scene("dropped-block"), 0.01
    points = [(0.0, 0.0)] + [((i + 0.5) * 0.5 * period, 1.0 if i % 2 == 0 else -1.0) for i in range(2 * cycles)]
    top = {"on": "block.top", "ux": 0.0, "uy": {"ramp": "table", "to": -0.2, "points": [list(p) for p in points]}}
    changes = {
        "contacts.0.algorithm": algorithm, "bodies.block.shift": [0.0, 0.0], "effects": [], "supports": [top],
        "time.end": points[-1][0], "time.damping": 1000.0, "time.step": 1e-4,
    }  # fmt: skip
    run = _Bounces(scene.with_(changes))
    forces = [run.pushed[int(p[0] / run.dt) - 1] for p in points[1::2]]
    change, which = abs(forces[-1] / forces[1] - 1.0), f"{cycles} times pressed: "
    events = sum(run.changes) / cycles / len(run.contact.pairs[0].slave.nodes)
    return [
        Figure(f"{which}largest force, change from the second to the last", change, most=1e-3),
        Figure(f"{which}largest rise of energy in a step, over that stored", run.rise / max(run.stored), most=1e-9),
        Figure(f"{which}changes of contact per node and cycle", events, 1.9, 2.1),
    ]
