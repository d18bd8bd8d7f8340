"""Contacts with gaps between smooth surfaces: which contacts allow them."""

from __future__ import annotations

from typing import Any

from contactlab.api import ContactMethod, Enforcement, NormalLaw, SegmentContact, Surface
from contactlab.errors import PartError, SceneError, Where, below
from contactlab.parts.registry import split_spec


def refuse_smooth(
    algorithm: ContactMethod, spec: Any, sides: tuple[Surface, Surface], enforcement: Enforcement, where: Where
) -> None:
    """Raise PartError or SceneError for a contact that cannot measure gaps between curves."""
    if not isinstance(algorithm, SegmentContact):
        raise PartError(
            "smooth surfaces are for algorithms that integrate over segments",
            where=below(where, "smooth"), got=f"true, with {split_spec('contact', spec.algorithm, where)[0]}",
            allowed="true with mortar-p0, mortar-p1, mortar-dual, or false",
        )  # fmt: skip
    if any(side.edges.shape[1] == 3 for side in sides):
        raise SceneError(
            "smooth surfaces are for edges of two nodes: second-order elements have curved edges already",
            where=below(where, "smooth"), got="true", allowed="false, or elements of first order on both sides",
        )  # fmt: skip
    if isinstance(enforcement, NormalLaw):
        raise SceneError(
            "gaps between smooth surfaces are held by multipliers: a pressure law stores energy of gaps along which "
            "its forces would not act",
            where=below(where, "smooth"), got=f"true, with {split_spec('enforcement', spec.enforcement, where)[0]}",
            allowed="true with the integrator's own enforcement, or false",
        )  # fmt: skip
    if enforcement.forces in ("consistent", "conjugate"):
        raise SceneError(
            "forces between smooth surfaces act as between segments, not along derivatives of their gaps, "
            "which would load nodes at ends of surfaces and of unlike length wrongly",
            where=below(where, "smooth"), got=f'true, with forces = "{enforcement.forces}"',
            allowed='true with forces = "frozen", or false',
            hint='write forces = "frozen" in the enforcement of the contact, or in the integrator central-difference',
        )  # fmt: skip
