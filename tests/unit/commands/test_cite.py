"""What to cite: sources of all parts of a run or a comparison, in full where the work is known."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from inline import runs_inline

from contactlab import compare, load_scene, simulate
from contactlab.cli import main
from contactlab.parts.registry import default_registry
from contactlab.reports.literature import works

SHORT = {"time.end": 1e-8, "record.recorders": ["vtkhdf"]}
HALLQUIST = "Hallquist, Goudreau & Benson 1985"


def _cited(folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    capsys.readouterr()
    assert main(["cite", str(folder), "--json"]) == 0
    found: dict[str, object] = json.loads(capsys.readouterr().out)
    return found


def test_a_run_names_scene_parts_and_works(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulate(load_scene("disc-on-block").with_(SHORT), out=tmp_path / "run")
    found = _cited(tmp_path / "run", capsys)
    assert found["scene"] == {"name": "disc-on-block", "source": "Baillet & Sassi 2005, test 1"}
    parts = {part["name"]: part["cite"] for part in found["parts"]}  # type: ignore[attr-defined]
    assert parts["mortar-p0"] == "Baillet & Sassi 2005"
    assert parts["neo-hookean"] == "Bonet & Wood 2008, 6.4.3"
    assert "Revue Européenne" in found["literature"]["Baillet & Sassi 2005"]  # type: ignore[index]


@pytest.mark.full
def test_a_comparison_names_the_parts_of_all_its_runs_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    algorithms = ["node-on-segment", "mortar-p1"]
    with runs_inline(report=False):
        compare(
            load_scene("disc-on-block").with_(SHORT), {"contacts.0.algorithm": algorithms}, out=tmp_path / "two", jobs=1
        )
    found = _cited(tmp_path / "two", capsys)
    names = [part["name"] for part in found["parts"]]  # type: ignore[attr-defined]
    assert set(algorithms) < set(names)
    assert len(names) == len(set(names))
    assert {HALLQUIST, "Baillet & Sassi 2005"} <= set(found["literature"])  # type: ignore[call-overload]
    assert main(["cite", str(tmp_path / "two")]) == 0
    assert "Sliding interfaces with contact-impact" in capsys.readouterr().out


def test_every_source_of_a_shipped_part_is_known_in_full() -> None:
    """Each work that a part of the core or of a shipped plugin names by authors and year has its full reference."""
    offers = [offer for offer in default_registry().parts() if offer.origin.distribution.startswith("contactlab")]
    named = {
        work.strip()
        for offer in offers
        if offer.part.kind not in ("case", "measure")
        for work in offer.part.reference.split(";")
        if work.strip()
    }
    assert named
    assert not [work for work in named if not works([work])]


def test_a_scene_is_cited_in_bibtex(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Entries for program and works; a source that is no known work stays as a comment. No run is needed."""
    bundled = load_scene("disc-on-block").toml()
    (tmp_path / "own.toml").write_text(bundled.replace("Baillet & Sassi 2005, test 1", "Laboratory book 7"))
    assert main(["cite", str(tmp_path / "own.toml"), "--bibtex"]) == 0
    entries = capsys.readouterr().out.strip().split("\n\n")
    assert entries[0].startswith("@software{contactlab,")
    bonet = """@book{BonetWood2008,
  author = {Bonet, J. and Wood, R. D.},
  title = {{Nonlinear Continuum Mechanics for Finite Element Analysis}},
  edition = {2nd},
  publisher = {Cambridge University Press},
  year = {2008},
}"""
    assert bonet in entries
    assert any("pages = {287--304}," in entry for entry in entries)
    assert entries[-1] == "% scene disc-on-block: Laboratory book 7"


@pytest.mark.parametrize("content", ["", "{", '{"parts": 3}', "[]"])
def test_other_folders_are_refused(content: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if content:
        (tmp_path / "summary.json").write_text(content, encoding="utf-8")
    assert main(["cite", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert str(tmp_path) in told
    assert "allowed  the folder of a run or a comparison, a bundled scene, or a TOML file" in told
