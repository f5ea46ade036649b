// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is made of fields of samples, and what of it is counted.
#include "server/render/cpu/resident_fields.h"

#include <gtest/gtest.h>

#include "storage/blocks/block_budget.h"

namespace mote::render {
namespace {

/// A coarse grid of 4 x 4 x 4, and eight bricks, half of which correct it.
std::shared_ptr<const GridField> smallField() {
    auto field = std::make_shared<GridField>();
    field->coarse.size = glm::uvec3(4);
    for (std::uint32_t i = 0; i < 64 + 4; ++i)
        field->coarse.values.push_back(static_cast<std::uint16_t>(1000 * i));
    field->coarse.normals.resize(64 + 4);
    auto bricks = std::make_shared<GridBricks>();
    bricks->size = glm::uvec3(16);
    bricks->count = glm::uvec3(2);
    bricks->numbers = {0, GridBricks::none, 1, GridBricks::none, 2, GridBricks::none, 3, GridBricks::none};
    bricks->values.resize(4 * GridBricks::volume + 4, 50000);
    bricks->normals.resize(bricks->values.size());
    field->bricks = std::move(bricks);
    return field;
}

/// Of one field, which shows from `from` on.
FramePlan planOf(const std::shared_ptr<const GridField>& field, double from, double gradient) {
    FramePlan plan;
    const auto opacity = Curve::create({{from, 0.0}, {1.0, 0.5}});
    plan.fields.push_back({.layer = 0,
                           .transfer = {.opacity = opacity.value(), .opacityLength = 0.1},
                           .samples = CorrectedField{.grid = field, .gradient = gradient}});
    return plan;
}

class ResidentFieldsTest : public testing::Test {
  protected:
    VisibleField of(double from, double gradient) {
        budget_->beginGeneration();
        return fields_.of(planOf(field_, from, gradient)).front();
    }

    static constexpr std::uint64_t dark_ = 8 * 4 + 4 * 64 * 4, slopes_ = 64 + 4 + 4 * 729 + 4;
    std::shared_ptr<const GridField> field_ = smallField();
    std::shared_ptr<storage::BlockBudget> budget_ = std::make_shared<storage::BlockBudget>(10000);
    ResidentFields fields_;
};

TEST_F(ResidentFieldsTest, WhatIsMadeOfAFieldTakesWhatIsCounted) {
    fields_.countTo(budget_);
    auto seen = of(0.5, 0.0);
    ASSERT_NE(seen.dark, nullptr);
    EXPECT_EQ(seen.seen.slopes, nullptr);
    EXPECT_EQ(budget_->resident(), dark_);
    seen = of(0.5, 1.0);
    ASSERT_NE(seen.seen.slopes, nullptr);
    EXPECT_EQ(seen.seen.slopes->coarse.capacity() + seen.seen.slopes->bricks.capacity(), slopes_);
    EXPECT_EQ(budget_->resident(), dark_ + slopes_);
    seen = {};
    of(0.6, 0.0);
    EXPECT_EQ(budget_->resident(), 2 * dark_ + slopes_);
    of(0.7, 0.0);
    EXPECT_EQ(budget_->resident(), 2 * dark_ + slopes_) << "two curves of a field are kept";
}

TEST_F(ResidentFieldsTest, WhatWasMadeLongestAgoGoesForOtherData) {
    fields_.countTo(budget_);
    of(0.5, 1.0);
    of(0.6, 0.0);
    EXPECT_TRUE(budget_->take(10000 - dark_, budget_->generation()));
    EXPECT_EQ(budget_->resident(), 10000U) << "what the present picture has not asked for";
    const auto seen = of(0.5, 1.0);
    EXPECT_NE(seen.seen.slopes, nullptr) << "a picture has all that it needs";
    EXPECT_NE(seen.dark, nullptr);
    EXPECT_EQ(budget_->resident(), 10000 + slopes_);
    budget_->giveBack(10000 - dark_);
}

TEST_F(ResidentFieldsTest, NothingIsCountedOfAFieldThatIsGone) {
    fields_.countTo(budget_);
    of(0.5, 1.0);
    field_.reset();
    fields_.dropExpired();
    EXPECT_EQ(budget_->resident(), 0U);
}

TEST_F(ResidentFieldsTest, ItIsMadeIfNobodyCounts) {
    EXPECT_NE(of(0.5, 1.0).dark, nullptr);
    EXPECT_NE(of(0.5, 1.0).seen.slopes, nullptr);
    EXPECT_EQ(budget_->resident(), 0U);
}

}  // namespace
}  // namespace mote::render
