"""Pages, GIFs and videos."""

from __future__ import annotations

import base64
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import acausal as ac
from acausal.animation.animation import Animation
from acausal.cli.main import execute
from acausal.diagnostics import AcausalError

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def pendulum():
    return ac.compile_file(EXAMPLES / "cartesian_pendulum.acm").simulate(stop_time=2)


@pytest.fixture(scope="module")
def gyroscope():
    return ac.compile_file(EXAMPLES / "gyroscope.acm").simulate()


class References(HTMLParser):
    """Collects what a page would load."""

    def __init__(self):
        super().__init__()
        self.found, self.tags = [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.found += [v for k, v in attrs if k in ("src", "href", "data", "srcset")]


def scene_of(page):
    return json.loads(re.search(r'<script id="scene"[^>]*>(.*?)</script>', page, re.S)[1])


@pytest.mark.parametrize("which", ["pendulum", "gyroscope"])
def test_page_needs_nothing_else(which, request):
    page = request.getfixturevalue(which).animate().html()
    parser = References()
    parser.feed(page)
    assert parser.found == []
    assert not {"link", "iframe", "img", "object"} & set(parser.tags)
    assert not re.search(r"https?:|@import|url\(|fetch\(|XMLHttpRequest|import\(", page)
    for control in ("play", "scrub", "speed", "loop", "clock", "view"):
        assert f'id="{control}"' in page


def test_page_holds_the_numbers(pendulum):
    animation = pendulum.animate()
    scene, record = animation.scene(), scene_of(animation.html())
    data = np.frombuffer(base64.b64decode(record["data"]), "<f4").reshape(-1, record["n"])
    assert record["n"] == len(scene.times)
    rods = [s for s in record["sprites"] if s["kind"] == "stretched"]
    x = data[rods[0]["c"][2][0]]
    expected = pendulum["x"](scene.times)
    np.testing.assert_allclose(x, expected, atol=2e-5)
    assert all(0 <= s["g"] < len(record["geometries"]) for s in record["sprites"] if "g" in s)


def test_same_bytes_every_time(pendulum, gyroscope):
    for result in (pendulum, gyroscope):
        assert result.animate().html() == result.animate().html()
    again = ac.compile_file(EXAMPLES / "cartesian_pendulum.acm").simulate(stop_time=2)
    assert pendulum.animate().html() == again.animate().html()


def test_texts_cannot_leave_their_element(pendulum):
    animation = Animation(pendulum, title="</script><b>&amp;").text((0, 0), "</script><i>")
    page = animation.html()
    parser = References()
    parser.feed(page)
    assert "b" not in parser.tags and "i" not in parser.tags
    assert scene_of(page)["sprites"][-1]["text"] == "</script><i>"


@pytest.mark.parametrize("which", ["pendulum", "gyroscope"])
def test_gif(which, request, tmp_path):
    result = request.getfixturevalue(which)
    file = tmp_path / "a.gif"
    result.animate(file, fps=10, speed=1, width=200, height=150)
    with Image.open(file) as image:
        assert image.n_frames == 21
        assert image.size == (200, 150)
        assert image.info["duration"] == 100 and image.info["loop"] == 0
        first = np.asarray(image.convert("RGB"), dtype=int)
        image.seek(5)
        later = np.asarray(image.convert("RGB"), dtype=int)
    assert (np.abs(first - later).max(axis=2) > 60).sum() > 50
    # Something other than paper is drawn, and not everywhere.
    dark = (first.sum(axis=2) < 550).mean()
    assert 0.005 < dark < 0.6
    before = file.read_bytes()
    result.animate(file, fps=10, speed=1, width=200, height=150)
    assert file.read_bytes() == before


def test_ball_is_drawn_where_it_is(tmp_path):
    result = ac.compile_text("""
model Two
  Real x = time;
end Two;
""").simulate(stop_time=2)
    animation = Animation(result, speed=1).circle(("x", 0), radius=0.5, color="#ff0000")
    animation.save(tmp_path / "a.gif", fps=10, width=400)
    left, right = [], []
    with Image.open(tmp_path / "a.gif") as image:
        for k in (0, 20):
            image.seek(k)
            pixels = np.asarray(image.convert("RGB"), dtype=int)
            red = (pixels[:, :, 0] > 200) & (pixels[:, :, 1] < 80)
            columns = np.flatnonzero(red.any(axis=0))
            left.append(columns[0])
            right.append(columns[-1])
    # Two metres are two diameters.
    assert right[0] - left[0] == pytest.approx((left[1] - left[0]) / 2, rel=0.08)


def test_mp4(pendulum, tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    pendulum.animate(tmp_path / "a.mp4", fps=10, speed=1, width=201, height=151)
    content = (tmp_path / "a.mp4").read_bytes()
    assert content[4:8] == b"ftyp" and len(content) > 2000
    import imageio_ffmpeg

    reader = imageio_ffmpeg.read_frames(str(tmp_path / "a.mp4"))
    about = next(reader)
    assert about["size"] == (200, 150) and about["fps"] == 10
    assert sum(1 for _ in reader) == 21


def test_mp4_without_its_package(pendulum, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with pytest.raises(AcausalError) as error:
        pendulum.animate(tmp_path / "a.mp4", fps=5, width=100)
    assert error.value.diagnostics[0].code == "F205"
    assert list(tmp_path.iterdir()) == []


def test_notebook_shows_the_player(pendulum):
    shown = pendulum.animate()._repr_html_()
    assert shown.startswith("<iframe") and "srcdoc=" in shown
    wrong = Animation(pendulum).circle(("x", "nothing"))._repr_html_()
    assert wrong.startswith("<pre>") and "D113" in wrong and "nothing" in wrong


def test_command(tmp_path, capfd):
    file = tmp_path / "four_bar.html"
    assert execute(["animate", str(EXAMPLES / "four_bar.acm"), "FourBar", "-o", str(file)]) == 0
    assert scene_of(file.read_text())["title"] == "FourBar"
    assert execute(["animate", str(EXAMPLES / "rlc.acm"), "-o", str(tmp_path / "b.html")]) == 1
    assert "D114" in capfd.readouterr().err
    assert execute(["animate", str(EXAMPLES / "rlc.acm"), "-o", str(tmp_path / "b.avi")]) == 1
    assert not (tmp_path / "b.html").exists()
