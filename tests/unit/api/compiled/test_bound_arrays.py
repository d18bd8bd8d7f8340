"""Arrays that are bound once are the same inside a kernel as outside."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.api.compiled.bound_arrays import BoundArrays
from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack

LAYOUT = "d2 i1 b1 l1 d3"


@kernel
def touch(bound, factor):
    """Writes to every array; returns what their shapes say."""
    matrix, numbers, flags, long, cube = unpack(bound, LAYOUT)
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            matrix[i, j] *= factor
    numbers[-1] = 7
    flags[0] = not flags[0]
    long[0] += 1
    cube[1, 0, 1] = cube.shape[2]
    return matrix.size + 100 * numbers.size


def test_a_kernel_sees_and_changes_the_bound_arrays() -> None:
    matrix, numbers = np.arange(6.0).reshape(3, 2), np.zeros(4, np.int32)
    flags, long, cube = np.zeros(2, np.bool_), np.full(1, 2**40), np.zeros((2, 1, 3))
    bound = BoundArrays(LAYOUT, matrix, numbers, flags, long, cube)
    assert touch(bound.address, 2.0) == 6 + 400
    np.testing.assert_array_equal(matrix, 2.0 * np.arange(6.0).reshape(3, 2))
    assert (numbers[3], flags[0], long[0], cube[1, 0, 1]) == (7, True, 2**40 + 1, 3.0)


@pytest.mark.parametrize(
    "array", [np.zeros(3), np.zeros((3, 2), np.float32), np.zeros((2, 3)).T], ids=["flat", "single", "turned"]
)
def test_arrays_that_are_not_as_the_layout_says_are_refused(array: np.ndarray) -> None:
    with pytest.raises(TypeError, match="needed: contiguous d2"):
        BoundArrays("d2", array)
    with pytest.raises(ValueError, match="argument 2 is"):
        BoundArrays("d1", np.zeros(3), np.zeros(3))
