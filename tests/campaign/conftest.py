"""A campaign tries by chance and by number what other tests try by thought; it is run on request, and tells its counts.

`pytest -m campaign` takes some ten minutes (a night's share); `RAILCLI_CAMPAIGN=100 pytest -m campaign` does a hundred
times as much. RAILCLI_CAMPAIGN_SEED begins elsewhere.
"""

import os
from collections import Counter

import numpy as np
import pytest

FACTOR = float(os.environ.get("RAILCLI_CAMPAIGN", "1"))
SEED = int(os.environ.get("RAILCLI_CAMPAIGN_SEED", "1"))
COUNTS = {}


@pytest.fixture
def many():
    """Function that gives how often something is tried, for a night's share."""
    return lambda share: max(1, round(share * FACTOR))


@pytest.fixture
def random(request):
    """Random numbers, other ones for each test."""
    return np.random.default_rng([SEED, *request.node.name.encode()])


@pytest.fixture
def counts(request):
    """What came of it, told at the end."""
    return COUNTS.setdefault(request.node.name, Counter())


def pytest_terminal_summary(terminalreporter):
    if COUNTS:
        terminalreporter.section("campaign")
    for name, counts in COUNTS.items():
        told = ", ".join(f"{count} {what}" for what, count in sorted(counts.items(), key=lambda item: -item[1]))
        terminalreporter.write_line(f"{name}: {sum(counts.values())} tried: {told}")
