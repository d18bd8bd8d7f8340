"""The quick matrix: every case with its declared slave, put to the three shipped algorithms.

Both mortars meet every criterion and break no invariant, but for what is listed here with its cause. Silent cells of
any algorithm, results that are wrong and look right, are listed, too. Lists can only shrink: what is met must leave
them. Tests that a cell of this matrix repeats are not written a second time. What a cell finds is also what
build/docs/cases.md says of it, so that the page cannot be of another version.
"""

from __future__ import annotations

import math

import case_rows
import cases_page
import pytest
from tiers import some

from contactlab.api import Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.cases.verdict import Finding, judge
from contactlab.parts.registry import default_registry

SAW = "saw-tooth of the pressure"
COARSE = "the die presses on a few segments of the foundation, with peaks at its edges; the run warns of it"
FEW = "seven nodes of the anvil carry the billet: multipliers swing at its edge; on half the segments they do not"
NOT_MET: dict[tuple[str, str], dict[str, str]] = {
    ("forging", "mortar-p0"): {SAW: FEW},
    ("forging", "mortar-p1"): {SAW: FEW, "saw-tooth of the shear": FEW},
    ("ironing", "mortar-p0"): {SAW: COARSE},
    ("ironing", "mortar-p1"): {SAW: COARSE, "saw-tooth of the shear": COARSE},
    ("lifted-beam", "mortar-p1"): {
        SAW: "a force in one point where the beam leaves the floor: linear multipliers swing"
    },
}
"""Measures of mortars that are not met, by case and algorithm, with the cause."""

SILENT = {
    ("bars-with-gap", "node-on-segment"): (
        "one-pass conditions do not pass a constant pressure between unlike meshes: bars that do not bulge are 1e-4 "
        "too soft, less than a run tells"
    ),
}
"""Cells that are silent, with the cause."""

SHARE = 0.02
"""Of a number and of its bound: how far the page may be off, on another machine."""
ROUND = 1e-12
ON_THE_PAGE = {(row["case"], row["contact"], row["measure"]): row for row in cases_page.stored()}

CASES = default_registry().names("case")
CELLS = [(name, algorithm) for name in CASES for algorithm in ("mortar-p0", "mortar-p1", "node-on-segment")]
EVERY_TIME = {"bars-with-gap", "inclined-layers", "patch", "stuck-rings", "two-rings"}
"""Cases that show what unlike meshes cost node-on-segment, and that its runs tell it; all others with FULL=1."""
BY_NODES = {"rocking-block", "vertex-to-vertex", "pulled-strip"}
"""Cases for which node-on-segment stands in every tier; in all others the mortars take turns (conftest.py)."""
LONG = {
    "block-on-incline": "test_shipped_scenes.py", "bouncing-bar": "test_implicit_dynamics.py",
    "corner-slide": "test_leaning_forces.py",
    "disc-on-block": "test_disc_on_block.py", "disc-with-friction": "test_statics_disc.py",
    "elastic-punch": "the case sliding-punch", "forging": "test_rounded_billet.py",
    "initial-overlap": "test_even_compression.py", "ironing": "test_statics_cases.py", "long-run": "test_energy.py",
    "mesh-ratio": "the case mesh-ladder", "oblique-discs": "test_implicit_curved.py and test_impacts.py",
    "prandtl-punch": "test_laws_runs.py", "resting-block": "test_shipped_scenes.py",
    "rolling-disc": "test_friction_steps.py", "spinning-pair": "test_case_invariance.py",
    "stack": "test_shipped_scenes.py", "stiffness-contrast": "the case unlike-layers", "two-beams": "test_bars.py",
    "wall-impact": "test_bars.py",
}  # fmt: skip
"""Cases that take seconds with a mortar, and the tests or the case that have the like in every tier."""
ALWAYS = [
    (name, algorithm) for name, algorithm in CELLS
    if (name in EVERY_TIME | BY_NODES if algorithm == "node-on-segment" else name not in BY_NODES and name not in LONG)
]  # fmt: skip


def finding(name: str, algorithm: str) -> Finding:
    case = default_registry().make("case", name)
    chosen = Setup(algorithm, element=case.elements[0], integrator=case.integrators[0])
    _, done = run_case(case, chosen)
    return judge(case, chosen, done, evaluated(case, chosen, done))


@pytest.mark.parametrize(("name", "algorithm"), some(CELLS, ALWAYS))
def test_cell_of_the_quick_matrix(name: str, algorithm: str) -> None:
    found = finding(name, algorithm)
    assert_as_on_the_page(name, algorithm, found)
    assert (found.verdict == "silent") == ((name, algorithm) in SILENT), found.reason
    if algorithm != "node-on-segment":
        assert found.status == "finished", found.reason
        missed = {j.measure.name for j in found.judged if j.verdict != "met"}
        assert missed == set(NOT_MET.get((name, algorithm), {}))
    elif name == "forging":
        # nodes of the finer billet are free between those of the anvil, and metal sinks in
        assert "deepest node of the billet in the anvil, in segments" in {
            j.measure.name for j in found.judged if j.verdict == "missed"
        }
    elif name == "nafems-cgs1":
        # forces jump where a node passes a vertex: the run stalls, and says what to try
        assert found.status == "not-converged"
        for words in ("of the load", "residuals of", "another algorithm", "swap"):
            assert words in found.reason


def assert_as_on_the_page(name: str, algorithm: str, found: Finding) -> None:
    """Verdict, and every number of a run that finished; where they differ, `make pages` with a new quick matrix."""
    shown = {key[2]: row for key, row in ON_THE_PAGE.items() if key[:2] == (name, algorithm)}
    assert {row["cell"] for row in shown.values()} == {found.verdict}
    assert {j.measure.name for j in found.judged} == set(shown) - {""}
    for judged in found.judged if found.status == "finished" else ():
        row, (least, most) = shown[judged.measure.name], (judged.measure.least, judged.measure.most)
        assert (row["least"], row["most"]) == (case_rows.short(least), case_rows.short(most))
        assert (row["value"] in ("", "nan")) == math.isnan(judged.value), judged.measure.name
        if not math.isnan(judged.value):
            bound = min(abs(least), abs(most))
            allowed = SHARE * (abs(judged.value) + (bound if math.isfinite(bound) else 0.0)) + ROUND
            assert abs(float(row["value"]) - judged.value) <= allowed, judged.measure.name


def test_lists_name_cells_that_there_are() -> None:
    assert {*SILENT, *NOT_MET} <= set(CELLS)
