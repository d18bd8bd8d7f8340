"""Meshes from a few numbers, from files, and from arrays."""

from contactlab.meshing.arrays import MeshArrays
from contactlab.meshing.blocks import ArcBlock, QuadBlock, Rectangle
from contactlab.meshing.file import MeshFile
from contactlab.meshing.round import Disc, Ring

__all__ = ["ArcBlock", "Disc", "MeshArrays", "MeshFile", "QuadBlock", "Rectangle", "Ring"]
