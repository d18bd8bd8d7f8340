"""A kernel that is found on the disk brings nothing in that only compiling needs; compiling after it works."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

KERNELS = """
import numpy as np
from contactlab.api.compiled.kernel import kernel

@kernel
def doubled(values):
    made = np.empty(values.size)  # an array of its own, whose references are counted
    for i in range(values.size):
        made[i] = 2.0 * values[i]
    return made
"""

PROGRAM = """
import sys
import numpy as np
from kernels_of_a_test import doubled
assert np.array_equal(doubled(np.arange(3.0)), [0.0, 2.0, 4.0])
print("numba.np.random.generator_core" in sys.modules)

import numba

@numba.njit
def ordered(values):
    made = [x for x in np.sort(values)]
    return made

assert ordered(np.array([2.0, 1.0])) == [1.0, 2.0]
"""


def test_a_stored_kernel_is_loaded_without_what_the_compiler_needs(tmp_path: Path) -> None:
    (tmp_path / "kernels_of_a_test.py").write_text(KERNELS, encoding="utf-8")

    def run() -> str:
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], env=os.environ | {"CONTACTLAB_CACHE": str(tmp_path)}, cwd=tmp_path,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert [run(), run()] == ["True", "False"], "compiled, then loaded"
