"""Readers given changed files, many in one process: `python readers.py READER SEED COUNT FOLDER` prints the counts.

Each input has 20 s and the process 3 GB; one that takes more, or ends in anything but a result or an InputError of one
line, is kept in FOLDER and ends it.
"""

import json
import resource
import signal
import sys
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parents[2])]

import accidents as acc  # noqa: E402

from railcli.errors import InputError  # noqa: E402

MEMORY, SECONDS = 3_000_000_000, 20
TESTS = Path(__file__).parents[1]
SAMPLES = sorted((TESTS / "data/samples").glob("*.[bwp]*"))
RECORDINGS = sorted((TESTS.parent / "examples/recording").glob("*.csv"))
LIMITS = b"sum_Y_factor = 0.85\nY_over_Q = 0.8\nQ_max_N = 145e3\nstability_share = 0.5\n"


def some(random, values):
    return values[random.integers(len(values))]


def change_of(random):
    place = random.random()
    return some(random, [
        (acc.replace_number, place, some(random, acc.NO_NUMBERS)),
        (acc.lines_changed, place, some(random, [1, 2, 3, 50, 1000]),
         some(random, ["repeat", "drop", "reverse", "shuffle"])),
        (acc.closed, place),
        (acc.scaled, some(random, [-1.0, 1e-3, 1e3, 25.4, 0.0, 1e300])),
        (acc.noisy, some(random, [1e-5, 1e-3, 0.02, 0.3]), int(random.integers(10))),
        (acc.flipped, place, int(random.integers(8))),
        (acc.encoded, some(random, ["utf-16", "utf-16-le", "utf-8-sig", "latin-1"])),
        (acc.cut, place),
        (acc.exchanged, some(random, [b"\n", b",", b".", b" ", b"="]),
         some(random, [b"\r\n", b"\r", b";", b",", b" ", b"\t", b"\n\n", b"\xe2\x80\xa8"])),
    ])  # fmt: skip


def toml_change_of(random):
    place = random.random()
    return some(random, [
        (acc.replace_number, place, some(random, acc.VALUES)),
        (acc.replace_value, place, some(random, acc.VALUES)),
        (acc.replace_key, place, some(random, acc.KEYS)),
        (acc.add_line, place, some(random, acc.KEYS), some(random, acc.VALUES)),
        change_of(random),
    ])  # fmt: skip


def changed(random, data, change=change_of, most=3):
    return acc.changed(data, [change(random) for _ in range(random.integers(1, most + 1))])


def profiles(random, folder):
    from railcli.files.profile_import import ImportSettings, import_profile
    from railcli.files.profiles import load_profile
    from railcli.files.resources import BUNDLED
    from railcli.files.resources import resource as bundled

    source = some(random, [*SAMPLES, *(bundled(place) for _, place in BUNDLED.values())])
    ending = some(random, [source.suffix] * 4 + [".txt", ".csv", ".ban", ".whl", ".prr", ".rail"])
    path = folder / f"a{ending}"
    path.write_bytes(changed(random, source.read_bytes()))
    kind = some(random, ["rail", "wheel"])
    if random.random() < 0.5:
        return path, lambda: load_profile(path, kind)
    return path, lambda: import_profile(path, ImportSettings(kind=some(random, [None, kind])))


def tracks(random, folder):
    from railcli.files.irregularity import Asked, recording
    from railcli.files.track_import import import_track
    from railcli.files.track_table import alignment

    texts = [acc.RECORDING.encode(), acc.LINE.encode(), *(path.read_bytes()[:20_000] for path in RECORDINGS)]
    path = folder / "track.csv"
    path.write_bytes(changed(random, some(random, texts)))
    asked = Asked(bridge=some(random, [0.0, 5.0]))
    return path, some(random, [
        lambda: recording(path, asked), lambda: alignment(path), lambda: import_track([path], asked)
    ])  # fmt: skip


def scenarios(random, folder):
    from railcli.files import scenario

    path = folder / "case.toml"
    path.write_bytes(changed(random, acc.RUN, toml_change_of) if random.random() < 0.7 else acc.RUN)
    vehicle = folder / "vehicle.toml"
    vehicle.write_bytes(changed(random, acc.VEHICLE, toml_change_of, 2) if random.random() < 0.5 else acc.VEHICLE)
    return path, lambda: scenario.load(path)


def vehicles(random, folder):
    from railcli.files.resources import VEHICLES
    from railcli.files.resources import resource as bundled
    from railcli.files.scenario import load_vehicle

    path = folder / "vehicle.toml"
    source = bundled(some(random, list(VEHICLES.values())))
    path.write_bytes(changed(random, source.read_bytes(), toml_change_of))
    return path, lambda: load_vehicle(path)


def limits(random, folder):
    from railcli.files.limits import load_limits

    path = folder / "limits.toml"
    path.write_bytes(changed(random, LIMITS, toml_change_of))
    return path, lambda: load_limits(path)


def sealed(random, folder):
    """Results of a run, copied to FOLDER/whole before: one of its files is changed, and all of it is read."""
    from railcli.files.read_results import Results

    place = folder / "results"
    place.mkdir(exist_ok=True)
    names = ["timeseries.h5", "inputs.h5", "scenario.json", "summary.json", ".railcli"]
    for name in names:
        (place / name).write_bytes((folder / "whole" / name).read_bytes())
    path = place / some(random, names[:4])
    before = path.read_bytes()
    change = some(random, [(acc.flipped, random.random(), int(random.integers(8))), (acc.cut, random.random())])
    path.write_bytes(after := acc.changed(before, [change]))

    def read():
        with Results(place) as results:
            assert results.scenario and results.summary
            for channel in results.channels:
                results.read(channel)
        assert after == before, "damage was not seen"

    return path, read


def tables(random, folder):
    from railcli.files import tables

    whole = (folder / "whole/table.h5").read_bytes()
    path = folder / "table.h5"
    change = some(random, [(acc.flipped, random.random(), int(random.integers(8))), (acc.cut, random.random())])
    path.write_bytes(after := acc.changed(whole, [change]))

    def read():
        tables.read(path)
        assert after == whole, "damage was not seen"

    return path, read


READERS = {one.__name__: one for one in (profiles, tracks, scenarios, vehicles, limits, sealed, tables)}


def too_long(*_):
    raise TimeoutError(f"more than {SECONDS} s")


def main(reader, seed, count, folder):
    folder, found = Path(folder), Counter()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGALRM, too_long)
    warnings.simplefilter("ignore")
    for number in range(int(count)):
        random = np.random.default_rng([int(seed), number, *reader.encode()])
        path, read = READERS[reader](random, folder)
        signal.alarm(SECONDS)
        try:
            read()
            found["read"] += 1
        except InputError as error:
            found["refused"] += 1
            text = str(error)
            if not (text.isprintable() and len(text) < 1500):
                found["faults"] += 1
                print(f"{reader} {seed} {number}: {text!r}", file=sys.stderr)
        except BaseException as error:
            found["faults"] += 1
            kept = folder / f"fault-{reader}-{number}{path.suffix}"
            kept.write_bytes(path.read_bytes())
            print(f"{reader} {seed} {number}: {type(error).__name__}: {error}; {kept}", file=sys.stderr)
            if found["faults"] >= 10:
                break
        finally:
            signal.alarm(0)
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
