// SPDX-License-Identifier: GPL-3.0-or-later
//
// Statistics of generated beams against plain sums in long double, and what they must do at the extremes.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "storage/beam/beam_rims.h"
#include "storage/beam/beam_statistics.h"

namespace mote::test {

// Generated beams, and the definitions of their statistics one number after another in long double, for
// tests. Values.

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

namespace mote::storage {
namespace {

using namespace test;

BeamRows rowsOf(const Particles& particles, std::uint64_t block, std::size_t begin, std::size_t count) {
    BeamRows rows;
    for (std::size_t c = 0; c < rows.coordinate.size(); ++c) {
        if (particles.coordinate[c].empty()) continue;
        rows.coordinate[c] = std::span(particles.coordinate[c]).subspan(begin, count);
    }
    rows.weight = std::span(particles.weight).subspan(begin, count);
    rows.block = block;
    rows.size = count;
    return rows;
}

/// In blocks of so many, by so many threads, which take blocks in an order of their own.
std::vector<double> statisticsOf(const Particles& particles, std::size_t block, std::size_t threads,
                                 const BeamFacts& facts) {
    const std::size_t blocks = (particles.size() + block - 1) / block;
    const auto rows = [&](std::size_t i) {
        return rowsOf(particles, i, i * block, std::min(block, particles.size() - i * block));
    };
    BeamMoments moments(facts.mass);
    for (std::size_t thread = threads; thread-- > 0;) {
        BeamMoments part(facts.mass);
        for (std::size_t i = blocks; i-- > 0;) {
            if (i % threads == thread) part.add(rows(i));
        }
        moments.merge(part.blocks());
    }
    const auto total = moments.total();
    BeamPercentiles percentiles(total);
    while (percentiles.needsPass()) {
        BeamPercentiles::Gathered all;
        for (std::size_t thread = 0; thread < threads; ++thread) {
            BeamPercentiles::Gathered part;
            for (std::size_t i = thread; i < blocks; i += threads) percentiles.add(rows(i), part);
            all.merge(part);
        }
        percentiles.finishPass(std::move(all));
    }
    return beamValues(total, percentiles, facts);
}

double valueOf(const std::vector<double>& values, std::string_view name) {
    const auto at = findStatistic(name);
    EXPECT_TRUE(at) << name;
    return at ? values[*at] : notNumber;
}

void expectClose(double value, Real expected, Real scale, const std::string& name) {
    EXPECT_LE(std::abs(static_cast<Real>(value) - expected), 1e-12L * std::abs(scale))
        << name << " is " << value << ", not " << static_cast<double>(expected);
}

TEST(BeamStatistics, AreThoseOfPlainSums) {
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U, 9U, 12U}) {
        const std::size_t size = 20000 + 777 * seed;
        const auto particles = generate(size, seed, false);
        const auto values = statisticsOf(particles, 1500, 3, {mass, "C", 5, 0.0});
        Plain plain(particles);
        const auto value = [&](const std::string& name) { return valueOf(values, name); };
        EXPECT_EQ(value("n_particle"), static_cast<double>(size));
        EXPECT_EQ(value("n_finite"), static_cast<double>(size));
        EXPECT_EQ(value("n_slope"), static_cast<double>(size));
        EXPECT_EQ(value("n_lost"), 5.0);
        for (const std::string name :
             {"x", "y", "z", "t", "px", "py", "pz", "p", "energy", "gamma", "xp", "yp", "delta"}) {
            const Real sigma = std::sqrt(plain.variance(name)), mean = plain.average(name);
            const auto [least, greatest] = std::ranges::minmax_element(plain.column[name]);
            // Rounding of the coordinates themselves shows in the spread of what lies far from 0.
            const Real fine = sigma + (name == "delta" ? 1e-3L : 1e-3L * std::abs(mean));
            expectClose(value("mean_" + name), mean, std::abs(mean) + sigma, "mean_" + name);
            expectClose(value("sigma_" + name), sigma, fine, "sigma_" + name);
            expectClose(value("min_" + name), *least, std::abs(*least) + fine, "min_" + name);
            expectClose(value("max_" + name), *greatest, std::abs(*greatest) + fine, "max_" + name);
        }
        const std::vector<std::string> pairs{"x", "px", "y", "py", "z", "pz", "t", "energy"};
        for (std::size_t a = 0; a < pairs.size(); ++a) {
            for (std::size_t b = a + 1; b < pairs.size(); ++b) {
                const auto name = "cov_" + pairs[a] + "__" + pairs[b];
                expectClose(value(name), plain.moment(pairs[a], 1, pairs[b], 1),
                            std::sqrt(plain.variance(pairs[a]) * plain.variance(pairs[b])), name);
            }
        }
        for (const std::string plane : {"x", "y", "z"}) {
            const auto momentum = "p" + plane;
            const Real emittance = plain.emittance(plane, momentum) / mass;
            expectClose(value("norm_emit_" + plane), emittance, 10 * emittance, "norm_emit_" + plane);
            for (const int percent : {90, 95, 99}) {
                const auto name = "emit" + std::to_string(percent) + "_action_" + plane;
                const Real inside = plain.inside(plane, momentum, percent) / mass;
                expectClose(value(name), inside, 10 * inside, name);
            }
            const Real qq = plain.variance(plane), q4 = plain.moment(plane, 4, plane, 0);
            expectClose(value("halo_h_" + plane), q4 / (qq * qq) - 2, 3, "halo_h_" + plane);
            const Real second = emittance * mass * emittance * mass;
            const Real q2p2 = plain.moment(plane, 2, momentum, 2);
            const Real fourth = q4 * plain.moment(momentum, 4, momentum, 0) + 3 * q2p2 * q2p2 -
                                4 * plain.moment(plane, 1, momentum, 3) * plain.moment(plane, 3, momentum, 1);
            expectClose(value("halo_H_" + plane), std::sqrt(3 * fourth) / (2 * second) - 2, 30,
                        "halo_H_" + plane);
        }
        for (const std::string plane : {"x", "y", "z"}) {
            const auto slope = plane == "z" ? "delta" : plane + "p";
            const Real e = plain.emittance(plane, slope);
            expectClose(value("emit_" + plane), e, 10 * e, "emit_" + plane);
            expectClose(value("twiss_beta_" + plane), plain.variance(plane) / e,
                        10 * plain.variance(plane) / e, "twiss_beta_" + plane);
            expectClose(value("twiss_gamma_" + plane), plain.variance(slope) / e,
                        10 * plain.variance(slope) / e, "twiss_gamma_" + plane);
            expectClose(value("twiss_alpha_" + plane), -plain.moment(plane, 1, slope, 1) / e, 10,
                        "twiss_alpha_" + plane);
            if (plane == "z") continue;
            const Real dd = plain.variance("delta"), qd = plain.moment(plane, 1, "delta", 1),
                       sd = plain.moment(slope, 1, "delta", 1);
            const Real b = plain.variance(plane) - qd * qd / dd, g = plain.variance(slope) - sd * sd / dd,
                       a = plain.moment(plane, 1, slope, 1) - qd * sd / dd;
            const Real bare = std::sqrt(b * g - a * a);
            expectClose(value("twiss_eta_" + plane), qd / dd, std::sqrt(plain.variance(plane) / dd),
                        "twiss_eta_" + plane);
            expectClose(value("twiss_etap_" + plane), sd / dd, std::sqrt(plain.variance(slope) / dd),
                        "twiss_etap_" + plane);
            expectClose(value("emit_" + plane + "_no_dispersion"), bare, 10 * bare, "bare emittance");
            expectClose(value("twiss_beta_" + plane + "_no_dispersion"), b / bare, 10 * b / bare, "beta");
            expectClose(value("twiss_gamma_" + plane + "_no_dispersion"), g / bare, 10 * g / bare, "gamma");
            expectClose(value("twiss_alpha_" + plane + "_no_dispersion"), -a / bare, 10, "alpha");
        }
        const Real four = plain.emittance("x", "px") * plain.emittance("y", "py");
        EXPECT_LE(value("norm_emit_4d") * mass * mass, static_cast<double>(four) * (1 + 1e-12));
        EXPECT_GE(value("norm_emit_4d") * mass * mass, static_cast<double>(four) * 0.95);
    }
}

TEST(BeamStatistics, AreTheSameBitsForAnyThreads) {
    for (const std::uint32_t seed : {5U, 6U, 7U, 8U}) {
        const auto particles = generate(30000, seed, seed % 2 == 0);
        const auto alone = statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0});
        for (const std::size_t threads : {2U, 3U, 8U}) {
            const auto together = statisticsOf(particles, 4096, threads, {mass, "1", 0, 0.0});
            for (std::size_t i = 0; i < alone.size(); ++i) {
                EXPECT_EQ(std::bit_cast<std::uint64_t>(alone[i]), std::bit_cast<std::uint64_t>(together[i]))
                    << statistics()[i].name;
            }
        }
    }
}

TEST(BeamStatistics, RowsThatAreNoNumbersAreAsIfTheyWereNotThere) {
    const auto broken = generate(5000, 3, true);
    Particles good;
    std::size_t slopes = 0;
    for (std::size_t i = 0; i < broken.size(); ++i) {
        bool finite = std::isfinite(broken.weight[i]) && broken.weight[i] >= 0.0;
        for (const auto& c : broken.coordinate) finite = finite && std::isfinite(c[i]);
        if (!finite) continue;
        for (std::size_t c = 0; c < BeamRows::coordinates; ++c) {
            good.coordinate[c].push_back(broken.coordinate[c][i]);
        }
        good.weight.push_back(broken.weight[i]);
        slopes += broken.coordinate[6][i] != 0.0 ? 1 : 0;
    }
    ASSERT_LT(slopes, good.size());
    const auto values = statisticsOf(broken, 512, 2, {mass, "1", 0, 0.0});
    const auto expected = statisticsOf(good, 512, 2, {mass, "1", 0, 0.0});
    EXPECT_EQ(valueOf(values, "n_particle"), 5000.0);
    EXPECT_EQ(valueOf(values, "n_finite"), static_cast<double>(good.size()));
    EXPECT_EQ(valueOf(values, "n_slope"), static_cast<double>(slopes));
    for (std::size_t i = 1; i < values.size(); ++i) {
        EXPECT_NEAR(values[i], expected[i], 1e-9 * std::abs(expected[i])) << statistics()[i].name;
    }
}

TEST(BeamStatistics, ABlockMayComeInParts) {
    for (const std::uint32_t seed : {6U, 7U}) {
        const auto particles = generate(20000, seed, seed % 2 == 0);
        const auto values = [&](std::size_t threads) {
            BeamMoments moments(mass);
            std::vector<BeamMoments> parts(threads, BeamMoments(mass));
            const auto block = [&](std::size_t i, const auto& use) {
                for (std::size_t begin = i * 5000; begin < (i + 1) * 5000; begin += 1250)
                    use(rowsOf(particles, i, begin, 1250));
            };
            for (std::size_t i = 0; i < 4; ++i)
                block(i, [&](const BeamRows& rows) { parts[i % threads].add(rows); });
            for (const auto& part : parts) moments.merge(part.blocks());
            EXPECT_EQ(moments.blocks().size(), 4U);
            BeamPercentiles percentiles(moments.total());
            while (percentiles.needsPass()) {
                std::vector<BeamPercentiles::Gathered> gathered(threads);
                for (std::size_t i = 0; i < 4; ++i)
                    block(i, [&](const BeamRows& rows) { percentiles.add(rows, gathered[i % threads]); });
                for (std::size_t i = 1; i < threads; ++i) gathered[0].merge(gathered[i]);
                percentiles.finishPass(gathered[0]);
            }
            return beamValues(moments.total(), percentiles, {mass, "1", 0, 0.0});
        };
        const auto alone = values(1), together = values(3);
        const auto whole = statisticsOf(particles, 5000, 1, {mass, "1", 0, 0.0});
        for (std::size_t i = 0; i < alone.size(); ++i) {
            EXPECT_EQ(std::bit_cast<std::uint64_t>(alone[i]), std::bit_cast<std::uint64_t>(together[i]))
                << statistics()[i].name;
            EXPECT_NEAR(alone[i], whole[i], 1e-10 * std::abs(whole[i])) << statistics()[i].name;
        }
    }
}

/// The rows that come first, about which the others are summed at first, lie far from them.
TEST(BeamStatistics, WhatComesFirstMayBeAnything) {
    for (const std::uint32_t seed : {1U, 3U}) {
        auto particles = generate(9000, seed, false);
        for (std::size_t block = 0; block < particles.size(); block += 3000) {
            for (std::size_t i = block; i < block + 200; ++i) {
                particles.weight[i] *= 1e-12;
                for (const std::size_t c : {0U, 2U, 4U}) particles.coordinate[c][i] += 1e6;
            }
        }
        const auto values = statisticsOf(particles, 3000, 2, {mass, "1", 0, 0.0});
        Plain plain(particles);
        for (const std::string name : {"x", "z", "px", "xp", "p"}) {
            const Real sigma = std::sqrt(plain.variance(name)), mean = plain.average(name);
            expectClose(valueOf(values, "mean_" + name), mean, std::abs(mean) + sigma, "mean_" + name);
            expectClose(valueOf(values, "sigma_" + name), sigma, sigma + 1e-3L * std::abs(mean),
                        "sigma_" + name);
        }
        const Real qq = plain.variance("x"), q4 = plain.moment("x", 4, "x", 0);
        expectClose(valueOf(values, "halo_h_x"), q4 / (qq * qq) - 2, q4 / (qq * qq), "halo_h_x");
    }
}

TEST(BeamStatistics, NothingIsSaidOfNothing) {
    const std::set<std::string> counts{"n_particle", "n_finite", "n_slope", "n_lost", "charge"};
    const auto values = statisticsOf(generate(0, 1, false), 100, 1, {mass, "1", 2, 0.0});
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto& name = statistics()[i].name;
        if (counts.contains(name)) {
            EXPECT_EQ(values[i], name == "n_lost" ? 2.0 : 0.0) << name;
        } else {
            EXPECT_TRUE(std::isnan(values[i])) << name;
        }
    }
}

TEST(BeamStatistics, WithoutWeightOnlyExtremesAreKnown) {
    auto particles = generate(3000, 1, false);
    std::ranges::fill(particles.weight, 0.0);
    const auto values = statisticsOf(particles, 700, 2, {mass, "1", 0, 0.0});
    EXPECT_EQ(valueOf(values, "n_particle"), 3000.0);
    EXPECT_EQ(valueOf(values, "charge"), 0.0);
    EXPECT_EQ(valueOf(values, "max_x"), *std::ranges::max_element(particles.coordinate[0]));
    for (const auto* name : {"mean_x", "sigma_x", "norm_emit_x", "emit90_action_x", "halo_h_x",
                             "twiss_beta_x", "cov_x__px", "mean_delta"}) {
        EXPECT_TRUE(std::isnan(valueOf(values, name))) << name;
    }
}

TEST(BeamStatistics, NeutralParticlesHaveNoCharge) {
    BeamFacts facts{mass, "1", 0, 0.0};
    const auto particles = generate(100, 1, false);
    EXPECT_GT(valueOf(statisticsOf(particles, 10, 1, facts), "charge"), 0.0)
        << "not known: an elementary one";
    facts.neutral = true;
    EXPECT_EQ(valueOf(statisticsOf(particles, 10, 1, facts), "charge"), 0.0);
    facts.weightUnit = "C";
    EXPECT_GT(valueOf(statisticsOf(particles, 10, 1, facts), "charge"), 0.0) << "weights that are charges";
}

TEST(BeamStatistics, OneParticleHasAPlaceAndNoSpread) {
    const auto values = statisticsOf(generate(1, 1, false), 10, 1, {mass, "", 0, 0.0});
    const auto particle = generate(1, 1, false);
    EXPECT_EQ(valueOf(values, "mean_x"), particle.coordinate[0][0]);
    EXPECT_EQ(valueOf(values, "sigma_x"), 0.0);
    EXPECT_EQ(valueOf(values, "norm_emit_x"), 0.0);
    EXPECT_TRUE(std::isnan(valueOf(values, "twiss_beta_x")));
    EXPECT_TRUE(std::isnan(valueOf(values, "halo_h_x")));
    EXPECT_TRUE(std::isnan(valueOf(values, "charge")));  // the unit of weights is not known
}

TEST(BeamStatistics, WhatIsNotKnownIsNotSaid) {
    auto particles = generate(2000, 1, false);
    for (const std::size_t c : {3U, 4U, 5U, 6U}) particles.coordinate[c].clear();
    const auto places = statisticsOf(particles, 500, 2, {mass, "1", 0, 0.0});
    EXPECT_GT(valueOf(places, "sigma_z"), 0.0);
    EXPECT_GT(valueOf(places, "cov_x__z"), -1.0);
    for (const auto* name : {"mean_t", "sigma_px", "mean_p", "mean_energy", "norm_emit_x", "emit_x",
                             "cov_x__px", "halo_H_x", "emit90_action_x", "min_xp", "mean_gamma"}) {
        EXPECT_TRUE(std::isnan(valueOf(places, name))) << name;
    }
    const auto massless = statisticsOf(generate(2000, 1, false), 500, 2, {0.0, "1", 0, 0.0});
    EXPECT_GT(valueOf(massless, "emit_x"), 0.0);
    for (const auto* name : {"mean_energy", "norm_emit_x", "norm_emit_4d", "mean_gamma", "emit90_action_x"}) {
        EXPECT_TRUE(std::isnan(valueOf(massless, name))) << name;
    }
}

/// Places and momenta of one plane, the same in all three.
Particles ofPlane(const std::vector<std::pair<double, double>>& points) {
    Particles particles;
    for (const auto& [q, p] : points) {
        // Any linear map leaves both halo parameters as they are.
        const double place = 1e-3 * q, momentum = 1e5 * p + 3e5 * q;
        for (const std::size_t c : {0U, 1U, 2U}) particles.coordinate[c].push_back(place + 0.5);
        for (const std::size_t c : {4U, 5U, 6U}) particles.coordinate[c].push_back(momentum + 1e9);
        particles.weight.push_back(1.0);
    }
    particles.coordinate[3].assign(points.size(), 0.0);
    return particles;
}

TEST(BeamStatistics, AUniformEllipseHasNoHaloAndAGaussianHasOne) {
    constexpr int side = 400;
    std::vector<std::pair<double, double>> ellipse, gaussian;
    for (int i = -side; i <= side; ++i) {
        for (int j = -side; j <= side; ++j) {
            const double q = static_cast<double>(i) / side, p = static_cast<double>(j) / side;
            if (q * q + p * p <= 1.0) ellipse.emplace_back(q, p);
        }
    }
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 400000; ++i) gaussian.emplace_back(normal(random), normal(random));
    const auto uniform = statisticsOf(ofPlane(ellipse), 65536, 2, {mass, "1", 0, 0.0});
    const auto normals = statisticsOf(ofPlane(gaussian), 65536, 2, {mass, "1", 0, 0.0});
    for (const std::string plane : {"x", "y", "z"}) {
        EXPECT_NEAR(valueOf(uniform, "halo_h_" + plane), 0.0, 1e-3);
        EXPECT_NEAR(valueOf(uniform, "halo_H_" + plane), 0.0, 1e-3);
        EXPECT_NEAR(valueOf(normals, "halo_h_" + plane), 1.0, 0.03);
        EXPECT_NEAR(valueOf(normals, "halo_H_" + plane), 1.0, 0.03);
        // The rms emittance of a uniform ellipse's inner part is that part of the whole.
        EXPECT_NEAR(valueOf(uniform, "emit90_action_" + plane) / valueOf(uniform, "norm_emit_" + plane), 0.9,
                    1e-3);
    }
}

/// So many particles of one action that a sort of all would be none: a ring, and one far away.
TEST(BeamStatistics, PercentilesOfEqualActionsHoldAllOfThem) {
    std::vector<std::pair<double, double>> ring;
    for (int i = 0; i < 1000000; ++i) {
        constexpr std::array<std::pair<double, double>, 4> corners{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
        ring.push_back(corners[static_cast<std::size_t>(i % 4)]);
    }
    auto particles = ofPlane(ring);
    for (std::size_t i = 0; i < ring.size(); ++i) {
        particles.coordinate[0][i] = ring[i].first;
        particles.coordinate[4][i] = 1e9 * ring[i].second;
    }
    const auto values = statisticsOf(particles, 65536, 2, {mass, "1", 0, 0.0});
    EXPECT_NEAR(valueOf(values, "emit90_action_x"), valueOf(values, "norm_emit_x"), 1e-12);
    EXPECT_NEAR(valueOf(values, "norm_emit_x"), 0.5 * 1e9 / mass, 1e-12);
}

/// Of one in so many blocks.
BeamSample sampleOf(const Particles& particles, std::size_t block, std::size_t stride) {
    BeamSample sample;
    const auto rows = BeamSample::strideOf(particles.size());
    for (std::size_t i = 0; i < particles.size(); i += rows)
        if (i / block % stride == 0) sample.add(rowsOf(particles, 0, i, 1));
    return sample;
}

/// Of one thread, by a sample of one in so many blocks; how many passes that takes is told.
std::vector<double> sampledStatistics(const Particles& particles, std::size_t block, std::size_t stride,
                                      int& passes) {
    BeamMoments moments(mass);
    const std::size_t blocks = (particles.size() + block - 1) / block;
    const auto rows = [&](std::size_t i) {
        return rowsOf(particles, i, i * block, std::min(block, particles.size() - i * block));
    };
    for (std::size_t i = 0; i < blocks; ++i) moments.add(rows(i));
    const auto sample = sampleOf(particles, block, stride);
    BeamPercentiles percentiles(moments.total(), std::span(&sample, 1));
    for (passes = 0; percentiles.needsPass(); ++passes) {
        BeamPercentiles::Gathered gathered;
        for (std::size_t i = 0; i < blocks; ++i) percentiles.add(rows(i), gathered);
        percentiles.finishPass(std::move(gathered));
    }
    return beamValues(moments.total(), percentiles, {mass, "1", 0, 0.0});
}

void expectSamePercentiles(const std::vector<double>& values, const std::vector<double>& expected) {
    for (const std::string plane : {"x", "y", "z"}) {
        for (const std::string percent : {"90", "95", "99"}) {
            const auto name = "emit" + percent + "_action_" + plane;
            const double wanted = valueOf(expected, name);
            if (std::isnan(wanted)) {
                EXPECT_TRUE(std::isnan(valueOf(values, name))) << name;
            } else {
                expectClose(valueOf(values, name), wanted, wanted, name);
            }
        }
    }
}

Particles manyNormals(std::size_t count) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    std::vector<std::pair<double, double>> plane;
    for (std::size_t i = 0; i < count; ++i) plane.emplace_back(normal(random), normal(random));
    auto particles = ofPlane(plane);
    std::uniform_real_distribution<double> weights(0.5, 1.5);
    for (auto& weight : particles.weight) weight = weights(random);
    return particles;
}

TEST(BeamStatistics, PercentilesByASampleTakeOnePassAndAreTheSame) {
    const auto particles = manyNormals(200000);
    const auto expected = statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0});
    int passes = 0;
    expectSamePercentiles(sampledStatistics(particles, 4096, 1, passes), expected);
    EXPECT_EQ(passes, 1);
}

/// A sample of which all cuts lie elsewhere than of all: its blocks hold the innermost, or the outermost.
TEST(BeamStatistics, PercentilesByAWrongSampleAreTheSame) {
    for (const double factor : {0.1, 10.0}) {
        auto particles = manyNormals(200000);
        for (std::size_t i = 0; i < particles.size(); ++i) {
            if (i / 4096 % 2 != 0) continue;
            for (const std::size_t c : {0, 1, 2, 4, 5, 6})
                if (!particles.coordinate[c].empty()) particles.coordinate[c][i] *= factor;
        }
        const auto expected = statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0});
        int passes = 0;
        expectSamePercentiles(sampledStatistics(particles, 4096, 2, passes), expected);
        EXPECT_EQ(passes, 3);
    }
}

/// Percentiles from the pass of moments, by a sample of one in so many blocks: NaN all if it says nothing.
std::vector<double> rimmedStatistics(const Particles& particles, std::size_t block, std::size_t stride) {
    const auto sample = sampleOf(particles, block, stride);
    BeamRims rims(std::span(&sample, 1), particles.size());
    BeamMoments moments(mass);
    const std::size_t blocks = (particles.size() + block - 1) / block;
    std::vector<BeamRims::Gathered> gathered(blocks);
    for (std::size_t i = 0; i < blocks; ++i) {
        const auto rows = rowsOf(particles, i, i * block, std::min(block, particles.size() - i * block));
        const auto taken = moments.add(rows);
        if (rims.known()) rims.add(rows, taken == rows.size, gathered[i]);
    }
    const auto total = moments.total();
    BeamPercentiles percentiles(total);
    const auto found = rims.known() ? rims.emittances(total, gathered) : std::nullopt;
    BeamRims::Emittances nothing;
    nothing.fill(notNumber);
    percentiles.finish(found.value_or(nothing));
    return beamValues(total, percentiles, {mass, "1", 0, 0.0});
}

bool knowsPercentiles(const std::vector<double>& values) {
    return !std::isnan(valueOf(values, "emit90_action_x"));
}

Particles ofOneWeight(Particles particles, double weight) {
    std::ranges::fill(particles.weight, weight);
    return particles;
}

TEST(BeamRims, SayWhatASortSays) {
    for (const double weight : {1.0, 3e-17, 7e11}) {
        const auto particles = ofOneWeight(generate(150000, 1, false), weight);
        const auto values = rimmedStatistics(particles, 4096, 1);
        ASSERT_TRUE(knowsPercentiles(values)) << weight;
        expectSamePercentiles(values, statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0}));
        Plain plain(particles);
        for (const std::string plane : {"x", "y", "z"}) {
            for (const int percent : {90, 95, 99}) {
                const Real inside = plain.inside(plane, "p" + plane, percent) / mass;
                const auto name = "emit" + std::to_string(percent) + "_action_" + plane;
                expectClose(valueOf(values, name), inside, 10 * inside, name);
            }
        }
    }
}

TEST(BeamRims, RowsThatAreNoNumbersAreAsIfTheyWereNotThere) {
    auto particles = ofOneWeight(generate(150000, 4, true), 1.0);
    for (std::size_t i = 0; i < particles.size(); i += 1000) particles.weight[i] = notNumber;
    // Far from all others they would have all of the digits.
    std::ranges::replace(particles.coordinate[6], 0.0, 1e9);
    // All of a block take part.
    for (std::size_t i = 0; i < 4096; ++i)
        for (auto& c : particles.coordinate) c[i] = c[5000];
    const auto values = rimmedStatistics(particles, 4096, 1);
    ASSERT_FALSE(knowsPercentiles(values)) << "weights that are no numbers are not alike";
    std::ranges::fill(particles.weight, 1.0);
    const auto good = rimmedStatistics(particles, 4096, 1);
    ASSERT_TRUE(knowsPercentiles(good));
    expectSamePercentiles(good, statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0}));
}

/// Coordinates have few values, so that many actions are equal, at each cut.
TEST(BeamRims, OfEqualActionsAllOrNoneAreInside) {
    auto particles = ofOneWeight(generate(300000, 2, false), 1.0);
    constexpr std::array<double, 7> steps{5e-4, 2e-4, 2e-3, 1e-9, 1e5, 1e5, 2e5};
    for (std::size_t c = 0; c < steps.size(); ++c)
        for (auto& value : particles.coordinate[c]) value = std::round(value / steps[c]) * steps[c];
    const auto values = rimmedStatistics(particles, 4096, 1);
    ASSERT_TRUE(knowsPercentiles(values));
    expectSamePercentiles(values, statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0}));
}

TEST(BeamRims, APlaneWithoutAnAreaHasNoPercentiles) {
    auto particles = ofOneWeight(generate(100000, 1, false), 1.0);
    std::ranges::fill(particles.coordinate[5], 1e3);
    const auto values = rimmedStatistics(particles, 4096, 1);
    ASSERT_TRUE(knowsPercentiles(values));
    EXPECT_TRUE(std::isnan(valueOf(values, "emit90_action_y")));
    expectSamePercentiles(values, statisticsOf(particles, 4096, 1, {mass, "1", 0, 0.0}));
}

TEST(BeamRims, SayNothingWhereTheyMightBeWrong) {
    const auto good = ofOneWeight(generate(200000, 1, false), 1.0);
    ASSERT_TRUE(knowsPercentiles(rimmedStatistics(good, 4096, 1)));
    auto weighed = good;
    weighed.weight[12345] = 1.5;  // not in the sample
    EXPECT_FALSE(knowsPercentiles(rimmedStatistics(weighed, 4096, 1))) << "two weights";
    weighed.weight[32 * 100] = 1.5;
    EXPECT_FALSE(knowsPercentiles(rimmedStatistics(weighed, 4096, 1))) << "two in the sample";
    EXPECT_FALSE(knowsPercentiles(rimmedStatistics(ofOneWeight(good, 0.0), 4096, 1))) << "no weight";
    EXPECT_FALSE(knowsPercentiles(rimmedStatistics(ofOneWeight(generate(20000, 1, false), 1.0), 4096, 1)))
        << "a small sample";
    for (const double factor : {0.1, 0.97, 1.03, 10.0}) {
        auto wrong = good;
        for (std::size_t i = 0; i < wrong.size(); ++i)
            for (const std::size_t c : {0U, 1U, 4U, 5U})
                wrong.coordinate[c][i] *= i / 4096 % 2 == 0 ? factor : 1.0;
        EXPECT_FALSE(knowsPercentiles(rimmedStatistics(wrong, 4096, 2))) << "a wrong sample, " << factor;
    }
    // What lies outside has all of the digits, and the sample knows of it.
    auto far = good;
    for (std::size_t i = 0; i < far.size(); i += 33) far.coordinate[0][i] = i / 1056 % 2 == 0 ? 1e6 : -1e6;
    EXPECT_FALSE(knowsPercentiles(rimmedStatistics(far, 4096, 1))) << "few particles far away";
}

/// More lies in rims than is kept: all particles have one action.
TEST(BeamRims, AreGivenUpWhereTooMuchLiesWithin) {
    std::vector<std::pair<double, double>> ring;
    for (int i = 0; i < 1000000; ++i) {
        constexpr std::array<std::pair<double, double>, 4> corners{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
        ring.push_back(corners[static_cast<std::size_t>(i * 7 / 3 % 4)]);
    }
    EXPECT_FALSE(knowsPercentiles(rimmedStatistics(ofPlane(ring), 65536, 1)));
}

TEST(BeamStatistics, NamesAreFoundOnce) {
    std::set<std::string> names;
    for (const auto& statistic : statistics()) {
        EXPECT_TRUE(names.insert(statistic.name).second) << statistic.name;
        EXPECT_FALSE(statistic.unit.empty()) << statistic.name;
    }
    EXPECT_EQ(findStatistic("cov_px__x"), findStatistic("cov_x__px"));
    for (const auto* wrong : {"", "cov_", "cov___", "cov_x__x", "mean_", "mean_w", "n_particle "}) {
        EXPECT_FALSE(findStatistic(wrong)) << wrong;
    }
}

}  // namespace
}  // namespace mote::storage
