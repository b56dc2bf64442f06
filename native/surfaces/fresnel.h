// SPDX-License-Identifier: GPL-3.0-or-later
// Fresnel reflectance: exact for dielectrics and conductors, Schlick with an edge tint at 82 degrees for
// metals (Kutz, Hasan and Edmondson 2021, "Novel aspects of the Adobe Standard Material"); either may bear a
// thin film, see thin_film.cpp. Cosines are of the angle between a direction and the microfacet's normal, in
// [0,1]; eta = ior on the transmitted side / ior on wo's side.
#pragma once

#include <complex>

#include "math/vec.h"

namespace nephele {

/// Unpolarised reflectance of a smooth dielectric. cos_t: cosine of the refracted direction, 0 at total
/// reflection.
inline float fresnel_dielectric(float cos_i, float eta, float& cos_t) {
    // eta^2 - sin^2: near normal incidence, and at grazing angles where the index is near 1, only one form
    // has digits.
    const float eta2_cos2_t =
        cos_i < 0.7f ? (eta - 1) * (eta + 1) + cos_i * cos_i : eta * eta - (1 - cos_i) * (1 + cos_i);
    cos_t = std::sqrt(std::max(0.0f, eta2_cos2_t)) / eta;
    if (eta2_cos2_t <= 0)
        return 1;
    const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 0.5f * (perpendicular * perpendicular + parallel * parallel);
}
inline float fresnel_dielectric(float cos_i, float eta) {
    float cos_t;
    return fresnel_dielectric(cos_i, eta, cos_t);
}

/// Amplitudes that a smooth conductor of index n + ik reflects, polarised across (s) and along (p) the plane
/// of incidence, as squared moduli and phases.
struct ConductorReflection {
    float s2, p2;
    std::complex<float> s, p;

    ConductorReflection(float cosine, float n, float k) {
        const std::complex<float> index(n, k), index2 = index * index;
        const std::complex<float> root = std::sqrt(index2 - (1 - cosine) * (1 + cosine));
        s = (cosine - root) / (cosine + root);
        p = (index2 * cosine - root) / (index2 * cosine + root);
        s2 = std::norm(s), p2 = std::norm(p);
    }
};
inline float fresnel_conductor(float cosine, float n, float k) {
    const ConductorReflection reflected(cosine, n, k);
    return 0.5f * (reflected.s2 + reflected.p2);
}

/// An index whose square, and that of its ratio to another, is a float.
constexpr float bounded_ior(float ior) {
    return std::clamp(ior, 1e-5f, 1e5f);
}

/// Reflectance at normal incidence, and the index above 1 that has it.
constexpr float f0_from_ior(float ior) {
    return sqr((ior - 1) / (ior + 1));
}
/// 1 - f0_from_ior(ior); 0 only where the index is beyond all measure.
constexpr float range_from_ior(float ior) {
    return ior / (ior + 1) * (4 / (ior + 1));
}
inline float ior_from_f0(float f0) {
    const float root = std::sqrt(std::clamp(f0, 0.0f, 0.99f));
    return (1 + root) / (1 - root);
}

/// Light's path inside a layer of this index >= 1, in units of its thickness: 1 / cosine there. Infinite only
/// for light that grazes a layer of index 1.
inline float path_through_coat(float mu, float ior) {
    return ior / std::sqrt((ior - 1) * (ior + 1) + mu * mu);
}

/// Cosine-weighted mean of fresnel_dielectric over the hemisphere (fit of Kulla and Conty 2017, "Revisiting
/// Physically Based Shading at Imageworks").
inline float fresnel_dielectric_mean(float eta) {
    if (eta >= 1)
        return (eta - 1) / (4.08567f + 1.00071f * eta);
    return 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f));
}

/// The same exactly, by the integral's closed form (Duntley 1942), without the fit's error of 1 %. From
/// inside to outside it follows from the other way: what gets through is the same, spread over eta^2 of the
/// projected solid angle.
inline float exact_fresnel_dielectric_mean(float eta) {
    if (eta < 1)
        return 1 - (1 - exact_fresnel_dielectric_mean(1 / eta)) * eta * eta;
    const double n = double{eta};
    if (n < 1.0001)  // there the terms cancel; the leading one of their sum is left
        return static_cast<float>((n - 1) / 3);
    const double n2 = n * n, n4 = n2 * n2, above = n2 + 1, between = n4 - 1;
    return static_cast<float>(0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
                              n2 * (n2 - 1) * (n2 - 1) / (above * above * above) *
                                  std::log((n - 1) / (n + 1)) -
                              2 * n2 * n * (n2 + 2 * n - 1) / (above * between) +
                              8 * n4 * (n4 + 1) / (above * between * between) * std::log(n));
}

/// A film on a surface. thickness: nanometres, 0 for none. ior: that of the film / ior on wo's side.
struct ThinFilm {
    float thickness = 0, ior = 1;
};

/// Colour of a reflection as a function of the cosine.
struct Fresnel {
    enum class Kind : std::uint8_t { constant, f82, dielectric, conductor };

    Kind kind = Kind::constant;
    Rgb f0{1};  ///< at normal incidence; conductor: the index's real part
    Rgb dip;    ///< f82: factor of the term that darkens Schlick's curve towards 82 degrees; conductor: the
                ///< index's imaginary part
    float eta = 1;  ///< dielectric: index whose curve leads from f0 to 1
    ThinFilm film;

    static Fresnel constant(Rgb color) { return {Kind::constant, color, Rgb(0), 1, {}}; }
    static Fresnel conductor(Rgb n, Rgb k) { return {Kind::conductor, n, k, 1, {}}; }

    /// Metal. tint: reflectance at 82 degrees (cosine 1/7) relative to Schlick's.
    static Fresnel metal(Rgb f0, Rgb tint) {
        constexpr float kCos = 1.0f / 7.0f, kSchlick = 0.46266436f;  // (1 - kCos)^5
        const Rgb schlick = f0 + (Rgb(1) - f0) * kSchlick;
        return {Kind::f82, f0, schlick * (Rgb(1) - tint) / (kCos * kSchlick * (1 - kCos)), 1, {}};
    }

    /// Dielectric whose reflectance at normal incidence is `f0` in place of the index's own.
    static Fresnel dielectric(float eta, Rgb f0) { return {Kind::dielectric, f0, Rgb(0), eta, {}}; }
    static Fresnel dielectric(float eta) { return dielectric(eta, Rgb(f0_from_ior(eta))); }

    /// The same under a film; a metal becomes the conductor that reflects like it at the normal and at 82
    /// degrees.
    Fresnel under(ThinFilm f) const { return f.thickness > 0 ? filmed_by(f) : *this; }
    /// Whether mean() and the tables of albedos know nothing of its curve.
    bool is_peculiar() const { return kind == Kind::conductor || film.thickness > 0; }

    Rgb at(float cosine) const { return film.thickness > 0 ? filmed(cosine) : bare(cosine); }

    /// Without the film.
    Rgb bare(float cosine) const {
        if (kind == Kind::constant)
            return f0;
        if (kind == Kind::dielectric)
            return remapped(fresnel_dielectric(cosine, eta));
        if (kind == Kind::conductor) {
            const auto channel = [&](int c) { return fresnel_conductor(cosine, f0[c], dip[c]); };
            return {channel(0), channel(1), channel(2)};
        }
        const float m = 1 - clamp01(cosine), m2 = m * m, m5 = m2 * m2 * m;
        return max(f0 + (Rgb(1) - f0) * m5 - dip * (cosine * m5 * m), Rgb(0));
    }

    /// Cosine-weighted mean over the hemisphere.
    Rgb mean() const {
        if (is_peculiar())
            return integrated_mean();
        if (kind == Kind::constant)
            return f0;
        if (kind == Kind::dielectric)
            return remapped(fresnel_dielectric_mean(eta));
        return f0 + (Rgb(1) - f0) * (1.0f / 21.0f) - dip * (1.0f / 126.0f);
    }

    /// Moves the index's reflectance `real`, or a mean of it, to the range from f0 to 1.
    Rgb remapped(float real) const {
        const float range = range_from_ior(eta);
        return range > 0 ? f0 + (Rgb(1) - f0) * clamp01((real - f0_from_ior(eta)) / range) : f0;
    }

  private:
    Fresnel filmed_by(ThinFilm f) const;  // thin_film.cpp
    Rgb filmed(float cosine) const;
    Rgb integrated_mean() const {  // Gauss's rule in the squared cosine
        constexpr float kNodes[] = {0.0694318442f, 0.3300094782f, 0.6699905218f, 0.9305681558f};
        constexpr float kWeights[] = {0.1739274226f, 0.3260725774f, 0.3260725774f, 0.1739274226f};
        Rgb sum;
        for (int i = 0; i < 4; ++i)
            sum += kWeights[i] * at(std::sqrt(kNodes[i]));
        return sum;
    }
};

}  // namespace nephele
