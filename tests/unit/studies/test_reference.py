"""References hold for the scenes they say, and say how good they are."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from contactlab.errors import RequestError
from contactlab.results.results import ContactCurve
from contactlab.scene.scene import load_scene
from contactlab.studies.find_reference import matching_reference
from contactlab.studies.make_reference import holds_for, limit, make_reference, mean_curve
from contactlab.studies.plan import make_plan
from contactlab.studies.profile import Profile, distance, integral, norm
from contactlab.studies.reference import bundled, load_reference
from contactlab.studies.study import Study, bundled_studies
from contactlab.studies.table import Row, Table

SHALLOW = {"supports.1.uy.to": -0.01}


@pytest.mark.parametrize("name", list(bundled()))
class TestEveryBundledReference:
    def test_says_what_it_is_and_how_good(self, name: str) -> None:
        reference = load_reference(name)
        assert reference.name == name
        assert len(reference.origin) > 40
        assert 0.0 < reference.pressure_uncertainty < 0.02
        assert reference.error_estimate["meaning"]
        assert reference.holds_for

    def test_its_pressure_carries_its_reaction(self, name: str) -> None:
        # The vertical force is the integral of the pressure over x, whatever the slope of the surface.
        reference = load_reference(name)
        force, error = reference.scalar("reaction"), reference.scalars["reaction"]["error"]
        allowed = error + reference.pressure_uncertainty * force
        assert integral(reference.profile) == pytest.approx(force, abs=allowed)

    def test_it_is_symmetric(self, name: str) -> None:
        profile = load_reference(name).profile
        assert distance(profile, profile.mirrored()) <= 1e-5 * integral(profile)  # written with six digits


def test_half_a_curve_is_mirrored_about_its_middle() -> None:
    profile = load_reference("disc-on-block-shallow-other-code").profile
    assert profile.x[0] == -profile.x[-1]
    assert np.count_nonzero(profile.x == 0.0) == 1


def test_own_runs_and_the_other_code_agree_within_their_errors() -> None:
    own, other = (load_reference(f"disc-on-block-shallow{code}") for code in ("", "-other-code"))
    known = own.pressure_uncertainty + other.pressure_uncertainty
    assert distance(own.profile, other.profile) <= known * norm(own.profile)
    errors = own.scalars["reaction"]["error"] + other.scalars["reaction"]["error"]
    assert own.scalar("reaction") == pytest.approx(other.scalar("reaction"), abs=errors)


def test_a_reference_holds_for_its_scene_and_no_other() -> None:
    scene = load_scene("disc-on-block").with_(SHALLOW)
    found = matching_reference(scene.data)
    assert found is not None
    assert found.name == "disc-on-block-shallow"
    stored = load_reference("disc-on-block-shallow")
    assert found.pressure_uncertainty == stored.pressure_uncertainty
    assert found.scalars["reaction"] == stored.scalars["reaction"]
    for key, value in [
        ("supports.1.uy.to", -0.0100001),
        ("materials.soft.young", 7001.0),
        ("materials.steel.use", "linear-elastic"),
        ("bodies.block.mesh.y", [-0.31, 0.0]),
        ("contacts.0.slave", "disc.top"),
    ]:
        changed = scene.with_({key: value}).data
        assert key in stored.mismatch(changed)
        assert matching_reference(changed) is None


@pytest.mark.parametrize(
    "free",
    [
        {"level": 4},
        {"contacts.0.swap": True},
        {"contacts.0.algorithm": "node-on-segment"},
        {"materials.soft.density": 1e-9},
        {"bodies.disc.mesh.cells": [30, 8]},
        {"time.end": 1e-4},
    ],
)
def test_meshes_algorithms_and_time_are_free(free: dict[str, object]) -> None:
    scene = load_scene("disc-on-block").with_(SHALLOW).with_(free)
    assert matching_reference(scene.data) is not None


def test_no_run_is_measured_against_a_mean_of_runs_as_fine_as_itself() -> None:
    stored = load_reference("disc-on-block-deep")
    assert stored.level is not None
    scene = load_scene("disc-on-block")
    assert stored.mismatch(scene.with_({"level": stored.level // 2}).data) == ""
    for level in (stored.level, 2 * stored.level):
        assert f"level {stored.level}" in stored.mismatch(scene.with_({"level": level}).data)
    assert matching_reference(scene.with_({"level": stored.level}).data) is None


def test_null_means_absent() -> None:
    reference = load_reference("disc-on-block-shallow")
    data = load_scene("disc-on-block").with_(SHALLOW).data
    data["contacts"][0]["friction"] = {"use": "coulomb", "mu": 0.2}
    assert "contacts.0.friction" in reference.mismatch(data)


def test_a_file_that_is_no_reference_says_what_is_missing(tmp_path: Path) -> None:
    (tmp_path / "bad.json").write_text('{"name": "bad", "curve": "c.csv"}')
    with pytest.raises(RequestError, match="cannot be read") as caught:
        load_reference("bad.json", beside=tmp_path)
    assert "columns" in str(caught.value)


def test_a_curve_that_runs_backwards_is_refused(tmp_path: Path) -> None:
    columns = {"x": "x", "pressure": "p", "spread": "s"}
    data = {"name": "n", "title": "t", "origin": "o", "curve": "c.csv", "columns": columns}
    (tmp_path / "r.json").write_text(json.dumps(data))
    (tmp_path / "c.csv").write_text("x,p,s\n1,1,0\n0,1,0\n")
    with pytest.raises(RequestError) as caught:
        load_reference(str(tmp_path / "r.json"))
    assert "x must increase" in str(caught.value)


class TestMaking:
    def test_geometric_convergence_is_extrapolated_exactly(self) -> None:
        values = [10.0 + 3.0 * level**-1.7 for level in (2, 4, 8)]
        found, error = limit(values, (2, 4, 8))
        assert found == pytest.approx(10.0, rel=1e-12)
        assert error == pytest.approx(values[-1] - 10.0, rel=1e-9)

    @pytest.mark.parametrize(
        ("values", "levels"), [((9.0, 10.5, 10.2), (2, 4, 8)), ((9.0, 9.9, 10.2), (2, 4, 6)), ((9.9, 10.2), (4, 8))]
    )
    def test_other_sequences_are_not(self, values: tuple[float, ...], levels: tuple[int, ...]) -> None:
        assert limit(values, levels) == (10.2, pytest.approx(abs(values[-1] - values[-2])))

    def test_the_curve_is_the_mean_and_its_error_the_larger_difference(
        self, curve_of: Callable[..., ContactCurve]
    ) -> None:
        x = np.linspace(-1.0, 1.0, 201)
        parabola = np.maximum(0.0, 1.0 - (x / 0.8) ** 2)
        factors = {("a", 2): 0.99, ("b", 2): 1.01, ("a", 1): 1.04, ("b", 1): 1.06}
        rows = [
            Row(f"{algorithm}{level}", algorithm, "disc", level, {}, "finished", "", curve=curve_of(x, f * parabola))
            for (algorithm, level), f in factors.items()
        ]
        table = Table(rows, Study(scene="s"), None, {"symmetry": "x"})
        curve, error = mean_curve(table, [1, 2])
        assert np.allclose(curve.pressure, Profile(x, parabola)(curve.x), atol=1e-12)
        assert np.allclose(curve.spread, 0.01 * curve.pressure, atol=1e-12)
        assert np.allclose(curve.refinement, 0.05 * curve.pressure, atol=1e-12)
        assert error == pytest.approx(0.05, rel=1e-9)

    @pytest.mark.parametrize(
        ("factors", "expected"),
        [
            # each run is compared with the mean of all others, in which it has no part
            ({("a", 4): 1.03, ("b", 4): 0.985, ("c", 4): 0.985, ("a", 2): 1.0, ("b", 2): 1.0, ("c", 2): 1.0}, 0.045),
            # a small change after a large one is a chance: first order leaves half of the large one
            ({("a", 4): 1.0, ("a", 2): 1.01, ("a", 1): 1.09}, 0.04),
            ({("a", 4): 1.0, ("a", 2): 1.06, ("a", 1): 1.09}, 0.06),
        ],
    )
    def test_no_run_vouches_for_itself(
        self, factors: dict[tuple[str, int], float], expected: float, curve_of: Callable[..., ContactCurve]
    ) -> None:
        x = np.linspace(-1.0, 1.0, 201)
        parabola = np.maximum(0.0, 1.0 - (x / 0.8) ** 2)
        rows = [
            Row(f"{algorithm}{level}", algorithm, "disc", level, {}, "finished", "", curve=curve_of(x, f * parabola))
            for (algorithm, level), f in factors.items()
        ]
        levels = sorted({level for _, level in factors})
        error = mean_curve(Table(rows, Study(scene="s"), None, {}), levels)[1]
        assert error == pytest.approx(expected, rel=1e-3)  # by interpolation

    def test_an_edge_of_contact_is_followed_to_its_root(self, curve_of: Callable[..., ContactCurve]) -> None:
        """Best approximations of p = (a^2 - x^2)^(1/2) on meshes in which a lies somewhere else each time."""
        at = np.linspace(-1.0, 1.0, 20001)
        exact = Profile(at, np.sqrt(np.maximum(0.64 - at**2, 0.0)))
        rows, raw = [], []
        for name, level in (("a", 8), ("b", 8), ("a", 4), ("b", 4)):
            x = np.linspace(-1.0, 1.0, (15 if name == "a" else 17) * level)
            shapes = np.stack([np.interp(at, x, unit) for unit in np.eye(len(x))])
            curve = curve_of(x, np.linalg.solve(shapes @ shapes.T, shapes @ exact.value))
            rows.append(Row(f"{name}{level}", name, "disc", level, {}, "finished", "", curve=curve))
            raw.append(distance(Profile.of_curve(curve), exact) / norm(exact))
        made, error = mean_curve(Table(rows, Study(scene="s"), None, {}), [4, 8])
        left = distance(Profile(made.x, made.pressure), exact) / norm(exact)
        assert left < 0.1 * min(raw)
        assert left < error

    def test_a_made_reference_holds_for_its_own_scene(self) -> None:
        scene = load_scene("disc-on-block")
        keys = holds_for(scene.data)
        assert keys["supports.1.uy.to"] == -0.1581
        assert keys["contacts.0.friction"] is None
        assert not any("cells" in key or "density" in key or "algorithm" in key for key in keys)

    def test_one_level_is_not_enough(self, tmp_path: Path, fake_runs: object) -> None:
        recipe = tmp_path / "r.toml"
        recipe.write_text('scene = "disc-on-block"\n[vary]\nlevel = [1]\n"contacts.0.algorithm" = ["mortar-p0"]\n')
        with pytest.raises(RequestError, match="one level"):
            make_reference(recipe, tmp_path, jobs=1)

    def test_several_answers_are_too_many(self, tmp_path: Path) -> None:
        recipe = tmp_path / "r.toml"
        recipe.write_text('scene = "disc-on-block"\n[vary]\nlevel = [1, 2]\n"supports.1.uy.to" = [-0.01, -0.02]\n')
        with pytest.raises(RequestError, match="different answers") as caught:
            make_reference(recipe, tmp_path, jobs=1)
        assert "supports.1.uy.to" in str(caught.value)

    def test_what_a_recipe_sets_is_held_for(self, tmp_path: Path, fake_runs: object) -> None:
        recipe = tmp_path / "set.toml"
        recipe.write_text('scene = "disc-on-block"\n[vary]\nlevel = [1, 3]\n"supports.1.uy.to" = [-0.01]\n')
        reference = load_reference(str(make_reference(recipe, tmp_path / "out", jobs=1)))
        assert reference.mismatch(load_scene("disc-on-block").with_(SHALLOW).data) == ""
        assert "supports.1.uy.to" in reference.mismatch(load_scene("disc-on-block").data)

    def test_what_is_written_reads_back_and_holds(self, tmp_path: Path, fake_runs: object) -> None:
        recipe = tmp_path / "fake.toml"
        recipe.write_text(
            'name = "made up"\nscene = "disc-on-block"\n[vary]\nlevel = [1, 3]\n'
            '"contacts.0.algorithm" = ["mortar-p0", "mortar-p1"]\n"contacts.0.swap" = [false, true]\n'
        )
        path = make_reference(recipe, tmp_path / "out", jobs=2)
        reference = load_reference(str(path))
        assert (reference.name, reference.title) == ("fake", "made up")
        assert reference.scalar("reaction") == 50.0
        assert reference.mismatch(load_scene("disc-on-block").data) == ""
        assert "supports.1.uy.to" in reference.mismatch(load_scene("disc-on-block").with_(SHALLOW).data)


@pytest.mark.parametrize("name", list(bundled_studies()))
def test_the_reference_of_a_bundled_study_holds_for_its_runs(name: str) -> None:
    plan = make_plan(name)
    assert plan.study.reference is not None
    reference = load_reference(plan.study.reference)
    assert [reference.mismatch(job.scene.data) for job in plan.jobs] == [""] * len(plan.jobs)
