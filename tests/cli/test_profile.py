"""`railcli profile` as a user sees it."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from railcli.cli import main
from railcli.files.profiles import load_profile

SAMPLES = Path(__file__).parents[1] / "data" / "samples"
GRID = "--normal hertz --inclination 0 --y-range 6 --y-step 0.5 --roll-range 2.5 --yaw-range 5"
COARSE = GRID + " --poses 200 --format json -q"


@pytest.fixture
def railcli(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        return CliRunner().invoke(main, [str(item) for item in arguments])

    return run


def test_import_writes_profile_and_report(railcli, tmp_path):
    result = railcli("profile", "import", SAMPLES / "avg_low2.ban", "-o", "rail.csv", "--smooth", 4, "--format", "json")
    assert (result.exit_code, result.stderr) == (0, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "rail.csv",
        "rail.curation.json",
        "rail.curation.txt",
    ]
    printed, stored = json.loads(result.stdout), json.loads((tmp_path / "rail.curation.json").read_text())
    assert {**stored, "profile": "rail.csv"} == printed
    assert {fault["treatment"] for fault in stored["faults"]} >= {"dropped", "replaced in pairs by their mean"}
    assert stored["smoothing"]["cutoff_mm"] == 4
    assert 0 < stored["smoothing"]["largest_change"]["position_mm"] < 0.2
    assert all(decision["reason"] for decision in stored["decisions"])
    profile = load_profile(tmp_path / "rail.csv", "rail")
    assert profile.y.size == stored["points"]
    text = (tmp_path / "rail.curation.txt").read_text()
    for part in ("mirror y", "lines 73-74", "cut-off wavelength 4 mm", "--inclination 0", "Fit for a contact table."):
        assert part in text


def test_import_to_a_new_folder(railcli, tmp_path):
    result = railcli("profile", "import", SAMPLES / "MBench_S1002_v3.prw")
    assert result.exit_code == 0
    assert "Smoothing: none" in result.stdout and "flange thickness  32.50 mm" in result.stdout
    folder = tmp_path / "railcli-out" / "profile-MBench_S1002_v3-1"
    assert load_profile(folder / "MBench_S1002_v3.csv", "wheel").flange_dimensions().qr == pytest.approx(
        10.794e-3, abs=5e-6
    )


def test_nothing_is_overwritten_unasked(railcli):
    arguments = ["profile", "import", SAMPLES / "avg_wheel.whl", "-o", "wheel.csv"]
    assert railcli(*arguments).exit_code == 0
    again = railcli(*arguments)
    assert again.exit_code == 2 and "exists already" in again.stderr
    assert railcli(*arguments, "--overwrite").exit_code == 0


def test_output_must_be_csv(railcli):
    result = railcli("profile", "import", SAMPLES / "avg_wheel.whl", "-o", "wheel.whl")
    assert result.exit_code == 2 and "end its name with .csv" in result.stderr


@pytest.mark.parametrize("name", ["uic60", "ORES1002"])
def test_check_of_bundled_profiles(railcli, name):
    result = railcli("profile", "check", name)
    assert result.exit_code == 0
    assert result.stdout.endswith("Fit for a contact table.\n")


def test_check_says_whether_import_is_needed(railcli, tmp_path):
    result = railcli("profile", "check", SAMPLES / "rail_left_iter288.ban", "--format", "json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["verdict"] == "fit"
    assert "once imported" in railcli("profile", "check", SAMPLES / "rail_left_iter288.ban").stdout
    railcli("profile", "import", SAMPLES / "rail_left_iter288.ban", "-o", "rail.csv")
    assert railcli("profile", "check", "rail.csv").stdout.endswith("Fit for a contact table.\n")
    assert not (tmp_path / "railcli-out").exists()


def test_check_of_what_is_not_fit(railcli):
    result = railcli("profile", "check", SAMPLES / "final_clean.prw", "--format", "json")
    assert result.exit_code == 4
    assert json.loads(result.stdout)["verdict"] == "not fit"
    assert result.stderr.startswith("Error: not fit for a contact table: ") and result.stderr.count("\n") == 1


@pytest.mark.parametrize("command", ["import", "show", "check"])
def test_unreadable(railcli, tmp_path, command):
    (tmp_path / "a.ban").write_bytes(b"\x00\x01")
    for name, part in (("a.ban", "binary file"), ("none.whl", "there is no such file")):
        result = railcli("profile", command, name)
        assert (result.exit_code, result.stdout) == (2, "")
        assert part in result.stderr and result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "arguments, size", [(["UIC60"], 20_000), ([SAMPLES / "whl_left_iter288.whl", "--smooth", "4"], 20_000)]
)
def test_show(railcli, tmp_path, arguments, size):
    result = railcli("profile", "show", *arguments, "-o", "picture.png")
    assert result.exit_code == 0
    picture = (tmp_path / "picture.png").read_bytes()
    assert picture.startswith(b"\x89PNG") and len(picture) > size
    assert "Figure: picture.png" in result.stdout


def test_show_refuses_other_pictures(railcli):
    assert "figures end with one of" in railcli("profile", "show", "UIC60", "-o", "a.bmp").stderr


def test_imported_profiles_build_a_table(railcli):
    """Worn wheel on worn rail, neither nominal: every contact of the table's poses is found again directly."""
    for name, output in (("left-wheel-v1-pre-dry.whl", "wheel.csv"), ("rail_left_iter288.ban", "rail.csv")):
        assert railcli("profile", "import", SAMPLES / name, "-o", output, "--smooth", 4).exit_code == 0
    result = railcli("build-lut", "--wheel", "wheel.csv", "--rail", "rail.csv", "-o", "table.h5", *COARSE.split())
    assert result.exit_code == 0, result.stderr
    facts = json.loads(result.stdout)
    assert facts["wheel"]["name"] == "wheel" and facts["rail"]["name"] == "rail"
    assert facts["certificate"]


@pytest.mark.parametrize("command", ["import", "show", "check"])
def test_help_is_light(run_python, command):
    code = "import sys\nfrom railcli.cli import main\nmain(sys.argv[1:], standalone_mode=False)\n"
    code += "print('loaded:', sorted({'numpy', 'scipy', 'numba', 'matplotlib'} & set(sys.modules)))"
    result = run_python(code, "profile", command, "--help")
    assert result.stdout.splitlines()[-1] == "loaded: []", result.stderr
