"""Does a block that slides with friction flutter by itself? (docs/theory/friction-flutter.md)

    python benchmarks/studies/flutter.py [--levels 1 2 4 8]

Modes of the block of `block-on-incline` on its plane and the damping that stops all of them, by an assembly of its own
(`contactlab_cases/flutter.py`), level by level; then the scene with 0.8 and 1.25 times that damping. Level 8 takes some
minutes. The case `sliding-flutter` asks the same at one level, of every contact algorithm.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping

import numpy as np
from contactlab_cases.flutter import flutter
from contactlab_cases.sliding_flutter import LESS, MORE, block

import contactlab

END = 0.06  # s; swings are looked at in the second half


def swing(level: int, rate: float) -> tuple[str, float]:
    """How the scene ends with that damping, and the range of the plane's reaction over its mean."""
    changes: Mapping[str, object] = {
        "level": level, "time.end": END, "effects.1.rate": rate, "record.recorders": []
    }  # fmt: skip
    found = contactlab.simulate(contactlab.load_scene("block-on-incline").with_(changes))
    force = np.asarray(found.history["plane.fy"])
    late = force[len(force) // 2 :]
    return found.summary["status"], float(np.ptp(late) / np.mean(late))


def main() -> None:
    """Print a row per level."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--levels", type=int, nargs="+", default=[1, 2, 4])
    for level in arguments.parse_args().levels:
        found = flutter(block(level), 0.3)
        print(
            f"level {level}: grows by {found.growth:.3g}/s at {found.frequency:.3g}/s, "
            f"in steps {found.in_steps:.3g}/s; stopped by {found.damping:.3g}/s",
            flush=True,
        )
        for factor in (LESS, MORE):
            status, size = swing(level, factor * found.damping)
            print(f"  {factor} of it: {status}, the reaction swings by {size:.2g} of its mean", flush=True)


if __name__ == "__main__":
    main()
