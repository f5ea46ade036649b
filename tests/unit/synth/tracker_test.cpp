// SPDX-License-Identifier: GPL-3.0-or-later
//
// The particle loop against an independent integration with the exact field, and against the laws that it
// must keep.
#include "preprocess/synth/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "preprocess/synth/waterbag.h"

namespace mote::prep {
namespace {

using Phase = std::array<double, 6>;  ///< x, y, zeta, x', y', zeta'

void put(ParticleArrays& particles, std::size_t row, const Phase& phase) {
    for (std::size_t plane = 0; plane < 3; ++plane) {
        particles.position[plane][row] = phase[plane];
        particles.slope[plane][row] = phase[3 + plane];
    }
}

Phase get(const ParticleArrays& particles, std::size_t row) {
    return {particles.position[0][row], particles.position[1][row], particles.position[2][row],
            particles.slope[0][row],    particles.slope[1][row],    particles.slope[2][row]};
}

/// One particle and the core together, by RK4 with small steps and the exact field.
class Reference {
  public:
    explicit Reference(const ChannelPlan& plan) : model_(plan.design), core_(plan.matched) {
        for (std::size_t plane = 0; plane < 3; ++plane) {
            core_.axes[plane] *= plan.design.mismatch[plane];
            core_.slopes[plane] *= plan.design.mismatch[plane];
        }
    }

    Phase track(Phase phase, double end) {
        const double h = 0.5e-3;  // divides every element
        const auto steps = static_cast<int>(std::lround(end / h));
        for (int i = 0; i < steps; ++i) {
            const double s = i * h;
            const Envelope middle = model_.advance(core_, s, s + 0.5 * h, h);
            const Envelope next = model_.advance(middle, s + 0.5 * h, s + h, h);
            const auto k = focusing(s + 0.5 * h);
            const Phase k1 = rate(phase, core_, k);
            const Phase k2 = rate(plus(phase, k1, 0.5 * h), middle, k);
            const Phase k3 = rate(plus(phase, k2, 0.5 * h), middle, k);
            const Phase k4 = rate(plus(phase, k3, h), next, k);
            phase = plus(plus(plus(plus(phase, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
            core_ = next;
        }
        return phase;
    }

  private:
    static Phase plus(Phase a, const Phase& b, double factor) {
        for (std::size_t i = 0; i < 6; ++i) a[i] += factor * b[i];
        return a;
    }

    std::array<double, 3> focusing(double s) const {
        const double within = std::fmod(s, model_.channel().periodLength());
        for (const ChannelElement& element : model_.channel().elements()) {
            if (within < element.begin + element.length) return element.focusing;
        }
        return model_.channel().elements().back().focusing;
    }

    Phase rate(const Phase& p, const Envelope& core, const std::array<double, 3>& k) const {
        const auto field = ellipsoidField(
            {core.axes[0] * core.axes[0], core.axes[1] * core.axes[1], core.axes[2] * core.axes[2]},
            {p[0], p[1], p[2]});
        Phase result{p[3], p[4], p[5], 0, 0, 0};
        for (std::size_t i = 0; i < 3; ++i) result[3 + i] = -k[i] * p[i] + model_.perveance() * field[i];
        return result;
    }

    EnvelopeModel model_;
    Envelope core_;
};

/// The plan of a channel whose first dump after the start lies `slices` on.
ChannelPlan planWithDumps(std::uint32_t steps) {
    return planChannel(mismatched({}, 1.5), steps).value();
}

/// Carries a particle through the plan's dumps up to `place`.
Phase trackTo(const ChannelPlan& plan, const Phase& start, double place) {
    ParticleArrays particles(1);
    put(particles, 0, start);
    for (const PlanDump& dump : plan.dumps) {
        if (dump.place > place + 1e-9) break;
        trackParticles(dump, particles, 0, 1);
    }
    return get(particles, 0);
}

double distance(const Phase& a, const Phase& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 6; ++i) {
        const double scale = i < 3 ? 5e-3 : 10e-3;  // a beam's size and divergence
        sum += (a[i] - b[i]) * (a[i] - b[i]) / (scale * scale);
    }
    return std::sqrt(sum);
}

// Kick-drift-kick is of second order: twice the slices, a quarter of the error. Inside the core the force is
// smooth, so the ratio is seen clean; a particle of the halo crosses the core's edge, where the force has a
// kink.
TEST(Tracker, agreesWithAnIndependentIntegrationToSecondOrder) {
    const ChannelPlan coarse = planWithDumps(481), fine = planWithDumps(961);
    ASSERT_EQ(fine.slices, 2 * coarse.slices);
    const double place = 2.0 * 0.42;
    const Phase inner{1.5e-3, 0.7e-3, 1.0e-3, 0.0, 1e-3, -0.5e-3};
    const Phase exact = Reference(coarse).track(inner, place);
    const double coarseError = distance(trackTo(coarse, inner, place), exact);
    const double fineError = distance(trackTo(fine, inner, place), exact);
    EXPECT_LT(coarseError, 5e-3);
    EXPECT_NEAR(coarseError / fineError, 4.0, 0.8);

    const Phase halo{9e-3, 1e-3, 4e-3, 0.0, 5e-3, 1e-3};
    const Phase exactHalo = Reference(coarse).track(halo, place);
    EXPECT_LT(distance(trackTo(coarse, halo, place), exactHalo), 1e-2);
    EXPECT_LT(distance(trackTo(fine, halo, place), exactHalo), 3e-3);
}

// Every map and every kick is a gradient: J = d(end)/d(start) keeps the symplectic form. Central differences
// of 1e-4 of the beam's size leave (1e-4)^2 times the nonlinearity, and the polynomial's 1e-7 curl.
TEST(Tracker, isSymplecticInsideAndOutsideTheCore) {
    const ChannelPlan plan = planWithDumps(41);  // dumps at every period
    const PlanDump& period = plan.dumps[1];
    ASSERT_EQ(period.stages.size(), static_cast<std::size_t>(slicesPerPeriod));
    const Phase scale{5e-3, 5e-3, 5e-3, 10e-3, 10e-3, 10e-3};
    for (const Phase& start : {Phase{1e-3, 1e-3, 1e-3, 0, 0, 0}, Phase{12e-3, 3e-3, 6e-3, 1e-3, 0, 1e-3}}) {
        double jacobian[6][6];
        for (std::size_t j = 0; j < 6; ++j) {
            ParticleArrays pair(2);
            for (std::size_t side = 0; side < 2; ++side) {
                Phase moved = start;
                moved[j] += (side == 0 ? -1e-4 : 1e-4) * scale[j];
                put(pair, side, moved);
            }
            trackParticles(period, pair, 0, 2);
            for (std::size_t i = 0; i < 6; ++i) {
                jacobian[i][j] = (get(pair, 1)[i] - get(pair, 0)[i]) / (2e-4 * scale[j]);
            }
        }
        for (std::size_t a = 0; a < 6; ++a) {
            for (std::size_t b = 0; b < 6; ++b) {
                double form = 0.0;
                for (std::size_t i = 0; i < 3; ++i) {
                    form += jacobian[i][a] * jacobian[i + 3][b] - jacobian[i + 3][a] * jacobian[i][b];
                }
                const double expected = b == a + 3 ? 1.0 : (a == b + 3 ? -1.0 : 0.0);
                EXPECT_NEAR(form, expected, 1e-3) << a << ' ' << b;
            }
        }
    }
}

TEST(Tracker, theBeamStartsWithTheRmsSizesOfItsCore) {
    const ChannelPlan plan = planWithDumps(10);
    constexpr std::size_t n = 100'000;
    ParticleArrays particles(n);
    startParticles(plan, 1, 0, particles, 0, n);
    for (std::size_t plane = 0; plane < 3; ++plane) {
        double uu = 0.0, up = 0.0, pp = 0.0, most = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            const double u = particles.position[plane][i], p = particles.slope[plane][i];
            uu += u * u / n;
            up += u * p / n;
            pp += p * p / n;
            most = std::max(most, std::abs(u));
        }
        const double axis = plan.dumps[0].core.axes[plane];
        EXPECT_NEAR(axis / plan.matched.axes[plane], plan.design.mismatch[plane], 1e-12);
        // <u^2> = axis^2 / 5; the standard deviation of its mean is sqrt(0.021875) * 8 / sqrt(n) = 0.0037 of
        // it.
        EXPECT_NEAR(std::sqrt(5.0 * uu) / axis, 1.0, 5 * 0.0019);
        EXPECT_NEAR(5.0 * std::sqrt(uu * pp - up * up) / plan.emittance[plane], 1.0, 5 * 0.0037);
        EXPECT_LE(most, axis * std::sqrt(1.6) * (1 + 1e-12));
        EXPECT_GT(most, axis * 1.2) << "the waterbag's shell starts outside the core";
    }
}

TEST(Tracker, blocksAndRangesDoNotMatter) {
    const ChannelPlan plan = planWithDumps(5);
    constexpr std::size_t n = 1500;
    ParticleArrays whole(n), parts(n);
    startParticles(plan, 9, 100, whole, 0, n);
    trackParticles(plan.dumps[1], whole, 0, n);
    for (std::size_t begin = 0; begin < n; begin += 7) {
        const std::size_t end = std::min(begin + 7, n);
        startParticles(plan, 9, 100, parts, begin, end);
        trackParticles(plan.dumps[1], parts, begin, end);
    }
    for (std::size_t plane = 0; plane < 3; ++plane) {
        EXPECT_EQ(whole.position[plane], parts.position[plane]);
        EXPECT_EQ(whole.slope[plane], parts.slope[plane]);
    }
}

TEST(Tracker, aParticleOnTheAxisStaysThere) {
    const ChannelPlan plan = planWithDumps(2);
    EXPECT_EQ(trackTo(plan, Phase{}, 1e9), Phase{});
}

TEST(Plan, dumpsLieEvenlyFromTheStartToTheEnd) {
    const ChannelPlan ten = planWithDumps(10);
    ASSERT_EQ(ten.dumps.size(), 10u);
    EXPECT_EQ(ten.dumps.front().place, 0.0);
    EXPECT_TRUE(ten.dumps.front().stages.empty());
    EXPECT_NEAR(ten.dumps.back().place, 0.42 * channelPeriods, 1e-9);
    const ChannelPlan one = planWithDumps(1);
    ASSERT_EQ(one.dumps.size(), 1u);
    EXPECT_EQ(one.dumps[0].slice, one.slices);
    const ChannelPlan many = planWithDumps(1000);
    for (std::size_t i = 1; i < many.dumps.size(); ++i)
        EXPECT_GT(many.dumps[i].slice, many.dumps[i - 1].slice);
    EXPECT_NEAR(many.dumps.back().place, 0.42 * channelPeriods, 1e-9);
}

}  // namespace
}  // namespace mote::prep
