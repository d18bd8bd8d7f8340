"""data/kernel_counts.json: how many kernels a run calls, for "compiling kernel 12 of 31".

    python tests/architecture/kernel_counts.py

writes it by first steps in processes of their own; `test_composition.py` compares.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from contactlab.explain.trial_run import run_trial
from contactlab.run.compiling import used_parts
from contactlab.scene.scene import Scene, bundled_scenes, load_scene

FILE = Path(__file__).parents[2] / "src" / "contactlab" / "data" / "kernel_counts.json"

FURTHER: dict[str, tuple[str, dict[str, Any]]] = {
    "disc-on-block node-on-segment": ("disc-on-block", {"contacts.0.algorithm": "node-on-segment"}),
    "disc-on-block mortar-p1": ("disc-on-block", {"contacts.0.algorithm": "mortar-p1"}),
    "disc-on-block friction": ("disc-on-block", {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}),
    "disc-on-block newton": ("disc-on-block", {"integrator": "newton"}),
    "disc-on-block q2": ("disc-on-block", {"bodies.disc.element": "q2", "bodies.block.element": "q2"}),
}
"""Scenes that people make first."""


def scenes() -> dict[str, Scene]:
    """All that are counted."""
    own = {name: load_scene(name) for name in bundled_scenes()}
    return own | {name: load_scene(scene).with_(changes) for name, (scene, changes) in FURTHER.items()}


def main() -> None:
    """Write the file."""
    rows = {}
    for name, scene in scenes().items():
        rows[name] = {"parts": sorted(used_parts(scene)), "kernels": len(run_trial(scene).kernels)}
        print(name, rows[name], flush=True)
    FILE.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
