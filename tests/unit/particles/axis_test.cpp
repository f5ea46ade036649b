// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <cmath>

#include "preprocess/particles/particles_job.h"
#include "preprocess/particles/plot_axis.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/step_range.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/manifest.h"
#include "tests/unit/particles/account.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::prep {
namespace {

using test::FakeSource;
using test::FakeStep;
using testing::ElementsAre;
using testing::HasSubstr;

FakeStep twoParticles() {
    FakeStep step;
    step[Column::x] = {3.0, 0.0};
    step[Column::y] = {4.0, 0.0};
    step[Column::z] = {1.0, 2.0};
    step[Column::px] = {30.0, 6.0};
    step[Column::py] = {40.0, 8.0};
    step[Column::pz] = {120.0, 24.0};
    step[Column::weight] = {1.0, 3.0};
    return step;
}

double valueOf(const std::string& name, std::size_t particle, double mass = 0.0) {
    FakeSource source({twoParticles()}, mass);
    PlotAxes axes{*PlotAxis::make(name, source), *PlotAxis::make("x", source), *PlotAxis::make("y", source)};
    test::QuietProgress progress;
    return test::loadStep(source, 0, axes, progress).coordinate[0].at(particle);
}

TEST(Axis, DerivedQuantities) {
    EXPECT_DOUBLE_EQ(valueOf("r", 0), 5.0);
    EXPECT_DOUBLE_EQ(valueOf("theta", 0), std::atan2(4.0, 3.0));
    EXPECT_DOUBLE_EQ(valueOf("xp", 0), 0.25);
    EXPECT_DOUBLE_EQ(valueOf("yp", 0), 1.0 / 3.0);
    EXPECT_DOUBLE_EQ(valueOf("pr", 0), (3.0 * 30.0 + 4.0 * 40.0) / 5.0);
    EXPECT_DOUBLE_EQ(valueOf("pr", 1), 10.0);  // on the axis all momentum across it is radial
    // |p| = 130 and 26, weights 1 and 3: mean (130 + 78) / 4 = 52.
    EXPECT_DOUBLE_EQ(valueOf("delta", 0), 1.5);
    EXPECT_DOUBLE_EQ(valueOf("delta", 1), -0.5);
}

TEST(Axis, EnergyIsKineticAndExactForSlowParticles) {
    EXPECT_DOUBLE_EQ(valueOf("gamma", 0, 130.0), std::sqrt(2.0));
    EXPECT_DOUBLE_EQ(valueOf("energy", 0, 130.0), 130.0 * (std::sqrt(2.0) - 1.0));
    // p^2 / 2m, where sqrt(p^2 + m^2) - m would be zero.
    EXPECT_NEAR(valueOf("energy", 0, 1e12) / (130.0 * 130.0 / 2e12), 1.0, 1e-14);
}

TEST(Axis, WhatTheRunLacksIsNamed) {
    FakeSource noMass({twoParticles()});
    const auto energy = PlotAxis::make("energy", noMass);
    ASSERT_FALSE(energy.ok());
    EXPECT_THAT(energy.error().toString(),
                testing::AllOf(HasSubstr("energy"), HasSubstr("mass"), HasSubstr("x, y, z, px")));
    const auto time = PlotAxis::make("t", noMass);
    ASSERT_FALSE(time.ok());
    EXPECT_EQ(time.error().where, "axis t");
    EXPECT_THAT(time.error().message, HasSubstr("x, y, z, px, py, pz, weight"));
    EXPECT_TRUE(PlotAxis::make("delta", noMass).ok());
    EXPECT_FALSE(PlotAxis::make("w", noMass).ok());
}

TEST(StepSelection, Forms) {
    EXPECT_THAT(*selectSteps("", 3), ElementsAre(0, 1, 2));
    EXPECT_THAT(*selectSteps("0:6:2", 7), ElementsAre(0, 2, 4, 6));
    EXPECT_THAT(*selectSteps("1:5:3", 7), ElementsAre(1, 4));
    EXPECT_THAT(*selectSteps("4", 7), ElementsAre(4));
    EXPECT_THAT(*selectSteps("5:", 7), ElementsAre(5, 6));
    EXPECT_THAT(*selectSteps("::3", 7), ElementsAre(0, 3, 6));
    EXPECT_THAT(*selectSteps("2:3:18446744073709551615", 7), ElementsAre(2));
}

TEST(StepSelection, WrongOnes) {
    for (const char* text :
         {"a", "1:2:3:4", "-1", "3:1", "0:2:0", "0:7", "7", "1.5", "99999999999999999999", "0: 2"}) {
        EXPECT_FALSE(selectSteps(text, 7).ok()) << text;
    }
    EXPECT_FALSE(selectSteps("", 0).ok());
}

/// The schema says the ends that the format has.
TEST(JobCheck, TakesWhatTheFormatHolds) {
    const auto most = [](const google::protobuf::Descriptor& type, const char* field) {
        return endsOf(*type.FindFieldByName(field)).value().greatest;
    };
    const auto& particles = *proto::ParticlesJob::descriptor();
    EXPECT_EQ(most(particles, "volume_level"), storage::maxVolumeLevel);
    EXPECT_EQ(most(particles, "max_level"), storage::maxOctreeLevel);
    EXPECT_EQ(most(*proto::VolumeJob::descriptor(), "max_points"),
              static_cast<double>(storage::maxGridSamples));
}

TEST(JobCheck, NamesTheField) {
    proto::ParticlesJob good;
    good.add_inputs("a.h5");
    for (const char* axis : {"x", "px", "y"}) good.add_axes(axis);
    EXPECT_TRUE(checkParticlesJob(good).ok());
    const auto where = [&](auto change) {
        auto job = good;
        change(job);
        const auto checked = checkParticlesJob(job);
        return checked.ok() ? std::string("accepted") : checked.error().where;
    };
    EXPECT_EQ(where([](auto& job) { job.clear_inputs(); }), "inputs");
    EXPECT_EQ(where([](auto& job) { job.set_axes(0, "y"); }), "axes");
    EXPECT_EQ(where([](auto& job) { job.add_axes("z"); }), "axes");
    EXPECT_EQ(where([](auto& job) { job.set_volume_level(9); }), "volumeLevel");
    EXPECT_EQ(where([](auto& job) { job.set_volume_level(0); }), "volumeLevel");
    EXPECT_EQ(where([](auto& job) { job.set_leaf_capacity(0); }), "leafCapacity");
    EXPECT_EQ(where([](auto& job) { job.set_max_level(17); }), "maxLevel");
    EXPECT_EQ(where([](auto& job) { job.set_steps("x"); }), "steps");
    const auto withBounds = [&](const char* name, double least, double greatest) {
        return where([&](auto& job) {
            auto& bounds = *job.add_bounds();
            bounds.set_name(name);
            bounds.set_min(least);
            bounds.set_max(greatest);
        });
    };
    EXPECT_EQ(where([](auto& job) { job.set_bounds_of("step"); }), "accepted");
    EXPECT_EQ(where([](auto& job) { job.set_bounds_of("bunch"); }), "boundsOf");
    EXPECT_EQ(withBounds("x", 0.0, 1.0), "accepted");
    EXPECT_EQ(withBounds("z", 0.0, 1.0), "bounds[0]");
    EXPECT_EQ(withBounds("x", 1.0, 1.0), "bounds[0]");
    EXPECT_EQ(withBounds("x", -1e308, 1e308), "bounds[0]");
    EXPECT_EQ(withBounds("x", NAN, 1.0), "bounds[0]");
}

}  // namespace
}  // namespace mote::prep
