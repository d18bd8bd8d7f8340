"""Every kernel of contact has a unit test of its own name, in the test file of its module's name."""

from __future__ import annotations

import ast
from pathlib import Path

import counts
import pytest

UNIT = Path(__file__).parents[1] / "unit"
HOMES = {
    "contactlab.kernels.contact": UNIT / "kernels" / "contact",
    "contactlab_mortar": UNIT / "plugins" / "mortar",
    "contactlab_segments": UNIT / "plugins" / "segments",
}
BESIDE = {"weights": "test_pairing.py"}  # modules whose kernels are tested with those that call them


def kernels() -> list[tuple[str, str, str]]:
    """Package, module and name of every kernel of contact that Python calls."""
    return [
        (package, module.rpartition(".")[2], function.name)
        for module, tree in counts.modules()
        for package in (module.rpartition(".")[0],)
        if package in HOMES
        for function in counts.functions(tree)
        if counts.is_entry(function)
    ]


def names_of_tests(file: Path) -> list[str]:
    """Names of the tests in a file that may not be there."""
    return [function.name for function in counts.functions(ast.parse(file.read_text()))] if file.exists() else []


def test_kernels_are_found() -> None:
    """Those of the core, of either plugin, and no part of a kernel."""
    found = {name for _, _, name in kernels()}
    assert len(found) > 40
    assert {"write_rows", "mortar_pieces", "mortar_derivatives", "pair_nodes"} <= found
    assert not {"integrate", "overlap", "put_piece"} & found


@pytest.mark.parametrize(("package", "module", "name"), kernels())
def test_every_kernel_has_a_test_of_its_name(package: str, module: str, name: str) -> None:
    file = HOMES[package] / BESIDE.get(module, f"test_{module}.py")
    tests = [test for test in names_of_tests(file) if test == f"test_{name}" or test.startswith(f"test_{name}_")]
    assert tests, f"{package}.{module}.{name}: write test_{name}_... in {file.relative_to(UNIT.parent)}"
