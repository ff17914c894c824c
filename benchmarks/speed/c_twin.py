"""Stages of the core in plain C, built with gcc for this machine and called on the arrays of the core."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np

from railcli.kernels import layout
from railcli.kernels.stages import Stage

SOURCE = Path(__file__).parent / "c"
OPTIONS = ("-std=c11", "-O3", "-march=native", "-fPIC", "-shared", "-Wall")
RECORDS = (
    "PARAM", "PIECE", "BODY", "JOINT", "ELEMENT", "CURVE", "WHEEL", "TABLE", "FRAME", "CONTACT", "RAIL",
    "STIFF", "SUPPORT", "AXLE", "ASSEMBLY", "PLAN", "LINE", "PORT", "TRAIN",
)  # fmt: skip
ENUMS = (layout.Status, layout.Kind, layout.Axes, layout.Creep, layout.Node, Stage)
SCALARS = {"f8": "double", "i8": "int64_t", "i4": "int32_t", "u8": "uint64_t"}


def compiler():
    """First line in which gcc names itself; empty where there is none."""
    if not shutil.which("gcc"):
        return ""
    return subprocess.run(["gcc", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]


def declare(name, dtype):
    """C declaration of one field of a record."""
    kind, shape = (dtype.base, dtype.shape) if dtype.shape else (dtype, ())
    return f"    {SCALARS[kind.str[1:]]} {name}{''.join(f'[{n}]' for n in shape)};"


def struct(name, lines):
    """C struct of declarations."""
    return "\n".join([f"struct {name} {{", *lines, "};"])


def pointers(name, arrays):
    """C struct of a Model or Data: each array and its length."""
    records = {np.dtype(getattr(layout, key)): key.lower() for key in RECORDS}
    lines = []
    for key, array in arrays._asdict().items():
        kind = f"struct {records[array.dtype]}" if array.dtype in records else SCALARS[array.dtype.str[1:]]
        rows = "".join(f"[{n}]" for n in array.shape[1:])
        lines.append(f"    {kind} (*{key}){rows};\n    int64_t n_{key};")
    return struct(name, lines)


def header(model, data):
    """Text of layout.h: the records, enums and constants of kernels/layout.py."""
    parts = ["#pragma once\n#include <stdint.h>"]
    parts += [f"enum {{ {', '.join(f'{m.name} = {m.value}' for m in enum)} }};" for enum in ENUMS]
    parts += [f"#define {key} {getattr(layout, key)}" for key in ("MAX_CONTACT", "NODE_CHANNELS")]
    for key in RECORDS:
        dtype = getattr(layout, key)
        parts.append(struct(key.lower(), [declare(name, dtype[name]) for name in dtype.names]))
    return "\n\n".join([*parts, pointers("model", model), pointers("data", data)]) + "\n"


def build(model, data, folder):
    """Compile the twin in a folder; returns the function repeat(model, data, stage, times)."""
    folder = Path(folder)
    (folder / "layout.h").write_text(header(model, data), encoding="utf-8")
    library = folder / "twin.so"
    sources = sorted(str(path) for path in SOURCE.glob("*.c"))
    subprocess.run(["gcc", *OPTIONS, f"-I{folder}", "-o", str(library), *sources, "-lm"], check=True)
    function = ctypes.CDLL(str(library)).repeat
    function.restype = ctypes.c_int64

    def repeat(model, data, stage, times):
        return function(packed(model), packed(data), ctypes.c_int64(int(stage)), ctypes.c_int64(times))

    return repeat


def packed(arrays):
    """Addresses and lengths of the arrays of a Model or Data, as its C struct."""
    pairs = [number for array in arrays for number in (array.ctypes.data, array.shape[0])]
    return (ctypes.c_int64 * len(pairs))(*pairs)
