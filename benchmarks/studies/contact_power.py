"""What the work of contact forces comes from, over a run (docs/theory/contact-energy.md).

    python benchmarks/studies/contact_power.py [SCENE] [--cells 72 12] [--forces published] [--algorithm mortar-p0]

Scenes follow their path (`time.history`): without, strong damping hides what contact makes. Sums in mJ at the end.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import contactlab
from contactlab.api.state import CONTACT_WORK
from contactlab.run.simulation import simulate


def parts_of(name: str, changes: dict[str, Any]) -> dict[str, float]:
    """Parts of the contact work, its sum, and the work of stresses and supports [mJ]."""
    scene = contactlab.load_scene(name).with_({"time.history": True, "record.contact_work": True, **changes})
    with tempfile.TemporaryDirectory() as folder:
        results = simulate(scene, Path(folder) / "run")
    print(results.status, results.reason)
    names = [*(f"contact.{part}" for part in CONTACT_WORK), "contact", "friction", "internal", "external"]
    return {name: float(results.history[f"energy.{name}"][-1]) for name in names}


def main() -> None:
    """Print the sums."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scene", nargs="?", default="disc-on-block")
    arguments.add_argument("--cells", nargs=2, type=int, default=[72, 12])
    arguments.add_argument("--forces", choices=("consistent", "frozen"), default="frozen")
    arguments.add_argument("--algorithm", default="mortar-p0")
    given = arguments.parse_args()
    enforcement = {"use": "forward-increment", "forces": given.forces}
    changes: dict[str, Any] = {"contacts.0.algorithm": given.algorithm, "contacts.0.enforcement": enforcement}
    if given.scene == "disc-on-block":
        changes["bodies.block.mesh.cells"] = given.cells
    for name, work in parts_of(given.scene, changes).items():
        print(f"{name:16} {work: .4g}")


if __name__ == "__main__":
    main()
