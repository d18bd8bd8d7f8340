"""Class attributes with values that the contract does not allow are refused by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from contactlab_dynamics.central_difference import CentralDifference
from contactlab_dynamics.forward_increment import ForwardIncrement
from contactlab_effects.gravity import Gravity
from contactlab_mortar.mortar import MortarP0
from contactlab_quads.q1 import Q1
from contactlab_solids.hypoelastic import Hypoelastic
from contactlab_statics.penalty import Penalty

from contactlab.cli import main
from contactlab.parts.contract import faults
from contactlab.parts.registry import Registry

WRONG = [
    ("element", Q1, "lumping", "row_sum", '"row-sum", "hrz", "quadrature"; did you mean "row-sum"?'),
    ("element", Q1, "lumping", None, '"row-sum", "hrz", "quadrature"'),
    ("element", Q1, "degree", 0, "a whole number of at least 1"),
    ("element", Q1, "degree", 1.0, "a whole number of at least 1"),
    ("element", Q1, "locks", "no", "True or False"),
    ("element", Q1, "edges", [[0, 1]], "a tuple of tuples of whole numbers"),
    ("element", Q1, "nodes", [[-1.0, -1.0]], "a NumPy array of finite float64"),
    ("element", Q1, "without", ("finite strain",), "a table of strings by string"),
    ("material", Hypoelastic, "kinematics", "finit", '"small", "finite", "rate"; did you mean "finite"?'),
    ("material", Hypoelastic, "history_size", -1, "a whole number of at least 0"),
    ("material", Hypoelastic, "history_names", "abcd", "a tuple of strings"),
    ("material", Hypoelastic, "has_energy", 1, "True or False"),
    ("contact", MortarP0, "rows_per_node", 0, "a whole number of at least 1"),
    ("contact", MortarP0, "memory_size", True, "a whole number of at least 0"),
    ("contact", MortarP0, "passes_patch_test", "both", "True or False"),
    ("enforcement", ForwardIncrement, "factored", "yes", "True or False"),
    ("enforcement", Penalty, "augments", 0, "True or False"),
    ("integrator", CentralDifference, "order", 0, "a whole number of at least 1"),
    ("integrator", CentralDifference, "needs", "ExplicitEnforcement", "Enforcement or a class derived from it"),
    ("effect", Gravity, "needs_mass", "always", "True or False"),
]


def changed(base: type, name: str, value: Any) -> type:
    return dataclass(frozen=True)(type("Changed", (base,), {name: value, "__module__": __name__}))


@pytest.mark.parametrize(("base", "name"), [(ForwardIncrement, "conjugate"), (Penalty, "conjugate_in")])
def test_names_that_nothing_reads_any_more_are_refused_with_what_takes_their_place(base: type, name: str) -> None:
    (fault,) = faults("enforcement", changed(base, name, property(lambda part: True)))
    assert fault.startswith(f"it has {name}, which is not read; to change: forces = ")


@pytest.mark.parametrize(("kind", "base", "name", "value", "allowed"), WRONG)
def test_a_wrong_value_is_refused_with_what_is_allowed(
    kind: str, base: type, name: str, value: Any, allowed: str
) -> None:
    found = [fault for fault in faults(kind, changed(base, name, value)) if f"attribute {name} is" in fault]
    assert len(found) == 1
    assert found[0].endswith(f"allowed: {allowed}")


def test_every_number_of_a_history_has_a_name() -> None:
    assert Hypoelastic.history_size != 1
    (fault,) = faults("material", changed(Hypoelastic, "history_names", ("one",)))
    assert "history_names has 1 names" in fault


def test_all_shipped_parts_are_allowed() -> None:
    assert Registry().incomplete() == []


def test_a_misspelt_lumping_is_no_other_mass(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It used to be taken for HRZ lumping, in silence."""
    file = tmp_path / "misspelt.py"
    file.write_text(
        "from dataclasses import dataclass\n"
        "from contactlab.api.plugin import Part, hookimpl\n"
        "from contactlab_quads.q1 import Q1\n\n"
        "@dataclass(frozen=True)\nclass Misspelt(Q1):\n    lumping = 'row_sum'\n\n"
        "@hookimpl\ndef contactlab_parts():\n"
        "    return [Part('element', 'misspelt', 'misspelt:Misspelt', 'wrong')]\n"
    )
    words = ["run", "disc-on-block", "--with", str(file), "--set", "bodies.disc.element=misspelt"]
    assert main([*words, "--out", str(tmp_path / "run")]) == 2
    shown = " ".join(capsys.readouterr().err.split())
    assert 'its class attribute lumping is "row_sum"' in shown
    assert 'did you mean "row-sum"?' in shown
