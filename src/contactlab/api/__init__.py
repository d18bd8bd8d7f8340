"""The contract between the core and its plugins: the only import a plugin needs.

Imports NumPy alone. Compiled kernels use `contactlab.api.compiled.kernel`, entry-point modules
`contactlab.api.plugin`; both import their library when they are imported themselves.
"""

from contactlab.api.arrays import BLOCK_CELLS, XX, XY, YY, ZZ, Floats, Ints
from contactlab.api.case import Answer, Case, Changes, Job, Measure, Setup, Spec
from contactlab.api.contact import ContactAlgorithm, ContactMethod, ContactView, GapAlgorithm, GapConditions, Pieces
from contactlab.api.derivatives import ConditionDerivatives, GapGradients, PieceDerivatives
from contactlab.api.effect import Effect, EffectView
from contactlab.api.element import BlockKernels, Element, Quadrature, Shape
from contactlab.api.enforcement import (
    Conditions,
    Enforcement,
    ExplicitEnforcement,
    FactoredGradients,
    FactoredRows,
    GapRows,
    ImplicitEnforcement,
    Response,
    Rows,
    Solve,
)
from contactlab.api.equations import (
    ContactDerivatives,
    ContactEquations,
    Equations,
    Estimate,
    ExplicitEquations,
    ImplicitContact,
    ImplicitEquations,
    PrescribedMotion,
)
from contactlab.api.formulas import formula
from contactlab.api.frame import ContactCurve, Event, Frame, Iterate, IterationRow, Layout, StoredRun
from contactlab.api.friction import FrictionBound, FrictionLaw
from contactlab.api.function import Function
from contactlab.api.integrator import ExplicitIntegrator, ImplicitIntegrator, Integrator
from contactlab.api.material import Kinematics, Material
from contactlab.api.measure import RunMeasure
from contactlab.api.mesh import Mesh, MeshSource
from contactlab.api.motion import ImplicitMotion, Motion
from contactlab.api.normal_law import NormalLaw
from contactlab.api.part import CONTRACT_VERSION, KINDS, Kind, Part
from contactlab.api.point_contact import PointContact
from contactlab.api.potential import NodalForces, Potential, PotentialView, Pressures
from contactlab.api.profile import Profile
from contactlab.api.record import Record
from contactlab.api.recorder import Recorder, Recording
from contactlab.api.reference import ReferenceSolution, Scalar, Solution
from contactlab.api.segment_contact import SegmentContact
from contactlab.api.segment_potential import SegmentPotential
from contactlab.api.segments import Overlap
from contactlab.api.state import WORK, State
from contactlab.api.step import Iteration, Step, StepControl, StepStatus
from contactlab.api.surface import Candidates, Surface, SurfacePositions
from contactlab.api.tensors import UNIT, Tensor, Vector
from contactlab.api.warning import RunWarning, Warnings
from contactlab.api.watch import Memory, StepView, Watch

__all__ = [
    "BLOCK_CELLS",
    "CONTRACT_VERSION",
    "KINDS",
    "UNIT",
    "WORK",
    "XX",
    "XY",
    "YY",
    "ZZ",
    "Answer",
    "BlockKernels",
    "Candidates",
    "Case",
    "Changes",
    "ConditionDerivatives",
    "Conditions",
    "ContactAlgorithm",
    "ContactCurve",
    "ContactDerivatives",
    "ContactEquations",
    "ContactMethod",
    "ContactView",
    "Effect",
    "EffectView",
    "Element",
    "Enforcement",
    "Equations",
    "Estimate",
    "Event",
    "ExplicitEnforcement",
    "ExplicitEquations",
    "ExplicitIntegrator",
    "FactoredGradients",
    "FactoredRows",
    "Floats",
    "Frame",
    "FrictionBound",
    "FrictionLaw",
    "Function",
    "GapAlgorithm",
    "GapConditions",
    "GapGradients",
    "GapRows",
    "ImplicitContact",
    "ImplicitEnforcement",
    "ImplicitEquations",
    "ImplicitIntegrator",
    "ImplicitMotion",
    "Integrator",
    "Ints",
    "Iterate",
    "Iteration",
    "IterationRow",
    "Job",
    "Kind",
    "Kinematics",
    "Layout",
    "Material",
    "Measure",
    "Memory",
    "Mesh",
    "MeshSource",
    "Motion",
    "NodalForces",
    "NormalLaw",
    "Overlap",
    "Part",
    "PieceDerivatives",
    "Pieces",
    "PointContact",
    "Potential",
    "PotentialView",
    "PrescribedMotion",
    "Pressures",
    "Profile",
    "Quadrature",
    "Record",
    "Recorder",
    "Recording",
    "ReferenceSolution",
    "Response",
    "Rows",
    "RunMeasure",
    "RunWarning",
    "Scalar",
    "SegmentContact",
    "SegmentPotential",
    "Setup",
    "Shape",
    "Solution",
    "Solve",
    "Spec",
    "State",
    "Step",
    "StepControl",
    "StepStatus",
    "StepView",
    "StoredRun",
    "Surface",
    "SurfacePositions",
    "Tensor",
    "Vector",
    "Warnings",
    "Watch",
    "formula",
]
