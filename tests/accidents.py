"""How files change by accident, by editors and by other programs; and some files to begin with."""

import re

import numpy as np

from railcli.files.resources import VEHICLES, resource

NUMBER = re.compile(rb"(?<!\w)[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
DECIMAL = re.compile(rb"(?<!\w)[-+]?\d+\.\d+")
NO_NUMBERS = [
    b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-320", b"1e400", b"text", b"", b"0", b"1,5", b"1_0", b".",
]  # fmt: skip
VALUES = [
    *NO_NUMBERS, b'"text"', b"-1", b"1e150", b"[]", b"[1, 2]", b"{}", b"{a = 1}", b"true", b"1979-05-27", b"9" * 400,
    b'"\\u0000"', b'"a\\nb"', b'""', b'"' + b"x" * 300 + b'"',
]  # fmt: skip
KEYS = [
    b"kind", b"name", b"vehicle", b"contact", b"run", b"track", b"body", b'"\\n"', b"mass_kg", b"left_wheel_radius_mm",
]  # fmt: skip


def at(data, place, pattern):
    found = list(pattern.finditer(data))
    return found[int(place * (len(found) - 1))] if found else None


def replace_number(data, place, value):
    match = at(data, place, NUMBER)
    return data[: match.start()] + value + data[match.end() :] if match else data


def lines_changed(data, place, count, what):
    lines = data.split(b"\n")
    i = int(place * (len(lines) - 1))
    part = lines[i : i + count]
    new = {"repeat": part * 2, "drop": [], "reverse": part[::-1], "shuffle": part[1::2] + part[::2]}[what]
    return b"\n".join(lines[:i] + new + lines[i + count :])


def closed(data, place):
    """All lines to a place, and back again."""
    lines = data.split(b"\n")
    return b"\n".join([*lines, *lines[: int(place * len(lines))][::-1]])


def scaled(data, factor):
    return DECIMAL.sub(lambda match: b"%.9g" % (float(match[0]) * factor), data)


def noisy(data, size, seed):
    noise = np.random.default_rng(seed)
    return DECIMAL.sub(lambda match: b"%.9g" % (float(match[0]) + noise.normal(0.0, size)), data)


def flipped(data, place, bit):
    i = int(place * (len(data) - 1))
    return data[:i] + bytes([data[i] ^ 1 << bit]) + data[i + 1 :] if data else data


def encoded(data, name):
    return data.decode("latin-1").encode(name)


def replace_value(data, place, value):
    match = at(data, place, re.compile(rb"(?m)= *(.*)$"))
    return data[: match.start(1)] + value + data[match.end(1) :] if match else data


def replace_key(data, place, key):
    match = at(data, place, re.compile(rb"(?m)^[\w ]+="))
    return data[: match.start()] + key + b" =" + data[match.end() :] if match else data


def add_line(data, place, key, value):
    lines = data.split(b"\n")
    lines.insert(int(place * len(lines)), key + b" = " + value)
    return b"\n".join(lines)


def cut(data, place):
    return data[: int(place * len(data))]


def exchanged(data, old, new):
    return data.replace(old, new)


def changed(data, changes):
    for function, *values in changes:
        data = function(data, *values)
    return data


# Files


RECORDING = "km;level_left [mm];level_right [mm];gauge [mm];cross_level [mm];versine_10m [mm]\n" + "".join(
    f"{12.4 + k / 4000:.5f};{np.sin(k / 9):.3f};{np.cos(k / 7):.2f};1436.{k % 10};{k / 9:.1f};{np.sin(k / 5):.2f}\n"
    for k in range(500)
)
LINE = "position_km,radius_m,cant_mm,gradient_permille,gauge_mm\n" + "".join(
    f"{12.4 + k / 10},{800 if k > 3 else 0},{100 if k > 3 else 0},2.5,1435\n" for k in range(12)
)

RUN = b"""
vehicle = "vehicle.toml"
[run]
speed_kmh = 72
step_ms = 0.5
average_over_m = 20
[contact]
wheel_profile = "ORES1002"
left_rail_profile = "worn.csv"
inclination = 40
gauge_mm = 1435
friction = 0.3
creep_law = "hard"
young_GPa = 210
[start]
lateral_mm = 1
[[track]]
kind = "straight"
length_m = 50
[[track]]
kind = "transition"
length_m = 50
shape = "bloss"
[[track]]
kind = "curve"
length_m = 50
radius_m = 500
hand = "left"
cant_mm = 80
"""
VEHICLE = resource(VEHICLES["manchester"]).read_bytes()
