"""Rules for the source of railcli that can be read off its syntax trees: floors, kernels, safety, size."""

import ast
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "railcli"
FILES = sorted(PACKAGE.rglob("*.py"))
LINES_ALLOWED = 500
LONGEST_COMMAND = 40  # lines of a function of commands behind its docstring: options, study, print
STILL_LONG = {  # commands that hold a study themselves; whoever moves one out takes it off this list
    "railcli.commands.build_lut: _build",
    "railcli.commands.contact: contact",
    "railcli.commands.profile: shape_options",
    "railcli.commands.rt_bench: _measure",
}

FLOORS = {
    "kernels": 0,
    "model": 1,
    "analysis": 2,
    "files": 3,
    "report": 4,
    "runtime": 4,
    "studies": 5,
    "door": 6,
    "commands": 6,
    "cli": 7,
    "__main__": 8,
}
OUTSIDE_KERNELS = {"math", "enum", "typing", "numpy", "numba"}
OF_THE_COMPILER = {"jit.py", "kept.py", "place.py"}  # which may use the standard library and what numba stands on
BELOW_ALL = {None, "errors", "interruption"}  # what other modules may import wherever they stand
UNSAFE_MODULES = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}
UNSAFE_CALLS = {"eval", "exec"}
COMPILERS = {"jit", "njit", "vectorize", "guvectorize", "stencil", "jitclass"}


def module_name(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_names(path, tree):
    """Absolute dotted names of all imports, those inside functions too."""
    package = module_name(path).split(".")
    if path.name != "__init__.py":
        package = package[:-1]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            base = base + (node.module.split(".") if node.module else [])
            yield from (".".join([*base, alias.name]) for alias in node.names)


def floor(name):
    """Second part of a dotted name inside railcli; None for another package or railcli itself."""
    parts = name.split(".")
    return parts[1] if parts[0] == "railcli" and len(parts) > 1 and parts[1] != "__version__" else None


def wrong_imports(path, tree):
    if module_name(path) == PACKAGE.name:
        return  # the door for Python users, whose functions may import from any floor
    mine = floor(module_name(path))
    for name in imported_names(path, tree):
        other = floor(name)
        if mine == "kernels" and name.startswith("railcli") and other != "kernels":
            yield name
        if other is None or other == mine:
            continue
        if mine in BELOW_ALL or (other not in BELOW_ALL and FLOORS[other] >= FLOORS[mine]):
            yield name


def foreign_imports(path, tree):
    """What a kernel module imports beside the kernels and the few libraries whose version the cache knows."""
    more = sys.stdlib_module_names | {"llvmlite"} if path.name in OF_THE_COMPILER else set()
    allowed = OUTSIDE_KERNELS | more
    for name in imported_names(path, tree):
        if not name.startswith("railcli.kernels") and name.split(".")[0] not in allowed:
            yield name


def unsafe_code(path, tree):
    for name in imported_names(path, tree):
        if name.split(".")[0] in UNSAFE_MODULES:
            yield name
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and node.func.id in UNSAFE_CALLS:
                yield f"{node.func.id}(...), line {node.lineno}"
            if any(keyword.arg == "allow_pickle" for keyword in node.keywords):
                yield f"allow_pickle, line {node.lineno}"


def own_compilers(path, tree):
    """Uses of numba's decorators outside kernels/jit.py, which alone knows the options and the cache."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.value.id in ("numba", "nb") and node.attr in COMPILERS:
                yield f"{node.value.id}.{node.attr}, line {node.lineno}"
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "numba":
            yield from (f"{alias.name}, line {node.lineno}" for alias in node.names if alias.name in COMPILERS)


def silent_kernels(path, tree):
    """Public compiled functions without a docstring."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_") and not ast.get_docstring(node):
            names = {getattr(getattr(item, "func", item), "id", None) for item in node.decorator_list}
            if names & {"kernel", "entry"}:
                yield f"{node.name}, line {node.lineno}"


def long_functions(path, tree):
    """Functions longer than LONGEST_COMMAND."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            body = node.body[1:] if ast.get_docstring(node) else node.body
            if body and node.end_lineno - body[0].lineno + 1 > LONGEST_COMMAND:
                yield node.name


def loud_studies(path, tree):
    """What a study must not do: know options, print."""
    yield from (name for name in imported_names(path, tree) if name.split(".")[0] in ("click", "rich"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("print", "input"):
            yield f"{node.func.id}(...), line {node.lineno}"


def complaints(rule, files=None):
    for path in FILES if files is None else files:
        for complaint in rule(path, ast.parse(path.read_text(encoding="utf-8"))):
            yield f"{module_name(path)}: {complaint}"


def on_floor(name):
    return [path for path in FILES if floor(module_name(path)) == name]


def test_every_module_has_a_floor():
    assert {floor(module_name(path)) for path in FILES} <= {*BELOW_ALL, *FLOORS}


def test_imports_point_down():
    assert list(complaints(wrong_imports)) == []


def test_kernels_import_only_what_the_cache_digest_covers():
    assert list(complaints(foreign_imports, on_floor("kernels"))) == []


def test_users_files_are_data():
    assert list(complaints(unsafe_code)) == []


def test_one_place_compiles():
    assert list(complaints(own_compilers, [path for path in FILES if path != PACKAGE / "kernels/jit.py"])) == []


def test_public_kernels_are_documented():
    assert list(complaints(silent_kernels, on_floor("kernels"))) == []


def test_commands_are_options_study_print():
    assert set(complaints(long_functions, on_floor("commands"))) == STILL_LONG


def test_studies_are_quiet():
    assert list(complaints(loud_studies, on_floor("studies") + on_floor("door"))) == []


def test_modules_are_short():
    lengths = {module_name(path): len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    assert {name: lines for name, lines in lengths.items() if lines > LINES_ALLOWED} == {}


@pytest.mark.parametrize(
    "rule, place, code",
    [
        (wrong_imports, "model/vehicle.py", "def f():\n    from railcli.files.scenario import load"),
        (wrong_imports, "model/vehicle.py", "from ..analysis import simulate"),
        (wrong_imports, "model/vehicle.py", "from railcli import cli"),
        (wrong_imports, "runtime/udp.py", "import railcli.report"),
        (wrong_imports, "studies/run.py", "from railcli.commands.options import format_option"),
        (wrong_imports, "report/run.py", "from railcli.studies.run import run"),
        (wrong_imports, "door.py", "from railcli.commands import run"),
        (long_functions, "commands/run.py", "def run():" + 41 * "\n    pass"),
        (loud_studies, "studies/run.py", "def f():\n    import click"),
        (loud_studies, "studies/run.py", "print(3)"),
        (wrong_imports, "errors.py", "import railcli.kernels.jit"),
        (wrong_imports, "kernels/creep.py", "from railcli.errors import InputError"),
        (wrong_imports, "kernels/creep.py", "from railcli import __version__"),
        (foreign_imports, "kernels/creep.py", "from scipy.special import ellipk"),
        (foreign_imports, "kernels/creep.py", "import os"),
        (unsafe_code, "files/tables.py", "import pickle as p"),
        (unsafe_code, "files/tables.py", "x = eval(text)"),
        (unsafe_code, "files/tables.py", "numpy.load(path, allow_pickle=True)"),
        (own_compilers, "kernels/creep.py", "@numba.njit(cache=True)\ndef f(): pass"),
        (own_compilers, "kernels/creep.py", "from numba import njit"),
        (silent_kernels, "kernels/creep.py", "@kernel\ndef linear(x): return x"),
        (silent_kernels, "kernels/creep.py", "@entry(SIGNATURE)\ndef core(x): return x"),
    ],
)
def test_rule_sees_its_violation(rule, place, code):
    assert list(rule(PACKAGE / place, ast.parse(code)))


@pytest.mark.parametrize(
    "rule, place, code",
    [
        (wrong_imports, "model/vehicle.py", "from railcli.errors import InputError\nfrom ..kernels import layout"),
        (wrong_imports, "__init__.py", "def f():\n    from railcli.files.columns import columns"),
        (wrong_imports, "cli.py", "from railcli import __version__\nfrom railcli.commands.run import run"),
        (foreign_imports, "kernels/creep.py", "from math import hypot\nfrom .jit import kernel\nimport numpy as np"),
        (foreign_imports, "kernels/jit.py", "import hashlib, os, numba"),
        (unsafe_code, "files/tables.py", "evaluate(text); table.eval(text)"),
        (own_compilers, "kernels/creep.py", "from .jit import kernel\nfrom numba import carray"),
        (wrong_imports, "studies/run.py", "from railcli.report import run\nfrom .tables import tables_for"),
        (long_functions, "commands/run.py", "def run():\n    'x'" + 40 * "\n    pass"),
        (loud_studies, "studies/run.py", "voice.announce('print(3)')"),
        (silent_kernels, "kernels/creep.py", "def plain(x): return x\n@kernel\ndef _inner(x): return x"),
    ],
)
def test_rule_lets_good_code_pass(rule, place, code):
    assert list(rule(PACKAGE / place, ast.parse(code))) == []
