"""`parisph report`: the page of a tiny run, whose numbers are those of its files, and a gallery."""

import base64
import html
import json
import os
import re
import shutil
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

from parisph import Case, Energy, Fluid, Numerics, PressureTap, ProbeArray, Profiles, Sponge, SurfaceGauge, load
from parisph.base.errors import CaseError, StoreError
from parisph.base.fields import FLUID, WALL
from parisph.base.json_digest import with_digest
from parisph.case.motion import Sway
from parisph.case.shapes import Box, Tank
from parisph.case.truths import PeakBand, Peaks, Truth
from parisph.io.layout import INDEX
from parisph.io.reader import open_run
from parisph.report import conditions, energies, gallery, page
from tests.launch import ROOT, parisph
from tests.scenes import run_alone

CELL = re.compile(r'<td class="number" data-from="(.*?)" title="(.*?)">(.*?)</td>')
PNG = b"\x89PNG\r\n\x1a\n"


def still(folder, **changes):
    """Run water at rest in a tank for some steps, with changes of its case, into a folder."""
    case = Case(**{
        "title": "Still", "fluid": Fluid(Box(width=1.0, height=0.4), density=1e3), "gravity": (0.0, -9.81),
        "walls": Tank(width=1.0, height=0.5), "end_time": 0.05,
        "numerics": Numerics(spacing=0.1, preset="gentle", time_step=0.005), **changes})
    run_alone(case, folder)
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of a run of a few steps, with a truth, another beside it, an error of others, and bands of peaks."""
    folder = tmp_path_factory.mktemp("report")
    lines = [f"{of},{t:.3f},{value}\n" for of, value in (("a", 1.0), ("b", 1.1)) for t in np.linspace(0.0, 0.1, 41)]
    (folder / "measured.csv").write_text("of,t,p\n" + "".join(lines))
    first, other = (
        Truth(str(folder / "measured.csv"), time="t", value="p", scale=2000.0, rows={"of": of}, name=f"<{of}>",
              window=(0.01, 0.04), smooth=0.012, published={"others": 0.123} if of == "a" else {})
        for of in ("a", "b")
    )
    bands = (PeakBand(start=0.0, end=0.03, low=1000.0, high=3000.0), PeakBand(start=0.0, end=0.03, low=1.0, high=2.0))
    truth = first.model_copy(update={"others": (other,), "peaks": bands, "note": "a sensor of brass"})
    late = first.model_copy(update={"window": (0.5, 0.9), "note": "a sensor of brass"})
    return still(folder / "run", title="Still & <calm>", source="Nobody (1999), <Fig 2>", probes=[
        PressureTap("tap", at=(0.0, 0.2), truth=truth, peak=True), SurfaceGauge("late", at=0.5, truth=late),
        Energy("energy")])


@pytest.fixture(scope="module")
def text(made):
    """The page of the run, in its folder."""
    return page.write(made).read_text(encoding="utf-8")


def entry(folder, source):
    """Return the entry of a JSON file that a cell names, read without parisph."""
    file, _, path = source.partition(": ")
    value = json.loads((folder / file).read_text())
    for name in path.split("/"):
        value = value[int(name) if isinstance(value, list) else name]
    return value


def test_every_number_of_the_page_is_in_the_files_of_the_run(made, text):
    cells = [(html.unescape(source), html.unescape(shown)) for source, _, shown in CELL.findall(text)]
    assert len(cells) > 50
    for source, shown in cells:
        value = entry(made, source)
        if isinstance(value, str):
            assert shown == value, source
        else:
            word = shown.split()[0]
            found = float(word.rstrip("%")) / (100.0 if word.endswith("%") else 1.0)
            assert found == pytest.approx(value, rel=0.01, abs=0.006 if word.endswith("%") else 1e-12), source
    rest = re.sub(CELL, "", text)
    words = [html.unescape(word) for word in re.findall(r"<td>(.*?)</td>", rest)]
    assert [word for word in words if re.search(r"(?<![A-Za-z])\d", word)] == [], "a number without a source"
    sources = {source for source, _ in cells}
    assert {"summary.json: errors/tap/relative_l2", "summary.json: errors/tap/others/<b>/relative_l2",
            "summary.json: errors/tap/best_shift", "summary.json: errors/tap/peaks/1/beyond",
            "case.json: probes/0/truth/published/others", "summary.json: cpu_seconds",
            "summary.json: volume_range/low", "summary.json: energy_in_motion/high",
            "summary.json: wall_particles", "summary.json: errors/late/reason"} <= sources


def test_the_page_is_one_file_with_its_pictures(made, text):
    assert "<title>Still &amp; &lt;calm&gt;</title>" in text and "<calm>" not in text
    assert "scene of" in text and "Nobody (1999), &lt;Fig 2&gt;" in text
    peak = open_run(made).peak("tap")
    assert f"greatest value of tap within the compared time: {peak['peak']:.4g} Pa at t = " in text
    assert "shift = 0" in text and "tap, late: a sensor of brass" in text and text.count("brass") == 1
    assert "relative to the whole energy" in text and "above that of the fluid at rest" in text
    assert "Errors of others at tap, late, against &lt;a&gt;: others: 0.123." in text
    found = [base64.b64decode(data) for data in re.findall('src="data:image/png;base64,(.*?)"', text)]
    beside = {path.name: path.read_bytes() for path in (made / "report").glob("*.png")}
    assert set(beside) == {"tap.png", "late.png", "probes.png", "flow.png", "peak_tap.png", "solver.png"}
    assert sorted(found) == sorted(beside.values()) and all(data.startswith(PNG) for data in found)
    assert not re.search('(src|href)="(?!data:)', text), "nothing is fetched"


def test_a_truth_that_is_gone_and_a_run_that_goes_on_are_said(made, tmp_path):
    away = [made.parent / "measured.csv", made / "summary.json"]
    for file in away:
        file.rename(tmp_path / file.name)
    try:
        text = page.write(made, tmp_path / "page").read_text(encoding="utf-8")
    finally:
        for file in away:
            (tmp_path / file.name).rename(file)
    assert "There is no summary.json: the run goes on, or was killed." in text and ">gentle</td>" in text
    assert "tap is shown without its reference" in text and (tmp_path / "page" / "report" / "probes.png").exists()


def test_a_gallery_shows_every_run(made, tmp_path):
    paths = gallery.write([made.parent], tmp_path)
    assert [path.name for path in paths] == ["gallery.html", "gallery.md"]
    pages, text = (path.read_text(encoding="utf-8") for path in paths)
    error = json.loads((made / "summary.json").read_text())["errors"]["tap"]["relative_l2"]
    assert f"{error:.3g}" in pages and f"| tap | \\<a> | {error:.3g} | 0.123 (others) | \\<b>: " in text
    assert "![run](run.png)" in text and "## Still & \\<calm>" in text
    assert (tmp_path / "run.png").read_bytes() in [
        base64.b64decode(data) for data in re.findall('base64,(.*?)"', pages)]


def test_a_gallery_is_put_between_the_marks_of_a_file_and_replaces_what_was_there(made, tmp_path):
    file = tmp_path / "README.md"
    with pytest.raises(StoreError, match="cannot read"):
        gallery.put_into([made], file)
    file.write_text("# Mine\n\n## Gallery\n")
    with pytest.raises(CaseError, match="must have one line <!-- gallery -->"):
        gallery.put_into([made], file)
    file.write_text(f"# Mine\n\n{gallery.START}\nold\n{gallery.END}\n\nbehind\n")
    assert parisph("report", made, "--into", file, cwd=tmp_path).stdout == f"{file}\n"
    once = file.read_text()
    assert once.startswith("# Mine\n") and once.endswith("\nbehind\n") and "old" not in once
    assert "### run" in once and "![Still & \\<calm>](pictures/run.png)" in once and "Still & \\<calm>. " in once
    summary = json.loads((made / "summary.json").read_text())
    peaks = summary["errors"]["tap"]["peaks"]
    fluid, wall = (int(np.count_nonzero(open_run(made).snapshot(-1)["kind"] == kind)) for kind in (FLUID, WALL))
    assert fluid + wall == summary["particles"] and f"{fluid} fluid and {wall} wall particles, spacing 0.1 m; " in once
    assert f"| {peaks[1]['found']:.4g} at " in once
    assert "greatest value 1000 to 3000 |" in once and ", inside | - | - |" in once and " beyond | - | - |" in once
    assert (tmp_path / "pictures" / "run.png").stat().st_size < 60_000
    gallery.put_into([made], file)
    assert file.read_text() == once


def test_a_folder_of_any_name_has_its_section_and_its_picture(made, tmp_path):
    run, file = tmp_path / "a [b](c) #1% `|` \udce9", tmp_path / "page.md"
    shutil.copytree(made, run)
    file.write_text(f"{gallery.START}\n{gallery.END}\n")
    gallery.put_into([run], file)
    text = file.read_text()
    assert "### a \\[b\\](c) #1% \\`\\|\\` \\\\udce9\n" in text
    where = re.search(r"!\[Still & \\<calm>\]\(([^() ]+)\)", text)[1]
    assert Path(os.fsdecode(tmp_path / unquote(where, errors="surrogateescape"))).read_bytes().startswith(PNG)
    shutil.rmtree(run / "snapshots")    # pictures take long
    (run / INDEX).unlink()
    assert gallery.write([run], tmp_path / "out")[1].exists()
    assert "".join(page._run(page.subject(run))).encode()


def test_a_linked_folder_of_pictures_is_refused_and_a_linked_page_is_replaced(made, tmp_path, monkeypatch):
    for part in ("_series", "_flow", "_cost"):    # with pictures, which take long
        monkeypatch.setattr(page, part, lambda *_: [])
    run, other = tmp_path / "run", tmp_path / "other"
    shutil.copytree(made, run, ignore=shutil.ignore_patterns("report*"))
    other.mkdir()
    (other / "mine.html").write_text("mine")
    (run / "report").symlink_to(other)
    (run / "report.html").symlink_to(other / "mine.html")
    with pytest.raises(StoreError, match="run/report is a symbolic link, .* put a real folder in its place, or choose "
                                         "another folder with -o"):
        page.write(run)
    assert [path.name for path in other.iterdir()] == ["mine.html"]
    (run / "report").unlink()
    assert not page.write(run).is_symlink() and (other / "mine.html").read_text() == "mine"


def test_a_peak_that_still_rises_and_a_shift_that_is_no_minimum_are_marked(made, tmp_path):
    path = made / "summary.json"
    before = path.read_text()
    content = json.loads(before)
    tap = content["errors"]["tap"]
    tap["peaks"][0].update(last=True)
    tap["peaks"][1].update(last=False)
    tap.update(best_shift=-0.0015, shift_sought=0.0015)
    tap["others"]["<b>"].update(best_shift=-0.0005, shift_sought=0.0015)
    try:
        path.write_text(json.dumps(with_digest(content)))
        text = page.write(made, tmp_path).read_text(encoding="utf-8")
        lines = gallery.write([made], tmp_path)[1].read_text(encoding="utf-8")
    finally:
        path.write_text(before)
    shown = {html.unescape(source): html.unescape(words) for source, _, words in CELL.findall(text)}
    assert shown["summary.json: errors/tap/best_shift"] == "-0.0015 (end of the range, no minimum)"
    assert shown["summary.json: errors/tap/others/<b>/best_shift"] == "-0.0005"
    assert "last sample" in shown["summary.json: errors/tap/peaks/0/time"]
    assert "last sample" not in shown["summary.json: errors/tap/peaks/1/time"]
    assert lines.count(" s, the last sample") == 1


def test_numbers_and_profiles_have_their_tables(tmp_path):
    (tmp_path / "profiles.csv").write_text("t,x,y\n" + "".join(f"{t},{x},0.41\n" for t in (0.01, 0.04) for x in (0, 1)))
    (tmp_path / "more.csv").write_text("t,x,y\n" + "".join(f"0.02,{x},0.42\n" for x in (0, 1)))
    gauges = [SurfaceGauge(f"x{k}", at=0.1 * k) for k in (3, 5, 7)]
    theirs, also = (Profiles(str(tmp_path / f"{file}.csv"), time="t", x="x", value="y", name=name)
                    for file, name in (("profiles", ""), ("more", "computed")))
    still(tmp_path / "run", probes=[
        PressureTap("tap", at=(0.0, 0.2), truth=Peaks([PeakBand(start=0.0, end=0.03, when=0.02)], name="theirs")),
        ProbeArray("all", gauges, truth=theirs.model_copy(update={"others": (also,)})),
        SurfaceGauge("level", at=0.5, arrival=0.39)])
    text = page.write(tmp_path / "run").read_text(encoding="utf-8")
    found = {html.unescape(source): shown for source, _, shown in CELL.findall(text)}
    for source, shown in found.items():
        if "/profiles/" in source or "/peaks/" in source:
            assert float(shown) == pytest.approx(entry(tmp_path / "run", source), rel=0.02), source
    assert {"summary.json: errors/all/others/computed/profiles/0/rms", "case.json: probes/2/arrival",
            *(f"summary.json: errors/all/profiles/1/{name}" for name in ("time", "relative_l2", "mean", "rms"))
            } <= set(found)
    assert (tmp_path / "run" / "report" / "all.png").exists()
    gallery.write([tmp_path / "run"], tmp_path / "gallery")
    lines = (tmp_path / "gallery" / "gallery.md").read_text(encoding="utf-8")
    assert "| tap | theirs: at 0.02 s | " in lines and "| all | profiles.csv | 0.0244 | - | computed: 0.0476 |" in lines
    assert "| level | when it passes 0.39 m | - | - |" in lines


def test_what_a_picture_does_not_show_is_told_of_the_scene(tmp_path):
    made = still(tmp_path / "run", fluid=Fluid(Box(width=2.0, height=0.4), density=1e3), frame=Sway(0.001, 3.0),
                 walls=Tank(width=2.0, height=0.5), absorb=Sponge(start=1.2, length=0.8), end_time=0.02,
                 numerics=Numerics(spacing=0.1, preset="gentle", time_step=0.01, jitter=0.2, seed=7),
                 probes=[Energy("energy")])
    text = page.write(made).read_text(encoding="utf-8")
    found = {source: shown for source, _, shown in CELL.findall(text)}
    told = {"numerics/jitter": "0.2 spacings", "numerics/seed": "7", "frame/kind": "sway", "absorb/0/start": "1.2 m",
            "absorb/0/length": "0.8 m"}
    assert {name: found[f"case.json: {name}"] for name in told} == told


@pytest.mark.parametrize("left, told", [
    (None, []), ({"particles": 0, "volume": 0.0}, []),
    ({"particles": 1, "volume": 7.57e-5}, ["1 particle has left over the rim, with a volume of 7.57e-05 m³/m"]),
    ({"particles": 12, "volume": 0.5}, ["12 particles have left over the rim, with a volume of 0.5 m³/m"])])
def test_what_has_left_is_told(left, told):
    found = energies.lost({} if left is None else {"left": left})
    assert len(found) == len(told) and all(text.startswith(due) for text, due in zip(found, told))


def test_a_greatest_value_at_the_end_of_what_is_compared_may_be_no_peak(made):
    about = page.subject(made)
    inside, last = (page._of_peak(about, "tap", 1.0, time) for time in (0.02, 0.02999))
    assert "within the compared time" in inside and "no peak" not in inside
    assert "perhaps no peak" in last


def test_wavemakers_and_walls_that_move_are_told():
    for name, told in (("submerged_bar", {"wave of piston", "sponge from x", "sponge, length"}),
                       ("wet_bed", {"motion of gate"}), ("standing_wave", set())):
        case = json.loads(load(ROOT / "cases" / f"{name}.py").model_dump_json())
        rows = {row[0].text for row in conditions.conditions(case, {}).rows}
        assert {row for row in rows if row.startswith(("wave of", "motion of", "sponge"))} >= told, name


def test_a_folder_without_a_run_is_an_error_with_a_remedy(made, tmp_path):
    for write, says in ((lambda: page.write(made.parent), "it holds runs .run.: give one of them, or all with --all"),
                        (lambda: page.write(tmp_path), "give the folder that `parisph run` has printed"),
                        (lambda: gallery.write([tmp_path], tmp_path), "holds no run: give the folder of a run")):
        with pytest.raises(StoreError, match=says):
            write()


def test_the_command_prints_what_it_has_written(made, tmp_path):
    done = parisph("report", "--all", made, cwd=tmp_path)
    assert done.stdout == "gallery/gallery.html\ngallery/gallery.md\n", done.stderr
    done = parisph("report", tmp_path, cwd=tmp_path)
    assert done.returncode == 5 and done.stderr.startswith("parisph: error: ") and "case.json" in done.stderr
