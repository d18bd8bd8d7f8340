"""Overlaps before the run: refused, ramped or adjusted, as the scene says."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.errors import SceneError
from contactlab.meshing.mesh import inverted_cells

ALGORITHMS = ("node-on-segment", "mortar-p0", "mortar-p1")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("depth", [1e-5, 0.005, 0.4])
def test_an_overlap_is_refused_with_its_depth(make, algorithm: str, depth: float) -> None:
    with pytest.raises(SceneError, match="overlap") as caught:
        make({"bodies.upper.shift": [0.0, -depth], "contacts.0.algorithm": algorithm})
    assert "contacts.0" in str(caught.value)
    assert f"{depth:.4g} mm" in str(caught.value)
    assert '{ overlap = "adjust" }' in str(caught.value)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("gap", [0.0, 1e-12, -1e-9, 0.01])
def test_touching_and_open_surfaces_are_accepted(make, algorithm: str, gap: float) -> None:
    assert make({"bodies.upper.shift": [0.0, gap], "contacts.0.algorithm": algorithm}).contact is not None


def test_matching_arcs_with_other_chords_do_not_overlap(make) -> None:
    """A disc in a socket of its own radius: its chords cut into the disc, and are no overlap."""
    socket = {"arc": {"centre": [0.0, 0.0], "radius": 1.0, "angles": [340.0, 200.0]}, "segment": 0.11}
    disc = {"use": "disc", "radius": 1.0, "cells": [8, 3]}
    model = make(
        {"bodies.upper.mesh": disc},
        contacts=[
            {"slave": "upper.bottom", "master": "socket", "algorithm": "mortar-p1", "start": {"overlap": "adjust"}}
        ],
        rigid={"socket": socket},
    )
    assert model.contact is not None


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_adjusted_nodes_lie_on_the_master_without_strain(make, algorithm: str, turn: float) -> None:
    """Every gap is zero to round-off afterwards, in the undeformed mesh, and only the slave's nodes have moved."""
    changes = {
        "contacts.0.algorithm": algorithm,
        "contacts.0.start": {"overlap": "adjust", "gap": 0.02},
        "bodies.upper.rotate": turn,
        "bodies.lower.rotate": turn,
    }
    axis = np.array([-np.sin(np.radians(turn)), np.cos(np.radians(turn))])
    for offset in (-0.01, 0.01):
        model = make({**changes, "bodies.upper.shift": (offset * axis).tolist()})
        pair = model.contact.pairs[0]
        pair.update(model.reference, np.zeros((2, len(pair.slave.nodes))))
        pair.compute_gaps(model.reference)
        gaps = pair.gaps[:, 0]
        assert np.abs(gaps[gaps < 1e299]).max() < 1e-11
        assert np.abs(model.state["internal_force"]).max() == 0.0
        moved = (
            model.reference[: model.bodies[0].count]
            - make(
                {
                    **changes,
                    "contacts.0.start": {"overlap": "refuse"},
                    "bodies.upper.shift": (0.05 * axis).tolist(),
                }
            ).reference[: model.bodies[0].count]
            - (offset - 0.05) * axis
        )
        inner = np.setdiff1d(np.arange(model.bodies[0].count), pair.slave.nodes)
        assert np.abs(moved[inner]).max() < 1e-14
        assert not len(inverted_cells(model.bodies[0].mesh, model.bodies[0].element))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_nodes_far_from_the_origin_are_adjusted_to_what_positions_resolve(make, algorithm: str) -> None:
    far, (x, y), turn = np.array([1e6, -2e6]), (-np.sin(0.5), np.cos(0.5)), np.degrees(0.5)
    model = make(
        {
            "contacts.0.algorithm": algorithm,
            "contacts.0.start": {"overlap": "adjust"},
            "bodies.upper.rotate": turn,
            "bodies.lower.rotate": turn,
            "bodies.upper.shift": [far[0] - 0.01 * x, far[1] - 0.01 * y],
            "bodies.lower.shift": far.tolist(),
        }
    )
    pair = model.contact.pairs[0]
    pair.update(model.reference, np.zeros((2, len(pair.slave.nodes))))
    pair.compute_gaps(model.reference)
    gaps = pair.gaps[:, 0]
    assert np.abs(gaps[gaps < 1e299]).max() < 1e-8  # positions of 2e6 are multiples of 2e-10


def test_an_adjustment_leaves_wider_gaps_alone(make) -> None:
    model = make({"contacts.0.start": {"overlap": "adjust", "gap": 0.02}, "bodies.upper.shift": [0.0, 0.03]})
    pair = model.contact.pairs[0]
    assert pair.gaps[:, 0] == pytest.approx(np.full(5, 0.03))


def test_an_overlap_deeper_than_a_segment_is_beyond_treatment(make) -> None:
    """The blocks are 1 high with segments of 0.5."""
    for treatment in ("ramp", "adjust"):
        with pytest.raises(SceneError, match="overlap by more than a segment"):
            make({"bodies.upper.shift": [0.0, -0.6], "contacts.0.start": {"overlap": treatment}})


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_ramped_overlap_counts_as_zero_first_and_in_full_later(make, algorithm: str) -> None:
    model = make(
        {
            "contacts.0.algorithm": algorithm,
            "contacts.0.start": {"overlap": "ramp", "duration": 8e-4},
            "bodies.upper.shift": [0.0, -0.01],
            "time.step": 1e-6,
        }
    )
    pair, memory = model.contact.pairs[0], np.zeros((2, len(model.contact.pairs[0].slave.nodes)))
    found = []
    for time in (0.0, 4e-4, 8e-4, 1e-3):
        model.state["clock"][0] = time
        pair.update(model.reference, memory)
        pair.compute_gaps(model.reference)
        found.append(pair.gaps[: len(pair.slave.nodes), 0].min())
    assert found == pytest.approx([0.0, -0.005, -0.01, -0.01], abs=1e-14)


def test_a_ramp_of_fewer_than_a_hundred_steps_is_refused(make) -> None:
    with pytest.raises(SceneError, match="steps") as caught:
        make({"contacts.0.start": {"overlap": "ramp", "duration": 9.9e-5}, "time.step": 1e-6})
    assert "contacts.0.start.duration" in str(caught.value)
