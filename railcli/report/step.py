"""The time step of a run in words and numbers."""

from railcli.analysis.step_choice import bound, milliseconds
from railcli.analysis.step_limit import MARGIN


def words(choice):
    """Name and value of facts: the step and whether it was chosen or given, and what limits it."""
    how = "chosen" if choice.chosen else "given"
    return [
        ("step", f"{choice.step * 1e3:.4g} ms, {how}; {bound(choice.limit)}"),
        ("limited by", choice.limit.limited_by),
    ]


def as_json(choice):
    """What a summary holds of a StepChoice."""
    return {
        "step_ms": choice.step * 1e3,
        "chosen": choice.chosen,
        "longest_ms": milliseconds(choice.limit.allowed),
        "stable_up_to_ms": milliseconds(choice.limit.stable),
        "margin": MARGIN,
        "limited_by": choice.limit.limited_by,
    }
