"""Run time of elements and contact by component.

Contact is timed as it works: one of its steps is a few calls from Python. Elements work block by block in microseconds,
so that a clock in their loop would cost too much; their share is measured after the run, by repeating the last update
of a few blocks into arrays of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import Any

import numpy as np

from contactlab.kernels.cells import midpoint
from contactlab.model.bodies.body import BodyForces
from contactlab.model.model import Model

BLOCKS = 3  # of each body: blocks are alike
REPEATS = 3  # of each, after a first repeat that fills the cache

Times = Mapping[str, Mapping[str, float]]


def element_times(model: Model) -> dict[str, dict[str, float]]:
    """Return seconds of `model.seconds` by body: in its law, its element, and in stiffness if implicit."""
    stiffness: float = getattr(model, "stiffness_s", 0.0)
    shares = {forces.body.name: _update(forces) for forces in model.forces}
    whole = sum(law + element for law, element in shares.values())
    if whole <= 0.0:
        return {}
    scale = (model.seconds - stiffness) / whole
    found = {name: {"law": law * scale, "element": element * scale} for name, (law, element) in shares.items()}
    if stiffness:
        cells = sum(len(body.cells) for body in model.bodies)
        for body in model.bodies:
            found[body.name]["stiffness"] = stiffness * len(body.cells) / cells
    return found


def _update(forces: BodyForces) -> tuple[float, float]:
    """Return seconds of one update of all blocks in the law and in the element, from the first few."""
    law = element = 0.0
    nodal, material, chosen = np.zeros_like(forces.force), forces.body.material, forces.blocks[:BLOCKS]
    gradient_of, force_of, stabilise = forces.kernels
    for block, scratch in zip(chosen, forces.scratch, strict=False):
        conn, g, sigma = block.connectivity, block.gradient.copy(), block.stress.copy()
        history, new_history = block.history.copy(), block.new_history.copy()
        for number in range(REPEATS + 1):
            began = perf_counter()
            gradient_of(forces.geometry, forces.field, conn, g, scratch)
            if material.kinematics == "rate":
                midpoint(g)
            asked = perf_counter()
            block.law.stress(g, history, forces.dt, sigma, new_history)
            told = perf_counter()
            force_of(forces.geometry, conn, sigma, nodal, scratch)
            if stabilise is not None and forces.shape is not None:
                stabilise(*forces.shape, conn, forces.body.shear_modulus, nodal, scratch)
            ended = perf_counter()
            if number:
                law, element = law + told - asked, element + (ended - told) + (asked - began)
    every = len(forces.blocks) / (REPEATS * max(1, len(chosen)))
    return law * every, element * every


def contact_times(contact: Any) -> dict[str, float]:
    """Return seconds of contact: searching, calling the algorithm and building rows, and solving.

    Implicit runs solve contact together with the bodies, without a separate solution time.
    """
    search = sum(pair.search_s for pair in contact.pairs)
    solution: float = getattr(contact, "solution_s", 0.0)
    times = {"search": search, "integration": max(0.0, contact.seconds - search - solution)}
    return times | ({"solution": solution} if solution else {})
