"""TOML: values as typed on a command line, line numbers, and text that reads back exactly."""

from __future__ import annotations

import math
import tomllib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlab.errors import SceneError
from contactlab.scene.toml_text import key_lines, parse_value, write_toml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("mortar-p1", "mortar-p1"),
        ("2", 2),
        ("-0.1581", -0.1581),
        ("2.7e-9", 2.7e-9),
        ("true", True),
        ('"true"', "true"),
        ("[4,4]", [4, 4]),
        ("[mortar-p0, 'mortar-p1', node-on-segment]", ["mortar-p0", "mortar-p1", "node-on-segment"]),
        ('{use="coulomb", mu=0.2}', {"use": "coulomb", "mu": 0.2}),
        ("{use=coulomb, mu=0.2}", {"use": "coulomb", "mu": 0.2}),
        ("[mortar-p0, {use=mortar-p1, cone=nodal}]", ["mortar-p0", {"use": "mortar-p1", "cone": "nodal"}]),
        ("[true, false, x]", [True, False, "x"]),
        ("disc.arc", "disc.arc"),
        ("path/to/mesh.msh", "path/to/mesh.msh"),
        ("two words", "two words"),
        ("1e-3mm", "1e-3mm"),
        ("", ""),
        ("1\nlevel = 3", "1\nlevel = 3"),
    ],
)
def test_bare_words_are_texts(text: str, value: Any) -> None:
    assert parse_value(text, "--set key") == value
    assert type(parse_value(text, "--set key")) is type(value)


def test_inf_and_nan_are_numbers_for_the_checks_to_refuse() -> None:
    assert parse_value("inf", "") == math.inf
    assert math.isnan(parse_value("[nan]", "")[0])


@pytest.mark.parametrize("text", ["[1, 2", "{use=coulomb", '"open', "[1, 2]]", "{a}"])
def test_a_list_or_table_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_value(text, "--set key")
    assert "--set key" in str(caught.value)
    assert text in str(caught.value)


LINED = """\
format = 1
title = \"\"\"
[not.a.table]
key = 1
\"\"\"

[time]
end = "auto"

[bodies.disc]
mesh = { use = "rectangle", x = [0, 1] }
velocity = [
  0.0,
  1.0,
]

[[contacts]]
slave = "a"

[[contacts]]
slave = "b"

[contacts.friction]
mu = 0.2
"""


def test_lines_of_keys() -> None:
    lines = key_lines(LINED)
    for key, text in {
        "format": "format = 1",
        "time": "[time]",
        "time.end": 'end = "auto"',
        "bodies.disc.mesh": 'mesh = { use = "rectangle", x = [0, 1] }',
        "bodies.disc.velocity": "velocity = [",
        "contacts.0.slave": 'slave = "a"',
        "contacts.1.slave": 'slave = "b"',
        "contacts.1.friction.mu": "mu = 0.2",
    }.items():
        assert LINED.splitlines()[lines[key] - 1] == text
    assert "not.a.table" not in lines


text = st.text(st.characters(codec="utf-8"), max_size=20)
scalar = st.one_of(
    st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), text,
)  # fmt: skip
value = st.recursive(
    scalar, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(text, inner, max_size=3)), max_leaves=8
)


@given(st.dictionaries(text, value, max_size=5))
def test_written_toml_reads_back_exactly(data: dict[str, Any]) -> None:
    """Every key, text and number, to the last bit, at any depth."""
    assert tomllib.loads(write_toml(data)) == data


def test_layout_is_that_of_a_hand_written_scene() -> None:
    data = {"level": 2, "bodies": {"disc": {"mesh": {"use": "r", "cells": [4, 4]}}}, "contacts": [{"a": 1}]}
    rows = ["level = 2", "", "[bodies.disc]", 'mesh = { use = "r", cells = [4, 4] }', "", "[[contacts]]", "a = 1", ""]
    assert write_toml(data).split("\n") == rows
