// SPDX-License-Identifier: GPL-3.0-or-later
// Interference in a thin film (Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the
// Modeling of Varying Iridescence"): light that goes back and forth m times in the film differs in phase from
// what its outside reflects; summed over m, a channel's reflectance is
//   C_0 + 2 sum over m of C_m Re(exp(i m phi) S(m D)),  D = 2 ior d cos(theta in the film),
// S the channel's sensitivity over the spectrum, transformed. The paper fits S by Gaussians of the matching
// functions of XYZ; here it is the integral itself, of the functions as Wyman, Sloan and Shirley 2013 fit
// them
// ("Simple Analytic Approximations to the CIE XYZ Color Matching Functions"), in Rec. 709, each channel with
// S(0) = 1 so that white stays white.
#include <array>
#include <vector>

#include "surfaces/fresnel.h"

namespace nephele {
namespace {

using Complex = std::complex<float>;

struct Lobe {
    double height, middle, below, above;  // nanometres

    double at(double wavelength) const {
        const double t = (wavelength - middle) * (wavelength < middle ? below : above);
        return height * std::exp(-0.5 * t * t);
    }
};

std::array<double, 3> rec709_sensitivity(double w) {
    const double x = Lobe{1.056, 599.8, 0.0264, 0.0323}.at(w) + Lobe{0.362, 442.0, 0.0624, 0.0374}.at(w) +
                     Lobe{-0.065, 501.1, 0.0490, 0.0382}.at(w);
    const double y = Lobe{0.821, 568.8, 0.0213, 0.0247}.at(w) + Lobe{0.286, 530.9, 0.0613, 0.0322}.at(w);
    const double z = Lobe{1.217, 437.0, 0.0845, 0.0278}.at(w) + Lobe{0.681, 459.0, 0.0385, 0.0725}.at(w);
    return {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
            0.0557 * x - 0.2040 * y + 1.0570 * z};
}

/// S by channel over path differences, which beyond the last leave no colour.
class Sensitivity {
  public:
    Sensitivity() : values_(kCount + 1) {
        std::array<double, 3> total{};
        for (double w = kShortest; w < kLongest; w += 1) {
            const auto response = rec709_sensitivity(w);
            for (std::size_t c = 0; c < 3; ++c)
                total[c] += response[c];
            for (int i = 0; i <= kCount; ++i) {
                const double phase = 2 * double{kPi} * double{kStep} * i / w;
                for (std::size_t c = 0; c < 3; ++c)
                    values_[static_cast<std::size_t>(i)][c] += std::polar(response[c], phase);
            }
        }
        for (auto& value : values_) {
            for (std::size_t c = 0; c < 3; ++c)
                value[c] /= total[c];
        }
    }
    Complex at(std::size_t channel, float difference) const {
        const float x = difference / kStep;
        if (!(x < kCount))
            return 0;
        const auto i = static_cast<std::size_t>(x);
        const double t = static_cast<double>(x) - static_cast<double>(i);
        return Complex(values_[i][channel] * (1 - t) + values_[i + 1][channel] * t);
    }

  private:
    static constexpr double kShortest = 360, kLongest = 830;
    static constexpr float kStep = 20;  // of a period of some 500
    static constexpr int kCount = 800;
    std::vector<std::array<std::complex<double>, 3>> values_;
};
const Sensitivity& sensitivity() {
    static const Sensitivity table;
    return table;
}

/// What the two faces of a film reflect of one polarisation, as amplitudes seen from the film's outside.
struct Faces {
    float outer;  ///< real: both sides are dielectrics
    Complex inner;
};

float reflectance(const Faces& faces, std::size_t channel, float difference) {
    const float outer2 = sqr(faces.outer), through = 1 - outer2, inner2 = std::norm(faces.inner);
    const float between = std::sqrt(outer2 * inner2);
    if (!(between < 0.9999f))
        return 1;
    const float several = sqr(through) * inner2 / (1 - outer2 * inner2);
    float sum = outer2 + several, factor = several - through;
    // Inside, the outer face reflects with the opposite sign.
    const Complex once = between > 0 ? -faces.outer * faces.inner / between : Complex(1);
    Complex phase = 1;
    for (int m = 1; m <= 8; ++m) {
        factor *= between;
        phase *= once;
        sum += 2 * factor * (phase * sensitivity().at(channel, static_cast<float>(m) * difference)).real();
    }
    return clamp01(sum);
}

}  // namespace

/// Index of a metal by its reflectance at the normal and an edge colour, for which the reflectance at 82
/// degrees stands (Gulbrandsen 2014, "Artist Friendly Metallic Fresnel").
Fresnel Fresnel::filmed_by(ThinFilm f) const {
    Fresnel out = *this;
    if (kind == Kind::f82) {
        const Rgb edge = min(bare(1.0f / 7.0f), Rgb(1));
        for (int c = 0; c < 3; ++c) {
            const float r = std::clamp(f0[c], 0.0f, 0.999f), root = std::sqrt(r);
            const float n = lerp((1 + root) / (1 - root), (1 - r) / (1 + r), edge[c]);
            out.f0[c] = n;
            out.dip[c] = std::sqrt(std::max(0.0f, (r * sqr(n + 1) - sqr(n - 1)) / (1 - r)));
        }
        out.kind = Kind::conductor;
    }
    out.film = f;
    return out;
}

Rgb Fresnel::filmed(float cosine) const {
    const float n = film.ior;
    float cos_film;
    if (fresnel_dielectric(cosine, n, cos_film) >= 1)
        return Rgb(1);
    const float difference = 2 * n * film.thickness * cos_film;
    const float outer_s = (cosine - n * cos_film) / (cosine + n * cos_film);
    const float outer_p = (n * cosine - cos_film) / (n * cosine + cos_film);
    Rgb out;
    const auto fill = [&](int c, Complex inner_s, Complex inner_p) {
        const auto channel = static_cast<std::size_t>(c);
        out[c] = 0.5f * (reflectance({outer_s, inner_s}, channel, difference) +
                         reflectance({outer_p, inner_p}, channel, difference));
    };
    if (kind == Kind::dielectric) {
        float cos_base;
        if (fresnel_dielectric(cos_film, eta / n, cos_base) >= 1)
            return Rgb(1);
        const float base = eta / n;
        const float s = (cos_film - base * cos_base) / (cos_film + base * cos_base);
        const float p = (base * cos_film - cos_base) / (base * cos_film + cos_base);
        for (int c = 0; c < 3; ++c)
            fill(c, s, p);
        const float own = f0_from_ior(eta);  // of which f0 is a tinted share
        return own > 0 ? out * f0 / own : out;
    }
    for (int c = 0; c < 3; ++c) {
        const ConductorReflection base(cos_film, f0[c] / n, dip[c] / n);
        fill(c, base.s, base.p);
    }
    return out;
}

}  // namespace nephele
