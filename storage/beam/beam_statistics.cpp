// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/beam_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/base/mote_check.h"
#include "storage/beam/moment_sums.h"

namespace mote::storage {
namespace {

using Sums = BeamMoments::Sums;

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
constexpr double elementaryCharge = 1.602176634e-19;  // C, exact
constexpr std::array<char, 3> planeNames{'x', 'y', 'z'};

/// With a mean, a spread and extremes.
constexpr std::array<std::string_view, 13> spreads{"x",      "y",     "z", "t",  "px", "py",   "pz",
                                                   "energy", "gamma", "p", "xp", "yp", "delta"};
/// Of covariances, in the order of system a.
constexpr std::array<std::string_view, 8> paired{"x", "px", "y", "py", "z", "pz", "t", "energy"};

enum InA : std::size_t { xA, pxA, yA, pyA, zA, pzA, tA, energyA, pA };
enum InB : std::size_t { xB, xpB, yB, ypB, pB };

/// a d - b c, nearly as if rounded once.
double determinant(double a, double b, double c, double d) {
    const double product = b * c;
    return std::fma(a, d, -product) + std::fma(-b, c, product);
}

/// Values in the order of statistics().
class Walk {
  public:
    void give(const std::string& name, double value) {
        MOTE_CHECK(name == statistics()[all.size()].name);
        all.push_back(std::isfinite(value) ? value : undefined);
    }
    std::vector<double> all;
};

/// Mean, spread and extremes.
struct Summary {
    double mean = undefined, sigma = undefined, least = undefined, greatest = undefined;

    Summary scaled(double factor, double offset) const {
        return {mean * factor + offset, sigma * factor, least * factor + offset, greatest * factor + offset};
    }
    Summary relativeTo(double value) const {
        return {(mean - value) / value, sigma / value, (least - value) / value, (greatest - value) / value};
    }
};

/// What the sums say, if it is defined; not a number if not.
class Beam {
  public:
    Beam(const Sums& sums, const BeamFacts& facts) : sums_(sums), facts_(facts) {}

    double covariance(std::size_t i, std::size_t j) const {
        if (!knows(i) || !knows(j)) return undefined;
        return sums_.a.sum[moments::pairIndex<BeamMoments::sizeA>(i, j)] / sums_.a.weight;
    }
    double slopeCovariance(std::size_t i, std::size_t j) const {
        const bool known = (i != xB || knows(xA)) && (j != xB || knows(xA)) && (i != yB || knows(yA)) &&
                           (j != yB || knows(yA)) && knows(pA);
        return known ? sums_.b.sum[moments::pairIndex<BeamMoments::sizeB>(i, j)] / sums_.b.weight : undefined;
    }
    Summary summary(std::string_view name) const {
        if (name == "gamma") return ofA(energyA).scaled(1.0 / facts_.mass, 1.0);
        if (name == "delta") return ofA(pA).relativeTo(reference());
        if (name == "xp") return knows(pA) ? of(sums_.b, xpB) : Summary();
        if (name == "yp") return knows(pA) ? of(sums_.b, ypB) : Summary();
        if (name == "p") return ofA(pA);
        const auto* const found = std::ranges::find(paired, name);
        return ofA(static_cast<std::size_t>(found - paired.begin()));
    }
    double meanMomentum() const { return ofA(pA).mean; }
    /// The moment of order i, j of a plane, i + j = 4.
    double fourth(std::size_t plane, std::size_t j) const {
        return knows(2 * plane) && (j == 0 || knows(2 * plane + 1))
                   ? sums_.planes[plane].fourth[j] / sums_.a.weight
                   : undefined;
    }
    const Sums& sums() const { return sums_; }
    const BeamFacts& facts() const { return facts_; }

  private:
    double reference() const { return facts_.meanMomentum > 0.0 ? facts_.meanMomentum : meanMomentum(); }
    bool has(std::size_t coordinate) const { return ((sums_.known >> coordinate) & 1U) != 0; }
    bool knows(std::size_t i) const {
        constexpr std::array<std::size_t, 7> coordinate{0, 4, 1, 5, 2, 6, 3};
        if (i < coordinate.size()) return has(coordinate[i]);
        return has(4) && has(5) && has(6) && (i == pA || facts_.mass > 0.0);
    }
    template <std::size_t N>
    static Summary of(const BeamMoments::Second<N>& from, std::size_t i) {
        if (from.count == 0) return {};
        Summary out{undefined, undefined, from.least[i], from.greatest[i]};
        if (!(from.weight > 0.0)) return out;
        out.mean = from.mean[i];
        out.sigma = std::sqrt(std::max(from.sum[moments::pairIndex<N>(i, i)], 0.0) / from.weight);
        return out;
    }
    Summary ofA(std::size_t i) const { return knows(i) ? of(sums_.a, i) : Summary(); }

    const Sums& sums_;
    const BeamFacts& facts_;
};

double charge(const Beam& beam) {
    const auto& unit = beam.facts().weightUnit;
    const double weight = beam.sums().a.weight;
    const double own = std::abs(beam.facts().particleCharge);
    if (unit == "1" && beam.facts().neutral) return std::isfinite(weight) ? 0.0 : undefined;
    return unit == "1" ? weight * (own > 0.0 ? own : elementaryCharge) : unit == "C" ? weight : undefined;
}

double area(double qq, double qp, double pp) {
    const double det = determinant(qq, qp, qp, pp);
    return std::sqrt(std::max(det, 0.0));
}

/// Of the covariance matrix of x px y py, by elimination of one row after another.
double determinantOf4(const Beam& beam) {
    double m[4][4];
    double product = 1.0;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) m[i][j] = beam.covariance(std::min(i, j), std::max(i, j));
    }
    for (std::size_t i = 0; i < 4; ++i) {
        product *= m[i][i];
        if (m[i][i] <= 0.0) return 0.0;
        for (std::size_t j = i + 1; j < 4; ++j) {
            const double factor = m[j][i] / m[i][i];
            for (std::size_t k = i; k < 4; ++k) m[j][k] -= factor * m[i][k];
        }
    }
    return product;
}

void giveTwiss(Walk& walk, const std::string& ending, double qq, double qp, double pp) {
    const double emittance = area(qq, qp, pp);
    walk.give("twiss_alpha_" + ending, -qp / emittance);
    walk.give("twiss_beta_" + ending, qq / emittance);
    walk.give("twiss_gamma_" + ending, pp / emittance);
}

/// In x or y: with slopes; and with what goes with delta taken out.
void giveTransverse(Walk& walk, const Beam& beam, std::size_t plane) {
    const char name = planeNames[plane];
    const std::size_t q = 2 * plane, s = q + 1;
    const double qq = beam.slopeCovariance(q, q), qs = beam.slopeCovariance(q, s),
                 ss = beam.slopeCovariance(s, s);
    const double qd = beam.slopeCovariance(q, pB), sd = beam.slopeCovariance(s, pB),
                 dd = beam.slopeCovariance(pB, pB);
    const auto ending = fmt::format("{}_no_dispersion", name);
    const double freeQq = qq - qd * (qd / dd), freeQs = qs - qd * (sd / dd), freeSs = ss - sd * (sd / dd);
    const double reference = beam.meanMomentum();
    walk.give(fmt::format("emit_{}", name), area(qq, qs, ss));
    giveTwiss(walk, std::string(1, name), qq, qs, ss);
    walk.give(fmt::format("twiss_eta_{}", name), qd / dd * reference);
    walk.give(fmt::format("twiss_etap_{}", name), sd / dd * reference);
    walk.give("emit_" + ending, area(freeQq, freeQs, freeSs));
    giveTwiss(walk, ending, freeQq, freeQs, freeSs);
}

/// In z: with delta.
void giveLongitudinal(Walk& walk, const Beam& beam) {
    const double reference = beam.meanMomentum();
    const double qq = beam.covariance(zA, zA), qd = beam.covariance(zA, pA) / reference,
                 dd = beam.covariance(pA, pA) / reference / reference;
    walk.give("emit_z", area(qq, qd, dd));
    giveTwiss(walk, "z", qq, qd, dd);
}

void giveEmittances(Walk& walk, const Beam& beam, const BeamPercentiles& percentiles) {
    const double mass = beam.facts().mass > 0.0 ? beam.facts().mass : undefined;
    for (std::size_t plane = 0; plane < planeNames.size(); ++plane) {
        const std::size_t q = 2 * plane, p = q + 1;
        walk.give(fmt::format("norm_emit_{}", planeNames[plane]),
                  area(beam.covariance(q, q), beam.covariance(q, p), beam.covariance(p, p)) / mass);
    }
    walk.give("norm_emit_4d", std::sqrt(std::max(determinantOf4(beam), 0.0)) / mass / mass);
    for (std::size_t plane = 0; plane < planeNames.size(); ++plane) {
        for (std::size_t i = 0; i < BeamPercentiles::percents.size(); ++i) {
            walk.give(fmt::format("emit{}_action_{}", BeamPercentiles::percents[i], planeNames[plane]),
                      percentiles.emittances()[plane * BeamPercentiles::percents.size() + i] / mass);
        }
    }
}

/// Allen and Wangler 2002 (doi 10.1103/PhysRevSTAB.5.124202).
void giveHalo(Walk& walk, const Beam& beam, std::size_t plane) {
    const std::size_t q = 2 * plane, p = q + 1;
    const double qq = beam.covariance(q, q), qp = beam.covariance(q, p), pp = beam.covariance(p, p);
    const double q4 = beam.fourth(plane, 0), q3p = beam.fourth(plane, 1), q2p2 = beam.fourth(plane, 2),
                 qp3 = beam.fourth(plane, 3), p4 = beam.fourth(plane, 4);
    const double second = determinant(qq, qp, qp, pp);
    const double fourth = q4 * p4 + 3.0 * q2p2 * q2p2 - 4.0 * qp3 * q3p;
    walk.give(fmt::format("halo_h_{}", planeNames[plane]), q4 / (qq * qq) - 2.0);
    walk.give(fmt::format("halo_H_{}", planeNames[plane]), std::sqrt(3.0 * fourth) / (2.0 * second) - 2.0);
}

void walkAll(Walk& walk, const Beam& beam, const BeamPercentiles& percentiles) {
    const auto& sums = beam.sums();
    walk.give("n_particle", static_cast<double>(sums.particles));
    walk.give("n_finite", static_cast<double>(sums.a.count));
    walk.give("n_slope", static_cast<double>(sums.b.count));
    walk.give("n_lost", static_cast<double>(beam.facts().lost));
    walk.give("charge", charge(beam));
    for (const auto name : spreads) {
        const auto summary = beam.summary(name);
        walk.give(fmt::format("mean_{}", name), summary.mean);
        walk.give(fmt::format("sigma_{}", name), summary.sigma);
        walk.give(fmt::format("min_{}", name), summary.least);
        walk.give(fmt::format("max_{}", name), summary.greatest);
    }
    for (std::size_t i = 0; i < paired.size(); ++i) {
        for (std::size_t j = i + 1; j < paired.size(); ++j) {
            walk.give(fmt::format("cov_{}__{}", paired[i], paired[j]), beam.covariance(i, j));
        }
    }
    giveEmittances(walk, beam, percentiles);
    giveTransverse(walk, beam, 0);
    giveTransverse(walk, beam, 1);
    giveLongitudinal(walk, beam);
    for (std::size_t plane = 0; plane < planeNames.size(); ++plane) giveHalo(walk, beam, plane);
}

}  // namespace

std::vector<double> beamValues(const Sums& total, const BeamPercentiles& percentiles,
                               const BeamFacts& facts) {
    Walk walk;
    walkAll(walk, Beam(total, facts), percentiles);
    return std::move(walk.all);
}

}  // namespace mote::storage
