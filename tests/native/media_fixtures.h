// SPDX-License-Identifier: GPL-3.0-or-later
// Media for tests, along one ray, with their optical depth by fine quadrature; and means with their standard
// errors.
#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <vector>

#include "math/sampler.h"
#include "media/segment.h"

namespace nephele::test {

/// Sum of independent samples. z() is standard normal for a right estimator of many samples.
class Mean {
  public:
    void add(double x) {
        ++n_;
        sum_ += x;
        sum2_ += x * x;
    }
    double mean() const { return sum_ / n_; }
    double error() const {
        return std::sqrt(std::max(0.0, sum2_ / n_ - mean() * mean()) / std::max(n_ - 1, 1.0));
    }
    /// Deviation from what is expected, in standard errors. `rounding`: of single precision, relative.
    double z(double expected, double rounding = 3e-6) const {
        const double off = std::max(0.0, std::fabs(mean() - expected) - rounding * std::fabs(expected));
        return off == 0 ? 0 : off / std::max(error(), 1e-300);
    }

  private:
    double n_ = 0, sum_ = 0, sum2_ = 0;
};

/// Largest deviation allowed to one of the z-tests here: 5.5 standard errors, a false alarm of 4e-8 each. All
/// z-tests of a binary together, some thousands, raise a false alarm with probability 2e-4; seeds are fixed.
inline constexpr double kSigmas = 5.5;

/// Density at a voxel.
using Voxels = std::function<float(int, int, int)>;

/// A density on a grid, with its bounds.
struct Field {
    std::shared_ptr<const BrickGrid> grid;
    std::shared_ptr<const MediumBounds> bounds;
};

/// A field of n^3 voxels from the origin of index space, which is also the world's.
inline Field field_of(int n, const Voxels& voxels, Accelerator accelerator = Accelerator::grid) {
    std::vector<float> values;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k)
                values.push_back(voxels(i, j, k));
        }
    }
    Field field;
    field.grid = brick_grid_of_dense({0, 0, 0}, {n, n, n}, values.data(), 0, VoxelType::single_float);
    const CellBounds cells = CellBounds::of_grid(*field.grid, Filter::trilinear);
    field.bounds =
        std::make_shared<MediumBounds>(MediumBounds{Majorants(cells, accelerator, 1.0f, true), {}});
    return field;
}

/// Mean cosine of squared_grid().
inline constexpr float kProgramG = -0.5f;

/// A program whose extinction is the square of grid 0, and not linear in it: sigma_s and sigma_a are the
/// colours times that, emission is the colour times the grid.
inline Program squared_grid(Rgb sigma_s, Rgb sigma_a, Rgb emission) {
    const auto op = [](Op o) { return static_cast<std::int32_t>(o); };
    Program program;
    program.registers = {sigma_s, sigma_a, emission, Vec3f(1), {}, {}, {}, Vec3f(kProgramG)};
    program.code = {{op(Op::position), 4},       {op(Op::grid), 5, 4},        {op(Op::multiply), 6, 5, 5},
                    {op(Op::multiply), 0, 0, 6}, {op(Op::multiply), 1, 1, 6}, {op(Op::multiply), 2, 2, 5}};
    ClosureRow row;
    row.kind = ClosureKind::medium;
    row.weight = 3;
    row.inputs = {0, 1, 2, 7, 7};
    program.closures = {row};
    return program;
}

/// Media along a ray through [0, length], and their integrals.
struct Line {
    std::deque<Medium> media;
    Segment segment;
    const Medium* scatters = nullptr;  ///< where set, `at` counts scattering in this medium only

    explicit Line(Ray ray) { segment.ray = ray; }

    Medium& add(Rgb sigma_s, Rgb sigma_a, float t0, float t1, const Field& field = {}) {
        Medium m;
        m.sigma_s = sigma_s;
        m.sigma_t = sigma_s + sigma_a;
        m.grid = field.grid;
        m.bounds = field.bounds;
        media.push_back(std::move(m));
        segment.intervals.push_back({&media.back(), t0, t1});
        return media.back();
    }

    /// A medium of squared_grid(), whose grid is a field of n^3 voxels from the origin.
    Medium& add_program(const Program& program, float t0, float t1, int n, const Voxels& voxels) {
        const Field grid = field_of(n, voxels);
        VolumeField field;
        field.components[0] = grid.grid;
        field.bounds[0] = std::make_shared<CellBounds>(CellBounds::of_grid(*grid.grid, field.filter));
        const BoundsFrame frame{{}, {}, {{-1, -1, -1}, {n, n, n}}};
        Medium m;
        m.program =
            std::make_shared<ProgramMedium>(program, nullptr, VolumeFields({field}), 1, ShadingPoint(),
                                            TextureContext(), std::span<const ImageBounds>());
        m.bounds = bounds_of_program(*m.program, frame, {Accelerator::grid, true});
        media.push_back(std::move(m));
        segment.intervals.push_back({&media.back(), t0, t1});
        return media.back();
    }

    /// Coefficients at t, by the true trilinear filter.
    struct Point {
        double sigma_t[3] = {}, sigma_s[3] = {}, emission[3] = {};
    };
    Point at(double t) const {
        Point out;
        for (const Interval& i : segment.intervals) {
            if (t < double{i.t0} || t > double{i.t1})
                continue;
            const Medium& m = *i.medium;
            const Vec3f p = segment.ray.at(static_cast<float>(t));
            const bool counted = !scatters || scatters == &m;
            if (m.program) {
                const MediumPoint all = m.program->coefficients({p, -segment.ray.d});
                const Rgb emission = m.program->emission({p, -segment.ray.d});
                for (int c = 0; c < 3; ++c) {
                    out.sigma_t[c] += double{all.sigma_t[c]};
                    out.sigma_s[c] += counted ? double{all.sigma_s[c]} : 0;
                    out.emission[c] += double{emission[c]};
                }
                continue;
            }
            const double density =
                m.grid ? double{m.grid->trilinear(m.bounds->index_from_world.point(p))} : 1;
            for (int c = 0; c < 3; ++c) {
                out.sigma_t[c] += density * double{m.sigma_t[c]};
                out.sigma_s[c] += counted ? density * double{m.sigma_s[c]} : 0;
                out.emission[c] += (m.density_scales_emission ? density : 1) * double{m.emission[c]};
            }
        }
        return out;
    }
};

/// Integrals along a line, by the midpoint rule at `steps` points, in channel c. edges(k) is t after k steps.
struct Profile {
    double t0, step;
    std::vector<double> tau, scattered, emitted;  ///< from t0 up to each edge; the last two are transmitted

    Profile(const Line& line, double from, double to, int c, int steps = 40000)
        : t0(from), step((to - from) / steps), tau{0}, scattered{0}, emitted{0} {
        for (int k = 0; k < steps; ++k) {
            const Line::Point p = line.at(t0 + (k + 0.5) * step);
            const double depth = p.sigma_t[c] * step;
            // The mean of exp(-sigma_t s) over the step, exact where the coefficients are constant.
            const double through = std::exp(-tau.back()) * (depth > 1e-12 ? -std::expm1(-depth) / depth : 1);
            scattered.push_back(scattered.back() + p.sigma_s[c] * step * through);
            emitted.push_back(emitted.back() + p.emission[c] * step * through);
            tau.push_back(tau.back() + depth);
        }
    }
    double transmittance() const { return std::exp(-tau.back()); }
    /// Value of a running integral at t.
    double at(const std::vector<double>& integral, double t) const {
        const double x = std::clamp((t - t0) / step, 0.0, static_cast<double>(integral.size() - 1));
        const auto k = std::min(static_cast<std::size_t>(x), integral.size() - 2);
        return integral[k] + (integral[k + 1] - integral[k]) * (x - static_cast<double>(k));
    }
};

}  // namespace nephele::test
