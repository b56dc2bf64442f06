# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed forms: sources in an infinite medium, absorption, emission.

False alarm: 5 standard errors, 6e-7 for each of about 60 numbers.
"""

import numpy as np
import pytest
import scipy.integrate
from nephele import description as d
from truth import (
    BOX_FILTER,
    NO_LIMIT,
    Scene,
    assert_mean,
    box,
    diffuse,
    emission,
    facing,
    joined,
    orthographic,
    perspective,
    placed,
    sphere,
    volume_of,
)  # fmt: skip

# Fluence rate phi(r), W/m^2, of an isotropic point source of 1 W in an infinite medium that scatters
# isotropically, extinction 1/m, albedo a: pole and continuum of Case and Zweifel 1967, computed
# independently; the volume integral of phi is 1/(1 - a) to 6 digits.
RADII = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
FLUENCE = {
    0.5: (1.264881, 2.947631e-1, 5.869514e-2, 7.927624e-3, 4.493863e-4, 4.076416e-6),
    0.9: (1.639311, 4.828327e-1, 1.432839e-1, 3.712640e-2, 6.194053e-3, 3.751829e-4),
}
ROUND = 5e-4  # the spheres are polyhedra, whose vertices lie 0.1 % further out than their faces


def shell_average(a, r, half):
    """Returns the mean of phi over the shell r +- half. It adds the curvature of r^2 phi, the density of a
    shell's share, by Simpson's rule; r^2 phi is interpolated as exp of a cubic in log r through the table."""
    log_r, values = np.log(RADII), np.log(np.array(FLUENCE[a]) * np.square(RADII))
    fit = np.polynomial.Polynomial.fit(log_r, values, len(RADII) - 1)
    flux = np.exp(fit(np.log([r - half, r, r + half])))
    return (flux[0] + 4 * flux[1] + flux[2]) / 6 / (r * r + half * half / 3)


def shell(r, albedos):
    """Returns (scene, expected radiance). By reciprocity the fluence at the centre of a shining shell is the
    point source's, averaged over the shell; by symmetry the radiance there is the same in all directions. The
    shell is two spheres in one mesh, and the medium around it is the world's."""
    half, a = 0.04 * r, np.array(albedos)
    mesh = joined(sphere(r + half, 5), sphere(r - half, 5, inwards=True))
    medium = d.VolumeClosure(tuple(a), tuple(1 - a))
    scene = Scene(perspective((0, 0, 0), (0.3, 1, 0.2)), world_volume=(medium,))
    scene.add(mesh, None, (d.VolumeClosure(emission=(1.0, 1.0, 1.0)),))
    return scene, volume_of(mesh) * np.array([shell_average(c, r, half) for c in albedos])


def fluence_image(scene, samples, seed=2, **settings):
    return scene.render(size=64, samples=samples, seed=seed, **settings, **NO_LIMIT, **BOX_FILTER)["Combined"]


@pytest.mark.parametrize("r", RADII[:-1])
@pytest.mark.parametrize("integrator", ["path", "plain"])
def test_fluence_of_a_source_in_an_endless_medium(r, integrator):
    scene, expected = shell(r, (0.5, 0.9, 0.5))
    assert_mean(fluence_image(scene, 128, integrator=integrator), expected, rounding=ROUND, most=0.03)


def test_fluence_far_from_a_source():
    """Eight mean free paths off, of albedo 0.9 alone: of 0.5, one path in 100000 gets there."""
    scene, expected = shell(8.0, (0.9, 0.9, 0.9))
    assert_mean(fluence_image(scene, 128), expected, rounding=ROUND, most=0.03)


@pytest.mark.long
@pytest.mark.parametrize(("r", "samples"), [(0.25, 512), (0.5, 512), (1.0, 1024), (2.0, 2048)])
def test_fluence_within_three_per_mille(r, samples):
    """False alarm: 3 standard errors, 0.3 % a number, with seeds that are fixed."""
    scene, expected = shell(r, (0.9, 0.9, 0.9))
    image = fluence_image(scene, samples)
    assert_mean(image, expected, sigmas=3, rounding=ROUND, most=0.001)
    assert np.abs(image.mean((0, 1)) / expected - 1).max() < 0.003


@pytest.mark.parametrize("lamp", ["point", "ball", "spot"])
def test_airlight_of_a_lamp_by_single_scattering(lamp):
    """One scattering event of a ray that passes a lamp at distance h: sigma_s / (4 pi) times the integral
    of the irradiance's transmitted part, an integral along the ray, in an endless medium of HG g = 0."""
    sigma_s, sigma_t, h, power = np.array([0.2, 0.5, 1.0]), np.array([0.4, 0.5, 1.5]), 0.7, 10.0
    radius = 0.02 if lamp == "ball" else 0.0
    kind = "spot" if lamp == "spot" else "point"
    light = d.Light(
        lamp, kind, facing((0, h, 0), (0, 0, 0)), (power,) * 3, radius=radius, spot_size=1.2, spot_blend=0.0
    )
    medium = d.VolumeClosure(tuple(sigma_s), tuple(sigma_t - sigma_s))
    view = orthographic((-2.0, 0, 0), (0, 0, 0), 1e-4)
    image = Scene(view, world_volume=(medium,), lights=(light,)).render(
        size=64, samples=256, max_bounces=0, pixel_filter="box"
    )["Combined"]

    def integrand(x, t):
        distance = np.hypot(x, h)
        lit = lamp != "spot" or abs(x) < h * np.tan(0.6)
        # A ball's near side is 2/3 of its radius nearer than its centre, averaged over its disc.
        return lit * np.exp(-t * (x + 2.0 + distance - 2 / 3 * radius)) / distance**2

    edges = (-h * np.tan(0.6), 0.0, h * np.tan(0.6))
    line = [scipy.integrate.quad(integrand, -2, 60, (t,), points=edges, limit=500)[0] for t in sigma_t]
    expected = sigma_s / (4 * np.pi) * power / (4 * np.pi) * np.array(line)
    # A ball of radius 0.02 at 0.7 is no point: (r / h)^2, 0.1 %, bounds the difference.
    assert_mean(image, expected, rounding=1e-3 if lamp == "ball" else 1e-5, most=0.003)


@pytest.mark.parametrize("integrator", ["path", "plain"])
def test_mean_transmittance_of_an_absorbing_ball(integrator):
    """Over the projected area of a ball of optical radius t: (1 - (1 + 2 t) exp(-2 t)) / (2 t^2)."""
    t = np.array([0.5, 1.0, 2.0])
    ball = (1 - (1 + 2 * t) * np.exp(-2 * t)) / (2 * t * t)
    scene = Scene(orthographic((0.3, -5, 0.2), (0.3, 0, 0.2), 2.0), emission(1.0))
    scene.add(sphere(1.0, 6), None, (d.VolumeClosure((0, 0, 0), tuple(t)),), placed(0.3, 0, 0.2))
    passes = ("Combined", "Transmittance") if integrator == "path" else ("Combined",)
    images = scene.render(passes, size=64, samples=128, integrator=integrator, **BOX_FILTER)
    expected = np.pi / 4 * ball + 1 - np.pi / 4  # the ball fills pi/4 of the square picture
    for (
        name
    ) in passes:  # pixels differ, but each is estimated by itself: the spread bounds the error from above
        assert_mean(images[name], expected, sigmas=1.0, most=0.02)
        assert np.abs(images[name].mean((0, 1)) / expected - 1).max() < (2e-3 if name == "Combined" else 1e-3)


@pytest.mark.parametrize("settings", [{}, {"tracking": "delta"}, {"integrator": "plain"}], ids=str)
def test_emission_through_an_absorbing_slab(settings):
    """L = j / sigma_a (1 - exp(-sigma_a d)), and the limit j d; each channel its own; dark world."""
    length, j, sigma_a = 1.6, np.array([2.0, 3.0, 4.0]), np.array([0.7, 2.0, 1e-7])
    scene = Scene(orthographic((5, 0.1, 0.2), (0, 0.1, 0.2)))
    scene.add(box((-0.6, -1, -1), (1.0, 1, 1)), None, (d.VolumeClosure((0, 0, 0), tuple(sigma_a), tuple(j)),))
    images = scene.render(("Combined", "Volume", "Surface", "Emission"), size=64, samples=64, **settings)
    expected = j / sigma_a * -np.expm1(-sigma_a * length)
    assert_mean(images["Combined"], expected, rounding=1e-5, most=0.005)
    assert np.array_equal(images["Volume"], images["Combined"])
    assert not images["Surface"].any()
    if settings.get("integrator") != "plain":
        assert np.array_equal(images["Emission"], images["Combined"])


def test_transmittance_of_overlapping_boxes_multiplies():
    """Two boxes and the world overlap; the transmittance up to a wall behind them is exact, chromatic."""
    world, one, two = np.array([0.01, 0.02, 0.0]), np.array([0.5, 1.0, 2.0]), np.array([1.0, 0.1, 0.0])
    scene = Scene(
        orthographic((6, 0.1, 0.2), (0, 0.1, 0.2)), world_volume=(d.VolumeClosure(sigma_a=tuple(world)),)
    )
    scene.add(box((-1, -1, -1), (1, 1, 1)), None, (d.VolumeClosure(tuple(one / 2), tuple(one / 2)),))
    scene.add(box((0, -1, -1), (3, 1, 1)), None, (d.VolumeClosure(sigma_a=tuple(two)),))
    scene.add(box((-5, -9, -9), (-4, 9, 9)), diffuse(0.5))
    image = scene.render(("Transmittance",), size=8, samples=4)["Transmittance"]
    assert np.allclose(image, np.exp(-(10 * world + 2 * one + 3 * two)), rtol=2e-5)
