"""A structure of elastic solids and asperity interfaces in Kratos, with access to its Newton iterations.

The elements are SmallDisplacementElement of StructuralMechanicsApplication and the zero-thickness
Geo_U*InterfaceElement of GeoMechanicsApplication 10.4.  The user chooses consistent units.  2D models are in
plane strain with thickness 1.
"""

from __future__ import annotations

import ctypes
import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import KratosMultiphysics as Kratos
import KratosMultiphysics.GeoMechanicsApplication as Geo
import KratosMultiphysics.LinearSolversApplication
import KratosMultiphysics.python_linear_solver_factory as solvers
import KratosMultiphysics.StructuralMechanicsApplication as Structural
import numpy as np
from asperity import Interface
from asperity.contract import Floats
from asperity.installed import named_library
from asperity.mesh import Jointed, write
from numpy.typing import NDArray

Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
Kratos.ParallelUtilities.SetNumThreads(1)  # one thread: every run adds in the same order

SOLID = {2: "LinearElasticPlaneStrain2DLaw", 3: "LinearElastic3DLaw"}
"""Law of the solids."""

INTERFACE = {2: "Geo_ULineInterfacePlaneStrainElement", 3: "Geo_USurfaceInterfaceElement"}
"""Element of the interfaces with the law of the card; another pair runs, but swaps normal with shear."""

DISPLACEMENTS = (Kratos.DISPLACEMENT_X, Kratos.DISPLACEMENT_Y, Kratos.DISPLACEMENT_Z)
REACTIONS = (Kratos.REACTION_X, Kratos.REACTION_Y, Kratos.REACTION_Z)
MOST_ITERATIONS = 30


class Lost(RuntimeError):
    """The Newton iterations did not converge; norms: of the residual after each of them."""

    def __init__(self, step: int, norms: list[float], tolerance: float) -> None:
        """Store what was found."""
        super().__init__(f"step {step}: residuals {norms}, expected at most {tolerance:g}")
        self.norms = norms


class Structure:
    """A model of nodes, solids and interfaces, solved in steps of prescribed displacements and loads."""

    def __init__(self, dimension: int) -> None:
        """Create an empty structure in 2 or 3 dimensions."""
        self.dimension = dimension
        self.model = Kratos.Model()
        self.part = part = self.model.CreateModelPart("Main", 2)
        for variable in (
            Kratos.DISPLACEMENT, Kratos.REACTION, Kratos.VELOCITY, Kratos.ACCELERATION,
            Kratos.VOLUME_ACCELERATION, Kratos.WATER_PRESSURE, Kratos.REACTION_WATER_PRESSURE,
            Geo.DT_WATER_PRESSURE, Structural.POINT_LOAD,
        ):  # fmt: skip
            part.AddNodalSolutionStepVariable(variable)
        part.ProcessInfo[Kratos.DOMAIN_SIZE] = dimension
        part.ProcessInfo[Geo.VELOCITY_COEFFICIENT] = 1.0
        part.ProcessInfo[Geo.DT_PRESSURE_COEFFICIENT] = 1.0
        self.interfaces: list[Kratos.Element] = []
        self._strategy: Kratos.ResidualBasedNewtonRaphsonStrategy | None = None

    # --- model ---------------------------------------------------------------

    def add_nodes(self, points: Floats) -> NDArray[np.int64]:
        """Add nodes at points (..., dimension); return their numbers (...)."""
        flat = np.zeros((points.size // self.dimension, 3))
        flat[:, : self.dimension] = points.reshape(-1, self.dimension)
        first = self.part.NumberOfNodes() + 1
        for i, (x, y, z) in enumerate(flat.tolist()):
            self.part.CreateNewNode(first + i, x, y, z)
        return np.arange(first, first + len(flat)).reshape(points.shape[:-1])

    def elastic(self, young: float, poisson: float, law: str = "") -> Kratos.Properties:
        """Return the properties of an elastic solid; law: another one than SOLID has."""
        properties = self.part.CreateNewProperties(self.part.NumberOfProperties() + 1)
        properties.SetValue(Kratos.CONSTITUTIVE_LAW, _law(law or SOLID[self.dimension]))
        properties.SetValue(Kratos.YOUNG_MODULUS, young)
        properties.SetValue(Kratos.POISSON_RATIO, poisson)
        properties.SetValue(Kratos.DENSITY, 0.0)
        return properties

    def umat(self, interface: Interface, implex: float = 0.0, **variables: object) -> Kratos.Properties:
        """Return the properties of an interface according to its card; implex: PROPS 25, for IMPL-EX.

        Further arguments replace variables of the card; None removes a variable.
        """
        card = json.loads(interface.card("kratos", dimension=self.dimension, implex=implex))
        material = card["properties"][0]["Material"]
        properties = self.part.CreateNewProperties(self.part.NumberOfProperties() + 1)
        properties.SetValue(Kratos.CONSTITUTIVE_LAW, _law(material["constitutive_law"]["name"]))
        for name, value in (material["Variables"] | variables).items():
            value = Kratos.Vector(value) if isinstance(value, list) else value
            if value is not None:
                properties.SetValue(Kratos.KratosGlobals.GetVariable(name), value)
        return properties

    def add_mesh(
        self,
        mesh: Jointed,
        solid: Kratos.Properties,
        joint: Kratos.Properties | Mapping[str, Kratos.Properties],
    ) -> None:
        """Add a mesh of `asperity.mesh`, by way of a .mdpa file; its nodes are numbered from 1.

        joint: properties of all joints, or of those whose names begin with each key.
        """
        with tempfile.TemporaryDirectory() as folder:
            (file,) = write(Path(folder, "mesh.mdpa"), mesh)
            Kratos.ModelPartIO(str(file.with_suffix(""))).ReadModelPart(self.part)

        def of_joint(name: str) -> Kratos.Properties:
            if not isinstance(joint, Mapping):
                return joint
            return next(properties for start, properties in joint.items() if name.startswith(start))

        for name in (*mesh.names, *mesh.joints):
            for element in self.part.GetSubModelPart(name).Elements:
                element.Properties = of_joint(name) if name in mesh.joints else solid
                if name in mesh.joints:
                    self.interfaces.append(element)

    def add_solid(self, nodes: Sequence[int], properties: Kratos.Properties) -> None:
        """Add a quadrilateral (4, 9 nodes) or hexahedron (8)."""
        self._add(f"SmallDisplacementElement{self.dimension}D{len(nodes)}N", nodes, properties)

    def add_interface(
        self, lower: Sequence[int], upper: Sequence[int], properties: Kratos.Properties
    ) -> None:
        """Add an interface between two sides with coincident nodes; it opens if upper moves away from lower.

        The axes are n, the right-hand normal of side 1 (in 2D the edge 1-2 rotated to the left), s along the
        edge 1-2, and t = n x s.  Middle nodes follow the corners of each side.
        """
        name = f"{INTERFACE[self.dimension]}{len(lower)}Plus{len(upper)}N"
        self.interfaces.append(self._add(name, [*lower, *upper], properties))

    def _add(self, name: str, nodes: Sequence[int], properties: Kratos.Properties) -> Kratos.Element:
        number = self.part.NumberOfElements() + 1
        return self.part.CreateNewElement(name, number, [int(node) for node in nodes], properties)

    # --- conditions ------------------------------------------------------------

    def fix(self, nodes: Sequence[int], *axes: int) -> None:
        """Constrain displacements of nodes along axes (0, 1, 2); `move` prescribes their values."""
        for node in np.ravel(nodes).tolist():
            for axis in axes:
                self.part.Nodes[node].Fix(DISPLACEMENTS[axis])

    def move(self, nodes: Sequence[int], axis: int, value: float | Callable[[Kratos.Node], float]) -> None:
        """Prescribe displacements of constrained nodes for the next step."""
        for number in np.ravel(nodes).tolist():
            node = self.part.Nodes[number]
            node.SetSolutionStepValue(DISPLACEMENTS[axis], value(node) if callable(value) else value)

    def load(self, forces: Mapping[int, Sequence[float]]) -> None:
        """Apply forces (three components) to nodes; this has to be called once before the first step."""
        properties = self.part.CreateNewProperties(self.part.NumberOfProperties() + 1)
        for number, force in forces.items():
            name = f"PointLoadCondition{self.dimension}D1N"
            self.part.CreateNewCondition(name, self.part.NumberOfConditions() + 1, [int(number)], properties)
            self.set_load(number, force)

    def set_load(self, number: int, force: Sequence[float]) -> None:
        """Change the load on a node that already has a load."""
        self.part.Nodes[int(number)].SetSolutionStepValue(Structural.POINT_LOAD, Kratos.Array3(list(force)))

    # --- steps -------------------------------------------------------------------

    def stress_solids(self, stress: Sequence[float]) -> None:
        """Set the initial stress xx, yy, (zz,) xy, (yz, xz) of all solids; the model has to be complete."""
        self.solver()  # creates the laws of all points
        interfaces = {element.Id for element in self.interfaces}
        solids = self.part.CreateSubModelPart("Solids")
        solids.AddElements([element.Id for element in self.part.Elements if element.Id not in interfaces])
        process = getattr(Kratos, f"SetInitialStateProcess{self.dimension}D")
        stress_type = 1  # 0: strain
        process(solids, Kratos.Vector(list(stress)), stress_type).ExecuteInitializeSolutionStep()

    def step(self, tolerance: float, again: bool = False, time: float = 1.0) -> list[float]:
        """Solve a step to a norm of the residual force; return the norm after every iteration.

        The norm is that of Kratos, the root of the mean square over the free components.  It is 0 here if no
        component is free.  With `again` the last step is solved once more with the current prescribed values.
        `time` is that of the step, for viscous damage.

        If the iterations do not converge, Lost is raised and all displacements are those of the last step.
        """
        strategy = self.solver()
        information = self.part.ProcessInfo
        if not again:
            self.part.CloneTimeStep(information[Kratos.TIME] + time)
            information[Kratos.STEP] += 1
        information[Kratos.DELTA_TIME] = time
        strategy.InitializeSolutionStep()
        strategy.Predict()
        free = any(
            not node.IsFixed(axis) for node in self.part.Nodes for axis in DISPLACEMENTS[: self.dimension]
        )
        norms: list[float] = []
        while not norms or norms[-1] > tolerance:
            strategy.SolveSolutionStep()  # one iteration, then the residual and the reactions
            norms.append(float(information[Kratos.RESIDUAL_NORM]) if free else 0.0)
            if len(norms) == MOST_ITERATIONS or not np.isfinite(norms[-1]):
                for node in self.part.Nodes:
                    last = node.GetSolutionStepValue(Kratos.DISPLACEMENT, 1)
                    node.SetSolutionStepValue(Kratos.DISPLACEMENT, last)
                raise Lost(information[Kratos.STEP], norms, tolerance)
        strategy.FinalizeSolutionStep()
        return norms

    def solver(self) -> Kratos.ResidualBasedNewtonRaphsonStrategy:
        """Return the strategy of Kratos, with the laws of all points; the model has to be complete."""
        if self._strategy is None:
            utilities = Kratos.VariableUtils()
            for axis in range(3):
                utilities.AddDof(DISPLACEMENTS[axis], REACTIONS[axis], self.part)
            utilities.AddDof(Kratos.WATER_PRESSURE, Kratos.REACTION_WATER_PRESSURE, self.part)
            for node in self.part.Nodes:
                node.Fix(Kratos.WATER_PRESSURE)
                if self.dimension == 2:
                    node.Fix(Kratos.DISPLACEMENT_Z)
            solver = solvers.ConstructSolver(
                Kratos.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}')
            )
            compute_reactions, reform, move_mesh = True, False, False
            self._strategy = Kratos.ResidualBasedNewtonRaphsonStrategy(
                self.part, Kratos.ResidualBasedIncrementalUpdateStaticScheme(),
                Kratos.ResidualCriteria(0.0, 0.0), Kratos.ResidualBasedBlockBuilderAndSolver(solver),
                1, compute_reactions, reform, move_mesh,
            )  # fmt: skip
            self._strategy.SetEchoLevel(0)
            self._strategy.Initialize()
            self._strategy.Check()
        return self._strategy

    # --- results -------------------------------------------------------------------

    def displacements(self) -> Floats:
        """Return the displacements of all nodes (n, dimension), in the order of their numbers."""
        values = [list(node.GetSolutionStepValue(Kratos.DISPLACEMENT)) for node in self.part.Nodes]
        return np.array(values)[:, : self.dimension]

    def reaction(self, nodes: Sequence[int]) -> Floats:
        """Return the sum of the reactions of nodes (dimension,)."""
        at_nodes = (self.part.Nodes[node] for node in np.ravel(nodes).tolist())
        values = [list(node.GetSolutionStepValue(Kratos.REACTION)) for node in at_nodes]
        total: Floats = np.sum(values, axis=0)[: self.dimension]
        return total

    def implex_errors(self) -> tuple[float, float]:
        """Largest errors of damage and traction of all points with IMPL-EX in the last iteration."""
        errors = (ctypes.c_double * 2)()
        ctypes.CDLL(str(named_library("asperity_kratos"))).asperity_kratos_errors(errors)
        return errors[0], errors[1]

    def points(self) -> tuple[Floats, Floats]:
        """Return separations and tractions (points, 3) of all points as (N, Tx, Ty); Ty is 0 in 2D."""
        fields, info = [], self.part.ProcessInfo
        for name in (Geo.GEO_RELATIVE_DISPLACEMENT_VECTOR, Geo.GEO_EFFECTIVE_TRACTION_VECTOR):
            rows = [
                list(x)
                for element in self.interfaces
                for x in element.CalculateOnIntegrationPoints(name, info)
            ]
            fields.append(np.pad(np.array(rows), ((0, 0), (0, 3 - self.dimension))))
        return fields[0], fields[1]


def _law(name: str) -> Kratos.ConstitutiveLaw:
    return Kratos.KratosGlobals.Kernel.GetConstitutiveLaw(name).Clone()
