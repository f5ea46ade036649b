// SPDX-License-Identifier: GPL-3.0-or-later
//
// Densities of what is seen in a rectangle, and a saver of data.
#include "client/view/numbers/density_lens.h"

#include <gtest/gtest.h>

#include "client/view/panes/pane.h"
#include "client/view/view_model.h"
#include "protocol/scene/selection.h"

namespace mote::client {
namespace {

TEST(DensityLens, AsksByTheCornersOfItsRectangle) {
    ViewModel model;
    proto::View view;
    auto& layer = *view.add_layers();
    layer.set_dataset("data/beam");
    layer.set_step(3);
    layer.mutable_particles();
    ASSERT_TRUE(model.load(view).ok());
    const auto query = densitiesIn(model, 1.5, {{0.25, 0.75}, {0.5, 0.125}}, 64);
    EXPECT_EQ(query.dataset(), "data/beam");
    EXPECT_EQ(query.steps(), "3:3:1");
    EXPECT_TRUE(query.histogram().unweighted());
    EXPECT_EQ(query.histogram().axes(0).bins(), 64U);
    EXPECT_TRUE(parseSelection(query.select()).ok());
    const auto& points = query.select().lasso().points();
    ASSERT_EQ(points.size(), 4);
    for (const auto& [at, column, row] :
         {std::tuple{0, 0.25, 0.75}, {1, 0.5, 0.75}, {2, 0.5, 0.125}, {3, 0.25, 0.125}}) {
        EXPECT_EQ(points[at].values(0).number_value(),
                  points[column == 0.25 ? 0 : 1].values(0).number_value());
        EXPECT_EQ(points[at].values(1).number_value(), points[row == 0.75 ? 0 : 2].values(1).number_value());
    }
}

TEST(DataSaver, AsksForLessAndLessOften) {
    DataSaver saver;
    PictureArea area{900.0F, 600.0F, 1.0F, 0.0F, 0.0F, 901, 1};
    EXPECT_EQ(saver.asked(area).columns, 901U);
    EXPECT_FALSE(saver.waits(0.01, true));
    saver.on = true;
    EXPECT_EQ(saver.asked(area).columns, 451U);
    EXPECT_EQ(saver.asked(area).rows, 1U);
    EXPECT_EQ(saver.asked(area).width, 900.0F);
    proto::View view;
    saver.scale(view);
    EXPECT_EQ(view.scale(), 0.5);
    saver.note(10.0);
    EXPECT_FALSE(saver.waits(10.0, true));  // another pane
    EXPECT_TRUE(saver.waits(10.1, true));
    EXPECT_FALSE(saver.waits(10.1, false));  // at rest at once
    EXPECT_FALSE(saver.waits(10.0 + DataSaver::pause, true));
}

}  // namespace
}  // namespace mote::client
