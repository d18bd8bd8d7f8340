"""The decorators of compiled kernels: what they save must not be seen from outside."""

from __future__ import annotations

import gc
import inspect
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering
from numba.extending import overload

from contactlab.api.compiled.compiler import COMPILATION
from contactlab.api.compiled.kernel import exp, kernel, log, point, power, table_kernel


@pytest.fixture(autouse=True)
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels that a test makes are not found as an earlier session of tests left them."""
    monkeypatch.setenv("CONTACTLAB_CACHE", str(tmp_path))


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
    # others of this file, which may have run before in this process, call it with float32
    doubles = [types for types in _add.signatures if types[0].dtype == numba.float64]  # type: ignore[attr-defined]
    assert len(doubles) <= 1, "none where `twice` came from the cache on disk"
    _add(values, 1, out)
    np.testing.assert_array_equal(out, 8.0 * values)


def test_time_for_compiling_and_loading_is_counted_apart_from_work() -> None:
    before = COMPILATION.seconds
    twice(np.zeros(2, np.float32), np.zeros(2, np.float32))  # of types that no other test has
    first = COMPILATION.seconds
    twice(np.zeros(2, np.float32), np.zeros(2, np.float32))
    assert before < first == COMPILATION.seconds


collections_seen: list[bool] = []


def _probe() -> None:
    """Stands for a call whose compilation shows whether garbage is collected."""


@overload(_probe)
def _probed() -> Any:
    collections_seen.append(gc.isenabled())
    return lambda: None


@pytest.mark.parametrize("ours", [False, True])
def test_only_our_own_compilations_hold_the_garbage_collector(ours: bool) -> None:
    """The host program compiles with its collector on, whatever it has imported of us."""
    collections_seen.clear()
    assert gc.isenabled()

    def compiled() -> None:
        _probe()

    compiled.__name__ = f"asks_{ours}"
    (kernel(compiled) if ours else numba.njit(compiled))()
    assert collections_seen
    assert set(collections_seen) == {not ours}
    assert gc.isenabled()


def test_table_kernels_make_no_arrays_but_call_kernels_that_do() -> None:
    """What they call is compiled as it is by itself, also where they are its first callers."""

    def total(values: Any) -> Any:
        made = np.empty(values.size)
        for i in range(values.size):
            made[i] = 2.0 * values[i]
        return made.sum()

    with pytest.raises(numba.TypingError, match="empty"):
        table_kernel(total)(np.ones(3))
    counted = kernel(total)

    def twice_total(values: Any) -> Any:
        return 2.0 * counted(values)

    assert table_kernel(twice_total)(np.ones(3)) == 12.0
    assert counted(np.ones(3)) == 6.0


def test_what_is_overridden_is_there_in_this_version_of_numba() -> None:
    """All that is used beside numba's decorators: a new version that changes it fails here and not in a run."""
    assert list(inspect.signature(CPUDispatcher.compile).parameters) == ["self", "sig"]
    assert list(inspect.signature(CPUDispatcher.get_call_template).parameters) == ["self", "args", "kws"]
    taken = inspect.signature(CPUDispatcher.__init__).parameters
    assert {"py_func", "targetoptions", "pipeline_class"} <= set(taken)
    assert isinstance(CPUDispatcher._numba_type_, property)
    assert list(inspect.signature(CompilerBase.compile_extra).parameters) == ["self", "func"]
    assert list(inspect.signature(CompilerBase.define_pipelines).parameters) == ["self"]
    assert list(inspect.signature(CompileResult._find_referenced_environments).parameters) == ["self"]
    for name in (
        "_finalize_final_module", "_optimize_final_module", "_finalize_dynamic_globals", "_verify_declare_only_symbols",
    ):  # fmt: skip
        assert list(inspect.signature(getattr(JITCodeLibrary, name)).parameters) == ["self"]
    assert list(inspect.signature(JITCodeLibrary.get_pointer_to_function).parameters) == ["self", "name"]
    assert isinstance(JITCodeLibrary.codegen, property)
    assert list(inspect.signature(JITCPUCodegen.set_env).parameters) == ["self", "env_name", "env"]
    flags = SimpleNamespace(no_rewrites=False, enable_ssa=True, auto_parallel=SimpleNamespace(enabled=False))
    state = SimpleNamespace(func_ir=None, flags=flags, func_id=SimpleNamespace(code=_probe.__code__))
    assert [k for k, _ in DefaultPassBuilder.define_nopython_pipeline(state).passes].count(NativeLowering) == 1
    assert type(numba.njit(cache=True)(_add.py_func)._cache) is FunctionCache  # type: ignore[attr-defined]
    made, ours = numba.njit(error_model="numpy")(_probe), kernel(_probe)
    # what `njit` passes on beside the options that it was given
    assert {name: made.targetoptions[name] for name in ("nopython", "boundscheck")} == {
        name: ours.targetoptions[name]  # type: ignore[attr-defined]
        for name in ("nopython", "boundscheck")
    }


@pytest.mark.full
def test_kernels_may_hold_functions_and_reckon_with_whole_arrays() -> None:
    """Neither is usual here, both are numba's."""

    @kernel
    def squares(values: Any, out: Any) -> None:
        def square(x: float) -> float:
            return x * x

        out[:] = 2.0 * values + np.array([square(x) for x in values])

    out = np.zeros(3)
    squares(np.arange(3.0), out)
    np.testing.assert_array_equal(out, [0.0, 3.0, 8.0])


@pytest.mark.full
def test_without_numba_kernels_are_plain_functions() -> None:
    """NUMBA_DISABLE_JIT serves to step through kernels with a debugger."""
    source = (
        "import numpy as np\n"
        "from contactlab.api.compiled.kernel import kernel, point\n"
        "def add(values, out):\n    out += values\n"
        "assert kernel(add) is add and point(add) is add\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", source], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
