"""Files appear whole or not at all, and nothing of the user's is overwritten."""

import errno
import json
import os
from pathlib import Path

import h5py
import numpy as np
import pytest

from railcli.errors import InputError, SimulationError
from railcli.files import output
from railcli.files.output import (
    output_file,
    results_folder,
    whole_file,
    whole_hdf5,
    write_json,
    write_text,
)
from railcli.kernels import place

FAILURES = [KeyboardInterrupt(), SimulationError("derailed"), ZeroDivisionError()]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def disk_full(monkeypatch):
    """The disk is full when a file is flushed."""

    def refuse(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(output.os, "fsync", refuse)


def names(folder="."):
    return sorted(str(path.relative_to(folder)) for path in Path(folder).rglob("*"))


def make_results(folder, *files):
    with results_folder("run", "curve", folder) as made:
        for name in files:
            write_text(made / name, f"old {name}")
    return made


# A file: whole or not at all


def test_file_appears_whole_with_its_folder():
    write_text("new/folder/a.csv", "x,y\n1,2\n")
    assert Path("new/folder/a.csv").read_bytes() == b"x,y\n1,2\n"
    assert names("new/folder") == ["a.csv"]


def test_file_is_not_there_before_it_is_whole():
    with whole_file("a.png") as temporary:
        temporary.write_text("half")
        assert not Path("a.png").exists()
        assert temporary.suffix == ".png" and temporary.parent == Path()
    assert names() == ["a.png"]


@pytest.mark.parametrize("failure", FAILURES, ids=repr)
@pytest.mark.parametrize("before", [None, "old"])
def test_failure_in_the_middle_leaves_what_was_there(failure, before):
    if before:
        write_text("a.txt", before)
    with pytest.raises(type(failure)), whole_file("a.txt") as temporary:
        temporary.write_text("half")
        raise failure
    assert names() == (["a.txt"] if before else [])
    assert not before or Path("a.txt").read_text() == before


def test_full_disk_is_told_and_leaves_nothing(disk_full):
    with pytest.raises(InputError, match=r"^a\.txt: cannot be written: the disk is full"):
        write_text("a.txt", "text")
    assert names() == []


@pytest.mark.parametrize(
    "number, reason",
    [
        (errno.ENOSPC, "the disk is full"),
        (errno.EACCES, "no permission"),
        (errno.EPERM, "no permission"),
        (errno.EROFS, "read-only"),
    ],
)
def test_refusal_of_the_system_names_file_and_reason(monkeypatch, number, reason):
    def refuse(path):
        raise OSError(number, "text of the system", str(path))

    monkeypatch.setattr(output.lock, "new", refuse)
    with pytest.raises(InputError) as caught:
        write_text("folder/a.txt", "text")
    assert str(caught.value).startswith(f"{Path('folder/a.txt')}: cannot be written: ")
    assert reason in str(caught.value)
    assert caught.value.exit_code == 2


def test_error_of_another_file_is_not_blamed_on_the_output():
    with pytest.raises(FileNotFoundError, match="profile.csv"), whole_file("a.txt"):
        open("profile.csv")
    assert names() == []


def test_file_in_the_way_of_a_folder():
    write_text("a", "mine")
    with pytest.raises(InputError, match="a file stands where a folder is needed"):
        write_text("a/b.txt", "text")
    assert Path("a").read_text() == "mine"


def test_new_file_has_ordinary_permissions():
    Path("ordinary").touch()
    write_text("a.txt", "text")
    assert os.stat("a.txt").st_mode == os.stat("ordinary").st_mode


def test_hdf5_file_appears_whole():
    with whole_hdf5("a.h5") as file:
        file["x"] = np.arange(3.0)
        assert not Path("a.h5").exists()
    with h5py.File("a.h5") as file:
        assert list(file["x"]) == [0.0, 1.0, 2.0]
    assert names() == ["a.h5"]


@pytest.mark.parametrize("failure", FAILURES, ids=repr)
def test_half_an_hdf5_file_leaves_nothing(failure):
    with pytest.raises(type(failure)), whole_hdf5("a.h5") as file:
        file["x"] = np.arange(3.0)
        raise failure
    assert names() == []


def test_hdf5_file_on_a_full_disk(disk_full):
    with pytest.raises(InputError, match="the disk is full"), whole_hdf5("a.h5") as file:
        file["x"] = np.arange(3.0)
    assert names() == []


def test_json_is_strict_and_takes_numpy():
    write_json(
        "a.json", {"n": np.int64(3), "ok": np.bool_(True), "y": np.array([1.5, np.nan, np.inf]), 2: (Path("b"), "µ")}
    )
    text = Path("a.json").read_text(encoding="utf-8")
    assert "NaN" not in text and "Infinity" not in text
    assert json.loads(text) == {"n": 3, "ok": True, "y": [1.5, None, None], "2": ["b", "µ"]}


# A single file that the user names


def test_existing_file_needs_overwrite():
    write_text("table.h5", "old")
    with pytest.raises(InputError, match=r"^table\.h5: exists already.*--overwrite"):
        output_file("table.h5")
    assert output_file("table.h5", overwrite=True) == Path("table.h5")


def test_folder_is_no_output_file():
    Path("folder").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        output_file("folder", overwrite=True)


@pytest.mark.skipif(not Path(os.devnull).exists(), reason="the null device has no path here")
def test_device_is_never_replaced():
    with pytest.raises(InputError, match="not a file"):
        write_text(os.devnull, "text")


# A results folder


def test_default_folders_are_numbered():
    made = [make_results(None, "a.csv") for _ in range(2)]
    Path("railcli-out/run-curve-9").mkdir()
    Path("railcli-out/run-curve-long-20").mkdir()
    made.append(make_results(None, "a.csv"))
    assert made == [Path("railcli-out") / f"run-curve-{number}" for number in (1, 2, 10)]


def test_name_of_a_scenario_cannot_leave_the_default_parent():
    with results_folder("run", "../../a b/ü") as folder:
        assert folder.parent == Path("railcli-out")
        assert folder.name.isascii()


def test_given_folder_is_made_with_its_parents():
    assert make_results("a/b/c", "summary.json") == Path("a/b/c")
    assert Path("a/b/c/summary.json").exists()


@pytest.mark.parametrize("failure", [None, *FAILURES], ids=repr)
def test_folder_without_results_is_not_left(failure):
    try:
        with results_folder("run", "curve", "out") as folder:
            assert folder.is_dir()
            if failure:
                raise failure
    except (Exception, KeyboardInterrupt) as error:
        assert error is failure
    assert names() == []


def test_whole_files_of_a_failed_run_are_kept():
    with pytest.raises(SimulationError), results_folder("run", "curve", "out") as folder:
        write_text(folder / "series.csv", "t\n")
        raise SimulationError("derailed")
    assert "series.csv" in names("out")


def test_existing_folder_needs_overwrite():
    make_results("out", "a.csv")
    before = names("out")
    with pytest.raises(InputError, match="^out: exists already.*--overwrite"):
        make_results("out", "a.csv")
    assert names("out") == before


def test_overwrite_takes_an_empty_folder():
    Path("out").mkdir()
    with results_folder("run", "curve", "out", overwrite=True) as folder:
        write_text(folder / "a.csv", "new")
    assert "a.csv" in names("out")


def test_overwrite_replaces_what_railcli_wrote_and_nothing_else():
    make_results("out", "a.csv", "figures/b.png")
    Path("out/notes.txt").write_text("mine")
    with results_folder("run", "curve", "out", overwrite=True) as folder:
        write_text(folder / "c.csv", "new")
    assert [name for name in names("out") if Path("out", name).is_file()] == [".railcli", "c.csv", "notes.txt"]
    assert Path("out/notes.txt").read_text() == "mine"


def test_overwrite_leaves_a_folder_of_the_user_alone():
    Path("thesis").mkdir()
    Path("thesis/summary.json").write_text("mine")
    with pytest.raises(InputError, match="did not write"):
        with results_folder("run", "curve", "thesis", overwrite=True):
            pass
    assert names("thesis") == ["summary.json"]


@pytest.mark.skipif(os.name == "nt", reason="making links needs a privilege there")
def test_list_cannot_make_overwrite_delete_elsewhere():
    make_results("out", "a.csv")
    Path("precious").write_text("mine")
    Path("aside").mkdir()
    Path("aside/precious").write_text("mine")
    os.symlink("../aside", "out/link")
    with open("out/.railcli", "a") as file:
        file.write(f"../precious\n{Path('precious').resolve()}\nlink/precious\n")
    with results_folder("run", "curve", "out", overwrite=True):
        pass
    assert Path("precious").exists() and Path("aside/precious").exists()


def test_file_where_the_folder_should_be():
    Path("out").write_text("mine")
    with pytest.raises(InputError, match="is a file"):
        with results_folder("run", "curve", "out", overwrite=True):
            pass
    assert Path("out").read_text() == "mine"


@pytest.mark.parametrize("place", ["taken", "taken/out", "taken/a/b"])
def test_file_in_the_way_of_the_folder(place):
    Path("taken").write_text("mine")
    with pytest.raises(InputError, match=f"^{place}: "):
        with results_folder("run", "curve", place):
            pass


def test_file_in_the_way_of_the_default_parent():
    Path("railcli-out").write_text("mine")
    with pytest.raises(InputError, match="a file stands where a folder is needed"):
        with results_folder("run", "curve"):
            pass


def test_folder_that_cannot_be_made(monkeypatch):
    def refuse(path, *_args, **_options):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(InputError, match="^out: cannot be written: no permission"):
        with results_folder("run", "curve", "out"):
            pass


# The cache


def test_cache_is_where_the_user_says(monkeypatch, tmp_path):
    monkeypatch.setenv("RAILCLI_CACHE_DIR", str(tmp_path / "given"))
    assert place.cache_root() == tmp_path / "given"


@pytest.mark.parametrize("value", ["", None])
def test_empty_cache_setting_counts_as_none(monkeypatch, tmp_path, value):
    monkeypatch.delenv("RAILCLI_CACHE_DIR", raising=False)
    monkeypatch.setattr(place.sys, "platform", "linux")
    monkeypatch.setenv("HOME", str(tmp_path))
    if value is None:
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    else:
        monkeypatch.setenv("XDG_CACHE_HOME", value)
    assert place.cache_root() == Path.home() / ".cache/railcli"


# What killed processes leave, and what others do at the same time


KILLED = """
import os, signal
from railcli.files.output import results_folder, whole_file
with results_folder("run", "curve", "out") as folder, whole_file(folder / "{name}") as part:
    part.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
needs_locks = pytest.mark.skipif(output.lock.fcntl is None, reason="the system has no such locks")


@needs_locks
def test_what_a_killed_process_left_is_removed_by_the_next(run_python):
    assert run_python(KILLED.format(name="a.csv")).returncode < 0
    (left,) = output.parts("out")
    assert left.read_text() == "half" and left.suffix == ".csv"
    write_text("out/b.csv", "new")
    assert output.parts("out") == [] and "b.csv" in names("out")


@needs_locks
def test_time_series_of_a_killed_run_stay_until_the_folder_is_overwritten(run_python):
    run_python(KILLED.format(name="timeseries.h5"))
    write_text("out/b.csv", "new")
    assert output.parts("out", "timeseries.h5")
    with results_folder("run", "curve", "out", overwrite=True) as folder:
        write_text(folder / "c.csv", "new")
    assert names("out") == [".railcli", "c.csv"]


@needs_locks
def test_a_file_that_is_being_written_is_no_leftover():
    with whole_file("a.csv") as part:
        write_text("b.csv", "other")
        part.write_text("whole")
    assert names() == ["a.csv", "b.csv"]


@needs_locks
def test_two_commands_do_not_write_into_one_folder():
    with results_folder("run", "curve", "out") as folder:
        write_text(folder / "a.csv", "of the first")
        with pytest.raises(InputError, match="^out: another railcli command writes there"):
            make_results_again()
    assert Path("out/a.csv").read_text() == "of the first"


def make_results_again():
    with results_folder("run", "curve", "out", overwrite=True):
        pass


def test_overwrite_spares_what_was_changed_since():
    make_results("out", "a.csv", "b.csv")
    Path("out/b.csv").write_text("by hand")
    assert output.is_changed("out/b.csv") and not output.is_changed("out/a.csv")
    with pytest.raises(InputError, match="^out/b.csv: was changed since railcli wrote it"):
        make_results_again()
    assert Path("out/a.csv").read_text() == "old a.csv"


def test_a_command_does_not_overwrite_what_it_reads():
    made = make_results("out", "a.csv")
    with pytest.raises(InputError, match="holds what this command reads"):
        with results_folder("assess", "curve", made, overwrite=True, reads=[Path("out/a.csv")]):
            pass
    assert Path("out/a.csv").exists()


def test_a_place_where_nothing_can_be_written_is_found_before_the_work(monkeypatch):
    def refuse(dir):
        raise OSError(errno.EROFS, "read-only", f"{dir}/other")

    monkeypatch.setattr(output.tempfile, "TemporaryFile", refuse)
    with pytest.raises(InputError, match="^new/a.csv: cannot be written: the file system is read-only"):
        output_file("new/a.csv")
    assert names() == []


@pytest.mark.skipif(os.name == "nt", reason="names there are text")
@pytest.mark.parametrize("name", [80 * "\u6e2c", os.fsdecode(b"Rad_gr\xf6sse"), "$a_b^2$", "\x1b[31mred", "-q"])
def test_any_name_of_a_file(name):
    write_text(f"{name}.csv", "x")
    with results_folder("run", name, f"results {name}"[:80]) as folder:
        write_text(folder / f"{name[:60]}.csv", "x")
    assert not output.is_changed(next(folder.glob("*.csv")))
    make_over(folder)
    assert [path.name for path in folder.iterdir()] == [".railcli", "b.csv"]


def make_over(folder):
    with results_folder("run", "curve", folder, overwrite=True):
        write_text(folder / "b.csv", "new")
