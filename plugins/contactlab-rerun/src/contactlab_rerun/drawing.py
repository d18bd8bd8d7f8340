"""The deformed mesh and the contacts of one run, frame by frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats, Ints
from contactlab.api.drawing.colours import CLOSED, FIELD, STATES, rgb
from contactlab.api.frame import Iterate
from contactlab_rerun.gathered import Appearance, Gathered, Surface
from contactlab_rerun.iterations import states_after
from contactlab_rerun.mesh_shape import MeshShape
from contactlab_rerun.projection import ON_MESH, camera, in_plane, line_strips
from contactlab_rerun.timelines import frame_times, iterate_times, last_iterations

MESH_BYTES = 16  # of a node in a frame: position and colour
LINE_BYTES = 12  # of a point of a line
FEWEST = 12  # frames that are drawn in any case
PLACES = 12  # bits of positions, of the size of the model: a fourth of a pixel
AT_ONCE = 4_000_000  # bytes of positions that are sent together
FEW_CELLS = 800  # up to here the sides of cells are drawn
LONGEST_ARROW = 0.16  # of the model's size
OUTLINE, WIRE = "#E2E5E9", (226, 229, 233, 46)
OPEN_NODE = (104, 112, 122)
_FLAT = np.array([1.0, 1.0, 0.0], np.float32)
HAIR, LINE = -0.6, -1.4  # radii: negative ones are pixels of the screen


@dataclass(frozen=True)
class Scale:
    """Scales common to all frames, and to all runs of a comparison.

    bottom, top  ends of the field's colours
    pressure  the contact pressure of the longest arrow
    size      of the model [mm]
    distance  of the camera from the plane [mm]
    """

    bottom: float
    top: float
    pressure: float
    size: float
    distance: float


def model_box(gathered: Sequence[Gathered]) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates (2,) of all frames of all runs."""
    positions = [instant.positions for run in gathered for instant in run.instants]
    return np.min([p.min(axis=0) for p in positions], axis=0), np.max([p.max(axis=0) for p in positions], axis=0)


class Film(NamedTuple):
    """Positions (N, 2) of nodes at instants one after another, and the times of some of them."""

    positions: Sequence[np.ndarray]
    when: Callable[[slice], list[rr.TimeColumn]]


class Drawing:
    """Draws the frames of one run; on the timeline of iterations the states between them as well."""

    def __init__(
        self,
        recording: rr.RecordingStream,
        run: Gathered,
        appearance: Appearance,
        scale: Scale,
        outline: str,
        wire: bool,
        room: float,
    ) -> None:
        self.recording, self.run, self.appearance, self.scale = recording, run, appearance, scale
        self.outline = outline
        self.shape = MeshShape(run.layout)
        self.wire = wire
        # bytes of the mesh and its lines in one frame
        lines = [*self.shape.outlines, *(self.shape.wire if self.wire else ())]
        size = MESH_BYTES * self.shape.nodes + LINE_BYTES * sum(map(len, lines))
        self.frames = drawn_frames(run, size, room)
        self.instants = [run.instants[k] for k in self.frames]
        self.iterates = drawn_iterates(run, self.frames, size, room)
        self.films = [self._frames_film(), *([self._iterates_film()] if self.iterates else [])]
        self.place = 2.0 ** (np.ceil(np.log2(scale.size)) - PLACES)

    def draw(self) -> None:
        """Draw meshes, outlines, arrows and fields of all frames."""
        self.recording.log(f"{self.appearance.path}/view", camera(self.scale.distance), static=True)
        self._mesh()
        self._strips("outline", self.shape.outlines)
        self._style("outline", rgb(self.outline), LINE)
        if self.wire:
            self._wire()
        self._arrows()
        self._node_states()

    def _frames_film(self) -> Film:
        steps, times = [i.step for i in self.instants], [i.time for i in self.instants]
        return Film([i.positions for i in self.instants], lambda some: frame_times(self.run, steps[some], times[some]))

    def _iterates_film(self) -> Film:
        """States between frames: in the colours of the last frame before each."""
        nodes, numbers = self.run.layout.nodes, [one.number for one in self.iterates]
        moved = [(nodes + one.displacement).astype(np.float32) for one in self.iterates]
        return Film(moved, lambda some: iterate_times(numbers[some]))

    def _mesh(self) -> None:
        path = f"{self.appearance.path}/mesh"
        self.recording.log(path, rr.Mesh3D.from_fields(triangle_indices=self.shape.triangles), static=True)
        nodes = self.shape.nodes
        for film in self.films:
            coloured = film is self.films[0]

            def columns(some: slice, film: Film = film, coloured: bool = coloured) -> rr.ComponentColumnList:
                positions = self._in_plane(np.array(film.positions[some]), 0.0)
                colours = np.concatenate([self._colours(i.values) for i in self.instants[some]]) if coloured else None
                made = rr.Mesh3D.columns(vertex_positions=positions, vertex_colors=colours)
                return made.partition(np.full(len(film.positions[some]), nodes))

            self._in_batches(path, MESH_BYTES * nodes, film, columns)

    def _colours(self, field: np.ndarray) -> np.ndarray:
        scale = self.scale
        values = (self.shape.nodal(field) - scale.bottom) / (scale.top - scale.bottom)
        return TABLE[np.clip(values * len(TABLE), 0, len(TABLE) - 1).astype(np.intp)]

    def _wire(self) -> None:
        if self.shape.wire:
            self._strips("wire", self.shape.wire)
            self._style("wire", WIRE, HAIR)

    def _arrows(self) -> None:
        """Tractions on the slaves, coloured by the state of their nodes."""
        surfaces = self.run.surfaces
        contacts = self.run.layout.contacts
        if not contacts:
            return
        longest = LONGEST_ARROW * self.scale.size / self.scale.pressure
        points = np.concatenate([surfaces[c.name].points[self.frames] for c in contacts], axis=1)
        pulls = np.concatenate([tractions(surfaces[c.name], c.slave_segments)[self.frames] for c in contacts], axis=1)
        state = np.concatenate([surfaces[c.name].state[self.frames] for c in contacts], axis=1)
        frictional = np.repeat([bool(c.friction) for c in contacts], [len(c.slave_nodes) for c in contacts])
        touching = state > 0
        columns = rr.Arrows3D.columns(
            origins=in_plane(points[touching], 2.0 * ON_MESH, self.scale.distance),
            vectors=in_plane(longest * pulls[touching]) * _FLAT,
            colors=np.where(frictional, COLOURS[state], CLOSED_COLOUR)[touching],
        )
        path = f"{self.appearance.path}/arrows"
        when = frame_times(self.run, [i.step for i in self.instants], [i.time for i in self.instants])
        self.recording.send_columns(path, when, columns.partition(touching.sum(axis=1)))
        if self.iterates:  # tractions belong to frames
            none = np.zeros((0, 3), np.float32)
            hidden = rr.Arrows3D.columns(origins=none, vectors=none, colors=np.zeros(0, np.uint32))
            when = iterate_times([one.number for one in self.iterates])
            self.recording.send_columns(path, when, hidden.partition(np.zeros(len(self.iterates), int)))
        self.recording.log(path, rr.Arrows3D.from_fields(radii=[-1.8]), static=True)

    def _node_states(self) -> None:
        """The slave nodes at every iteration, in the colours of the states that it found."""
        states = states_after(self.run)
        kept = [one for one in self.run.iterates if one.number - 1 < len(states)]
        if not kept or not len(states):
            return
        contacts = self.run.layout.contacts
        nodes = np.concatenate([contact.slave_nodes for contact in contacts])
        frictional = np.repeat([bool(c.friction) for c in contacts], [len(c.slave_nodes) for c in contacts])
        points = np.array([(self.run.layout.nodes + one.displacement)[nodes] for one in kept])
        state = np.array([states[one.number - 1] for one in kept])
        colours = np.where(frictional, COLOURS[state], CLOSED_COLOUR)
        columns = rr.Points3D.columns(
            positions=in_plane(points, 3.0 * ON_MESH, self.scale.distance).reshape(-1, 3),
            colors=np.where(state > 0, colours, packed(np.array([OPEN_NODE], float))[0]).ravel(),
        )
        path = f"{self.appearance.path}/nodes"
        when = iterate_times([one.number for one in kept])
        self.recording.send_columns(path, when, columns.partition(np.full(len(kept), len(nodes))))
        self.recording.log(path, rr.Points3D.from_fields(radii=[-3.0]), static=True)

    # --- sending ----------------------------------------------------------------------------------

    def _strips(self, name: str, lines: Sequence[Ints]) -> None:
        """Lines through nodes, in every frame."""
        nodes, lengths = np.concatenate(lines), [len(line) for line in lines]
        for film in self.films:

            def columns(some: slice, film: Film = film) -> rr.ComponentColumnList:
                positions = np.array(film.positions[some])
                points = self._in_plane(positions[:, nodes], ON_MESH)
                made = rr.LineStrips3D.columns(strips=line_strips(points, np.tile(lengths, len(positions))))
                return made.partition(np.full(len(positions), len(lengths)))

            self._in_batches(f"{self.appearance.path}/{name}", LINE_BYTES * len(nodes), film, columns)

    def _in_plane(self, positions: np.ndarray, lift: float) -> np.ndarray:
        """Positions (..., 2) as the viewer takes them (P, 3), to a fraction of a pixel: what is finer is noise."""
        points = in_plane(positions, lift, self.scale.distance)
        points[..., :2] = np.rint(points[..., :2] / self.place) * self.place
        return points.reshape(-1, 3)

    def _in_batches(
        self, path: str, frame_bytes: int, film: Film, columns: Callable[[slice], rr.ComponentColumnList]
    ) -> None:
        batch = max(1, AT_ONCE // max(1, frame_bytes))
        for begin in range(0, len(film.positions), batch):
            some = slice(begin, begin + batch)
            self.recording.send_columns(path, film.when(some), columns(some))

    def _style(self, name: str, colour: tuple[int, ...], radius: float) -> None:
        style = rr.LineStrips3D.from_fields(colors=[colour], radii=[radius])
        self.recording.log(f"{self.appearance.path}/{name}", style, static=True)


def drawn_frames(run: Gathered, size: float, room: float) -> list[int]:
    """Numbers of frames of `size` bytes to draw: the last steps before an end, others evenly apart in `room` bytes."""
    whole = {instant.step for part in run.last_steps.values() for instant in part}
    others = [k for k, instant in enumerate(run.instants) if instant.step not in whole]
    apart = max(1, min(math.ceil(size * len(others) / room), len(others) // FEWEST))
    left_out = {k for place, k in enumerate(reversed(others)) if place % apart and k != others[0]}
    return [k for k in range(len(run.instants)) if k not in left_out]


def drawn_iterates(run: Gathered, frames: Sequence[int], size: float, room: float) -> list[Iterate]:
    """States after iterations to draw in addition to these frames: evenly apart in `room` bytes, of `size` each."""
    last = last_iterations(run)
    shown = {last.get(run.instants[frame].step) for frame in frames}
    others = [one for one in run.iterates if one.number not in shown]
    apart = max(1, math.ceil(size * len(others) / room))
    return others[::-1][::apart][::-1]


def tractions(surface: Surface, segments: np.ndarray) -> Floats:
    """Contact traction (F, m, 2) [MPa] on the slave at its nodes: pressure inwards, shear along the chain."""
    points = surface.points
    tangent = np.zeros_like(points)
    along = points[:, segments[:, 1]] - points[:, segments[:, 0]]
    tangent[:, segments[:, 0]] = along  # no node starts or ends two segments
    tangent[:, segments[:, 1]] += along
    tangent /= np.maximum(np.hypot(tangent[..., 0], tangent[..., 1]), 1e-300)[..., None]
    inward = np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)  # the body lies on the left
    return surface.pressure[..., None] * inward + surface.shear[..., None] * tangent


def packed(colours: Floats) -> np.ndarray:
    """Colours (k, 3) of 0 to 255 as the viewer takes them, (k,) 0xRRGGBBAA."""
    parts = np.rint(colours).astype(np.uint32)
    return (parts[:, 0] << 24) | (parts[:, 1] << 16) | (parts[:, 2] << 8) | 0xFF


def _table() -> np.ndarray:
    anchors = np.array([rgb(colour) for colour in FIELD], np.float64)
    at, places = np.linspace(0.0, 1.0, 256), np.linspace(0.0, 1.0, len(anchors))
    return packed(np.stack([np.interp(at, places, anchors[:, i]) for i in range(3)], axis=1))


TABLE = _table()
COLOURS = packed(np.array([rgb(colour) for colour in STATES], np.float64))
CLOSED_COLOUR = packed(np.array([rgb(CLOSED)], np.float64))[0]
