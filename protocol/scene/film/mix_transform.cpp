// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/mix_transform.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "protocol/scene/film/rotation.h"
#include "protocol/scene/mix.h"

namespace mote {
namespace {

struct Polar {
    glm::dmat3 rotation;  ///< without the mirror
    glm::dmat3 stretch;   ///< symmetric, positive
    bool mirrored;
};

double largest(const glm::dmat3& matrix) {
    double most = 0.0;
    for (int i = 0; i < 9; ++i) most = std::max(most, std::abs(matrix[i / 3][i % 3]));
    return most;
}

/// The nearest rotation by Newton's iteration (N. Higham, Computing the polar decomposition, 1986), each step
/// scaled so that it is none of volume.
glm::dmat3 nearestRotation(glm::dmat3 matrix) {
    for (int i = 0; i < 100; ++i) {
        const double scale = std::cbrt(1.0 / glm::determinant(matrix));
        const glm::dmat3 even = scale * matrix;
        const glm::dmat3 next = 0.5 * (even + glm::inverse(glm::transpose(even)));
        const double change = largest(next - matrix);
        matrix = next;
        if (change < 1e-15) break;
    }
    return matrix;
}

Polar polarOf(const glm::dmat4& transform) {
    const glm::dmat3 matrix(transform);
    const bool mirrored = glm::determinant(matrix) < 0.0;
    const glm::dmat3 proper = mirrored ? -matrix : matrix;
    const glm::dmat3 rotation = nearestRotation(proper);
    const glm::dmat3 stretch = glm::transpose(rotation) * proper;
    return {rotation, 0.5 * (stretch + glm::transpose(stretch)), mirrored};
}

double trace(const glm::dmat3& matrix) {
    return matrix[0][0] + matrix[1][1] + matrix[2][2];
}

/// Whether it says again what it was taken from, which the digits of a very uneven stretch do not.
bool holds(const Polar& polar, const glm::dmat4& transform) {
    const glm::dmat3 matrix(transform);
    const glm::dmat3 again = (polar.mirrored ? -1.0 : 1.0) * (polar.rotation * polar.stretch);
    return largest(again - matrix) <= 1e-9 * largest(matrix) &&
           largest(glm::transpose(polar.rotation) * polar.rotation - glm::dmat3(1.0)) < 1e-9;
}

}  // namespace

bool canMixTransforms(const glm::dmat4& from, const glm::dmat4& to) {
    if (from == to) return true;
    const Polar a = polarOf(from), b = polarOf(to);
    // A volume between them is at most that of a cube of the mean stretch; a layer's is at most 1e18.
    constexpr double mostTrace = 3.0 * 0.9e6;
    return a.mirrored == b.mirrored && holds(a, from) && holds(b, to) && trace(a.stretch) < mostTrace &&
           trace(b.stretch) < mostTrace;
}

glm::dmat4 mixTransforms(const glm::dmat4& from, const glm::dmat4& to, double share) {
    if (from == to || share <= 0.0) return from;
    if (share >= 1.0) return to;
    const Polar a = polarOf(from), b = polarOf(to);
    const auto begin = glm::normalize(glm::quat_cast(a.rotation));
    const auto end = nearerTo(begin, glm::normalize(glm::quat_cast(b.rotation)));
    const glm::dmat3 rotation = glm::mat3_cast(mixRotations(begin, end, share));
    const glm::dmat3 stretch = (1.0 - share) * a.stretch + share * b.stretch;
    const double sign = a.mirrored ? -1.0 : 1.0;
    glm::dmat4 result(sign * (rotation * stretch));
    result[3] = glm::dvec4(mix(glm::dvec3(from[3]), glm::dvec3(to[3]), share), 1.0);
    return result;
}

}  // namespace mote
