"""What must not lie in the repository: lock files, names of package registries, tolerances of two meanings."""

import ast
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LOCK_FILES = {"uv.lock", "poetry.lock", "pdm.lock", "pylock.toml", "Pipfile.lock", "conda-lock.yml", "pixi.lock"}
REGISTRIES = [".".join(parts) for parts in (("pypi", "org"), ("pythonhosted", "org"), ("anaconda", "org"))]
INDEX_SETTINGS = ["-".join(parts) for parts in (("index", "url"), ("find", "links"))]


@pytest.fixture(scope="module")
def files():
    """Every file that is or would be committed."""
    if not (ROOT / ".git").exists() or not shutil.which("git"):
        pytest.skip("the repository's list of files needs git and a checkout")
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return [ROOT / name for name in listing.stdout.split("\0") if name and (ROOT / name).is_file()]


def test_no_lock_file(files):
    assert [path for path in files if path.name in LOCK_FILES] == []


def test_no_registry_is_named(files):
    words = [word.encode() for word in REGISTRIES + INDEX_SETTINGS]
    assert [(path, word) for path in files for word in words if word in path.read_bytes()] == []


def test_a_tolerance_has_one_meaning():
    """The second of two of one name would silently be that of all tests of the first."""
    tree = ast.parse((ROOT / "tests" / "tolerances.py").read_text(encoding="utf-8"))
    names = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    assert len(names) > 100
    assert sorted(name for name in set(names) if names.count(name) > 1) == []
