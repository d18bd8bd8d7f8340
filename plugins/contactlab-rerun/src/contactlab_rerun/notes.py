"""What is told in words: lanes of contact states, events, and the page about the scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr

from contactlab.api.colours import STATES as COLOURS
from contactlab.api.colours import rgb
from contactlab.api.frame import OPEN, SLIP, STATES, STICK, ContactCurve, ContactLayout, Event, Layout
from contactlab_rerun.gathered import Gathered, Instant, Look, short
from contactlab_rerun.series import times

LEVELS = {"info": "INFO", "warning": "WARN", "error": "ERROR"}


# --- lanes ----------------------------------------------------------------------------------------


def log_lanes(recording: rr.RecordingStream, run: Gathered, look: Look, lanes: int) -> None:
    """A lane of open, stick and slip for some nodes of every contact, evenly spread over what was ever closed.

    A lane is named by the arc length of its node.
    """
    for contact in run.layout.contacts:
        curves = [instant.curves[contact.name] for instant in run.instants]
        # as many decimals for all: the viewer sorts lanes by name
        digits = max(0, 2 - int(np.floor(np.log10(max(np.ptp(curves[0].s), 1e-300)))))
        for node in watched_nodes(curves, lanes):
            path = f"{look.path}/state/{contact.name}/s-{curves[0].s[node]:.{digits}f}"
            _log_lane(recording, path, run.instants, [int(curve.state[node]) for curve in curves])


def watched_nodes(curves: Sequence[ContactCurve], lanes: int) -> list[int]:
    """Positions of the watched nodes among the slave nodes."""
    touched = np.flatnonzero(np.max([curve.state for curve in curves], axis=0) > OPEN)
    touched = touched[np.argsort(curves[0].s[touched], kind="stable")]
    chosen = np.linspace(0, len(touched) - 1, min(lanes, len(touched))).round().astype(int)
    return [int(node) for node in touched[chosen]]


def _log_lane(recording: rr.RecordingStream, path: str, instants: Sequence[Instant], states: Sequence[int]) -> None:
    known = rr.StateConfiguration(values=STATES, labels=STATES, colors=[rgb(colour) for colour in COLOURS])
    recording.log(path, known, static=True)
    changes = [k for k in range(len(states)) if k == 0 or states[k] != states[k - 1]]
    when = times([instants[k].step for k in changes], [instants[k].time for k in changes])
    recording.send_columns(path, when, rr.StateChange.columns(state=[STATES[states[k]] for k in changes]))


# --- events ---------------------------------------------------------------------------------------


def log_events(recording: rr.RecordingStream, run: Gathered, look: Look) -> None:
    """The run's own events and the changes of its contacts between frames, in order of time."""
    events = sorted([*run.events, *contact_changes(run)], key=lambda event: event.step)
    if not events:
        return
    columns = rr.TextLog.columns(text=[event.text for event in events], level=[LEVELS[event.level] for event in events])
    when = times([event.step for event in events], [event.time for event in events])
    recording.send_columns(f"{look.path}/events", when, columns)


def contact_changes(run: Gathered) -> Iterator[Event]:
    """Slave nodes that closed, opened, began to stick or slip, or came to face another segment, in numbers."""
    for contact in run.layout.contacts:
        before: tuple[np.ndarray, np.ndarray] | None = None
        for instant in run.instants:
            curve = instant.curves[contact.name]
            now = curve.state, facing(contact, curve, instant.positions)
            if before is not None and (text := _changes(before, now)):
                name = f"{contact.label}: " if len(run.layout.contacts) > 1 else ""
                yield Event(instant.step, instant.time, "info", f"{name}{text}")
            before = now


def _changes(before: tuple[np.ndarray, np.ndarray], now: tuple[np.ndarray, np.ndarray]) -> str:
    (old, old_facing), (new, new_facing) = before, now
    counts = {
        "closed": (old == OPEN) & (new != OPEN),
        "opened": (old != OPEN) & (new == OPEN),
        "began to slip": (old == STICK) & (new == SLIP),
        "began to stick": (old == SLIP) & (new == STICK),
        "passed to another segment": (old_facing != new_facing) & (old_facing >= 0) & (new_facing >= 0),
    }
    numbers = {what: int(mask.sum()) for what, mask in counts.items()}
    return ", ".join(f"{number} {what}" for what, number in numbers.items() if number)


def facing(contact: ContactLayout, curve: ContactCurve, positions: np.ndarray) -> np.ndarray:
    """The master segment (m,) that each covered slave node is nearest to, -1 for the rest."""
    ends = positions[contact.master_nodes].astype(np.float64)[contact.master_segments]
    along = ends[:, 1] - ends[:, 0]
    offset = np.stack([curve.x, curve.y], axis=1)[:, None] - ends[None, :, 0]
    share = np.clip((offset * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
    distance = ((offset - share[..., None] * along) ** 2).sum(axis=2)
    return np.where(np.isnan(curve.gap), -1, np.argmin(distance, axis=1))


# --- the page about the scene ---------------------------------------------------------------------


def log_page(recording: rr.RecordingStream, layout: Layout, look: Look, summary: Mapping[str, Any]) -> None:
    """Scene, parts with versions, and what the run cost."""
    page = rr.TextDocument(page_text(layout, look, summary), media_type=rr.MediaType.MARKDOWN)
    recording.log(f"{look.path}/scene", page, static=True)


def page_text(layout: Layout, look: Look, summary: Mapping[str, Any]) -> str:
    """The page as Markdown."""
    status, reason = summary.get("status", ""), summary.get("reason", "")
    rows = [f"# {look.title}", f"Scene **{layout.title}**, {status}{': ' + reason if reason else ''}", ""]
    rows += _table("part", "used", layout.parts) + _table("library", "version", layout.versions)
    rows += [*_table("cost", "", _costs(summary)), "## Scene", "```toml", layout.scene.strip(), "```"]
    return "\n".join(rows)


def _table(left: str, right: str, values: Mapping[str, Any]) -> list[str]:
    rows = [f"| {name} | {value} |" for name, value in values.items()]
    return [f"| {left} | {right} |", "|---|---|", *rows, ""] if rows else []


def _costs(summary: Mapping[str, Any]) -> dict[str, str]:
    cost = summary.get("cost", {})
    found = {name: str(summary[name]) for name in ("steps", "iterations", "contact_sweeps") if name in summary}
    found |= {name: short(value) for name, value in cost.items() if isinstance(value, int | float)}
    return found | {f"phase {name} [s]": short(value) for name, value in cost.get("phases", {}).items()}
