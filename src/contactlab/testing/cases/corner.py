"""A slider that is pushed over the edge of its base."""

from __future__ import annotations

import math

import numpy as np

from contactlab.api import Floats
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.cases.figures import Figure
from contactlab.testing.cases.watched import WatchedRun

SPEED, END, MU = 1e4, 8e-4, 0.2  # mm/s, s
SETTLED, AT_EDGE = 1e-4, 4e-4  # s: vibrations are over; the slider's front reaches the edge
EDGE = 10.0
TIPPED = 0.01  # rad: reached within 0.25 mm of travel after the balance is lost
SEGMENT = 0.25


def corner_slide(algorithm: str, full: bool) -> list[Figure]:
    """Forces until the overhang, where it tips, and what is left after it has gone; smooth base and kinked base."""
    scene = load_scene("corner-slide").with_({"contacts.0.algorithm": algorithm})
    slower = 2.0 if full else 1.0
    scene = scene.with_({"time.end": slower * END, "bodies.slider.velocity": [SPEED / slower, 0.0]})
    return _before_the_edge(scene, slower, "") + _over_the_edge(scene) + _on_kinks(scene, slower)


def _before_the_edge(scene: Scene, slower: float, which: str) -> list[Figure]:
    load = -4.0 * scene.data["loads"][0]["ty"]["to"]
    run = WatchedRun(scene)
    run.until(slower * SETTLED)
    forces = []
    run.until(slower * AT_EDGE, lambda: forces.append(run.force_on("slider")))
    along, normal = np.array(forces).T
    return [
        Figure(f"{which}normal force until the edge, largest deviation", _largest(normal / load - 1.0), most=0.01),
        Figure(f"{which}friction over mu times it, largest deviation", _largest(along / normal / MU + 1.0), most=0.01),
    ]


def _largest(values: Floats) -> float:
    return float(np.abs(values).max())


def _over_the_edge(scene: Scene) -> list[Figure]:
    run = WatchedRun(scene)
    bottom, tipped, after, gone = run.contact.pairs[0].slave.nodes, math.nan, 0.0, False
    end = float(scene.time.end)
    while run.time < end - 0.5 * run.dt:
        run.step()
        if math.isnan(tipped) and run.tilt("slider") < -TIPPED:
            tipped = float(run.mean(run.model.position, "slider")[0])
        gone = run.model.position[bottom, 0].min() > EDGE
        if gone:
            after = max(after, _largest(run.force_on("slider")))
    # the push at half height turns a rigid slider when its centre is still half of mu before the edge
    early = tipped - (EDGE - 0.5 * MU)
    return [
        Figure("centre when it tips, beyond that of a rigid slider [segments]", early / SEGMENT, -2.0, 2.0),
        Figure("largest force after it has left the base [N]", after if gone else math.nan, most=0.0),
    ]


def _on_kinks(scene: Scene, slower: float) -> list[Figure]:
    """The base as a rigid zigzag line that turns by a degree at every point.

    The slider is soft and pressed hard enough to lie in the kinks: else it would jump from crest to crest.
    """
    count = 36
    height = EDGE / count * math.tan(math.radians(0.5))
    points = [[EDGE, -2.0]] + [[EDGE * (1.0 - i / count), -height * (i % 2)] for i in range(count + 1)]
    data = scene.with_({"materials.rubber.young": 1000.0, "loads.0.ty.to": -10.0, "loads.1.tx.to": 8.0}).data
    del data["bodies"]["base"]
    data["supports"] = []
    data["rigid"] = {"base": {"line": points, "segment": 0.3}}
    data["contacts"][0]["master"] = "base"
    return _before_the_edge(Scene.from_data(data, registry=scene.registry), slower, "kinks of 1 degree: ")
