"""What may act on a wheelset, which turns freely in its frame: ends on its axle (theory.md section 5.9)."""

from .elements import Link
from .friction_elements import Friction
from .moments import Matrix, Torque

ON_AXLE = 1e-9  # place along the vehicle of an element's end on the axle of its wheelset: rounding [m]
NEAR_AXLE = 0.005  # height over the axle within which an element moves onto it: worn wheels [m]
_AXLE_BOX = "or let it act on an axle box, a body that a bushing on the axle holds (docs/scenario.md, Axle boxes)"


def fault_on_wheelset(joint, lower, upper):
    """What would give a wheelset's spin a moment or energy that no bearing does; an empty text if nothing."""
    if joint.total_turn_stiffness[1] > 0.0:
        return "a wheelset spins, so its joints take no turn stiffness about y"
    if joint.total_turn_stiffness.any() and lower.is_wheelset and upper.is_wheelset:
        return "turn stiffness between two wheelsets is not possible; join each with a body that does not spin"
    placed = ((f"{key}[{n}]", each) for key, row in joint.lists.items() for n, each in enumerate(row, start=1))
    for place, element in placed:
        body = lower if lower.is_wheelset else upper
        if isinstance(element, Torque):
            if not element.is_along_y:
                return f"{place} turns {body.name!r} about another axis than its axle; give axis = [0, 1, 0]"
            if element.springs:
                return f"{place}: {body.name!r} turns without end about its axle, where no spring can act"
        elif isinstance(element, Matrix):
            return f"{place}: a matrix would hold the axle of {body.name!r} from turning; use a bushing, {_AXLE_BOX}"
        elif not _is_a_line(element) and (upper.is_wheelset or joint.axes != "upper"):
            return (
                f"{place} would drive the spin of {body.name!r} as its ends move apart; give axes = \"upper\" and name "
                f"the wheelset first in the pair, {_AXLE_BOX}"
            )
        for end, one in zip(element.ends, (lower, upper), strict=True):
            off = lower.x + end[0] - one.x, end[2] - one.centre[2]
            if isinstance(element, Torque) or not one.is_wheelset:
                continue
            if abs(off[0]) > ON_AXLE or abs(off[1]) > NEAR_AXLE:
                return (
                    f"{place} acts {off[0] * 1e3:.4g} mm ahead of and {off[1] * 1e3:.4g} mm over the axle of "
                    f"{one.name!r}, which turns freely; put that end on the axle {_AXLE_BOX}"
                )
    return ""


def _is_a_line(element):
    """True when it acts along the line between two points."""
    return isinstance(element, Link) or (isinstance(element, Friction) and element.is_link)


def on_axle(ends, bodies):
    """Both ends of an element, raised or lowered together so that the one on a wheelset lies on its axle."""
    for end, body in zip(ends, bodies, strict=True):
        if body.is_wheelset:
            up = body.centre[2] - end[2]
            return [(x, y, other.centre[2] if other.is_wheelset else height + up)
                    for (x, y, height), other in zip(ends, bodies, strict=True)]  # fmt: skip
    return ends
