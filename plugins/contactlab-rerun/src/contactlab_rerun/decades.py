"""Signed lengths by their powers of ten: shades of pictures and heights of curves, as gaps span ten decades."""

from __future__ import annotations

import numpy as np

from contactlab.api.frame import ContactLayout
from contactlab_rerun.gathered import Gathered

SHADES = 10


def shade_levels(lengths: np.ndarray, largest: float) -> np.ndarray:
    """Colours (n, m) of lengths [mm] by their powers of ten below `largest`: 0 where there is no length (NaN)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        power = np.clip(np.floor(-np.log10(np.abs(lengths) / largest)), 0, SHADES - 1)
    first = np.where(lengths < 0.0, 1, 1 + SHADES)
    return np.asarray(np.where(np.isnan(lengths), 0, first + np.nan_to_num(power)), np.uint8)


def heights(lengths: np.ndarray, least: float) -> np.ndarray:
    """Powers of ten of lengths [mm] over `least`, with their sign; 0 for all that are smaller."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.sign(lengths) * np.maximum(0.0, np.log10(np.abs(lengths) / least)))


def segment_length(run: Gathered, contact: ContactLayout) -> float:
    """Mean distance [mm] between the ends of a slave segment."""
    ends = run.layout.nodes[contact.slave_nodes][contact.slave_segments[:, [0, -1]]]
    return float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).mean())


def _shades(strong: tuple[int, ...]) -> list[str]:
    """Shades from a strong colour for large lengths to a dark one for lengths of a converged step."""
    shares = np.linspace(1.0, 0.12, SHADES)
    return ["#" + "".join(f"{round(share * part + (1.0 - share) * 44):02x}" for part in strong) for share in shares]


NEGATIVE, POSITIVE = _shades((255, 92, 60)), _shades((92, 176, 255))
