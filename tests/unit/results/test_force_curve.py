"""Which motion a force curve is drawn over."""

from __future__ import annotations

import numpy as np

from contactlab.results.force_curve import force_curve


def history(**columns: list[float]) -> dict[str, np.ndarray]:
    rows = {"time": [0.0, 0.5, 1.0], "share": [0.0, 0.5, 1.0]}
    rows |= {name.replace("__", "."): values for name, values in columns.items()}
    return {name: np.array(values) for name, values in rows.items()}


CAM = {
    "cam__ux": [0.0, 1e-17, 2e-17],
    "cam__uy": [0.0] * 3,
    "cam__fx": [0.0, -3.0, -4.0],
    "cam__fy": [0.0, 70.0, 150.0],
}


def test_the_round_off_of_a_support_that_turns_is_no_displacement() -> None:
    """A cam turns and lifts a follower that is free along y: neither has a displacement with a force."""
    follower = {"top__ux": [0.0] * 3, "top__uy": [0.0, 0.7, 1.5], "top__fx": [0.0, 3.0, 4.0], "top__fy": [0.0] * 3}
    for on in ("cam", ""):
        curve = force_curve(history(**CAM, **follower), on, {})
        assert (curve.on, curve.moved, curve.component) == ("cam", "", "y")
        np.testing.assert_array_equal(curve.x, [0.0, 50.0, 100.0])
        np.testing.assert_array_equal(curve.force, [0.0, 70.0, 150.0])


def test_a_driven_support_is_drawn_over_its_motion() -> None:
    driven = {"top__ux": [0.0] * 3, "top__uy": [0.0, -0.7, -1.5], "top__fx": [0.0] * 3, "top__fy": [0.0, -60.0, -140.0]}
    curve = force_curve(history(**CAM, **driven), "", {})
    assert (curve.on, curve.moved, curve.along, curve.sign) == ("top", "top", "y", -1.0)
    np.testing.assert_array_equal(curve.x, [0.0, 0.7, 1.5])
    np.testing.assert_array_equal(curve.force, [0.0, 60.0, 140.0])
