"""Parts that break the contract end in one message with the part, the method and the line, never in a traceback."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import contactlab.api
from contactlab.cli import main
from contactlab.parts.contract import faults
from contactlab.parts.registry import Registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

SOURCE = """
from dataclasses import dataclass

import numpy as np

from contactlab.api import Shape
from contactlab.api.plugin import Part, hookimpl
from contactlab_mortar.mortar import MortarP0
from contactlab_quads.q1 import Q1
from contactlab_solids.neo_hookean import NeoHookean

MORTAR = MortarP0()  # whose kernels are there: those of a class derived from its own would be compiled
"""

CONTACTS = {
    "raises": (
        "return {}['nothing']",
        r"wrong_parts.py, line \d+, in Raises.pieces: the part raised KeyError: 'nothing'",
    ),
    "form": (
        "out.D[:] = np.zeros((3, 3))",
        r"line \d+, in Form.pieces: the part raised ValueError: could not broadcast",
    ),
    "forgets": (
        "MORTAR.pieces(view, out)",
        "Forgets: pieces gave None, needed: how many",
    ),
    "many": ("return len(out.slave) + 1", r"Many: pieces gave \d+, needed: how many of the \d+ pieces"),
    "outside": (
        "n = MORTAR.pieces(view, out); out.master[:n] += 999; return n",
        r"Outside: pieces filled master with \d+, needed: positions 0 to 12",
    ),
    "negative": (
        "n = MORTAR.pieces(view, out); out.slave[:n] -= 9; return n",
        r"Negative: pieces filled slave with -\d+, needed: positions 0 to 8",
    ),
}
LAWS = {
    "typo": (
        "def stress(self, gradient, history, dt, stress, new_history): stres[0] = 1.0",
        r"in Typo.stress: .* NameError: name 'stres'",
    ),
    "rows": (
        "def stress(self, gradient, history, dt, stress, new_history): stress[:] = np.zeros((3, stress.shape[1]))",
        r"in Rows.stress: the part raised ValueError: could not broadcast input array from shape \(3,",
    ),
    "speed": (
        "def wave_speeds(self): return 1.0",
        "Speed: wave_speeds gave 1.0, needed: a dilatational and a smaller shear",
    ),
    "takes": (
        "def stress(self, gradient, history, stress): pass",
        r"its stress takes \(self, gradient, history, stress\); it is called",
    ),
}
ELEMENTS = {
    "turned": (
        "def shape(self, points): s = super().shape(points); return Shape(s.value, s.gradient.transpose(0, 2, 1))",
        r"Turned: shape gave \(4, 4\) and \(4, 2, 4\), needed: \(4, 4\) and \(4, 4, 2\) for 4 points",
    ),
    "trace": (
        "def edge_shape(self, s): return s, s",
        r"Trace: edge_shape gave \(3,\) and \(3,\), needed: \(3, 2\) twice",
    ),
}


def source() -> str:
    bases = {"contact": "MortarP0", "material": "NeoHookean", "element": "Q1"}
    text, offers = SOURCE, []
    for kind, wrong in (("contact", CONTACTS), ("material", LAWS), ("element", ELEMENTS)):
        for name, (body, _) in wrong.items():
            if kind == "contact":
                body = f"def pieces(self, view, out): {body}"
            text += f"\n\n@dataclass(frozen=True)\nclass {name.title()}({bases[kind]}):\n    {body}\n"
            offers.append(f'Part("{kind}", "{name}", "wrong_parts:{name.title()}", "wrong")')
    return text + f"\n\n@hookimpl\ndef contactlab_parts():\n    return [{', '.join(offers)}]\n"


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    path = tmp_path_factory.mktemp("wrong") / "wrong_parts.py"
    path.write_text(source())
    yield path
    sys.modules.pop("wrong_parts", None)


SMALL = ["--set", "bodies.disc.mesh.cells=[8, 2]", "--set", "bodies.block.mesh.cells=[12, 2]", "--set", "time.end=1e-7"]
CASES = [
    *(("contacts.0.algorithm", name, words) for name, (_, words) in CONTACTS.items()),
    *(("materials.soft.use", name, words) for name, (_, words) in LAWS.items()),
    *(("bodies.disc.element", name, words) for name, (_, words) in ELEMENTS.items()),
]


@pytest.mark.parametrize(("key", "name", "words"), CASES, ids=[name for _, name, _ in CASES])
def test_a_wrong_part_is_refused_with_its_line(
    key: str, name: str, words: str, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["run", "disc-on-block", "--with", str(file), *SMALL, "--set", f"{key}={name}"]) == 2
    shown = capsys.readouterr().err
    assert re.search(words, " ".join(shown.split())), shown
    assert "Traceback" not in shown


def test_a_part_that_raises_later_ends_the_run_as_failed(tmp_path: Path) -> None:
    """What was stored before stays."""
    late = tmp_path / "late_part.py"
    late.write_text(
        SOURCE
        + """
@dataclass(frozen=True)
class Late(NeoHookean):
    def stress(self, gradient, history, dt, stress, new_history):
        super().stress(gradient, history, dt, stress, new_history)
        if abs(gradient).max() > 1.01:
            raise RuntimeError("too much")

@hookimpl
def contactlab_parts():
    return [Part("material", "late", "late_part:Late", "raises in a strained state")]
"""
    )
    registry = Registry(files=[late])
    changes = {"materials.soft.use": "late", "time.end": 8e-6, "record.frames": 100}
    results = simulate(load_scene("disc-on-block", registry).with_(changes), registry=registry)
    sys.modules.pop("late_part", None)
    assert results.status == "failed"
    words = r"step \d+: .*late_part.py, line \d+, in Late.stress: the part raised RuntimeError: too much"
    assert re.fullmatch(words, results.reason), results.reason
    assert len(results.history["time"]) >= 1


@pytest.mark.parametrize(
    ("kind", "base", "names", "told"),
    [
        (
            "material",
            "Material",
            {"memory": ("m",)},
            "its memory is not read from a part of this kind; allowed: history",
        ),
        ("contact", "GapAlgorithm", {"memory": ("m",)}, "its memory is not read .* allowed: memory_size"),
        ("effect", "Effect", {"needs": ("time",)}, "its needs name time; .* is called with it"),
        ("material", "Material", {"needs": ("slip_rate",)}, "its needs name slip_rate; .* surfaces slip"),
        ("contact", "GapAlgorithm", {"needs": ("dt",)}, "its needs is not read .* friction and pressure laws"),
        ("enforcement", "NormalLaw", {"memory": ("m",)}, "it has memory but no evolve"),
        ("enforcement", "ImplicitEnforcement", {"memory": ("m",)}, "its memory is not read .* allowed: none"),
    ],
)
def test_needs_and_memory_that_nobody_reads_are_refused(kind: str, base: str, names: dict[str, str], told: str) -> None:
    part = type("Mine", (getattr(contactlab.api, base),), names)
    assert any(re.match(told, fault) for fault in faults(kind, part))
