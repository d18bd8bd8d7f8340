"""The deformed mesh and the contacts of one run, frame by frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats, Ints
from contactlab.api.drawing.colours import CLOSED, FIELD, STATES, rgb
from contactlab_rerun.gathered import Appearance, Gathered, Instant, Surface
from contactlab_rerun.iterations import frame_times
from contactlab_rerun.mesh_shape import MeshShape
from contactlab_rerun.projection import ON_MESH, camera, in_plane, line_strips

POINT_BYTES = 16.0  # of a node in a frame: position and colour
FEWEST = 20  # frames that are drawn in any case
PLACES = 16  # bits of positions, of the size of the model: a twentieth of a pixel, and one where it is seen from near
AT_ONCE = 4_000_000  # bytes of positions that are sent together
FEW_CELLS = 800  # up to here the sides of cells are drawn
LONGEST_ARROW = 0.16  # of the model's size
OUTLINE, WIRE = "#E2E5E9", (226, 229, 233, 46)
_FLAT = np.array([1.0, 1.0, 0.0], np.float32)
HAIR, LINE = -0.6, -1.4  # radii: negative ones are pixels of the screen


@dataclass(frozen=True)
class Scale:
    """What is common to all frames, and to all runs of a comparison.

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


class Drawing:
    """Draws the frames of one run."""

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
        self.frames = drawn_frames(run, room)
        self.instants = [run.instants[k] for k in self.frames]
        self.place = 2.0 ** (np.ceil(np.log2(scale.size)) - PLACES)

    def draw(self) -> None:
        """Draw meshes, outlines, arrows and fields of all frames."""
        self.recording.log(f"{self.appearance.path}/view", camera(self.scale.distance), static=True)
        self._mesh()
        self._outlines()
        if self.wire:
            self._wire()
        self._arrows()

    def _mesh(self) -> None:
        path = f"{self.appearance.path}/mesh"
        self.recording.log(path, rr.Mesh3D.from_fields(triangle_indices=self.shape.triangles), static=True)
        nodes = self.shape.nodes

        def columns(instants: Sequence[Instant]) -> rr.ComponentColumnList:
            positions = self._in_plane(np.array([i.positions for i in instants]), 0.0)
            colours = np.concatenate([self._colours(i) for i in instants])
            made = rr.Mesh3D.columns(vertex_positions=positions, vertex_colors=colours)
            return made.partition(np.full(len(instants), nodes))

        self._in_batches(path, 16 * nodes, columns)

    def _colours(self, instant: Instant) -> np.ndarray:
        scale = self.scale
        values = (self.shape.nodal(instant.values) - scale.bottom) / (scale.top - scale.bottom)
        return TABLE[np.clip(values * len(TABLE), 0, len(TABLE) - 1).astype(np.intp)]

    def _outlines(self) -> None:
        loops = self.shape.outlines
        self._strips("outline", np.concatenate(loops), [len(loop) for loop in loops])
        self._style("outline", rgb(self.outline), LINE)

    def _wire(self) -> None:
        sides = self.shape.wire
        if sides:
            lengths = [side.shape[1] for side in sides for _ in side]
            self._strips("wire", np.concatenate([side.ravel() for side in sides]), lengths)
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
        self.recording.log(path, rr.Arrows3D.from_fields(radii=[-1.8]), static=True)

    # --- sending ----------------------------------------------------------------------------------

    def _strips(self, name: str, nodes: Ints, lengths: Sequence[int]) -> None:
        """Lines through nodes, so many in each, in every frame."""

        def columns(instants: Sequence[Instant]) -> rr.ComponentColumnList:
            positions = np.array([i.positions for i in instants])[:, nodes]
            points = self._in_plane(positions, ON_MESH)
            made = rr.LineStrips3D.columns(strips=line_strips(points, np.tile(lengths, len(instants))))
            return made.partition(np.full(len(instants), len(lengths)))

        self._in_batches(f"{self.appearance.path}/{name}", 12 * len(nodes), columns)

    def _in_plane(self, positions: np.ndarray, lift: float) -> np.ndarray:
        """Positions (..., 2) as the viewer takes them (P, 3), to a fraction of a pixel: what is finer is noise."""
        points = in_plane(positions, lift, self.scale.distance)
        points[..., :2] = np.rint(points[..., :2] / self.place) * self.place
        return points.reshape(-1, 3)

    def _in_batches(
        self, path: str, frame_bytes: int, columns: Callable[[Sequence[Instant]], rr.ComponentColumnList]
    ) -> None:
        instants = self.instants
        batch = max(1, AT_ONCE // max(1, frame_bytes))
        for begin in range(0, len(instants), batch):
            some = instants[begin : begin + batch]
            when = frame_times(self.run, [i.step for i in some], [i.time for i in some])
            self.recording.send_columns(path, when, columns(some))

    def _style(self, name: str, colour: tuple[int, ...], radius: float) -> None:
        style = rr.LineStrips3D.from_fields(colors=[colour], radii=[radius])
        self.recording.log(f"{self.appearance.path}/{name}", style, static=True)


def drawn_frames(run: Gathered, room: float) -> list[int]:
    """Which frames are drawn: the last steps before an end, and others evenly apart as far as `room` bytes go."""
    whole = {instant.step for part in run.last_steps.values() for instant in part}
    others = [k for k, instant in enumerate(run.instants) if instant.step not in whole]
    size = POINT_BYTES * len(run.layout.nodes) * len(others)
    apart = max(1, min(math.ceil(size / room), len(others) // FEWEST))
    left_out = {k for place, k in enumerate(reversed(others)) if place % apart and k != others[0]}
    return [k for k in range(len(run.instants)) if k not in left_out]


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
