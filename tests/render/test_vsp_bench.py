# SPDX-License-Identifier: GPL-3.0-or-later
"""The measuring of guiding (bench/vsp.py): its arithmetic, what Mitsuba gets, one tiny run."""

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from nephele.description import Closure, Phase, Program, VolumeClosure

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import mitsuba, vsp  # noqa: E402  the project's root is on the path only now
from bench.reference import Reference  # noqa: E402


def test_noise_of_the_reference_is_taken_off():
    """Truth 10, halves and image with the same independent noise of 0.5: the image's relMSE is 0.25 / 100.01,
    not the 1.5-fold that stands between it and the reference. 12288 values know it to 2 % (one standard
    error; the false alarm of 5 of them is under 1e-6)."""
    rng = np.random.default_rng(4)
    first, second, image = (10 + 0.5 * rng.standard_normal((64, 64, 3)) for _ in range(3))
    error = Reference.of(np.stack([first, second])).error(image)
    assert error["relmse"] == pytest.approx(0.25 / 100.01, rel=0.10)
    assert abs(error["bias"]) < 1e-3


def test_pixels_that_are_not_finite_are_refused():
    good = np.ones((4, 4, 3))
    bad = good.copy()
    bad[1, 2, 0] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        Reference.of(np.stack([good, good])).error(bad)


def test_gains_are_what_they_say():
    """Half the error at twice the time is no gain at equal samples; at equal time only the error counts."""

    def runs(cpu, error):
        errors = {"relmse": error, "relmse_trimmed": error, "bias": 0.0}
        return [{"seed": seed, "samples": 8, "cpu": cpu, **errors} for seed in (1, 2)]

    row = {
        "equal_samples": {"delta": runs(1.0, 0.4), "vspg": runs(2.0, 0.2)},
        "equal_time": {"delta": runs(1.0, 0.4), "vspg": runs(1.0, 0.3)},
    }
    vspg = vsp.summary(row)["vspg"]
    assert vspg["equal_samples"]["efficiency"] == pytest.approx(1.0)
    assert vspg["equal_time"]["gain"] == pytest.approx(4 / 3)


def test_samples_fit_the_budget():
    assert vsp.fitting_samples(64, 2.0, 1.0) == 32
    assert vsp.fitting_samples(4, 100.0, 1.0) == 1


def test_tiny_run(tmp_path):
    """The script measures two configurations in one scene, prints its table and writes its JSON."""
    output = tmp_path / "vsp.json"
    arguments = (
        "--scenes cumulus --configs vspg --resolution 16x9 --seeds 2 --samples 4 --reference-samples 16"
    )
    command = [sys.executable, "bench/vsp.py", *arguments.split(), "--output", str(output)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stdout.splitlines() if line.startswith("| ")]
    assert [line.split(" | ")[0] for line in lines] == ["| configuration", "| delta", "| vspg"]
    scene = json.loads(output.read_text())["scenes"]["cumulus"]
    for kind in ("equal_samples", "equal_time"):
        runs = scene[kind]["vspg"]
        assert len({run["seed"] for run in runs}) == 2
        assert all(run["cpu"] > 0 and run["samples"] >= 1 for run in runs)
    assert scene["summary"]["delta"]["equal_samples"]["efficiency"] == pytest.approx(1.0)
    assert len(list(tmp_path.glob("vsp_references/cumulus-16x9-16-*.npz"))) == 1


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
