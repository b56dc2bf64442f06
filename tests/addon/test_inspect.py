# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele inspect`: what the page holds, that it needs nothing else, and how bad input is told."""

import base64
import html.parser
import io
import json
import re

import numpy as np
import pytest
from nephele import checkpoint, cli, description, exr, maps, parameters
from nephele.false_colour import SEQUENTIAL
from nephele.passes import BY_NAME
from PIL import Image

WIDTH, HEIGHT = 12, 7
IDENTITY = {
    "version": "0.1.0",
    "settings": parameters.defaults() | {"seed": 77},
    "film": {"width": WIDTH, "height": HEIGHT, "crop": None},
    "scene": "0" * 64,
}


class Page(html.parser.HTMLParser):
    """headings, images (PNG, by their alt text), tables (rows of cells) and every attribute of a page."""

    def __init__(self, text):
        super().__init__()
        self.images, self.attributes, self.tables, self.figures, self.histograms = {}, [], [], 0, 0
        self.cell = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.attributes += attrs
        self.figures += tag == "figure"
        self.histograms += tag == "svg"
        if tag == "img":
            kind, _, data = values["src"].partition(",")
            assert kind == "data:image/png;base64"
            self.images[values["alt"]] = np.asarray(Image.open(io.BytesIO(base64.b64decode(data))))
        if tag == "table":
            self.tables.append([])
        if tag == "tr":
            self.tables[-1].append([])
        if tag in ("td", "th"):
            self.cell = ""

    def handle_data(self, data):
        if self.cell is not None:
            self.cell += data

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.tables[-1][-1].append(self.cell)
            self.cell = None


@pytest.fixture
def images():
    """Returns the passes of the page and Normal as (h, w, channels), bottom row first, random in [0, 1]."""
    rng = np.random.default_rng(5)
    names = [name for name in maps.ORDER if name in BY_NAME] + ["Normal"]
    return {name: rng.random((HEIGHT, WIDTH, len(BY_NAME[name].channels)), np.float32) for name in names}


@pytest.fixture
def write(tmp_path):
    """Returns a function that writes an EXR and returns its path."""

    def call(images, identity=IDENTITY):
        attributes = checkpoint.image_attributes(identity, 8) if identity is not None else None
        exr.write(tmp_path / "a.exr", images, description.Film(WIDTH, HEIGHT), attributes=attributes)
        return tmp_path / "a.exr"

    return call


@pytest.fixture
def inspect(tmp_path, capfd):
    """Returns a function that runs the command and returns (exit code, stderr, page or None)."""

    def call(image, *arguments):
        page = tmp_path / "page.html"
        code = cli.main(["inspect", str(image), "-o", str(page), *map(str, arguments)])
        text = page.read_text() if page.exists() else None
        return code, capfd.readouterr().err, text

    return call


def test_the_page_needs_nothing_else(write, images, inspect):
    code, err, text = inspect(write(images))
    assert (code, err) == (0, "")
    markup = re.sub(r"base64,[^\"]*", "", text)
    assert not re.search(r"http|//|<script|<link|@import|url\(", markup)
    for name, value in Page(text).attributes:
        if name in ("src", "href"):
            assert value.startswith("data:")


def test_one_figure_for_each_map(write, images, inspect):
    page = Page(inspect(write(images))[2])
    assert list(page.images) == list(maps.ORDER)
    assert page.figures == page.histograms == len(maps.ORDER)
    assert {picture.shape for picture in page.images.values()} == {(HEIGHT, WIDTH, 3)}


def test_only_maps_that_the_file_holds(write, images, inspect):
    some = {name: images[name] for name in ("Combined", "VSP Achieved", "Cost", "Normal")}
    assert list(Page(inspect(write(some))[2]).images) == ["Combined", "VSP Achieved", "Cost"]


def test_images_stand_upright_in_the_colours_of_their_scale(write, images, inspect):
    images["VSP Target"][...] = 0
    images["VSP Target"][-1] = 1  # the top row
    shown = Page(inspect(write(images))[2]).images["VSP Target"]
    assert (shown[0] == SEQUENTIAL[-1]).all() and (shown[1:] == SEQUENTIAL[0]).all()


def test_values_are_numpys(write, images, inspect):
    images["Cost"][2, 3] = np.inf
    table = Page(inspect(write(images))[2]).tables[0]
    assert table[0] == ["pass", "unit", "min", "median", "mean", "max", "not finite"]
    rows = {row[0]: row[1:] for row in table[1:]}
    assert set(rows) == (set(images) - {"Normal"}) | {"Normal.X", "Normal.Y", "Normal.Z"}
    for name, row in rows.items():
        base, _, letter = name.partition(".")
        pixels = images[base].astype(float)
        values = pixels[..., "XYZ".index(letter)] if letter else pixels[..., :3].mean(axis=-1)
        values = values[np.isfinite(values)]
        assert row[0] == BY_NAME[base].unit
        expected = [np.min(values), np.median(values), np.mean(values), np.max(values)]
        assert [float(cell) for cell in row[1:5]] == pytest.approx(expected, rel=1e-5), name
        assert row[5] == ("1" if name == "Cost" else "0")


def test_the_difference_is_achieved_less_target(write, images, inspect):
    images["VSP Target"][...], images["VSP Achieved"][...] = 0.75, 0.5
    read = exr.read(write(images))
    shown = next(item for item in maps.maps_of(read) if item.name == maps.DIFFERENCE)
    assert (shown.values == -0.25).all()
    assert (shown.scale.low, shown.scale.high) == (-0.25, 0.25)


def test_pictures_share_one_exposure():
    pixels = np.full((4, 4, 3), 8.0, np.float32)
    shown = maps.maps_of({"Combined": ("RGB", pixels), "Volume": ("RGB", pixels / 2)})
    assert [item.colours.max() for item in shown] == [255, 188]


def test_decades_span_no_more_than_six():
    values = np.array([[0, 1e-12, 1e-3, 10]], np.float32)[..., np.newaxis]
    scale = maps.maps_of({"Variance": ("X", values)})[0].scale
    assert scale.logarithmic and scale.high / scale.low == pytest.approx(1e6)


def test_layers_have_figures_of_their_own():
    one = np.zeros((2, 2, 1), np.float32)
    images = {f"{layer}.{name}": ("X", one) for layer in "AB" for name in ("VSP Target", "VSP Achieved")}
    assert [item.name for item in maps.maps_of(images)] == [
        f"{layer}.{name}" for name in (maps.TARGET, maps.ACHIEVED, maps.DIFFERENCE) for layer in "AB"
    ]


def test_constant_and_empty_maps_have_scales():
    for value in (0, 3, np.nan):
        images = {name: ("X", np.full((2, 2, 1), value, np.float32)) for name in maps.FALSE_COLOURED
                  if name in BY_NAME and name != "Transmittance"}  # fmt: skip
        for item in maps.maps_of(images):
            assert item.scale.low < item.scale.high, item.name


def test_settings_and_statistics(write, images, inspect, tmp_path):
    stats = tmp_path / "stats.json"
    stats.write_text(json.dumps({"rays": 12345, "seconds": {"render": 1.5}, "grids": [{"name": "<b>"}]}))
    text = inspect(write(images), "--stats", stats)[2]
    assert f"{WIDTH} x {HEIGHT} pixels, 8 samples per pixel, Nephele 0.1.0" in text
    _, settings, statistics = Page(text).tables
    assert ["seed", "77"] in settings and len(settings) == len(parameters.PARAMETERS) + 1
    assert statistics[1:] == [["rays", "12345"], ["seconds.render", "1.5"], ["grids.0.name", "<b>"]]


def test_a_file_of_blenders_has_maps_but_no_settings(write, images, inspect):
    code, _, text = inspect(write(images, identity=None))
    assert code == 0 and "does not tell of a render" in text
    assert len(Page(text).tables) == 1


def one_line(code, err, *words):
    assert code == 2
    assert err.startswith("nephele: error: ") and err.count("\n") == 1
    for word in words:
        assert word in err


def test_bad_images(write, images, inspect, tmp_path):
    code, err, _ = inspect(tmp_path / "none.exr")
    one_line(code, err, "none.exr", "no such file")
    (tmp_path / "text.exr").write_text("no picture")
    code, err, _ = inspect(tmp_path / "text.exr")
    one_line(code, err, "text.exr", "not an OpenEXR file")
    code, err, _ = inspect(write({name: images[name] for name in ("Combined", "Normal")}))
    one_line(code, err, "a.exr", "Combined, Normal", "--passes", "vsp_target")
    code, err, page = inspect(write(images, identity=IDENTITY | {"film": 3}))
    one_line(code, err, "a.exr", "header")
    assert page is None


def test_bad_output_and_statistics(write, images, inspect, tmp_path, capfd):
    image = write(images)
    assert cli.main(["inspect", str(image), "-o", str(tmp_path / "page.txt")]) == 2
    assert ".html" in capfd.readouterr().err
    assert cli.main(["inspect", str(image)]) == 2
    assert "--output" in capfd.readouterr().err
    (tmp_path / "list.json").write_text("[]")
    (tmp_path / "text.json").write_text("{")
    for name in ("none.json", "list.json", "text.json"):
        code, err, page = inspect(image, "--stats", tmp_path / name)
        one_line(code, err, name)
        assert page is None
