"""The decorators of compiled kernels: what they save must not be seen from outside."""

from __future__ import annotations

import gc
import math

import numpy as np
import pytest

from contactlab.api.compiled.kernel import COMPILATION, exp, kernel, log, point, power


@kernel
def _add(values, times, out):
    for i in range(out.size):
        out[i] += times * values[i]


@kernel
def twice(values, out):
    """Calls `_add` with two different constants."""
    _add(values, 2, out)
    _add(values, 5, out)


@point
def square(x: float) -> float:
    """x^2."""
    return x * x


@pytest.mark.parametrize("x", [1e-300, 0.3, 1.0, 1.0 + 1e-12, 2.5, 1e300])
def test_points_have_an_entry_from_python_when_it_is_asked_for(x: float) -> None:
    assert square(3.0) == 9.0
    # within an ulp or so of the C library's, as their docstrings say
    assert log(x) == pytest.approx(math.log(x), rel=5e-16, abs=1e-30)
    assert exp(math.log(x)) == pytest.approx(x, rel=5e-13)  # the argument's own round-off times 700
    assert power(x, 0.5) == pytest.approx(math.sqrt(x), rel=5e-13)


def test_an_inner_kernel_is_compiled_once_for_all_constants_and_serves_python_too() -> None:
    values, out = np.arange(3.0), np.zeros(3)
    twice(values, out)
    np.testing.assert_array_equal(out, 7.0 * values)
    assert len(_add.signatures) <= 1, "none where `twice` came from the cache on disk"  # type: ignore[attr-defined]
    _add(values, 1, out)
    np.testing.assert_array_equal(out, 8.0 * values)


def test_time_for_compiling_and_loading_is_counted_apart_from_work() -> None:
    before = COMPILATION.seconds
    twice(np.zeros(2, np.float32), np.zeros(2, np.float32))  # of types that no other test has
    first = COMPILATION.seconds
    twice(np.zeros(2, np.float32), np.zeros(2, np.float32))
    assert before < first == COMPILATION.seconds


@pytest.mark.parametrize("collecting", [True, False])
def test_the_garbage_collector_is_left_as_it_was(collecting: bool) -> None:
    before = gc.isenabled()
    (gc.enable if collecting else gc.disable)()
    try:

        @point
        def fresh(x: float) -> float:
            return x + gc_free

        gc_free = 1.0
        assert fresh(2.0) == 3.0
        assert gc.isenabled() == collecting
        with pytest.raises(Exception, match="nothing"):
            point(_refused)(1.0)
        assert gc.isenabled() == collecting
    finally:
        (gc.enable if before else gc.disable)()


def _refused(x):
    return x.nothing
