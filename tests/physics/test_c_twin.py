"""Stages of the core against the same written in plain C."""

import pytest
import scenes
import tolerances as tol

from benchmarks.speed import c_twin, equality


@pytest.mark.skipif(not c_twin.compiler(), reason="gcc is not installed, which builds the C twin")
def test_stages_against_c(wagon, tmp_path):
    """Suspension, contact and creep at shaken states, creep laws of one factor."""
    repeat = None
    for law in equality.LAWS:
        system = scenes.tuned(wagon, creep_law=int(law))
        for data in equality.states(system):
            repeat = repeat or c_twin.build(system.model, data, tmp_path)
            found = equality.against_c(system, data, repeat)
            assert max(found.values()) < tol.TWIN, found
