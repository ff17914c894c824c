"""`railcli report`: a page that needs nothing but itself, with the values of the results in it."""

import base64
import io
import json
import re
import shutil
import sys
from html.parser import HTMLParser

import h5py
import numpy as np
import pytest
import tolerances as tol
from click.testing import CliRunner
from PIL import Image

from railcli.cli import main

FIGURES = {"track", "wheelsets", "forces", "quotients", "creepages", "contact", "accelerations", "spectra"}
TITLE = "A short <curve> & its end"
VOID = {"meta", "img", "br", "input", "link", "source"}


class Page(HTMLParser):
    """Tags with their attributes, tables as lists of rows, and what is not closed."""

    def __init__(self, path):
        super().__init__()
        self.text = path.read_text(encoding="utf-8")
        self.tags, self.open, self.tables, self.titles = [], [], [], []
        self.feed(self.text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        if tag == "tr":
            self.tables[-1].append([])
        if tag in ("td", "th"):
            self.tables[-1][-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> at {self.getpos()}"

    def handle_data(self, data):
        if "td" in self.open or "th" in self.open:
            self.tables[-1][-1][-1] += data
        if self.open and self.open[-1] == "h1":
            self.titles.append(data)

    def values(self, name):
        """All values of an attribute."""
        return [attributes[name] for _, attributes in self.tags if name in attributes]

    def table(self, *head):
        """Rows of the table that has such a row, by their first cell."""
        (rows,) = [rows for rows in self.tables if any(row[: len(head)] == list(head) for row in rows)]
        return {row[0]: row[1:] for row in rows}


def run(*arguments):
    return CliRunner().invoke(main, ["report", *map(str, arguments), "-q"], prog_name="railcli")


@pytest.fixture(scope="module")
def single(recorded, tmp_path_factory):
    """Folder, page and record of the report on one result."""
    out = tmp_path_factory.mktemp("single") / "out"
    result = run(recorded(), "-o", out, "--format", "json")
    assert result.exit_code == 0, result.stderr
    return out, Page(out / "report.html"), json.loads(result.stdout)


@pytest.fixture(scope="module")
def double(recorded, tmp_path_factory):
    """The same of two results that differ in friction, as SVG, with limits that the runs break."""
    place = tmp_path_factory.mktemp("double")
    (place / "limits.toml").write_text("run_in_s = 0.5\nsum_Y_factor = 0.01\n")
    options = ["--picture", "svg", "--limits", place / "limits.toml", "--format", "json"]
    result = run(recorded(), recorded(friction=0.2), "-o", place / "out", *options)
    assert result.exit_code == 0, result.stderr
    return place / "out", Page(place / "out" / "report.html"), json.loads(result.stdout)


@pytest.mark.parametrize("which", ["single", "double"])
def test_page_needs_nothing_but_itself(which, request):
    """Whatever it loads is data in the page, every link leads into the page, and its tags close."""
    _, page, _ = request.getfixturevalue(which)
    assert page.open == []
    assert all(source.startswith("data:image/") for source in page.values("src"))
    assert {link.removeprefix("#") for link in page.values("href")} <= set(page.values("id"))
    assert all(link.startswith("#") for link in page.values("href"))
    assert not {tag for tag, _ in page.tags} & {"link", "iframe", "object", "embed", "base", "form"}
    bare = re.sub(r"data:[\w/+]+;base64,[\w+/=]+", "", page.text)
    assert not re.search(r"https?:|//\w|url\(|@import", bare)


def test_figures_stand_in_the_page_and_in_the_folder(single):
    folder, page, record = single
    assert {path.stem for path in folder.glob("*.png")} >= FIGURES
    assert {path.name for path in folder.iterdir()} == {*record["files"], ".railcli"}
    for source in page.values("src"):
        head, _, data = source.partition(",")
        picture = base64.b64decode(data, validate=True)
        assert head == "data:image/png;base64"
        assert picture in {path.read_bytes() for path in folder.glob("*.png")}
        with Image.open(io.BytesIO(picture)) as image:
            image.load()
            assert np.ptp(np.asarray(image.convert("L"))) > 200, "an empty picture"


def test_figures_as_svg(double):
    folder, page, _ = double
    assert {path.stem for path in folder.glob("*.svg")} >= FIGURES
    assert all("<svg" in path.read_text() for path in folder.glob("*.svg"))
    assert all(source.startswith("data:image/svg+xml;base64,") for source in page.values("src"))


def test_words_of_users_files_are_text(single):
    """Title of the scenario: no tag of the page."""
    _, page, _ = single
    assert page.titles == [TITLE] and "<curve>" not in page.text
    assert page.table("folder")["title"] == [TITLE]


def test_largest_values_are_those_of_the_file(single, recorded):
    _, page, record = single
    rows = page.table("lateral displacement of a wheelset [mm]")
    with h5py.File(recorded() / "timeseries.h5") as file:
        wheels = [str(name) for name in file.attrs["wheels"]]
        loads = {name: file[f"wheels/{name}/Q_greatest"][:] for name in wheels}
        first = max(wheels, key=lambda name: loads[name].max())
        place = file["bodies/car body/position"][loads[first].argmax(), 0]
        lateral = max((file[f"bodies/wheelset {k}/position"][:, 1] for k in range(1, 5)), key=lambda y: abs(y).max())
    value, name, where = re.fullmatch(r"(\S+), (\S+ \w+) at s = (\S+) m", rows["Q, largest [kN]"][0]).groups()
    assert float(value) == pytest.approx(loads[first].max() * 1e-3, rel=tol.SHOWN_DIGITS)
    assert name.replace(" ", "_") == first and float(where) == pytest.approx(place, abs=0.051)
    shown = float(rows["lateral displacement of a wheelset [mm]"][0].split(",")[0])
    assert shown == pytest.approx(lateral[np.abs(lateral).argmax()] * 1e3, rel=tol.SHOWN_DIGITS)
    assert record["tables"]["largest"]["rows"][0][1:] == rows["lateral displacement of a wheelset [mm]"]


def test_provenance_and_steady_values_stand_in_the_page(single, recorded):
    _, page, _ = single
    summary = json.loads((recorded() / "summary.json").read_text())
    origin = page.table("railcli")
    assert origin["kernels"] == [summary["provenance"]["kernels"]]
    assert origin["scenario.digest"] == [summary["provenance"]["scenario"]["digest"]]
    steady = page.table("over")
    assert steady["lateral values"] == ["towards the outer rail"]
    assert steady["W1 y [mm]"][0].startswith(f"{summary['steady']['mean']['lateral_mm'][0]:.3f} ")


def test_several_results_stand_side_by_side(double, recorded):
    _, page, record = double
    assert page.table("folder")["folder"] == [str(recorded()), str(recorded(friction=0.2))]
    assert page.table("contact.friction")["contact.friction"] == ["0.3", "0.2"]
    assert page.titles == [f"{recorded().name} against {recorded(friction=0.2).name}"]
    assert len(record["assessment"]) == 2


def test_assessment_is_that_of_assess(double, recorded, tmp_path):
    """Every figure with the verdict that `railcli assess` gives it under the same limits; one fails, some pass."""
    folder, page, record = double
    limits = folder.parent / "limits.toml"
    result = CliRunner().invoke(
        main, ["assess", str(recorded()), "--limits", str(limits), "--format", "json", "-q", "--no-figures",
               "-o", str(tmp_path / "assess")],
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    (judged,) = json.loads(result.stdout)["results"]
    assert record["assessment"][0] == judged["figures"]
    rows = next(rows for rows in page.tables if any("Running safety" in row[0] for row in rows))
    shown = {row[0].split("\n")[0]: row for row in rows if len(row) == 10}
    statuses = set()
    for figure in judged["figures"].values():
        row = next(row for name, row in shown.items() if name.startswith(figure["title"] + figure["processing"]))
        assert row[5].startswith(figure["status"])
        statuses.add(figure["status"])
    assert {"pass", "fail"} <= statuses
    assert ("span", {"class": "status fail"}) in page.tags


def test_animation_in_the_page(recorded, tmp_path):
    """A player of the frames, each a picture of its own, and still nothing from outside."""
    result = run(recorded(), "-o", tmp_path / "out", "--animate", "--frames", 4, "--no-assessment")
    assert result.exit_code == 0, result.stderr
    page = Page(tmp_path / "out" / "report.html")
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', page.text, flags=re.S)
    frames = json.loads(data)
    assert len(frames) == 4 == len(set(frames)) and frames[0] in page.values("src")
    sizes = set()
    for frame in frames:
        assert frame.startswith("data:image/png;base64,")
        with Image.open(io.BytesIO(base64.b64decode(frame.partition(",")[2], validate=True))) as image:
            image.load()
            sizes.add(image.size)
    assert len(sizes) == 1
    assert ("input", "range") in {(tag, attributes.get("type")) for tag, attributes in page.tags}
    assert not re.search(r"https?:|//\w|url\(|@import", re.sub(r"data:[\w/+]+;base64,[\w+/=]+", "", page.text))


def test_animation_as_gif(recorded, tmp_path):
    result = run(recorded(), "-o", tmp_path / "out", "--film", "gif", "--frames", 4, "--no-assessment")
    assert result.exit_code == 0, result.stderr
    with Image.open(tmp_path / "out" / "animation-1.gif") as film:
        assert film.n_frames == 4
    sources = Page(tmp_path / "out" / "report.html").values("src")
    assert any(source.startswith("data:image/gif;base64,") for source in sources)


@pytest.mark.skipif(not shutil.which("ffmpeg"), reason="needs ffmpeg")
def test_animation_as_mp4(recorded, tmp_path):
    result = run(recorded(), "-o", tmp_path / "out", "--film", "mp4", "--frames", 4, "--no-assessment")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "out" / "animation-1.mp4").read_bytes()[4:8] == b"ftyp"
    assert any(source.startswith("data:video/mp4") for source in Page(tmp_path / "out" / "report.html").values("src"))


def test_what_cannot_be_judged_is_said(recorded, tmp_path):
    """A scenario of another version and a missing summary: a page all the same, with notes."""
    copy = tmp_path / "other"
    shutil.copytree(recorded(), copy)
    scenario = json.loads((copy / "scenario.json").read_text())
    scenario["contact"]["friction"] = {"dry": 0.3}
    scenario["vehicle"] = "another one"
    (copy / "scenario.json").write_text(json.dumps(scenario))
    (copy / ".railcli").unlink()  # which has its checksum
    (copy / "summary.json").unlink()
    result = run(copy, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    page = Page(tmp_path / "out" / "report.html")
    assert "no track and no assessment" in page.text and "no scenario of this version" in result.stdout
    assert "broke off before it wrote a summary" in page.text
    assert 'id="assessment"' not in page.text and not (tmp_path / "out" / "track.png").exists()


def test_odd_names_are_words(recorded, tmp_path):
    """Names of folders that mean something to a page or to matplotlib."""
    odd = ["_$\\frac$", "<b>&"]
    for name in odd:
        shutil.copytree(recorded(), tmp_path / name)
    result = run(*(tmp_path / name for name in odd), "-o", tmp_path / "out", "--picture", "svg", "--no-assessment")
    assert result.exit_code == 0, result.stderr
    page = Page(tmp_path / "out" / "report.html")
    assert "".join(page.titles) == " against ".join(odd)
    drawn = (tmp_path / "out" / "forces.svg").read_text()
    assert "$\\frac$, right wheel" in drawn and "&lt;b&gt;&amp;, left wheel" in drawn


def test_missing_extra_is_named(recorded, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "jinja2", None)
    result = run(recorded(), "-o", tmp_path / "out")
    assert result.exit_code == 2 and not (tmp_path / "out").exists()
    (line,) = result.stderr.splitlines()
    assert "jinja2" in line and "railcli[report]" in line


def test_bad_input_is_one_line(recorded, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(recorded(), broken)
    with open(broken / "timeseries.h5", "r+b") as file:
        file.truncate(5000)
    unreadable = tmp_path / "unreadable"
    shutil.copytree(recorded(), unreadable)
    (unreadable / "summary.json").write_text('{"scenario": ')
    for arguments, words in [
        ((tmp_path / "nowhere",), ["no such folder"]),
        ((unreadable,), ["summary.json", "damaged"]),
        ((recorded(), broken), ["timeseries.h5", "run the scenario again"]),
        ((recorded(), "-o", broken), ["exists already"]),
        ((*[recorded()] * 7,), ["at most 6"]),
        ((recorded(), "--animate", "--wheelset", 5), ["--wheelset", "4 wheelsets"]),
    ]:
        result = run(*arguments, *([] if "-o" in arguments else ["-o", tmp_path / "out"]))
        assert result.exit_code == 2, arguments
        assert all(word in result.stderr for word in words), result.stderr
    assert not (tmp_path / "out").exists()
