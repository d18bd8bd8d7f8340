"""Arrays that are bound once are the same inside a kernel as outside."""

from __future__ import annotations

import sys
import weakref
from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np
import pytest

from contactlab.api.compiled.bound_arrays import (
    ADDRESS_BITS,
    LAST_SERIAL,
    BoundArrays,
    BoundCache,
    Floats1,
    Floats2,
    Ints1,
    KernelArgument,
    layout_of,
)
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


class Inner(NamedTuple):
    weight: Floats2
    start: Ints1


class Outer(NamedTuple):
    scale: Floats1
    first: Inner
    second: Inner


@kernel
def weighed(bound):
    """Moves a weight from the first to the second inner table; returns what names and shapes say."""
    table = unpack(bound, Outer)
    table.second.weight[1, 1] += table.first.weight[0, 2] * table.scale[0]
    return table.first.start.size + 10 * table.second.start[0]


def test_tables_have_names_inside_kernels_and_hold_tables() -> None:
    first, second = (Inner(np.full((2, 3), w), np.full(4, n, np.int32)) for w, n in ((2.0, 5), (1.0, 7)))
    bound = BoundArrays(Outer, np.full(1, 3.0), first, second)
    assert layout_of(Outer) == "d1 d2 i1 d2 i1"
    assert weighed(bound.address) == 4 + 70
    assert second.weight[1, 1] == 7.0
    with pytest.raises(TypeError, match="needed: contiguous i1"):
        BoundArrays(Outer, np.full(1, 3.0), first, Inner(first.weight, np.zeros(4)))


@kernel
def misspelt(bound):
    """Asks for a field that there is not."""
    return unpack(bound, Outer).third


def test_a_field_that_a_table_has_not_is_an_error_when_the_kernel_is_compiled() -> None:
    with pytest.raises(numba.TypingError, match="third"):
        misspelt(0)


@kernel
def larger(bound, second):
    """Total of one of two inner tables, chosen when the kernel runs, whose array is passed from hand to hand."""
    table = unpack(bound, Outer)
    chosen = table.second if second else table.first
    kept, total = chosen.weight, 0.0
    for i in range(kept.shape[0]):
        kept = chosen.weight
        for j in range(kept.shape[1]):
            total += kept[i, j]
    return total


def test_tables_can_be_chosen_between_and_no_reference_to_their_arrays_is_counted() -> None:
    weights = np.full((2, 3), 1.0), np.full((2, 3), 2.0)
    first, second = (Inner(weight, np.zeros(1, np.int32)) for weight in weights)
    bound = BoundArrays(Outer, np.zeros(1), first, second)
    before = [sys.getrefcount(weight) for weight in weights]
    assert (larger(bound.address, False), larger(bound.address, True)) == (6.0, 12.0)
    assert [sys.getrefcount(weight) for weight in weights] == before


class Owner:
    """Something whose arrays are bound."""


def test_a_cache_binds_once_for_an_owner_and_its_source_and_forgets_the_owner() -> None:
    cache, owner, made = BoundCache(), Owner(), []
    source = np.zeros(1)

    def bind(_: Owner, source: np.ndarray) -> BoundArrays:
        made.append(BoundArrays("d1", source))
        return made[-1]

    first = cache.of(owner, bind, source)
    assert cache.of(owner, bind, source) is first
    assert cache.of(owner, bind, np.zeros(1)) is made[1] is not first
    bound = weakref.ref(made.pop())
    made.clear()
    del owner, first
    assert bound() is None


@kernel
def total(bound):
    """Sum of the first of two arrays."""
    numbers, _ = unpack(bound, "d1 d1")
    found = 0.0
    for i in range(numbers.size):
        found += numbers[i]
    return found


@kernel
def _of_another(bound):
    return total(bound) + 1.0


@kernel
def passed_on(bound):
    """Asks a kernel that asks a kernel."""
    return _of_another(bound)


@dataclass
class Held(KernelArgument):
    """An object of two arrays, with more besides."""

    second: Floats1
    name: str
    first: Floats1
    count: int = 0


@kernel
def difference(count, held, out):
    """The first arrays less the second."""
    for i in range(count):
        out[i] = held.first[i] - held.second[i]


def test_a_kernel_names_the_arrays_of_an_object_that_it_is_given() -> None:
    out, held = np.zeros(3), Held(np.ones(3), "held", np.arange(3.0))
    difference(3, held, out)
    np.testing.assert_array_equal(out, [-1.0, 0.0, 1.0])
    held.first[:] = 5.0  # filled anew
    difference(2, held, out)
    np.testing.assert_array_equal(out, [4.0, 4.0, 1.0])
    with pytest.raises(TypeError, match="needed: contiguous d1"):
        difference(3, Held(np.ones(3), "held", np.arange(3)), out)


def test_an_address_that_outlives_its_object_is_an_error() -> None:
    """It used to be read, whatever stood there by then."""
    bound = BoundArrays("d1 d1", np.ones(3), np.ones(1))
    address = bound.address
    assert total(address) == 3.0
    assert passed_on(address) == 4.0
    del bound
    for ask in (total, passed_on):
        with pytest.raises(ValueError, match="their BoundArrays object is gone"):
            ask(address)


def test_an_old_address_is_an_error_where_others_are_bound_by_then() -> None:
    """Tables of the same size take each other's place; a serial number tells them apart."""
    old = BoundArrays("d1 d1", np.ones(3), np.ones(1))
    address = old.address
    del old
    kept = [BoundArrays("d1 d1", np.full(3, 2.0), np.ones(1)) for _ in range(5)]
    where = (1 << ADDRESS_BITS) - 1
    assert any(bound.address & where == address & where for bound in kept), "no table was reused: nothing is shown"
    assert [total(bound.address) for bound in kept] == [6.0] * 5
    with pytest.raises(ValueError, match="their BoundArrays object is gone"):
        total(address)


@pytest.mark.full
def test_a_table_whose_numbers_are_used_up_is_not_used_again() -> None:
    """Serial numbers never begin anew, and addresses stay positive."""
    array, seen = np.ones(2), set()
    for _ in range(2 * LAST_SERIAL + 10):
        bound = BoundArrays("d1 d1 d1 d1 d1", array, array, array, array, array)
        assert 0 < bound.address < 2**63
        seen.add(bound.address)
        del bound
    assert len(seen) == 2 * LAST_SERIAL + 10
