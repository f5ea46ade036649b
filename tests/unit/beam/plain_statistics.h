// SPDX-License-Identifier: GPL-3.0-or-later
//
// Generated beams, and the definitions of their statistics one number after another in long double, for
// tests. Values.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "storage/beam/beam_statistics.h"

namespace mote::test {

using storage::BeamRows;
using Real = long double;
inline constexpr double mass = 938.27208816e6;
inline constexpr double notNumber = std::numeric_limits<double>::quiet_NaN();

struct Particles {
    std::array<std::vector<double>, BeamRows::coordinates> coordinate;  ///< x y z t px py pz
    std::vector<double> weight;

    std::size_t size() const { return weight.size(); }
};

/// Correlated, skewed, far from the origin; some rows are no numbers where `broken`.
inline Particles generate(std::size_t size, std::uint32_t seed, bool broken) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Particles particles;
    for (auto& c : particles.coordinate) c.resize(size);
    particles.weight.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
        const double a = normal(random), b = normal(random), c = normal(random), d = normal(random),
                     e = normal(random), f = normal(random);
        auto& [x, y, z, t, px, py, pz] = particles.coordinate;
        x[i] = 1e-3 + 2e-3 * a + 1e-4 * a * a;
        px[i] = 3e5 * (b + 0.6 * a) - 1e4 * a * b;
        y[i] = -5e-3 + 1e-3 * c;
        py[i] = 2e5 * d - 3e5 * c;
        z[i] = 12.5 + 1e-2 * e;
        pz[i] = 1e9 * (1.0 + 1e-3 * f + 5e-4 * e);
        t[i] = 1e-9 * e + 4e-8;
        particles.weight[i] = seed % 3 == 0 ? 1.0 : seed % 3 == 1 ? std::exp(2.0 * normal(random)) : 3e-17;
        if (seed % 4 == 0 && i % 7 == 0) particles.weight[i] = 0.0;
        if (broken && i % 11 == 3) particles.coordinate[i % 7][i] = notNumber;
        if (broken && i % 13 == 5) particles.weight[i] = i % 2 == 0 ? -1.0 : notNumber;
        if (broken && i % 17 == 5) pz[i] = 0.0;
    }
    return particles;
}

/// The definitions, one number after another.
class Plain {
  public:
    explicit Plain(const Particles& particles) {
        for (std::size_t i = 0; i < particles.size(); ++i) {
            bool finite = std::isfinite(particles.weight[i]) && particles.weight[i] >= 0.0;
            for (const auto& c : particles.coordinate) finite = finite && std::isfinite(c[i]);
            if (!finite) continue;
            const auto at = [&](std::size_t c) { return static_cast<Real>(particles.coordinate[c][i]); };
            constexpr std::array<const char*, 7> names{"x", "y", "z", "t", "px", "py", "pz"};
            for (std::size_t c = 0; c < names.size(); ++c) column[names[c]].push_back(at(c));
            const Real p = std::sqrt(at(4) * at(4) + at(5) * at(5) + at(6) * at(6));
            const Real m = mass;
            column["p"].push_back(p);
            column["energy"].push_back(std::sqrt(p * p + m * m) - m);
            column["gamma"].push_back(std::sqrt(p * p + m * m) / m);
            column["xp"].push_back(at(4) / at(6));
            column["yp"].push_back(at(5) / at(6));
            weight.push_back(particles.weight[i]);
        }
        column["delta"] = column["p"];
        const Real mean = average("p");
        for (auto& d : column["delta"]) d = d / mean - 1;
    }

    Real average(const std::string& name) {
        Real sum = 0, all = 0;
        for (std::size_t i = 0; i < weight.size(); ++i) {
            sum += weight[i] * column[name][i];
            all += weight[i];
        }
        return sum / all;
    }
    Real moment(const std::string& a, int i, const std::string& b, int j) {
        const Real meanA = average(a), meanB = average(b);
        Real sum = 0, all = 0;
        for (std::size_t k = 0; k < weight.size(); ++k) {
            Real product = weight[k];
            for (int n = 0; n < i; ++n) product *= column[a][k] - meanA;
            for (int n = 0; n < j; ++n) product *= column[b][k] - meanB;
            sum += product;
            all += weight[k];
        }
        return sum / all;
    }
    Real variance(const std::string& a) { return moment(a, 2, a, 0); }
    Real emittance(const std::string& a, const std::string& b) {
        const Real ab = moment(a, 1, b, 1);
        return std::sqrt(variance(a) * variance(b) - ab * ab);
    }
    /// Of those with the smallest action that hold the share.
    Real inside(const std::string& a, const std::string& b, double percent) {
        const Real qq = variance(a), qp = moment(a, 1, b, 1), pp = variance(b);
        const Real meanA = average(a), meanB = average(b);
        std::vector<std::pair<Real, std::size_t>> order;
        const double greatest = static_cast<double>(*std::ranges::max_element(weight));
        Real all = 0;
        const auto share = [&](std::size_t i) {
            return std::floor(static_cast<double>(weight[i]) * (2147483648.0 / greatest) + 0.5);
        };
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const Real q = column[a][i] - meanA, p = column[b][i] - meanB;
            order.emplace_back(pp * q * q - 2 * qp * q * p + qq * p * p, i);
            all += share(i);
        }
        std::ranges::sort(order);
        Real held = 0, total = 0, sumQq = 0, sumQp = 0, sumPp = 0;
        for (const auto& [action, i] : order) {
            if (held * 100 >= all * percent) break;
            const Real q = column[a][i] - meanA, p = column[b][i] - meanB;
            held += share(i);
            total += weight[i];
            sumQq += weight[i] * q * q;
            sumQp += weight[i] * q * p;
            sumPp += weight[i] * p * p;
        }
        return std::sqrt(sumQq * sumPp - sumQp * sumQp) / total;
    }

    std::map<std::string, std::vector<Real>> column;
    std::vector<Real> weight;
};

}  // namespace mote::test
