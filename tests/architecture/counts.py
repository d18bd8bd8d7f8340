"""Counts of the house: what a newcomer meets at the top, how large classes and functions are, how many arguments.

    python tests/architecture/counts.py

prints them; `test_counts.py` holds them.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
CORE = ROOT / "src" / "contactlab"
ENTRIES = {"kernel", "summation", "table_kernel"}
COMPILED = {*ENTRIES, "point", "section"}


class Count(NamedTuple):
    """Something counted, and where it is."""

    name: str
    number: int


def modules() -> Iterator[tuple[str, ast.Module]]:
    """Every module of the core and the plugins by dotted name."""
    for folder in (ROOT / "src", *sorted((ROOT / "plugins").glob("*/src"))):
        for path in sorted(folder.rglob("*.py")):
            yield ".".join(path.relative_to(folder).with_suffix("").parts), ast.parse(path.read_text())


def loose_modules() -> list[str]:
    """Modules at the top of the core that are in no package."""
    return sorted(path.name for path in CORE.glob("*.py"))


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef]:
    """All functions and methods."""
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


def is_compiled(function: ast.FunctionDef) -> bool:
    """Whether numba compiles it."""
    names = {n.id for decorator in function.decorator_list for n in ast.walk(decorator) if isinstance(n, ast.Name)}
    return bool(names & COMPILED)


def is_entry(function: ast.FunctionDef) -> bool:
    """Whether a kernel is called from Python: sections and points are written into the kernels that call them."""
    names = {n.id for decorator in function.decorator_list for n in ast.walk(decorator) if isinstance(n, ast.Name)}
    return bool(names & ENTRIES) and not function.name.startswith("_")


def class_attributes() -> list[Count]:
    """Attributes of every class, most first: fields, and names that its methods assign on self."""
    found = []
    for module, tree in modules():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                found.append(Count(f"{module}.{node.name}", len(_attributes(node))))
    return sorted(found, key=lambda count: -count.number)


def _attributes(node: ast.ClassDef) -> set[str]:
    declared = (item.target for item in node.body if isinstance(item, ast.AnnAssign))
    fields = {target.id for target in declared if isinstance(target, ast.Name)}
    stored = (n for n in ast.walk(node) if isinstance(n, ast.Attribute) and isinstance(n.ctx, ast.Store))
    return fields | {n.attr for n in stored if isinstance(n.value, ast.Name) and n.value.id == "self"}


def function_lines() -> list[Count]:
    """Lines of every function, docstrings included, most first; a kernel's sections count for themselves."""
    found = [
        Count(f"{module}.{function.name}", (function.end_lineno or 0) - function.lineno + 1)
        for module, tree in modules()
        for function in functions(tree)
    ]
    return sorted(found, key=lambda count: -count.number)


ROOMS = ("contactlab.kernels.contact.", "contactlab_mortar.", "contactlab_segments.", "contactlab_dynamics.")


def contact_kernel_arguments() -> list[Count]:
    """Arguments of the compiled functions of contact, those inside kernels included, most first."""
    found = [
        Count(f"{module}.{function.name}", len(function.args.args))
        for module, tree in modules()
        if module.startswith(ROOMS)
        for function in functions(tree)
        if is_compiled(function)
    ]
    return sorted(found, key=lambda count: -count.number)


def main() -> None:
    """Print the counts."""
    top = loose_modules()
    print(f"loose modules at the top of contactlab: {len(top)} ({', '.join(top)})")
    for title, counts in (
        ("attributes of a class", class_attributes()),
        ("lines of a function", function_lines()),
        ("arguments of a contact kernel", contact_kernel_arguments()),
    ):
        print(f"{title}, the most:")
        for name, number in counts[:8]:
            print(f"  {number:4d}  {name}")


if __name__ == "__main__":
    main()
