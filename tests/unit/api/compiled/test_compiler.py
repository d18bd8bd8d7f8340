"""A kernel runs the copies of its callees that were compiled with it, whatever else the process has loaded."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from llvmlite.binding import Linkage

from contactlab.api.compiled.kernel import kernel

SOURCE = '''
import numpy as np
from contactlab.api.compiled.kernel import kernel

@kernel
def total(x, out):
    """Long enough not to be written into its caller."""
    out[0] = 0.0
    for i in range(len(x)):
        if x[i] > 0.5:
            out[0] += np.sqrt(x[i]) * np.sin(x[i])
        elif x[i] > 0.25:
            out[0] -= np.cos(x[i]) / (1.0 + x[i])
        else:
            out[0] += np.exp(-x[i]) + np.log1p(x[i]) * np.tan(x[i])

@kernel
def twice(x, out):
    """Two calls."""
    total(x, out)
    before = out[0]
    total(x[1:], out)
    out[0] += before
'''


@kernel
def _halved(x, out):  # type: ignore[no-untyped-def]
    for i in range(len(x)):
        out[i] = 0.5 * x[i]


@kernel
def quartered(x, out):  # type: ignore[no-untyped-def]
    """Calls another kernel twice."""
    _halved(x, out)
    _halved(out, out)


def test_no_copy_of_a_callee_is_seen_from_outside() -> None:
    """The linker takes the first of all visible copies for all kernels: there must be none to take."""
    out = np.zeros(4)
    quartered(np.ones(4), out)
    assert out.tolist() == [0.25] * 4
    (compiled,) = quartered.overloads.values()  # type: ignore[attr-defined]
    linkages = {function.linkage for function in compiled.library.get_defined_functions()}
    assert Linkage.linkonce_odr not in linkages


RAISES = """
from contactlab.api.compiled.kernel import kernel, point

@point
def checked(x):
    if x < 0.0:
        raise ValueError("below zero", x)
    return x

@kernel
def passed(x):
    return checked(x) + 1.0
"""


@pytest.mark.full
def test_an_error_of_a_part_carries_its_numbers_also_from_the_cache(tmp_path: Path) -> None:
    """What it is made of in Python lies in the environment of the part, of which the kernel has a copy."""
    (tmp_path / "raises.py").write_text(RAISES)
    program = "import raises\ntry:\n    raises.passed(-2.5)\nexcept ValueError as error:\n    print(error.args)"
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True,
            env={"PATH": "", "CONTACTLAB_CACHE": str(tmp_path / "cache")},
        )  # fmt: skip
        assert done.stdout.strip() == "('below zero', -2.5)"


@pytest.mark.full
def test_one_file_of_machine_code_for_a_kernel_and_one_result_however_it_is_loaded(tmp_path: Path) -> None:
    """Compiled, loaded after the kernel that it calls was compiled, and after that was loaded.

    What a kernel calls has no place in the cache: it gets its own when Python calls it.
    """
    (tmp_path / "sums.py").write_text(SOURCE)
    found = []
    for first, stored in (
        ("", ["twice"]), ("sums.total(x, out);", ["total", "twice"]), ("sums.total(x, out);", ["total", "twice"]),
    ):  # fmt: skip
        program = (
            "import numpy as np, sums; x = np.linspace(0.0, 1.0, 1001); out = np.zeros(1);"
            f"{first} sums.twice(x, out); print(out[0].hex(), sum(sums.twice.stats.cache_hits.values()))"
        )
        done = subprocess.run(
            [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True,
            env={"PATH": "", "CONTACTLAB_CACHE": str(tmp_path / "cache")},
        )  # fmt: skip
        found.append(done.stdout.split())
        files = sorted((tmp_path / "cache").rglob("*.nbc"))
        assert [path.name.split(".")[1].split("-")[0] for path in files] == stored
    assert len({value for value, _ in found}) == 1
    assert [hits for _, hits in found] == ["0", "1", "1"]
