"""A block on an inclined plane: it slides as Coulomb says, or does not move at all."""

from __future__ import annotations

import math

import numpy as np

from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.cases.figures import Figure, near
from contactlab.testing.cases.watched import WatchedRun

GRAVITY, ANGLE = 9810.0, math.radians(20.0)
BEGIN, END = 0.02, 0.12  # s: after the weight has come and vibrations have gone, and 0.1 s later
DOWN = np.array([math.cos(ANGLE), -math.sin(ANGLE)])


def block_on_incline(algorithm: str, full: bool) -> list[Figure]:
    """Acceleration, creep below and slip above the threshold, the scene turned to a level plane, and a stop."""
    scene = _scene(algorithm, full)
    sliding = _acceleration(scene, 0.3)
    beyond = _acceleration(scene, 0.36)
    exact, least = (GRAVITY * (math.sin(ANGLE) - mu * math.cos(ANGLE)) for mu in (0.3, 0.36))
    return [
        near("acceleration at mu = 0.3 over 0.1 s [mm/s2]", sliding, exact, 0.005),
        near("acceleration at mu = 0.36, just below tan 20 [mm/s2]", beyond, least, 0.05),
        Figure("creep at mu = 0.37, just above tan 20, in 0.1 s [mm]", _creep(scene, 0.37), most=1e-6),
        Figure("path in the scene turned to a level plane, relative difference", _turned(scene), most=1e-10),
        *_stop(scene),
    ]


def _scene(algorithm: str, full: bool) -> Scene:
    cells = [8, 4] if full else [4, 2]
    return load_scene("block-on-incline").with_(
        {"contacts.0.algorithm": algorithm, "bodies.block.mesh.cells": cells, "time.end": END}
    )


def _acceleration(scene: Scene, mu: float) -> float:
    run = WatchedRun(scene.with_({"contacts.0.friction.mu": mu}))
    run.until(BEGIN)
    began, speed = run.time, run.mean(run.state["velocity"], "block") @ DOWN
    run.until(END)
    return float((run.mean(run.state["velocity"], "block") @ DOWN - speed) / (run.time - began))


def _creep(scene: Scene, mu: float) -> float:
    run = WatchedRun(scene.with_({"contacts.0.friction.mu": mu}))
    run.until(BEGIN)
    nodes = run.contact.pairs[0].slave.nodes
    before = run.state["displacement"][nodes].copy()
    run.until(END)
    return float(np.abs((run.state["displacement"][nodes] - before) @ DOWN).max())


def _turned(scene: Scene) -> float:
    """Paths of the block's centre, along the plane, in the scene and in one turned by 20 degrees."""
    pull = [GRAVITY * math.sin(ANGLE), -GRAVITY * math.cos(ANGLE)]
    level = scene.with_(
        {
            "bodies.block.rotate": 0.0,
            "rigid.plane.line": [[100.0, 0.0], [-20.0, 0.0]],
            "effects.0.acceleration": pull,
        }
    )
    inclined, flat = WatchedRun(scene), WatchedRun(level)
    for run in (inclined, flat):
        run.until(END)
    wanted = inclined.mean(inclined.state["displacement"], "block") @ DOWN
    return float(abs(flat.mean(flat.state["displacement"], "block")[0] / wanted - 1.0))


def _stop(scene: Scene) -> list[Figure]:
    """On a level plane a block thrown at v0 stops after v0/(mu g), and stays where it is."""
    speed, mu = 100.0, 0.3
    run = WatchedRun(
        scene.with_(
            {
                "bodies.block.rotate": 0.0,
                "bodies.block.velocity": [speed, 0.0],
                "rigid.plane.line": [[100.0, 0.0], [-20.0, 0.0]],
                "effects.0.ramp": 0.0,
                "contacts.0.friction.mu": mu,
            }
        )
    )
    nodes, stopped, last = run.contact.pairs[0].slave.nodes, math.nan, 0.0
    exact = speed / (mu * GRAVITY)
    while run.time < 1.5 * exact:
        run.step()
        moving = float(run.mean(run.state["velocity"], "block")[0])
        if math.isnan(stopped) and moving <= 0.0:
            stopped = run.time
        if run.time < 1.4 * exact:
            last = float(run.state["displacement"][nodes, 0].mean())
    crept = abs(float(run.state["displacement"][nodes, 0].mean()) - last)
    return [
        near("time until a thrown block stops [s]", stopped, exact, 0.01),
        Figure("creep after the stop, in a tenth of that time [mm]", crept, most=1e-6),
    ]
