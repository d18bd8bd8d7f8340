"""Items that a results object does not have are refused with the numbers there are, or with the way to have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from contactlab.results.named import Named
from contactlab.results.stored_sequence import NoneStored, StoredSequence


class Tens(StoredSequence[int]):
    what = "frame"

    def __len__(self) -> int:
        return 3

    def read(self, number: int) -> int:
        assert 0 <= number < 3
        return 10 * number


def test_items_are_found_as_in_a_list() -> None:
    assert [Tens()[k] for k in range(-3, 3)] == [0, 10, 20, 0, 10, 20]
    assert Tens()[1:] == [10, 20]
    assert list(Tens()) == [0, 10, 20]


@pytest.mark.parametrize("number", [3, -4, 1000])
def test_a_number_beyond_the_last_item_is_answered_with_the_numbers_there_are(number: int) -> None:
    with pytest.raises(IndexError, match=f"no frame {number}: there are 3, 0 to 2, or -3 to -1 from the end"):
        Tens()[number]


@pytest.mark.parametrize("items", [Tens(), NoneStored[int].of("frame", "")])
@pytest.mark.parametrize("number", [1.0, "last", None])
def test_what_is_no_number_is_refused_as_such(items: Sequence[int], number: Any) -> None:
    with pytest.raises(TypeError, match=f"a frame is named by a whole number or a slice, not by {number!r}"):
        items[number]


@pytest.mark.parametrize("number", [0, -1, 7])
def test_nothing_stored_says_why_and_is_an_empty_tuple_otherwise(number: int) -> None:
    nothing: NoneStored[int] = NoneStored.of("frame", "frames are kept in files")
    with pytest.raises(IndexError, match=f"no frame {number}: frames are kept in files"):
        nothing[number]
    assert (nothing, nothing[:3], list(nothing), len(nothing)) == ((), (), [], 0)


def test_another_name_of_a_key_gives_its_value_and_is_not_listed() -> None:
    contacts = Named.of("contact", {"contacts.0": 1}, same={"disc on block": "contacts.0"})
    assert contacts["disc on block"] == 1
    assert list(contacts) == ["contacts.0"]
    with pytest.raises(KeyError, match="no contact 'disc on rock'"):
        contacts["disc on rock"]
