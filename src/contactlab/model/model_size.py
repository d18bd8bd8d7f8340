"""Memory estimate of a model from the sizes of its parts: above all measured values, by a fifth to a half.

Each number counts arrays that exist at the same time, or was measured if libraries allocate; `make fuzz` compares
the peak memory of every scene that it tries with the sum, and prints the margin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from contactlab.api import Element, Material

MODEL = 2.5 * 2**20  # B of any model: objects of Python, tables of elements, text of the scene, pages of allocators
NODE = 280.0  # B per node: five copies of positions, the state twice, results of the last frame, mass
CELL = 24.0  # B per cell: sizes and frequencies, by which the stable step is followed
NUMBER = 12.0  # B per node of a cell: the numbers of the mesh, of the body and of the block
POINT = 64.0  # B per point: deformation gradients and stresses of blocks, and later the stresses of the results
HISTORY = 32.0  # B per history variable of a law: the state, its copy, and twice the results
BLOCK = 1024  # cells processed together
ROWS = 48.0  # B per node of a cell of a block: scratch of the element's kernels
MATRIX = 32.0  # B per entry of a cell's stiffness: itself, scaled, and in the eigenvalue search
TRIPLET = 56.0  # B per entry of the stiffness of all cells: with rows and columns, sorted and added up
DENSER = 1.4  # times as much for matrices of elements of more nodes than corners: a node has more neighbours
FACTORS = 250.0  # B per node and doubling of nodes: factors of its stiffness grow as n log n
SMALL = 1000  # degrees of freedom of all bodies up to which these are dense: 20 ms for a solution
DENSE = 8.0 * SMALL**2  # B of a dense matrix for the lowest frequency
COPIES = 3.2  # of it at one time: itself, springs of joints, their factors; later its free part and its factors
SOLUTION = 1500.0  # B per node: GMRES, Newton's iterations, right-hand sides
MATRICES = 5200.0  # B per node of an implicit model: pattern, stiffness, saddle point system and its parts
CONTACT = 4500.0  # B per slave node: constraints and their rows, near lists, tables of the algorithm
LINEARISED = 15000.0  # B more in an implicit model: derivatives of all pieces of the surface and their matrices
FRICTION = 3500.0  # B more with friction: slips, bounds, and the memory of the start of a step


@dataclass
class ModelSize:
    """Sizes that determine the memory of a model.

    implicit   True if matrices are factorised in every step; lowest: once, for the lowest frequency
    threads    that work on blocks of cells
    nodes, cells, points
               of all bodies; numbers: nodes of each cell, added up
    history    numbers in memory of laws at all points
    entries    of the stiffness matrices of all cells
    scratch    bytes of thread scratch; block: bytes of the matrices of a block of cells
    slaves     nodes with constraints; rubbing: nodes with friction among them
    dense      True if elements have more nodes than corners
    """

    implicit: bool
    lowest: bool = False
    threads: int = 1
    nodes: float = 0.0
    cells: float = 0.0
    points: float = 0.0
    numbers: float = 0.0
    history: float = 0.0
    entries: float = 0.0
    scratch: float = 0.0
    block: float = 0.0
    slaves: float = 0.0
    rubbing: float = 0.0
    dense: bool = False

    def add(self, cells: float, element: type[Element], material: type[Material]) -> None:
        """Add a body of `cells` cells."""
        corner, side, all_nodes = 4, sum(len(edge) - 2 for edge in element.edges), len(element.nodes)
        points = all_nodes + (side > 0)  # elements of eight nodes have nine
        at_once, entries = min(cells, float(BLOCK)), 4.0 * all_nodes**2
        self.dense = self.dense or all_nodes > corner
        self.nodes += cells * (1.0 + side / 2.0 + (all_nodes - corner - side))  # sides and corners are shared
        self.nodes += math.sqrt(cells) * 2.0  # but on the boundary
        self.cells += cells
        self.points += cells * points
        self.numbers += cells * all_nodes
        self.history += cells * points * material.history_size
        self.entries += cells * entries
        self.scratch += at_once * (ROWS * (all_nodes + 1) + POINT * points)
        self.block = max(self.block, MATRIX * entries * at_once)

    def add_contact(self, slaves: float, friction: bool) -> None:
        """Add a contact with `slaves` slave nodes."""
        self.slaves += slaves
        self.rubbing += slaves if friction else 0.0

    @property
    def bytes(self) -> float:
        """Upper limit of the model's memory at any time [B]."""
        fixed = MODEL + self.threads * self.scratch + self.block
        bodies = NODE * self.nodes + CELL * self.cells + NUMBER * self.numbers + POINT * self.points
        contact = (CONTACT + LINEARISED * self.implicit) * self.slaves + FRICTION * self.rubbing
        nodes = self.nodes * (DENSER if self.dense else 1.0)
        factors = nodes * FACTORS * math.log2(max(nodes, 2.0))
        whole = factors + nodes * (SOLUTION + MATRICES) if self.implicit else 0.0
        dense = COPIES * min(32.0 * self.nodes**2, DENSE)
        matrices = max(whole, max(factors, dense) + TRIPLET * self.entries if self.lowest else 0.0)
        return fixed + bodies + HISTORY * self.history + contact + matrices

    @property
    def words(self) -> str:
        """Return a description of the memory use."""
        return f"{self.nodes:.3g} nodes so far{', with matrices of all of them' if self.implicit else ''}"
