"""The contract between the core and its plugins: the only import a plugin needs.

Imports NumPy alone. Compiled kernels use `contactlab.api.kernel`, entry-point modules
`contactlab.api.plugin`; both import their library when they are imported themselves.
"""

from contactlab.api.arrays import BLOCK_CELLS, XX, XY, YY, ZZ, Floats, Ints
from contactlab.api.contact import ContactAlgorithm, GapAlgorithm, GapConditions, Pieces
from contactlab.api.effect import Effect, EffectView
from contactlab.api.element import BlockKernels, Element, Quadrature, Shape
from contactlab.api.enforcement import Enforcement, ExplicitEnforcement, Rows, Solve
from contactlab.api.friction import FrictionBound, FrictionLaw
from contactlab.api.integrator import ContactEquations, Equations, Integrator, PrescribedMotion, Step, StepStatus
from contactlab.api.material import Kinematics, Material
from contactlab.api.mesh import Mesh, MeshSource
from contactlab.api.part import CONTRACT_VERSION, KINDS, Kind, Part
from contactlab.api.recorder import Recorder
from contactlab.api.state import WORK, State
from contactlab.api.surface import Candidates, Surface, SurfacePositions

__all__ = [
    "BLOCK_CELLS",
    "CONTRACT_VERSION",
    "KINDS",
    "WORK",
    "XX",
    "XY",
    "YY",
    "ZZ",
    "BlockKernels",
    "Candidates",
    "ContactAlgorithm",
    "ContactEquations",
    "Effect",
    "EffectView",
    "Element",
    "Enforcement",
    "Equations",
    "ExplicitEnforcement",
    "Floats",
    "FrictionBound",
    "FrictionLaw",
    "GapAlgorithm",
    "GapConditions",
    "Integrator",
    "Ints",
    "Kind",
    "Kinematics",
    "Material",
    "Mesh",
    "MeshSource",
    "Part",
    "Pieces",
    "PrescribedMotion",
    "Quadrature",
    "Recorder",
    "Rows",
    "Shape",
    "Solve",
    "State",
    "Step",
    "StepStatus",
    "Surface",
    "SurfacePositions",
]
