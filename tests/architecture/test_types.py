"""Types are checked strictly in the core and in the plugins; what is left out is left out by a rule."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parents[2]
COMPILED = {"kernel", "point", "section", "summation", "table_kernel"}
MOST_ANY = 0.05  # of all arguments


def sources() -> Iterator[tuple[str, ast.Module]]:
    """Every module of the core and of the plugins by dotted name."""
    for folder in (ROOT / "src", *(ROOT / "plugins").glob("*/src")):
        for path in sorted(folder.rglob("*.py")):
            yield ".".join(path.relative_to(folder).with_suffix("").parts), ast.parse(path.read_text())


def functions(tree: ast.Module) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]


def is_kernel(function: ast.FunctionDef) -> bool:
    names = {
        node.id for decorator in function.decorator_list for node in ast.walk(decorator) if isinstance(node, ast.Name)
    }
    return bool(names & COMPILED)


def is_formula(function: ast.FunctionDef) -> bool:
    return "formula" in {ast.unparse(decorator) for decorator in function.decorator_list}


def excepted() -> list[str]:
    """Module patterns whose functions need no types."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mypy"]
    return [
        name
        for table in settings["overrides"]
        if not table.get("disallow_untyped_defs", True)
        for name in table["module"]
    ]


def test_plugins_are_checked_as_strictly_as_the_core() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mypy"]
    assert settings["strict"]
    assert set(settings["files"]) >= {"src", "plugins"}


def test_only_modules_of_kernels_may_leave_types_out() -> None:
    compiled = {name for name, tree in sources() if any(is_kernel(function) for function in functions(tree))}
    patterns = excepted()
    missing = {name for name in compiled if not any(fnmatch(name, pattern) for pattern in patterns)}
    assert not missing, f"modules of kernels: add {sorted(missing)} to the mypy override in pyproject.toml"
    idle = {p for p in patterns if "*" not in p and p not in compiled}
    assert not idle, f"{sorted(idle)} hold no kernel: take them out of the mypy override in pyproject.toml"


def test_a_function_without_types_is_a_kernel_or_is_called_by_one() -> None:
    """In modules of kernels, too, whatever is not compiled says its types."""
    untyped = {
        f"{name}.{function.name}"
        for name, tree in sources()
        for function in functions(tree)
        if function.returns is None and not is_kernel(function) and not name.startswith("contactlab.api.compiled")
    }
    assert not untyped


def test_few_arguments_may_be_anything() -> None:
    """Beside formulas, whose numbers may be dual ones, and the compiler, which is handed numba's own objects."""
    loose, total = [], 0
    for name, tree in sources():
        for function in functions(tree):
            if is_kernel(function) or is_formula(function) or name.startswith("contactlab.api.compiled"):
                continue
            own = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
            own = [argument for argument in own if argument.arg not in ("self", "cls")]
            total += len(own)
            loose += [
                f"{name}.{function.name}: {a.arg}" for a in own if a.annotation and ast.unparse(a.annotation) == "Any"
            ]
    assert len(loose) <= MOST_ANY * total, "\n".join([f"{len(loose)} of {total}:", *loose])


def test_scenes_and_registries_say_what_they_are() -> None:
    loose = [
        f"{name}.{function.name}"
        for name, tree in sources()
        for function in functions(tree)
        for argument in function.args.args
        if argument.arg in ("scene", "registry", "where")
        and argument.annotation
        and ast.unparse(argument.annotation) == "Any"
    ]
    assert not loose
