"""Meshes from a few numbers, and from files."""

from contactlab.meshing.blocks import ArcBlock, QuadBlock, Rectangle
from contactlab.meshing.file import MeshFile
from contactlab.meshing.round import Disc, Ring

__all__ = ["ArcBlock", "Disc", "MeshFile", "QuadBlock", "Rectangle", "Ring"]
