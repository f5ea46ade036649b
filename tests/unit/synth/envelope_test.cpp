// SPDX-License-Identifier: GPL-3.0-or-later
//
// The envelope against its matched solution, the zero-current limit and the order of its integrator.
#include "preprocess/synth/envelope.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mote::prep {
namespace {

double relativeMiss(const Envelope& a, const Envelope& b, double period) {
    double most = 0.0;
    for (std::size_t plane = 0; plane < 3; ++plane) {
        most = std::max(most, std::abs(a.axes[plane] - b.axes[plane]) / b.axes[plane]);
        most = std::max(most, std::abs(a.slopes[plane] - b.slopes[plane]) * period / b.axes[plane]);
    }
    return most;
}

TEST(Envelope, theMatchedBeamRepeatsAfterAPeriodAndAfterFifty) {
    const EnvelopeModel model{BeamDesign{}};
    const auto matched = model.matched();
    ASSERT_TRUE(matched.ok());
    const double period = model.channel().periodLength();
    const Envelope after = model.advance(*matched, 0.0, period, EnvelopeModel::defaultStep);
    EXPECT_LT(relativeMiss(after, *matched, period), 1e-9);
    const Envelope late = model.advance(*matched, 0.0, 50 * period, EnvelopeModel::defaultStep);
    EXPECT_LT(relativeMiss(late, *matched, period), 1e-9);
    // In the middle of a quadrupole of a symmetric cell nothing converges or diverges.
    for (const double slope : matched->slopes) EXPECT_NEAR(slope, 0.0, 1e-10);
    // Half a period on, x and y change places.
    const Envelope half = model.advance(*matched, 0.0, 0.5 * period, EnvelopeModel::defaultStep);
    EXPECT_NEAR(half.axes[0] / matched->axes[1], 1.0, 1e-9);
    EXPECT_NEAR(half.axes[1] / matched->axes[0], 1.0, 1e-9);
    EXPECT_GT(matched->axes[0], 1.5 * matched->axes[1]);
}

TEST(Envelope, aMismatchedBeamDoesNotRepeat) {
    const EnvelopeModel model{BeamDesign{}};
    Envelope envelope = model.matched().value();
    const Envelope matched = envelope;
    for (double& axis : envelope.axes) axis *= 1.05;
    const double period = model.channel().periodLength();
    double most = 0.0;
    for (int p = 0; p < 20; ++p) {
        envelope = model.advance(envelope, p * period, (p + 1) * period, EnvelopeModel::defaultStep);
        most = std::max(most, relativeMiss(envelope, matched, period));
    }
    EXPECT_GT(most, 0.04);
    EXPECT_LT(most, 0.5) << "the channel is stable against small mismatch";
}

// Without current a^2 = emittance * beta, and beta is element (1, 2) of the period's map over sin mu; the
// phase of a particle inside is that of the channel.
TEST(Envelope, zeroCurrentIsLinearOptics) {
    BeamDesign design;
    design.current = 0.0;
    const EnvelopeModel model(design);
    const auto matched = model.matched();
    ASSERT_TRUE(matched.ok());
    const ChannelMap map = model.channel().map(0.0, design.periodLength);
    const auto advance = model.depressedAdvance(*matched);
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const double mu = model.channel().phaseAdvance(plane);
        // The integrator leaves 1e-9 a period at its default step (see the test of its order).
        EXPECT_NEAR(matched->axes[plane] * matched->axes[plane] /
                        (model.emittance()[plane] * map[plane].up / std::sin(mu)),
                    1.0, 3e-9);
        // Simpson's rule over 420 panels of a smooth function.
        EXPECT_NEAR(advance[plane], mu, 1e-8);
    }
}

TEST(Envelope, spaceChargeDepressesThePhaseAdvance) {
    const EnvelopeModel model{BeamDesign{}};
    const auto advance = model.depressedAdvance(model.matched().value());
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const double depression = advance[plane] / model.channel().phaseAdvance(plane);
        EXPECT_GT(depression, 0.40);
        EXPECT_LT(depression, 0.60);
    }
    // Below 90 degrees there is no envelope instability (docs/SYNTH.md).
    EXPECT_LT(model.channel().phaseAdvance(0), M_PI / 2.0);
}

TEST(Envelope, theIntegratorIsOfFourthOrderAcrossHardEdges) {
    const EnvelopeModel model{mismatched({}, 1.5)};
    Envelope start = model.matched().value();
    for (double& axis : start.axes) axis *= 1.5;
    const double end = 2.0 * model.channel().periodLength();
    const Envelope reference = model.advance(start, 0.0, end, 0.25e-3);
    const double coarse = relativeMiss(model.advance(start, 0.0, end, 8e-3), reference, 0.42);
    const double fine = relativeMiss(model.advance(start, 0.0, end, 4e-3), reference, 0.42);
    // 2^4 = 16; the steps are rounded to whole parts of the elements, (9/5)^4 = 10.5 to (9/4)^4 = 25.6.
    EXPECT_GT(coarse / fine, 10.0);
    EXPECT_LT(coarse / fine, 26.0);
    EXPECT_LT(relativeMiss(model.advance(start, 0.0, end, EnvelopeModel::defaultStep), reference, 0.42),
              1e-8);
}

TEST(Envelope, aChannelWithoutFocusingHasNoMatchedBeam) {
    BeamDesign weak;
    weak.quadrupoleGradient = 5.0;  // rf defocusing wins
    const auto none = EnvelopeModel(weak).matched();
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::invalidArgument);
    BeamDesign strong;
    strong.quadrupoleGradient = 120.0;  // over-focused: |trace| > 2
    EXPECT_FALSE(EnvelopeModel(strong).matched().ok());
}

}  // namespace
}  // namespace mote::prep
