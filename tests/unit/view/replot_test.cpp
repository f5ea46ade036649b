// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/replot.h"

#include <gtest/gtest.h>

#include "client/shared/jobs.h"

namespace mote::client {
namespace {

proto::Description described(const std::string& dataset, const AxisNames& axes) {
    proto::Description description;
    description.set_dataset(dataset);
    for (const auto& axis : axes)
        description.mutable_manifest()->mutable_particles()->add_axes()->set_name(axis);
    auto& particles = *description.mutable_replot()->mutable_particles();
    particles.add_inputs("data/run.h5");
    for (const auto& axis : axes) particles.add_axes(axis);
    particles.add_bounds()->set_name("x");
    particles.set_leaf_capacity(64);
    return description;
}

TEST(Replot, KeepsTheRunAndItsOptionsAndChangesTheAxes) {
    const auto request = replotRequest(described("data/beam", {"x", "px", "y"}), {"x", "y", "z"});
    ASSERT_TRUE(request);
    EXPECT_EQ(request->output(), "data/beam-x-y-z.mote");
    EXPECT_EQ(request->particles().inputs(0), "data/run.h5");
    EXPECT_EQ(request->particles().axes(2), "z");
    EXPECT_EQ(request->particles().leaf_capacity(), 64U);
    EXPECT_EQ(request->particles().bounds_size(), 0);
    EXPECT_EQ(datasetName(*request), "data/beam-x-y-z");
}

TEST(Replot, NamesDoNotGrow) {
    const auto request = replotRequest(described("data/beam-x-y-z", {"x", "y", "z"}), {"x", "px", "y"});
    ASSERT_TRUE(request);
    EXPECT_EQ(request->output(), "data/beam-x-px-y.mote");
}

TEST(Replot, NothingWhereTheRunIsOutOfReach) {
    auto description = described("data/beam", {"x", "px", "y"});
    description.clear_replot();
    EXPECT_FALSE(replotRequest(description, {"x", "y", "z"}));
    EXPECT_FALSE(axesOf(proto::Description()));
}

}  // namespace
}  // namespace mote::client
