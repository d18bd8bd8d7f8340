"""The core's own parts: they come in by an entry point, like anyone's."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """The core's own parts: mesh generators, meshes from files, the file of a run, and references."""
    return [
        Part("mesh", "rectangle", "contactlab.meshing:Rectangle", "rectangle, graded or in spans"),
        Part("mesh", "arc-block", "contactlab.meshing:ArcBlock", "block whose lower side is a circular arc"),
        Part(
            "mesh", "quad-block", "contactlab.meshing:QuadBlock", "block between four corners, sides straight or arcs"
        ),
        Part("mesh", "disc", "contactlab.meshing:Disc", "full disc"),
        Part("mesh", "ring", "contactlab.meshing:Ring", "ring, or the part of it between two angles"),
        Part("mesh", "file", "contactlab.meshing:MeshFile", "mesh of quadrilaterals that meshio reads"),
        Part("mesh", "arrays", "contactlab.meshing:MeshArrays", "mesh from arrays, kept in the scene: contactlab.mesh"),
        Part(
            "recorder",
            "vtkhdf",
            "contactlab.results.vtkhdf:VtkHdf",
            "all of a run in one file, for ParaView and Python",
        ),
        Part(
            "reference",
            "disc-on-block-deep",
            "contactlab.studies.stored_references:DiscOnBlockDeep",
            "disc-on-block at the depth of the paper, from static runs on fine meshes",
        ),
        Part(
            "reference",
            "disc-on-block-shallow",
            "contactlab.studies.stored_references:DiscOnBlockShallow",
            "disc-on-block at a depth of 0.01 mm, from static runs on fine meshes",
        ),
    ]
