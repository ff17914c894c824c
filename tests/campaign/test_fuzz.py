"""Every reader, given files as accidents leave them: a result or one line of error, in little time and memory."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from railcli.files import tables

pytestmark = [pytest.mark.campaign, pytest.mark.skipif(os.name != "posix", reason="limits of Unix")]
HERE = Path(__file__).parent
SHARES = {
    "profiles": 1500, "tracks": 2000, "scenarios": 700, "vehicles": 500, "limits": 3000, "sealed": 300, "tables": 800,
}  # fmt: skip


@pytest.mark.parametrize("reader", SHARES)
def test_readers(reader, many, counts, random, recorded, table, tmp_path):
    (tmp_path / "whole").mkdir()
    if reader == "sealed":
        shutil.copytree(recorded(), tmp_path / "whole", dirs_exist_ok=True)
    if reader == "tables":
        tables.save(table, tmp_path / "whole/table.h5")
    seed, count = int(random.integers(2**31)), many(SHARES[reader])
    done = subprocess.run(
        [sys.executable, str(HERE / "readers.py"), reader, str(seed), str(count), str(tmp_path)],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    counts.update(found)
    assert not found.get("faults"), done.stderr[-3000:]
