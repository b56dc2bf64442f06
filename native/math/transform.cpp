// SPDX-License-Identifier: GPL-3.0-or-later
#include "math/transform.h"

#include <stdexcept>

namespace nephele {

Transform transform_of(const double (&m)[16]) {
    Transform t;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            t.row[static_cast<size_t>(r)][c] = static_cast<float>(m[4 * r + c]);
        t.translation[r] = static_cast<float>(m[4 * r + 3]);
    }
    return t;
}

Transform inverse_of(const double (&m)[16]) {
    double cofactor[9];
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            cofactor[3 * c + r] = m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1];
        }
    }
    const double det = m[0] * cofactor[0] + m[1] * cofactor[3] + m[2] * cofactor[6];
    const bool placed = std::isfinite(m[3]) && std::isfinite(m[7]) && std::isfinite(m[11]);
    if (!placed || !(std::fabs(det) > 0) || !std::isfinite(det) || !std::isfinite(1 / det)) {
        throw std::invalid_argument(
            "its transform is singular (a scale of zero or a value that is not finite); mend its location, "
            "rotation and scale, or hide it");
    }
    double inverse[16] = {};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            inverse[4 * r + c] = cofactor[3 * r + c] / det;
        for (int c = 0; c < 3; ++c)
            inverse[4 * r + 3] -= inverse[4 * r + c] * m[4 * c + 3];
    }
    return transform_of(inverse);
}

Transform inverse_of(const Transform& t) {
    // Columns of the inverse: cross products of the rows, over the determinant.
    const Vec3f x = cross(t.row[1], t.row[2]), y = cross(t.row[2], t.row[0]), z = cross(t.row[0], t.row[1]);
    const float scale = 1 / dot(t.row[0], x);
    Transform inverse;
    for (int r = 0; r < 3; ++r)
        inverse.row[static_cast<std::size_t>(r)] = Vec3f(x[r], y[r], z[r]) * scale;
    inverse.translation = -inverse.vector(t.translation);
    return inverse;
}

void multiply(const double (&a)[16], const double (&b)[16], double (&out)[16]) {
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            out[4 * r + c] = 0;
            for (int k = 0; k < 4; ++k)
                out[4 * r + c] += a[4 * r + k] * b[4 * k + c];
        }
    }
}

}  // namespace nephele
