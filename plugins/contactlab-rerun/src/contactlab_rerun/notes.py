"""Notes in words: tracks of contact states, events, and the page about the scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr

from contactlab.api.arrays import Ints
from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.api.drawing.colours import CLOSED, rgb
from contactlab.api.drawing.colours import STATES as COLOURS
from contactlab.api.frame import OPEN, SLIP, STATES, STICK, ContactLayout, Event, IterationRow
from contactlab_rerun.gathered import Appearance, Gathered, Surface, entity_name, short, state_names
from contactlab_rerun.timelines import frame_times, iteration_times

RESTLESS = 5  # changes of its segment from which on a node has one line for all of them
LEVELS = {"info": "INFO", "warning": "WARN", "error": "ERROR"}


# --- tracks ---------------------------------------------------------------------------------------


def log_state_tracks(recording: rr.RecordingStream, run: Gathered, folders: Sequence[str], tracks: int) -> None:
    """Log tracks of open, stick and slip for some nodes of every contact, evenly spread over what was ever closed."""
    for contact, folder in zip(run.layout.contacts, folders, strict=True):
        surface = run.surfaces[contact.name]
        nodes = watched_nodes(surface, tracks)
        for node, track in zip(nodes, track_names(surface, contact, nodes), strict=True):
            _log_track(recording, f"{folder}/{track}", run, surface.state[:, node].tolist(), bool(contact.friction))


def track_folders(run: Gathered, appearance: Appearance, several: bool) -> list[str]:
    """Return the entity path above the tracks of each contact: the viewer writes all of it as the name of a track."""
    slaves = [contact.slave for contact in run.layout.contacts]
    above = appearance.path if several else ""
    return [
        f"{above}/{entity_name(c.slave if slaves.count(c.slave) == 1 else f'{c.slave}_{c.name}')}"
        for c in run.layout.contacts
    ]


def track_names(surface: Surface, contact: ContactLayout, nodes: Sequence[int]) -> list[str]:
    """Name the tracks of the `nodes` by arc length and node, and by chain if there are several, without blanks."""
    chains = [f"_chain_{surface.chain[node]}" if surface.chain.max(initial=0) else "" for node in nodes]
    apart = np.diff(np.unique(surface.s[nodes]))
    finest = min(0.01 * float(np.ptp(surface.s)), float(apart.min(initial=np.inf)))
    # as many decimals for all: the viewer sorts tracks by name
    digits = max(0, -int(np.floor(np.log10(max(finest, 1e-300)))))
    return [
        f"s_{surface.s[node]:.{digits}f}_node_{contact.slave_nodes[node]}{chain}"
        for node, chain in zip(nodes, chains, strict=True)
    ]


def watched_nodes(surface: Surface, tracks: int) -> list[int]:
    """Positions of the watched nodes among the slave nodes."""
    ever = np.flatnonzero(surface.state.max(axis=0) > OPEN)
    touched = surface.along[np.isin(surface.along, ever)]
    chosen = np.linspace(0, len(touched) - 1, min(tracks, len(touched))).round().astype(int)
    return [int(node) for node in touched[chosen]]


def _log_track(
    recording: rr.RecordingStream, path: str, run: Gathered, states: Sequence[int], frictional: bool
) -> None:
    colours = COLOURS if frictional else (*COLOURS[:SLIP], CLOSED)
    known = rr.StateConfiguration(values=STATES, labels=state_names(frictional), colors=[rgb(one) for one in colours])
    recording.log(path, known, static=True)
    changes = [k for k in range(len(states)) if k == 0 or states[k] != states[k - 1]]
    when = frame_times(run, [run.instants[k].step for k in changes], [run.instants[k].time for k in changes])
    recording.send_columns(path, when, rr.StateChange.columns(state=[STATES[states[k]] for k in changes]))


# --- events ---------------------------------------------------------------------------------------


def log_events(recording: rr.RecordingStream, run: Gathered, appearance: Appearance, several: bool) -> None:
    """The run's own events and the changes of its contacts between frames, in order of time.

    A line begins with its step, which the viewer's own column cuts; among `several` runs it ends with the run's path.
    """
    events = sorted([*contact_changes(run), *run.events], key=lambda event: event.step)
    if not events:
        return
    name = f" [{appearance.path.removeprefix('/')}]" if several else ""
    texts = [f"{event.step}: {event.text}{name}" for event in events]
    levels = [LEVELS[event.level] for event in events]
    when = frame_times(run, [event.step for event in events], [event.time for event in events])
    recording.send_columns(f"{appearance.path}/events", when, rr.TextLog.columns(text=texts, level=levels))


def contact_changes(run: Gathered) -> Iterator[Event]:
    """Slave nodes that closed, opened, began to stick or slip, or came to face another segment; few are named."""
    for contact in run.layout.contacts:
        surface = run.surfaces[contact.name]
        name = f"{contact.label}: " if len(run.layout.contacts) > 1 else ""
        recorded = recorded_segments(run, contact)
        facing = [
            segments_faced(contact, surface, frame, instant.positions) for frame, instant in enumerate(run.instants)
        ]
        moved = np.zeros(surface.state.shape, bool)
        for frame in range(1, len(moved)):
            both = (frame - 1, frame)
            old, new = (recorded[k] if all(j in recorded for j in both) else facing[k] for k in both)
            moved[frame] = (old != new) & (old >= 0) & (new >= 0)
        restless = _restless(run, contact, moved)
        for frame, instant in enumerate(run.instants[1:], start=1):
            texts = [text for begin, text in restless if begin == frame]
            if text := _changes(contact, surface.state[frame - 1], surface.state[frame], moved[frame]):
                texts.append(text)
            for text in texts:
                yield Event(instant.step, instant.time, "info", f"{name}{text}")


def _restless(run: Gathered, contact: ContactLayout, moved: np.ndarray) -> list[tuple[int, str]]:
    """Take nodes that change their segment often out of `moved` (F, m); one line for each, with its first frame."""
    found = []
    for k in np.flatnonzero(moved.sum(axis=0) >= RESTLESS).tolist():
        frames = np.flatnonzero(moved[:, k])
        moved[:, k] = False
        times = f"{len(frames)} times up to step {run.instants[frames[-1]].step}"
        found.append((int(frames[0]), f"node {contact.slave_nodes[k]} changes segment {times}"))
    return found


def recorded_segments(run: Gathered, contact: ContactLayout) -> dict[int, Ints]:
    """The master segment (m,) that each closed slave node has in the contact record, by the frames that are in it."""
    states = run.surfaces[contact.name].state
    return {
        frame: np.where((row["segment"] != NO_SEGMENT) & (states[frame] != OPEN), row["segment"].astype(int), -1)
        for frame, row in run.recorded_frames(contact.name).items()
    }


def _changes(contact: ContactLayout, old: Ints, new: Ints, moved: np.ndarray) -> str:
    changed = {
        "closed": (old == OPEN) & (new != OPEN),
        "opened": (old != OPEN) & (new == OPEN),
        "began to slip": (old == STICK) & (new == SLIP),
        "began to stick": (old == SLIP) & (new == STICK),
        "changed segment": moved,
    }
    nodes = {what: contact.slave_nodes[mask].tolist() for what, mask in changed.items()}
    return ", ".join(f"{len(which)} {what}{_names(which)}" for what, which in nodes.items() if which)


def _names(nodes: Sequence[int]) -> str:
    """Name up to two nodes, as in the pictures of all steps; more would fill the line."""
    if len(nodes) > 2:
        return ""
    return f" (node{'s' if len(nodes) > 1 else ''} {' and '.join(map(str, nodes))})"


def segments_faced(contact: ContactLayout, surface: Surface, frame: int, positions: np.ndarray) -> Ints:
    """The master segment (m,) that each closed slave node is nearest to, -1 for open ones.

    For a node between two segments the choice is arbitrary; a contact record, if there is one, has the true segment.
    """
    closed = np.flatnonzero(surface.state[frame])
    found = np.full(len(surface.s), -1)
    if len(closed):
        ends = positions[contact.master_nodes].astype(np.float64)[contact.master_segments]
        points = np.stack([surface.x[frame, closed], surface.y[frame, closed]], axis=1)
        along = ends[:, 1] - ends[:, 0]
        offset = points[:, None] - ends[None, :, 0]
        share = np.clip((offset * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
        found[closed] = np.argmin(((offset - share[..., None] * along) ** 2).sum(axis=2), axis=1)
    return found


def log_iterations(recording: rr.RecordingStream, run: Gathered, appearance: Appearance) -> None:
    """Log a line for each Newton iteration; iterations of rejected steps stand out."""
    if not run.iterations:
        return
    last = {row.step: row.attempt for row in run.iterations}
    texts = [_iteration_text(row) for row in run.iterations]
    levels = ["INFO" if row.attempt == last[row.step] else "WARN" for row in run.iterations]
    when = iteration_times(run.iterations, np.arange(len(run.iterations)))
    recording.send_columns(f"{appearance.path}/iterations", when, rr.TextLog.columns(text=texts, level=levels))


def _iteration_text(row: IterationRow) -> str:
    attempt = f"attempt {row.attempt}, " if row.attempt > 1 else ""
    shorter = f", {row.length:.3g} of the correction" if row.length < 1.0 else ""
    return (
        f"{row.step}: {attempt}iteration {row.number}: force {row.force:.1e}, contact {row.contact:.1e}; "
        f"{row.active} closed, {row.sticking} sticking, {row.changed} changed{shorter}"
        f"{'; ' + row.note if row.note else ''}"
    )


# --- the page about the scene ---------------------------------------------------------------------


def log_page(recording: rr.RecordingStream, run: Gathered, appearance: Appearance, summary: Mapping[str, Any]) -> None:
    """Write the page with scene, parts, versions, and what the run cost."""
    page = rr.TextDocument(page_text(run, appearance, summary), media_type=rr.MediaType.MARKDOWN)
    recording.log(f"{appearance.path}/scene", page, static=True)


def page_text(run: Gathered, appearance: Appearance, summary: Mapping[str, Any]) -> str:
    """Write the page about the scene and its end as Markdown."""
    layout = run.layout
    status, reason = summary.get("status", ""), summary.get("reason", "")
    rows = [f"# {appearance.title}", f"Scene **{layout.title}**, {status}{': ' + reason if reason else ''}", ""]
    rows += ["## What to look for", *what_to_look_for(run), ""]
    warnings = {warning["code"]: warning["text"] for warning in summary.get("warnings", ())}
    rows += _table("warning", "", warnings)
    rows += _table("part", "used", layout.parts) + _table("library", "version", layout.versions)
    rows += [*_table("cost", "", _costs(summary)), "## Scene", "```toml", layout.scene.strip(), "```"]
    return "\n".join(rows)


def what_to_look_for(run: Gathered) -> list[str]:
    """Lines of Markdown with an introduction for readers of this recording."""
    lines = []
    if window := run.window():
        lines.append(f"- Steps {window[0]} to {window[1]} have all fields: move the cursor step by step there.")
    if run.records:
        lines.append("- A stripe in *master segment under each node*: a node alternates, as chatter begins.")
        lines.append("- *Pressure*: teeth from node to node are the method's, a smooth arch is the contact's.")
    if run.layout.contacts:
        lines.append("- *nodes of* the slave: gap, multipliers, state and segment of each at the cursor, as numbers.")
        lines.append("- *energy*: contact without friction makes none; its line leaves zero where contact goes wrong.")
    if run.iterations:
        lines.append("- *residual* and *iterations*: how the step at the cursor converged, and what opened or closed.")
        lines.append(
            "- The timeline *iteration* walks through Newton's iterations; *active set* has a column for each of them."
        )
    return lines or ["- *energy* and *reaction* over the whole run; the mesh is at the cursor."]


def _table(left: str, right: str, values: Mapping[str, Any]) -> list[str]:
    rows = [f"| {name} | {value} |" for name, value in values.items()]
    return [f"| {left} | {right} |", "|---|---|", *rows, ""] if rows else []


def _costs(summary: Mapping[str, Any]) -> dict[str, str]:
    cost = summary.get("cost", {})
    found = {name: str(summary[name]) for name in ("steps", "iterations", "contact_sweeps") if name in summary}
    found |= {name: short(value) for name, value in cost.items() if isinstance(value, int | float)}
    return found | {f"phase {name} [s]": short(value) for name, value in cost.get("phases", {}).items()}
