"""Measures of the accuracy of a contact pressure: errors, asymmetries, oscillation, edges.

All of them compare linear interpolants over the deformed x, for P0 and P1 multipliers alike.
Every measure is NaN if it has no meaning (no pressure at all, no edge).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.studies.profile import Profile, Window, distance, norm

EDGE_LEVEL = 0.05
"""Pressure, as a share of the largest one, at which the edge of contact is read. Above the small
over- and undershoot that the weak contact cone allows next to the edge."""


def pressure_error(profile: Profile, reference: Profile, window: Window | None = None) -> float:
    """Relative L2 distance ||p - r|| / ||r|| over the window, or over all x."""
    return _ratio(distance(profile, reference, window), norm(reference, window))


def largest_pressure_error(profile: Profile, reference: Profile, window: Window | None = None) -> float:
    """Largest nodal |p - r| / max r at nodes two segments or more inside the reference's edge of contact."""
    edges = reference.edges(EDGE_LEVEL * _peak(reference))
    if edges is None:
        return np.nan
    margins = [2.0 * profile.spacing_at(edge) for edge in edges]
    inside = (profile.x >= edges[0] + margins[0]) & (profile.x <= edges[1] - margins[1])
    if window is not None:
        inside &= (profile.x >= window[0]) & (profile.x <= window[1])
    if not inside.any():
        return np.nan
    errors = np.abs(profile.value[inside] - reference(profile.x[inside]))
    return float(errors.max() / _peak(reference))


def mutual_difference(a: Profile, b: Profile) -> float:
    """2 ||p_a - p_b|| / (||p_a|| + ||p_b||): the swap asymmetry S when a and b are the two choices of slave."""
    return _ratio(2.0 * distance(a, b), norm(a) + norm(b))


def mirror_asymmetry(profile: Profile, axis: float = 0.0) -> float:
    """||p(x) - p(2 axis - x)|| / ||p||: zero for a result as symmetric as its scene."""
    return _ratio(distance(profile, profile.mirrored(axis)), norm(profile))


def second_differences(values: Floats) -> float:
    """sum |p_{k-1} - 2 p_k + p_{k+1}| / sum |p_k|."""
    return _ratio(float(np.abs(np.diff(values, 2)).sum()), float(np.abs(values).sum()))


def oscillation(profile: Profile, reference: Profile) -> float:
    """O: second differences of the nodal pressures, less the reference's at the same nodes."""
    return second_differences(profile.value) - second_differences(reference(profile.x))


def turning_points(values: Floats) -> int:
    """Sign changes of the first differences; equal neighbours do not count."""
    steps = np.diff(values)
    signs = np.sign(steps[steps != 0.0])
    return int(np.count_nonzero(signs[1:] != signs[:-1]))


def excess_turning_points(profile: Profile, reference: Profile) -> int:
    """Turning points of the nodal pressures, less the reference's at the same nodes."""
    return turning_points(profile.value) - turning_points(reference(profile.x))


def edge_error(profile: Profile, reference: Profile) -> float:
    """Largest distance between the edges of contact, in lengths h of the segment at the edge.

    At an edge the pressure reaches `EDGE_LEVEL` of the largest reference pressure.
    """
    level = EDGE_LEVEL * _peak(reference)
    found, wanted = profile.edges(level), reference.edges(level)
    if found is None or wanted is None:
        return np.nan
    return max(abs(f - w) / profile.spacing_at(f) for f, w in zip(found, wanted, strict=True))


def relative_difference(a: float, b: float) -> float:
    """2 |a - b| / (|a| + |b|), for two results of equal standing."""
    return _ratio(2.0 * abs(a - b), abs(a) + abs(b))


def _peak(profile: Profile) -> float:
    return float(profile.value.max(initial=0.0)) or np.nan


def _ratio(numerator: float, denominator: float) -> float:
    return numerator / denominator if denominator > 0.0 else np.nan
