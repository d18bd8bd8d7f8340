"""The counts of `counts.py` stay within what a newcomer can take in; that no import runs up is in `test_layers.py`."""

from __future__ import annotations

import ast

import counts

MODULES, ATTRIBUTES, LINES, ARGUMENTS = 6, 20, 60, 8


def beyond(found: list[counts.Count], most: int) -> dict[str, int]:
    """What is above a limit, by name."""
    return {name: number for name, number in found if number > most}


def test_few_modules_lie_at_the_top() -> None:
    assert 1 < len(counts.loose_modules()) <= MODULES


def test_no_function_is_long() -> None:
    found = counts.function_lines()
    assert len(found) > 2000  # core and plugins are found
    assert not beyond(found, LINES)


def test_compiled_functions_of_contact_have_few_arguments() -> None:
    """One of them may be a table."""
    found = counts.contact_kernel_arguments()
    assert {name.partition(".")[0] for name, _ in found} == {
        "contactlab", "contactlab_mortar", "contactlab_segments", "contactlab_dynamics"
    }  # fmt: skip
    assert not beyond(found, ARGUMENTS)


def test_classes_have_few_attributes() -> None:
    found = counts.class_attributes()
    assert len(found) > 200
    assert not beyond(found, ATTRIBUTES)


def test_what_is_counted() -> None:
    """Fields and names assigned on self are attributes; sections are compiled, and only kernels are entries."""
    source = """
class Box:
    width: float
    def grow(self):
        self.height, other.depth = 1.0, 2.0

@section
def part(a, b): ...

@kernel
def whole(a): ...

@kernel
def _inner(a): ...
"""
    tree = ast.parse(source)
    box = next(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    assert counts._attributes(box) == {"width", "height"}
    compiled = [function.name for function in counts.functions(tree) if counts.is_compiled(function)]
    assert sorted(compiled) == ["_inner", "part", "whole"]
    assert [function.name for function in counts.functions(tree) if counts.is_entry(function)] == ["whole"]
