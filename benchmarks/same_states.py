"""Do two versions compute the same, bit by bit? For changes that are to move code and no result.

    python benchmarks/same_states.py save before      # at one commit, with its own environment
    python benchmarks/same_states.py save before "newton friction" disc-in-box    # runs with these words in their names
    python benchmarks/same_states.py save after       # at the other, on the same machine
    python benchmarks/same_states.py compare before after

`save` runs every scene below for a short while and keeps what the run ends with: displacements, velocities, stresses,
history variables, contact curves, the columns of the history. It uses names of the public surface alone, so that any
two commits can be compared. `compare` exits with 1 if an array differs and says by how much.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

Changes = dict[str, Any]

ALGORITHMS = ("node-on-segment", "mortar-p0", "mortar-p1")
COULOMB: Changes = {"use": "coulomb", "mu": 0.2}
SKIPPED = {"s", "chain"}  # arc lengths along the slave: a way of counting, no result
DISC: Changes = {"level": 1, "supports.1.uy.to": -0.02}
EXPLICIT: Changes = {**DISC, "time.end": 5e-6}
STATIC: Changes = {**DISC, "integrator": {"use": "newton", "steps": 3}}
IMPLICIT: Changes = {**DISC, "integrator": {"use": "implicit-dynamics"}, "time.end": 5e-6, "time.step": 5e-7}
# a short stretch of every bundled scene: enough for contact to close, slip and open in most of them
BUNDLED: dict[str, Changes] = {
    "block-on-incline": {"time.end": 4e-3},
    "bouncing-bar": {"time.end": 2.0},
    "corner-slide": {"time.end": 4e-5},
    "disc-in-box": {"time.end": 1e-3},
    "dropped-block": {"time.end": 2e-2},
    "initial-overlap": {},
    "spinning-pair": {"time.end": 4e-4},
    "stack": {"time.end": 1e-2},
    "three-body-forging": {"time.end": 2e-5},
    "tresca-block": {},
    "two-bars": {},
    "vertex-to-vertex": {"time.end": 2e-5},
}


def jobs() -> Iterator[tuple[str, str, Changes]]:
    """Name, scene and changes of every run."""
    for swap in (False, True):
        for algorithm in ALGORITHMS:
            contact = {"contacts.0.algorithm": algorithm, "contacts.0.swap": swap}
            side = f"{algorithm} {'swapped' if swap else 'as declared'}"
            yield f"explicit {side}", "disc-on-block", {**EXPLICIT, **contact}
            yield f"explicit friction {side}", "disc-on-block", {**EXPLICIT, **contact, "contacts.0.friction": COULOMB}
            yield f"newton {side}", "disc-on-block", {**STATIC, **contact}
            yield f"newton friction {side}", "disc-on-block", {**STATIC, **contact, "contacts.0.friction": COULOMB}
    for algorithm in ALGORITHMS:
        contact = {"contacts.0.algorithm": algorithm}
        yield f"implicit dynamics {algorithm}", "disc-on-block", {**IMPLICIT, **contact}
        for element in ("q2", "q2-lagrange"):
            quadratic = {**contact, "bodies.disc.element": element, "bodies.block.element": element}
            yield f"explicit {element} {algorithm}", "disc-on-block", {**EXPLICIT, **quadratic}
            yield f"newton {element} {algorithm}", "disc-on-block", {**STATIC, **quadratic}
    for enforcement in ("penalty", "augmented-lagrangian"):
        yield f"newton {enforcement}", "disc-on-block", {**STATIC, "contacts.0.enforcement": enforcement}
    for scene, changes in BUNDLED.items():
        for algorithm in ALGORITHMS:
            yield f"{scene} {algorithm}", scene, {**changes, "contacts.0.algorithm": algorithm}


def content(results: Any) -> dict[str, np.ndarray]:
    """Everything a run ends with, as flat arrays by name."""
    found = {"displacement": results.displacement, "velocity": results.velocity}
    found |= {f"stress {body}": stress for body, stress in results.stress.items()}
    for body, variables in results.internal_variables.items():
        found |= {f"{name} {body}": values for name, values in variables.items()}
    for contact, history in results.contact.items():
        curve = history.last if history.curves else None
        own = vars(curve) if curve is not None and hasattr(curve, "__dict__") else {}
        found |= {f"{contact} {k}": v for k, v in own.items() if isinstance(v, np.ndarray) and k not in SKIPPED}
    found |= {f"history {name}": values for name, values in results.history.items()}
    return {name: np.asarray(values, np.float64) for name, values in found.items()}


def save(folder: Path, words: list[str]) -> None:
    """Run everything, or what has one of the words in its name, and keep one file for each run in `folder`."""
    import contactlab

    chosen = [job for job in jobs() if not words or any(word in job[0] for word in words)]
    folder.mkdir(parents=True)
    for name, scene, changes in chosen:
        try:
            results = contactlab.simulate(contactlab.load_scene(scene).with_({**changes, "record.recorders": []}))
        except contactlab.ContactlabError as refusal:
            arrays, ended = {}, f"refused: {str(refusal).splitlines()[0]}"
        else:
            arrays, ended = content(results), f"{results.status}, {results.summary['steps']} steps"
        np.savez(folder / f"{name}.npz", ended=np.array(ended), **arrays)
        print(f"{name}: {ended}", flush=True)


def compare(before: Path, after: Path) -> int:
    """Print every difference; 1 if there is one."""
    names = sorted({file.name for file in (*before.glob("*.npz"), *after.glob("*.npz"))})
    different = 0
    for name in names:
        differences = list(_differences(before / name, after / name))
        different += bool(differences)
        for line in differences:
            print(f"{name.removesuffix('.npz')}: {line}")
    print(f"{len(names) - different} of {len(names)} runs are the same to the last bit")
    return 1 if different or not names else 0


def _differences(before: Path, after: Path) -> Iterator[str]:
    for file in (before, after):
        if not file.exists():
            yield f"not in {file.parent}"
            return
    with np.load(before) as old, np.load(after) as new:
        for name in sorted({*old.files, *new.files}):
            if name not in old.files or name not in new.files:
                yield f"{name} is only in {(before if name in old.files else after).parent}"
            elif name == "ended":
                if str(old[name]) != str(new[name]):
                    yield f"{old[name]} became {new[name]}"
            elif old[name].shape != new[name].shape:
                yield f"{name}: shape {old[name].shape} became {new[name].shape}"
            elif not np.array_equal(old[name], new[name], equal_nan=True):
                largest = float(np.nanmax(np.abs(old[name]), initial=0.0)) or 1.0
                change = float(np.nanmax(np.abs(old[name] - new[name]), initial=0.0))
                yield f"{name}: differs by {change / largest:.1e} of its largest value"


def main(words: list[str]) -> int:
    """`save FOLDER WORDS` or `compare FOLDER FOLDER`."""
    if len(words) >= 2 and words[0] == "save":
        save(Path(words[1]), words[2:])
        return 0
    if len(words) == 3 and words[0] == "compare":
        return compare(Path(words[1]), Path(words[2]))
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
