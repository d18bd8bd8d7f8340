"""Two blocks that overlap a little before the run, or leave a gap."""

from __future__ import annotations

from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.cases.figures import Figure, near
from contactlab.testing.cases.watched import WatchedRun

TREATED, END = 5e-4, 1e-3  # s: before that the overlap is treated, then the blocks are pressed
YOUNG, PRESSED, OVERLAP = 1000.0, 0.01, 0.0025


def initial_overlap(algorithm: str, full: bool) -> list[Figure]:
    """An overlap of a hundredth of a segment, ramped or adjusted, and gaps of 1e-12 of a segment and of none."""
    scene = load_scene("initial-overlap").with_({"contacts.0.algorithm": algorithm})
    if full:
        scene = scene.with_({"bodies.upper.mesh.cells": [8, 6], "bodies.lower.mesh.cells": [14, 6]})
    adjusted = scene.with_({"contacts.0.start": {"overlap": "adjust"}})
    gaps = [_force(_shifted(scene, 0.25 * gap)) for gap in (0.0, 1e-12)]
    change, wide = abs(gaps[1] / gaps[0] - 1.0), _force(_shifted(scene, OVERLAP))
    return [
        *_treated(scene, "ramped", YOUNG * (PRESSED + OVERLAP)),
        *_treated(adjusted, "adjusted", YOUNG * PRESSED / (1.0 - OVERLAP)),
        Figure("force with a gap of 1e-12 segments against none, relative change", change, most=1e-9),
        near("force with a gap of a hundredth of a segment [N]", wide, YOUNG * (PRESSED - OVERLAP), 1e-3),
    ]


def _shifted(scene: Scene, gap: float) -> Scene:
    return scene.with_({"contacts.0.start": {"overlap": "refuse"}, "bodies.upper.shift": [0.0, gap]})


def _force(scene: Scene) -> float:
    run = WatchedRun(scene)
    run.until(END)
    return float(run.force_on("upper")[1])


def _treated(scene: Scene, how: str, force: float) -> list[Figure]:
    """Kinetic energy while the overlap is treated over the energy stored later, and the force in the end.

    nu = 0, so that the exact force is Young's modulus times the shortening over the height: a ramp turns the
    overlap into pressure, an adjustment takes it from the height.
    """
    run, kinetic = WatchedRun(scene), [0.0]
    run.until(TREATED, lambda: kinetic.append(run.model.kinetic_energy()))
    run.until(END)
    stored = sum(forces.stored_energy() for forces in run.model.forces)
    return [
        Figure(f"{how}: largest kinetic energy until then over that stored later", max(kinetic) / stored, most=1e-6),
        near(f"{how}: force in the end [N]", float(run.force_on("upper")[1]), force, 1e-3),
    ]
