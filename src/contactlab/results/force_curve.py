"""Force against displacement: the curve of a support or a contact, from the history of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.errors import RequestError, did_you_mean

if TYPE_CHECKING:
    from contactlab.api.drawing.units import Units

ROUND_OFF = 1e-9  # of the largest motion
COMPONENTS = ("x", "y", "magnitude")
IN_TIME, QUASI_STATIC, THE_END_ONLY = "in time", "quasi-static", "the end only"
"""Force-displacement curve of a run, the entry `history.curve` of `summary.json`."""


@dataclass(frozen=True)
class ForceCurve:
    """The way of one run.

    on            whose force it is: a support or a contact
    moved         the support whose displacement is the abscissa; empty: nothing is moved, it is `share`
    component     of displacement and force, "x" or "y"; of the force also "magnitude"
    sign          1 or -1: both are counted along the motion, so that a force that resists it is positive
    displacement  (frames,) [mm]
    force         (frames,) [N/mm]
    time, share   (frames,) [s], and of the loading (statics) or of time, 0 to 1
    equilibrium   False if only the final state is in equilibrium
    """

    on: str
    moved: str
    along: str
    component: str
    sign: float
    displacement: Floats
    force: Floats
    time: Floats
    share: Floats
    equilibrium: bool

    @property
    def x(self) -> Floats:
        """The abscissa: displacement, or percent of the loading if nothing is moved."""
        return self.displacement if self.moved else 100.0 * self.share

    def labels(self, units: Units) -> tuple[str, str]:
        """Labels of abscissa and ordinate."""
        length, force = (f" [{unit}]" if unit else "" for unit in (units.length, units.line_force))
        arrow = "-" if self.sign < 0.0 else ""
        x = f"displacement of {self.moved} along {arrow}{self.along}{length}" if self.moved else "share of the load [%]"
        along = "" if self.component == "magnitude" else f" along {arrow}{self.component}"
        return x, f"force of {self.on}{along}{force}"


def force_curve(history: Mapping[str, Floats], on: str, summary: Mapping[str, Any], component: str = "") -> ForceCurve:
    """The curve of a support or contact; of the driven support if `on` is empty.

    component  of the force: "x", "y" or "magnitude"; not given: along the motion. Raises RequestError.
    """
    names = [name.removesuffix(".fx") for name in history if name.endswith(".fx")]
    supports = [name for name in names if f"{name}.ux" in history]
    if not names or not len(history.get("time", ())):
        raise RequestError("the run has no force: neither supports nor contacts", where="plot force")
    if on and on not in names:
        raise RequestError(
            "no such support or contact", where="plot force", got=on, allowed=", ".join(names),
            hint=did_you_mean(on, names),
        )  # fmt: skip
    if component and component not in COMPONENTS:
        raise RequestError("no such component", where="plot force", got=component, allowed=", ".join(COMPONENTS))
    moved, along = _motion(history, [on] if on in supports else supports) or _motion(history, supports) or ("", "")
    on = on or moved or _strongest(history, names)
    component = component or along or max("xy", key=lambda c: float(np.abs(history[f"{on}.f{c}"]).max(initial=0.0)))
    if component == "magnitude":
        force = np.hypot(history[f"{on}.fx"], history[f"{on}.fy"])
    else:
        force = history[f"{on}.f{component}"]
    displacement = history[f"{moved}.u{along}"] if moved else np.zeros_like(force)
    sign = -1.0 if moved and displacement[np.argmax(np.abs(displacement))] < 0.0 else 1.0
    own = sign if component in ("x", "y") else 1.0
    equilibrium = summary.get("history", {}).get("curve") != THE_END_ONLY
    share = history.get("share", np.full(len(force), np.nan))
    return ForceCurve(
        on, moved, along, component, sign, sign * displacement, own * force, history["time"], share, equilibrium
    )


def _motion(history: Mapping[str, Floats], supports: list[str]) -> tuple[str, str] | None:
    """The support and direction of the largest motion that meets a force; None if there is none beyond round-off.

    Free directions have no force. The mean displacement of a support that turns about its centre is round-off.
    """
    ranges = {(on, c): float(np.ptp(history[f"{on}.u{c}"])) for on in supports for c in "xy"}
    driven = {(on, c): size for (on, c), size in ranges.items() if np.any(history[f"{on}.f{c}"])}
    found = max(driven, key=lambda key: driven[key], default=None)
    motions = [float(np.ptp(values)) for name, values in history.items() if name.endswith((".ux", ".uy"))]
    largest = max(motions, default=0.0)
    return found if found is not None and driven[found] > ROUND_OFF * largest else None


def _strongest(history: Mapping[str, Floats], names: list[str]) -> str:
    return max(names, key=lambda on: float(np.hypot(history[f"{on}.fx"], history[f"{on}.fy"]).max(initial=0.0)))
