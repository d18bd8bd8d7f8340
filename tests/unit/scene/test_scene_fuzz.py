"""Whatever stands in a scene, reading it ends in a scene or in one clear message."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlab.errors import RequestError
from contactlab.scene.overrides import changed
from contactlab.scene.scene import Scene, load_scene
from contactlab.scene.toml_text import parse_value

BASE = load_scene("disc-on-block")


def paths(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every key of the scene, tables and single numbers."""
    found = [path] if path else []
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for name, inner in items:
        found += paths(inner, (*path, name))
    return found


ALL = paths(BASE.data)
words = st.sampled_from(
    ["q1", "auto", "disc", "disc.arc", "block.top", "rectangle", "mortar-p1", "use", "none", "", ".", "0"]
)
value = st.recursive(
    st.one_of(words, st.text(max_size=5), st.booleans(), st.integers(), st.floats(), st.none()),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.one_of(words, st.text(max_size=3)), inner, max_size=3)
    ),
    max_leaves=5,
)


@pytest.mark.full
@settings(deadline=None, max_examples=50)
@given(st.sampled_from(ALL), value)
def test_any_value_anywhere(path: tuple[Any, ...], new: Any) -> None:
    data = copy.deepcopy(BASE.data)
    holder: Any = data
    for name in path[:-1]:
        holder = holder[name]
    holder[path[-1]] = new
    try:
        scene = Scene.from_data(data)
    except RequestError as error:
        assert str(error)
    else:
        assert Scene.from_data(scene.data) == scene


@settings(deadline=None, max_examples=100)
@given(st.sampled_from(ALL), st.one_of(words, st.text(max_size=4)), value)
def test_any_override(path: tuple[Any, ...], more: str, new: Any) -> None:
    key = ".".join(map(str, path)) + (f".{more}" if more else "")
    try:
        BASE.with_({key: new})
    except RequestError as error:
        assert str(error)


@settings(deadline=None, max_examples=100)
@given(st.text(max_size=20))
def test_any_words_as_a_value(text: str) -> None:
    try:
        parse_value(text, "--set key")
    except RequestError as error:
        assert "--set key" in str(error)


def test_changes_never_touch_what_they_start_from() -> None:
    before = BASE.data
    changed(before, {"bodies.disc.mesh.cells.0": 5}, lambda path: False, lambda *given: {})
    assert before == BASE.data
