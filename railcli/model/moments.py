"""Elements that turn bodies against each other: a torque about one axis, and the matrix of all six relative motions."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, model_validator

from .checks import NONE, Coefficient, Description, Flag, Name, NotNegative, Real
from .element_parts import MIRRORS, AtPoint, mirrored_apart
from .tables import TurnDamperTable, TurnTable

SEMIDEFINITE = 1e-9  # of the largest eigenvalue: what the rounding of a file's digits may take below zero
_Entry = Annotated[Real, Field(ge=-1e15, le=1e15)]
_Row = tuple[_Entry, _Entry, _Entry]
_Block = tuple[_Row, _Row, _Row]
_EMPTY = (NONE, NONE, NONE)
_Share = Annotated[Real, Field(ge=-1.0, le=1.0)]
_SIDES = ((1.0, 1.0, 1.0, 1.0, 1.0, 1.0), (-1.0, 1.0, 1.0, 1.0, -1.0, -1.0), (1.0, -1.0, 1.0, -1.0, 1.0, -1.0))


class Matrix(AtPoint):
    """Stiffness and damping that couple displacements and rotations about x, y, z, both ends at one point.

    Blocks of the symmetric 6 x 6 matrices: force over displacement, force over rotation (its transpose is moment over
    displacement), moment over rotation.
    """

    stiffness: _Block = Field(_EMPTY, alias="stiffness_N_per_m")
    coupling_stiffness: _Block = Field(_EMPTY, alias="coupling_stiffness_N_per_rad")
    turn_stiffness: _Block = Field(_EMPTY, alias="turn_stiffness_Nm_per_rad")
    damping: _Block = Field(_EMPTY, alias="damping_Ns_per_m")
    coupling_damping: _Block = Field(_EMPTY, alias="coupling_damping_Ns_per_rad")
    turn_damping: _Block = Field(_EMPTY, alias="turn_damping_Nms_per_rad")
    carries_weight: Flag = False

    def packed(self, sign):
        """Stiffness above damping, (12, 6), of the copy with these signs of x and y."""
        flip = np.prod([_SIDES[1 + axis] for axis in (0, 1) if sign[axis] < 0] or [_SIDES[0]], axis=0)
        return np.concatenate([flip[:, None] * matrix * flip for matrix in (self.k, self.c)])

    @property
    def k(self):
        """Stiffness matrix (6, 6)."""
        return _joined(self.stiffness, self.coupling_stiffness, self.turn_stiffness)

    @property
    def c(self):
        """Damping matrix (6, 6)."""
        return _joined(self.damping, self.coupling_damping, self.turn_damping)

    @model_validator(mode="after")
    def _is_passive(self):
        for word, matrix, alias in (
            ("stiffness", self.k, "stiffness_N_per_m"),
            ("damping", self.c, "damping_Ns_per_m"),
        ):
            for block, name in ((matrix[:3, :3], alias), (matrix[3:, 3:], f"turn_{word}_...")):
                i, j = np.unravel_index(np.argmax(np.abs(block - block.T)), (3, 3))
                if block[i, j] != block[j, i]:
                    raise ValueError(
                        f"{name} must be symmetric; row {i + 1}, column {j + 1} is {block[i, j]:g}, "
                        f"row {j + 1}, column {i + 1} is {block[j, i]:g}"
                    )
            size = np.sqrt(np.abs(np.diag(matrix)))
            scale = np.where(size > 0.0, size, 1.0)
            values = np.linalg.eigvalsh(matrix / np.outer(scale, scale))
            if values[0] < -SEMIDEFINITE * max(abs(values).max(), 1.0):
                raise ValueError(
                    f"the {word} matrix must not have a negative eigenvalue, or it would give energy; scaled to a "
                    f"unit diagonal its least one is {values[0]:.3g}"
                )
        if not (self.k.any() or self.c.any()):
            raise ValueError("does nothing; give stiffness_N_per_m or one of the other blocks")
        return mirrored_apart(self)


def _joined(block, coupling, turn):
    coupling = np.array(coupling)
    return np.block([[np.array(block), coupling], [coupling.T, np.array(turn)]])


class Torque(Description):
    """Turns two bodies against each other about one axis: spring, damper, dry friction, a constant moment.

    About the axle of a wheelset it acts on its spin: a brake, a motor, the drag of a bearing.
    """

    name: Name
    axis: tuple[_Share, _Share, _Share] = (0.0, 1.0, 0.0)  # forward, right, down; made a unit vector
    turn_stiffness: Coefficient = Field(0.0, alias="turn_stiffness_Nm_per_rad")
    turn_table: TurnTable | None = None
    turn_damping: Coefficient = Field(0.0, alias="turn_damping_Nms_per_rad")
    turn_damper_table: TurnDamperTable | None = None
    friction: NotNegative = Field(0.0, alias="friction_Nm")
    torque: Annotated[Real, Field(ge=-1e9, le=1e9)] = Field(0.0, alias="torque_Nm")  # on the upper body

    ends: ClassVar = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # it acts at no place
    signs: ClassVar = MIRRORS["none"]

    @property
    def direction(self):
        """Unit vector along its axis."""
        return np.array(self.axis) / np.linalg.norm(self.axis)

    @property
    def is_along_y(self):
        return self.axis[0] == 0.0 and self.axis[2] == 0.0

    @property
    def springs(self):
        return self.turn_stiffness > 0.0 or self.turn_table is not None

    @model_validator(mode="after")
    def _acts(self):
        if not np.any(self.axis):
            raise ValueError("axis = [0, 0, 0] is no direction")
        if self.turn_damping > 0.0 and self.turn_damper_table is not None:
            raise ValueError("give either turn_damping_Nms_per_rad or turn_damper_table, not both")
        damps = self.turn_damping > 0.0 or self.turn_damper_table is not None
        if not (self.springs or damps or self.friction > 0.0 or self.torque != 0.0):
            raise ValueError(
                "does nothing; give turn_stiffness_Nm_per_rad, turn_damping_Nms_per_rad, friction_Nm or torque_Nm"
            )
        return self
