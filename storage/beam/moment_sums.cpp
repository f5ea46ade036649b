// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/moment_sums.h"

namespace mote::storage::moments {
namespace {

constexpr std::size_t order = 4;
constexpr std::array<std::array<double, order + 1>, order + 1> binomial{
    {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}}};

/// Where the momentum of a plane's coordinate lies among the variables of system a.
constexpr std::size_t coordinateOf(std::size_t plane) {
    return 2 * plane;
}

void add(Plane& to, const Plane& from) {
    for (std::size_t i = 0; i < to.third.size(); ++i) to.third[i] += from.third[i];
    for (std::size_t i = 0; i < to.fourth.size(); ++i) to.fourth[i] += from.fourth[i];
}

}  // namespace

Plane shifted(const Plane& plane, const Lower& lower, double dq, double dp) {
    const double moment[order + 1][order + 1] = {
        {lower.weight, lower.p, lower.pp, plane.third[3], plane.fourth[4]},
        {lower.q, lower.qp, plane.third[2], plane.fourth[3]},
        {lower.qq, plane.third[1], plane.fourth[2]},
        {plane.third[0], plane.fourth[1]},
        {plane.fourth[0]},
    };
    std::array<double, order + 1> powerQ{1.0}, powerP{1.0};
    for (std::size_t i = 1; i <= order; ++i) {
        powerQ[i] = powerQ[i - 1] * dq;
        powerP[i] = powerP[i - 1] * dp;
    }
    const auto about = [&](std::size_t i, std::size_t j) {
        double sum = 0.0;
        for (std::size_t k = 0; k <= i; ++k) {
            for (std::size_t l = 0; l <= j; ++l) {
                sum += binomial[i][k] * binomial[j][l] * powerQ[i - k] * powerP[j - l] * moment[k][l];
            }
        }
        return sum;
    };
    Plane out;
    for (std::size_t j = 0; j < out.third.size(); ++j) out.third[j] = about(order - 1 - j, j);
    for (std::size_t j = 0; j < out.fourth.size(); ++j) out.fourth[j] = about(order - j, j);
    return out;
}

void join(BeamMoments::Sums& to, const BeamMoments::Sums& from) {
    to.known = to.particles == 0 ? from.known : from.particles == 0 ? to.known : (to.known & from.known);
    to.particles += from.particles;
    to.oneWeight = to.oneWeight && from.oneWeight &&
                   (to.a.count == 0 || from.a.count == 0 || to.greatestWeight == from.greatestWeight);
    to.greatestWeight = std::max(to.greatestWeight, from.greatestWeight);
    join(to.b, from.b);
    if (from.a.weight > 0.0 && to.a.weight > 0.0) {
        const double weight = to.a.weight + from.a.weight;
        for (std::size_t plane = 0; plane < to.planes.size(); ++plane) {
            const auto q = coordinateOf(plane);
            const double apartQ = from.a.mean[q] - to.a.mean[q];
            const double apartP = from.a.mean[q + 1] - to.a.mean[q + 1];
            const double back = -from.a.weight / weight, forth = to.a.weight / weight;
            auto& mine = to.planes[plane];
            mine = shifted(mine, lowerOf(to.a, q, q + 1), back * apartQ, back * apartP);
            add(mine, shifted(from.planes[plane], lowerOf(from.a, q, q + 1), forth * apartQ, forth * apartP));
        }
    } else if (from.a.weight > 0.0) {
        to.planes = from.planes;
    }
    join(to.a, from.a);
}

}  // namespace mote::storage::moments
