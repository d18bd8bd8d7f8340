"""Bodies that only contacts are to hold end in front of what holds them, or the run says that they do not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.scene.scene import Scene

GAP, LOAD, WIDTH = 0.01, 2.0, 1.8
SOFT = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.25, "density": 1e-9}


def across_a_gap(algorithm: str, swap: bool, spring: float, gap: float = GAP, **integrator: Any) -> Scene:
    """A disc above a block, pressed by a load; a spring holds it until surfaces meet, or nothing does."""
    disc = {"use": "arc-block", "radius": 2.0, "half_width": 0.9, "top": 1.0, "cells": [10, 3]}
    block = {"use": "rectangle", "x": [-2.0, 2.0], "y": [-1.0, 0.0], "cells": [16, 4]}
    return Scene.from_data(
        {
            "format": 1,
            "symmetry": "x",
            "integrator": {"use": "newton", **integrator},
            "materials": {"soft": SOFT},
            "bodies": {
                "disc": {"element": "q1", "material": "soft", "mesh": disc, "shift": [0.0, gap]},
                "block": {"element": "q1", "material": "soft", "mesh": block},
            },
            "contacts": [{"slave": "disc.arc", "master": "block.top", "algorithm": algorithm, "swap": swap}],
            "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}, {"on": "disc.top", "ux": 0.0}],
            "loads": [{"on": "disc.top", "ty": {"ramp": "linear", "to": -LOAD}}],
            "effects": [{"use": "spring", "on": "disc.top", "stiffness": [0.0, spring]}] if spring else [],
        }
    )


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1", "node-on-segment"])
@pytest.mark.parametrize(("swap", "steps"), [(False, 1), (True, 10)])
@pytest.mark.parametrize("spring", some([0.1, 0.001], [0.001]))
def test_a_load_across_a_gap_ends_on_the_block(algorithm: str, swap: bool, steps: int, spring: float) -> None:
    """The first correction is load over spring, 36 to 3600 mm; the block carries all but the force of the spring.

    The springs, of a stiffness per mm^2, hold the gap and what both bodies give way: less than 0.04 mm.
    """
    results = contactlab.simulate(across_a_gap(algorithm, swap, spring, steps=steps))
    assert results.status == "finished", results.reason
    carried = results.summary["reactions"]["block.bottom"][1]
    assert LOAD * WIDTH - 0.04 * spring * WIDTH < carried < LOAD * WIDTH


@pytest.mark.parametrize("gap", [GAP, 3.0])
def test_no_spring_is_needed_where_a_load_drives_a_body_to_what_holds_it(gap: float) -> None:
    """To the tolerance of the equilibrium; the gap closes, however wide it was."""
    results = contactlab.simulate(across_a_gap("mortar-p0", False, 0.0, gap))
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["block.bottom"][1] == pytest.approx(LOAD * WIDTH, rel=1e-6)


def thrown(steps: int, law: str = "linear-elastic", end: float = 5e-4) -> Scene:
    """A block that flies onto a plate held at both ends, by a third to twice its own height in a step."""
    body, plate = [-0.5, 0.5], {"use": "rectangle", "x": [-3.0, 3.0], "y": [-0.3, 0.0], "cells": [24, 2]}
    block = {"use": "rectangle", "x": body, "y": [0.2, 1.2], "cells": [4, 4]}
    held = [{"on": f"plate.{side}", "ux": 0.0, "uy": 0.0} for side in ("left", "right")]
    return Scene.from_data(
        {
            "format": 1,
            "time": {"end": end},
            "integrator": {"use": "implicit-dynamics", "steps": steps},
            "materials": {"soft": {**SOFT, "use": law}},
            "bodies": {
                "block": {"element": "q1", "material": "soft", "mesh": block, "velocity": [0.0, -2e4]},
                "plate": {"element": "q1", "material": "soft", "mesh": plate},
            },
            "contacts": [{"slave": "block.bottom", "master": "plate.top", "algorithm": "mortar-p0"}],
            "supports": held,
        }
    )


@pytest.mark.parametrize("steps", some([1, 5], [1]))
def test_a_body_that_flies_in_large_steps_does_not_pass_through_a_plate(steps: int) -> None:
    """The free flight ends 10 mm lower: steps are cut until the block meets the plate, and it is on top at the end."""
    results = contactlab.simulate(thrown(steps))
    assert results.status == "finished", results.reason
    assert results.summary["steps"] > steps
    reference = results.layout.nodes
    at = reference + results.displacement
    under = np.abs(reference[:, 0]) <= 0.5
    above = at[under & (reference[:, 1] == 0.2), 1].min()
    assert above > at[under & (reference[:, 1] == 0.0), 1].max() - 0.02  # a tenth of a segment


@pytest.mark.parametrize("steps", some([2, 6], [6]))
def test_large_steps_of_a_nonlinear_body_are_cut_for_their_energy(steps: int) -> None:
    """The midpoint rule keeps the energy of linear bodies alone, so that a run of so large steps was stopped.

    A step may make a thousandth of the energy that there is, and some ten steps bounce.
    """
    results = contactlab.simulate(thrown(steps, "neo-hookean", 1.5e-4))
    assert results.status == "finished", results.reason
    assert not {"energy-at-end", "ledger"} & {one.code for one in results.warnings}
    balance = results.summary["balance"]
    energy = 0.5 * SOFT["density"] * 1.0 * 2e4**2  # type: ignore[operator]
    assert balance["kinetic"] + balance["stored"] - balance["contact"] == pytest.approx(energy, rel=0.02)


def test_forces_of_a_beam_that_rests_on_single_nodes_are_an_answer() -> None:
    """Each roller carries half of the load; no pressure is known where one node presses, and forces are exact."""
    roller = {"radius": 0.5, "angles": [0.0, 180.0]}
    friction = {"use": "coulomb", "mu": 0.2}
    beam = {"use": "rectangle", "x": [-5.0, 5.0], "y": [0.0, 0.5], "cells": [20, 1]}
    sides = {"left": -3.0, "right": 3.0}
    contact = {"slave": "beam.bottom", "algorithm": "mortar-p0", "friction": friction}
    scene = Scene.from_data(
        {
            "format": 1,
            "integrator": "newton",
            "materials": {"soft": SOFT},
            "bodies": {"beam": {"element": "q2", "material": "soft", "mesh": beam}},
            "rigid": {name: {"arc": {**roller, "centre": [x, -0.5]}, "segment": 0.1} for name, x in sides.items()},
            "contacts": [{**contact, "master": name} for name in sides],
            "loads": [{"on": "beam.top", "ty": {"ramp": "linear", "to": -0.1}}],
        }
    )
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    for name in sides:
        assert results.summary["reactions"][name][1] == pytest.approx(0.5, rel=1e-6)


YOUNG, HEIGHT, LENGTH, STOP = 1000.0, 0.2, 2.0, 1.9  # of a cantilever [MPa, mm], and where a stop below it begins


@pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p0", "mortar-p1"])
@pytest.mark.parametrize(("load", "segment", "cells"), [
    (0.025, 0.05, [[20, 20], 4]), (0.1, 4.0, [[20, 20], 4]), (0.05, 0.002, [[18, 2], 2]),
])  # fmt: skip
def test_a_beam_rests_on_the_edge_of_a_stop_whatever_the_lengths_of_its_segments(
    algorithm: str, load: float, segment: float, cells: list[Any]
) -> None:
    """Timoshenko's cantilever under an even load, on a prop at a distance below: R = (w - gap)/f, both at the prop.

    Its free end would pass through the stop by many segments of the finer side, where no condition would bring it back.
    The stop ends within the beam: nodes beyond its end are not held by a vertex of the stop, which would move the prop.
    Terms of the rotations (0.1) squared are left.
    """
    gap, a = 0.004, STOP
    bending, shearing = YOUNG * HEIGHT**3 / 12.0, YOUNG / 2.0 * 5.0 / 6.0 * HEIGHT
    sunk = load * a**2 * (6.0 * LENGTH**2 - 4.0 * LENGTH * a + a**2) / (24.0 * bending)
    sunk += load * (LENGTH * a - 0.5 * a**2) / shearing
    prop = (sunk - gap) / (a**3 / (3.0 * bending) + a / shearing)
    beam = {"use": "rectangle", "x": [0.0, 1.8, LENGTH], "y": [0.0, HEIGHT], "cells": cells}
    results = contactlab.simulate(
        Scene.from_data(
            {
                "integrator": "newton",
                "materials": {"soft": {**SOFT, "young": YOUNG, "poisson": 0.0}},
                "bodies": {"beam": {"element": "q2", "material": "soft", "mesh": beam}},
                "rigid": {"stop": {"line": [[LENGTH + 2.0, -gap], [STOP, -gap]], "segment": segment}},
                "contacts": [{"slave": "beam.bottom", "master": "stop", "algorithm": algorithm}],
                "supports": [{"on": "beam.left", "ux": 0.0, "uy": 0.0}],
                "loads": [{"on": "beam.top", "ty": -load}],
                "record": {"frames": 1, "recorders": []},
            }
        )
    )
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["stop"][1] == pytest.approx(prop, rel=0.01)
    assert "open-contact" not in {warning.code for warning in results.warnings}
