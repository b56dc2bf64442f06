// SPDX-License-Identifier: GPL-3.0-or-later
#include "math/motion.h"

#include <stdexcept>

namespace nephele {
namespace {

/// Largest turn between two matrices, rad: linear interpolation cuts a corner of its square / 8 of the
/// radius.
constexpr double kLargestTurn = 0.04;

using Matrix3 = std::array<std::array<double, 3>, 3>;
using Quaternion = std::array<double, 4>;  // w, x, y, z

Matrix3 transposed_inverse(const Matrix3& m) {
    Matrix3 cofactor{};
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            cofactor[r][c] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        }
    }
    const double determinant = m[0][0] * cofactor[0][0] + m[0][1] * cofactor[0][1] + m[0][2] * cofactor[0][2];
    if (!(std::fabs(determinant) > 0) || !std::isfinite(1 / determinant))
        throw std::invalid_argument("its transform is singular at some time of its motion");
    for (auto& row : cofactor) {
        for (double& v : row)
            v /= determinant;
    }
    return cofactor;
}

/// The rotation nearest to m, or a mirrored one where m mirrors, by Newton's iteration.
Matrix3 orthogonal_part(Matrix3 m) {
    for (int i = 0; i < 40; ++i) {
        const Matrix3 other = transposed_inverse(m);
        double change = 0;
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                const double v = 0.5 * (m[r][c] + other[r][c]);
                change = std::max(change, std::fabs(v - m[r][c]));
                m[r][c] = v;
            }
        }
        if (change < 1e-14)
            break;
    }
    return m;
}

Quaternion quaternion_of(const Matrix3& r) {
    // The largest component comes from its own square, the others from products with it.
    const double squares[4] = {1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
                               1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]};
    const auto largest = std::max_element(squares, squares + 4) - squares;
    const double wx = r[2][1] - r[1][2], wy = r[0][2] - r[2][0], wz = r[1][0] - r[0][1];
    const double xy = r[1][0] + r[0][1], xz = r[0][2] + r[2][0], yz = r[2][1] + r[1][2];
    const Quaternion rows[4] = {{squares[0], wx, wy, wz},
                                {wx, squares[1], xy, xz},
                                {wy, xy, squares[2], yz},
                                {wz, xz, yz, squares[3]}};
    Quaternion q = rows[largest];
    const double size = 2 * std::sqrt(squares[largest]);
    for (double& v : q)
        v /= size;
    return q;
}

Matrix3 matrix_of(const Quaternion& q) {
    const auto [w, x, y, z] = q;
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

/// A matrix as translation + rotation * stretch; a mirroring is in the stretch.
struct Pose {
    std::array<double, 3> translation{};
    Quaternion rotation{};
    Matrix3 stretch{};

    explicit Pose(const std::array<double, 16>& m) {
        Matrix3 linear{};
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c)
                linear[r][c] = m[4 * r + c];
            translation[r] = m[4 * r + 3];
        }
        Matrix3 turn = orthogonal_part(linear);
        const Matrix3 other = transposed_inverse(turn);  // the same; of determinant -1 where it mirrors
        const double determinant = turn[0][0] * (turn[1][1] * turn[2][2] - turn[1][2] * turn[2][1]) -
                                   turn[0][1] * (turn[1][0] * turn[2][2] - turn[1][2] * turn[2][0]) +
                                   turn[0][2] * (turn[1][0] * turn[2][1] - turn[1][1] * turn[2][0]);
        for (auto& row : turn) {
            for (double& v : row)
                v = determinant < 0 ? -v : v;
        }
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t k = 0; k < 3; ++k)
                    stretch[r][c] += (determinant < 0 ? -other[k][r] : other[k][r]) * linear[k][c];
            }
        }
        rotation = quaternion_of(turn);
    }
};

double cosine(const Quaternion& a, const Quaternion& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}
/// Angle between two rotations, rad.
double turn_between(const Quaternion& a, const Quaternion& b) {
    return 2 * std::acos(std::min(1.0, std::fabs(cosine(a, b))));
}

Quaternion slerp(const Quaternion& a, Quaternion b, double t) {
    double c = cosine(a, b);
    if (c < 0) {  // the shorter way round
        c = -c;
        for (double& v : b)
            v = -v;
    }
    const double angle = std::acos(std::min(1.0, c)), s = std::sin(angle);
    const double wa = s > 1e-9 ? std::sin((1 - t) * angle) / s : 1 - t,
                 wb = s > 1e-9 ? std::sin(t * angle) / s : t;
    Quaternion q;
    for (std::size_t i = 0; i < 4; ++i)
        q[i] = wa * a[i] + wb * b[i];
    return q;
}

Transform between(const Pose& a, const Pose& b, double t) {
    const Matrix3 turn = matrix_of(slerp(a.rotation, b.rotation, t));
    double m[16] = {};
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t k = 0; k < 3; ++k)
                m[4 * r + c] += turn[r][k] * ((1 - t) * a.stretch[k][c] + t * b.stretch[k][c]);
        }
        m[4 * r + 3] = (1 - t) * a.translation[r] + t * b.translation[r];
    }
    return transform_of(m);
}

Transform given(const std::array<double, 16>& matrix) {
    double m[16];
    std::copy(matrix.begin(), matrix.end(), m);
    return transform_of(m);
}

}  // namespace

Motion::Motion(std::span<const std::array<double, 16>> matrices) {
    if (matrices.size() < 2 || matrices.size() > kMaxMotionSteps) {
        throw std::invalid_argument("its motion has " + std::to_string(matrices.size()) + " steps; 2 to " +
                                    std::to_string(kMaxMotionSteps) + " are possible");
    }
    std::vector<Pose> poses;
    for (const auto& m : matrices)
        poses.emplace_back(m);
    double turn = 0;
    for (std::size_t i = 1; i < poses.size(); ++i)
        turn = std::max(turn, turn_between(poses[i - 1].rotation, poses[i].rotation));
    const std::size_t intervals = poses.size() - 1, most = (kMaxMotionSteps - 1) / intervals;
    const auto parts =
        std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(turn / kLargestTurn)), 1, most);
    for (std::size_t i = 0; i < intervals; ++i) {
        steps_.push_back(given(matrices[i]));
        for (std::size_t k = 1; k < parts; ++k) {
            const double t = static_cast<double>(k) / static_cast<double>(parts);
            steps_.push_back(between(poses[i], poses[i + 1], t));
        }
    }
    steps_.push_back(given(matrices.back()));
}

Transform Motion::at(float time) const {
    const MotionPlace place(time, steps_.size());
    const Transform &a = steps_[place.step], &b = steps_[place.step + 1];
    Transform out;
    for (std::size_t r = 0; r < 3; ++r)
        out.row[r] = lerp(a.row[r], b.row[r], place.fraction);
    out.translation = lerp(a.translation, b.translation, place.fraction);
    return out;
}

}  // namespace nephele
