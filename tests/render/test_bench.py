# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time (`nephele bench`): its arithmetic, its references, what Mitsuba gets, a tiny run."""

import csv
import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from nephele.cli import main
from nephele.description import Closure, Phase, Program, VolumeClosure

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import analysis, measure, methods, mitsuba, pictures, suites  # noqa: E402  the root is on the path only now
from bench.reference import Reference, load, save  # noqa: E402


def noisy(truth, deviation, count, seed):
    """Returns `count` images (64, 64, 3) of independent noise around `truth`."""
    rng = np.random.default_rng(seed)
    return truth + deviation * rng.standard_normal((count, 64, 64, 3))


def test_noise_of_the_reference_is_taken_off():
    """Truth 10, halves and image with the same independent noise of 0.5: the image's relMSE is 0.25 / 100.01,
    not the 1.5-fold that stands between it and the reference. 12288 values know it to 2 % (one standard
    error; the false alarm of 5 of them is under 1e-6)."""
    *halves, image = noisy(10, 0.5, 3, 4)
    error = Reference.of(np.stack(halves)).errors(image)
    assert error["relmse"] == pytest.approx(0.25 / 100.01, rel=0.10)
    assert abs(error["bias"]) < 1e-3


def test_bias_is_told_in_standard_errors():
    """A difference of the mean of 10 standard errors comes out as that, within its own spread (5 of them:
    false alarm 1e-6). The channels here are independent, which the estimate does not know: it takes them for
    one another's copies, and so is sqrt(3) too careful."""
    halves, images = noisy(10, 0.5, 2, 5), noisy(10, 0.5, 4, 6)
    made = Reference.of(halves)
    error = 0.5 * np.sqrt(1 / 2 + 1 / 4) / 64
    assert made.bias_z(images + 10 * error) == pytest.approx(10, abs=5 / np.sqrt(3) + 0.5)
    assert made.bias_z(images[:1]) is None


def test_pixels_that_are_not_finite_are_refused():
    good = np.ones((16, 16, 3))
    bad = good.copy()
    bad[1, 2, 0] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        Reference.of(np.stack([good, good])).errors(bad)
    with pytest.raises(ValueError, match="not finite"):
        Reference.of(np.stack([good, bad]))


def test_a_reference_is_kept_with_its_provenance(tmp_path):
    """To the 2^-11 of half floats; one of another scene is not taken for it."""
    made = Reference.of(noisy(10, 0.5, 2, 7), {"command": "nephele bench", "samples": 2})
    of = {"scene": "fog", "digest": "0", "resolution": [64, 64], "bounces": 3}
    save(tmp_path / "fog.exr", made, of)
    kept = load(tmp_path / "fog.exr", of)
    np.testing.assert_allclose(kept.image, made.image, rtol=2**-11)
    assert (kept.noise, kept.mean_error, kept.provenance) == (made.noise, made.mean_error, made.provenance)
    assert load(tmp_path / "fog.exr", of | {"digest": "1"}) is None
    assert load(tmp_path / "none.exr", of) is None


def rows_of(method, constant, exponent, seeds=(1, 2, 3)):
    """Returns rows whose relMSE is constant * samples^exponent, half of it trimmed; a sample takes 0.1 s."""
    rows = []
    for seed in seeds:
        for k, samples in enumerate((10, 40, 160)):
            error = constant * samples**exponent
            errors = dict.fromkeys(analysis.ERRORS, error) | {"relmse_trimmed": error / 2, "bias": 0.0}
            rows.append(
                {"method": method, "seed": seed, "slice": k, "cpu": samples / 10, "samples": samples} | errors
            )
    return rows


def test_curves_say_what_they_are_made_of():
    """A third of the error everywhere is a gain and a speed-up of 3; slopes are the exponents."""
    rows = rows_of("delta", 3.0, -1) + rows_of("guided", 1.0, -1) + rows_of("biased", 1.0, -0.25)
    base, guided = analysis.curve(rows, "delta"), analysis.curve(rows, "guided")
    assert [point["samples"] for point in base] == [10, 40, 160]
    found = analysis.compared(guided, base)
    assert found["gain"] == pytest.approx(3)
    assert found["speedup"] == pytest.approx(3)
    assert not found["gain_extrapolated"]
    assert not found["speedup_extrapolated"]
    back = analysis.compared(base, guided)
    assert back["speedup"] == pytest.approx(1 / 3)
    assert back["speedup_extrapolated"]
    assert analysis.slopes(rows, "guided") == (pytest.approx(-1), pytest.approx(0, abs=1e-9))
    assert analysis.slopes(rows, "biased")[0] == pytest.approx(-0.25)


def test_noise_below_the_reference_gives_no_figure():
    rows = rows_of("delta", 1.0, -1) + rows_of("lucky", -1e-6, -1)
    found = analysis.compared(analysis.curve(rows, "lucky"), analysis.curve(rows, "delta"))
    assert found["gain"] is None
    assert analysis.geometric_mean([2.0, None, 8.0]) == pytest.approx(4)
    assert analysis.geometric_mean([None]) is None


def test_samples_fit_the_budget():
    assert measure.fitting_samples(64, 2.0, 1.0) == 32
    assert measure.fitting_samples(4, 100.0, 1.0) == 1


def test_insets_lie_where_the_error_is():
    errors = np.zeros((90, 160))
    errors[20:30, 100:120] = 1.0
    errors[70:80, 10:30] = 0.9
    first, second = pictures.inset_places(errors)
    assert errors[first].sum() > 150
    assert errors[second].sum() > 100
    assert not np.intersect1d(np.arange(160)[first[1]], np.arange(160)[second[1]]).size


@pytest.mark.parametrize("suite", suites.SUITES)
def test_suites_name_scenes_that_are_there(suite):
    for scene in suites.SUITES[suite]:
        assert scene.path.is_file(), scene.path
        assert scene.reference in methods.METHODS
        assert scene.about


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fog", "-o", "x"], "no suite is called 'fog'"),
        (["none.blend", "-o", "x"], "none.blend: no such file"),
        (["guiding"], "name the report's directory"),
        (["guiding", "--scenes", "door", "-o", "x"], "has no scene 'door'"),
        (["guiding", "--methods", "delta,magic", "-o", "x"], "--methods: nothing is called 'magic'"),
        (["guiding", "--against", "eevee", "-o", "x"], "--against: nothing is called 'eevee'"),
        (["guiding", "--budgets", "5,2", "-o", "x"], "not ascending"),
        (["guiding", "--budgets", "soon", "-o", "x"], "cannot be read"),
        (["guiding", "--resolution", "64", "-o", "x"], "cannot be read"),
        (["guiding", "--seeds", "0", "-o", "x"], "--seeds: 0 is below 1"),
    ],
)
def test_bad_usage_is_told_in_a_line(capsys, monkeypatch, tmp_path, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert main(["bench", *arguments]) == 2
    told = capsys.readouterr().err
    assert words in told
    assert told.count("\n") == 1


@pytest.fixture(scope="module")
def tiny_run(tmp_path_factory):
    """Returns the folder of a report on one scene at 16x9, two methods, one program that refuses it."""
    folder = tmp_path_factory.mktemp("bench")
    options = (
        "--scenes cumulus --methods delta,vspg --against mitsuba --budgets 0.02,0.1 --seeds 2 "
        "--resolution 16x9 --reference-samples 16"
    )
    command = [sys.executable, "-m", "nephele", "bench", "guiding", *options.split(), "-o", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(folder / "report.html")
    return folder


def test_tiny_run_tells_its_runs(tiny_run):
    report = json.loads((tiny_run / "report.json").read_text())
    scene = report["scenes"]["cumulus"]
    assert {(row["method"], row["seed"], row["slice"]) for row in scene["runs"]} == {
        (method, seed, k) for method in ("delta", "vspg") for seed in (1, 2) for k in (0, 1)
    }
    for method in ("delta", "vspg"):
        own = [row for row in scene["runs"] if row["method"] == method and row["seed"] == 1]
        assert own[0]["cpu"] < own[1]["cpu"]
        assert own[0]["samples"] < own[1]["samples"]
        cost = scene["summary"][method]["cost"]
        assert cost["path_length"] >= 1
        assert cost["lookups"] > 0
        assert cost["peak_rss_bytes"] > 2**20
    assert scene["summary"]["delta"]["against_base"]["gain"] == pytest.approx(1)
    assert scene["reference"]["provenance"]["samples"] == 16
    assert report["about"]["machine"]["cores"] >= 1
    assert "mitsuba" in scene["failed"]
    with (tiny_run / "report.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(scene["runs"])
    assert float(rows[0]["relmse"]) == scene["runs"][0]["relmse"]
    assert len(list((tiny_run / "references").glob("cumulus-16x9.exr"))) == 1


def test_tiny_run_has_a_page_that_loads_nothing(tiny_run):
    page = (tiny_run / "report.html").read_text()
    assert page.count("<svg") >= 2
    for name in ("delta", "vspg", "reference", "error of vspg", "FLIP of delta", "target of vspg"):
        assert f'alt="{name}"' in page or f">{name}<" in page or f'alt="VSP {name.capitalize()}"' in page, (
            name
        )
    assert "mitsuba did not render this scene" in page
    loaded = re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', page)
    assert loaded == []


def test_what_mitsuba_cannot_express_is_said():
    """Textures, mixtures and other phase functions are refused; what is constant is handed over as it is."""
    red = Program(np.float32([[1, 1, 1], [0.6, 0.2, 0.1]]), closures=(Closure("diffuse", 0, (1, -1, -1)),))
    reflectance = mitsuba.surface(red)["bsdf"]["bsdf"]["reflectance"]["value"]
    assert reflectance == pytest.approx([0.6, 0.2, 0.1])
    for changed in (
        dataclasses.replace(red, code=np.zeros((1, 8), np.int32)),
        dataclasses.replace(red, closures=(*red.closures, *red.closures)),
        dataclasses.replace(red, closures=(Closure("translucent", 0, (1, -1)),)),
    ):
        with pytest.raises(mitsuba.NotExpressible):
            mitsuba.surface(changed)
    fog = VolumeClosure((0.05, 0.1, 0.2), (0.05, 0.0, 0.2), phase=Phase("henyey_greenstein", 0.3))
    medium = mitsuba.medium((fog,))
    assert medium["sigma_t"]["value"] == pytest.approx([0.1, 0.1, 0.4])
    assert medium["albedo"]["value"] == pytest.approx([0.5, 1, 0.5])
    assert medium["phase"]["g"] == pytest.approx(0.3)
    for changed in (
        dataclasses.replace(fog, density_grid="density"),
        dataclasses.replace(fog, phase=Phase("rayleigh")),
    ):
        with pytest.raises(mitsuba.NotExpressible):
            mitsuba.medium((changed,))
