"""Two blocks that hold each other and turn freely: nothing slips, nothing is lost."""

from __future__ import annotations

import math

import numpy as np

from contactlab.api import Floats
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.cases.figures import Figure
from contactlab.testing.cases.watched import WatchedRun

BEGIN = 1e-3  # s: vibrations of the start are over
TURN = 2e-3 * math.pi  # s
SPEED = 500.0  # mm/s, of the centre of each


def spinning_pair(algorithm: str, full: bool) -> list[Figure]:
    """One turn (ten in full) of a pair that sticks, damped and not, and of one without friction."""
    turns = 10 if full else 1
    damped = load_scene("spinning-pair").with_({"contacts.0.algorithm": algorithm, "time.end": 20.0 * TURN})
    stuck = damped.with_({"effects.1.until": BEGIN})
    data = stuck.data
    del data["contacts"][0]["friction"]
    free = Scene.from_data(data, registry=stuck.registry)
    return _stick(damped, turns) + _balance(stuck, turns, "") + _balance(free, turns, ", without friction")


def _stick(scene: Scene, turns: int) -> list[Figure]:
    """Slip, and the direction of the force against the direction of the pair."""
    run = WatchedRun(scene)
    run.until(BEGIN)
    slips, largest, angles = np.zeros(run.contact.multipliers.shape[1]), 0.0, []

    def look() -> None:
        nonlocal largest
        slips[:] += _slips(run)
        largest = max(largest, float(np.abs(slips).max()))
        fx, fy = run.force_on("upper")
        angles.append(math.remainder(math.atan2(fy, fx) - run.tilt("upper"), 2.0 * math.pi))

    run.until(BEGIN + turns * TURN, look)
    size = run.contact.pairs[0].size
    return [
        Figure("largest slip of a stuck pair in a turn [segments]", largest / size / turns, most=1e-8),
        Figure("direction of the force against that of the pair, change [rad]", float(np.ptp(angles)), most=1e-6),
    ]


def _slips(run: WatchedRun) -> Floats:
    """Tangential motion (slots,) [mm] in the last step, of every contact condition."""
    rows, out = run.contact.rows, np.zeros(run.contact.multipliers.shape[1])
    compliance, force = run.contact_compliance(), run.state["contact_force"]
    for k in range(rows.count):
        entries = slice(rows.start[k], rows.start[k + 1])
        node = rows.node[entries]
        out[rows.slot[k]] += rows.slip[k] + float((rows.tangent_weight[entries] * compliance[node] * force[node]).sum())
    return out


def _balance(scene: Scene, turns: int, which: str) -> list[Figure]:
    """Momenta and energy, with no damping since the start."""
    run = WatchedRun(scene)
    run.until(BEGIN)
    momentum, spin, energy = run.momentum(), run.angular_momentum(), run.energy()
    run.until(BEGIN + turns * TURN)
    scale = run.model.mass[run.nodes("upper")].sum() * SPEED
    return [
        Figure(f"linear momentum{which}, change", float(np.abs(run.momentum() - momentum).max() / scale), most=1e-12),
        Figure(
            f"angular momentum{which}, change per turn", abs(run.angular_momentum() / spin - 1.0) / turns, most=1e-6
        ),
        Figure(f"energy{which}, change per turn", abs(run.energy() / energy - 1.0) / turns, most=1e-5),
    ]
