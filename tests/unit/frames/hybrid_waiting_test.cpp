// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is drawn of a hybrid volume while its step is on its way.
#include <gmock/gmock.h>

#include "server/frames/picture_maker.h"
#include "server/render/plan/grid_field.h"

namespace mote::server {
namespace {

using render::GridField;

std::shared_ptr<GridField> smallStep() {
    auto step = std::make_shared<GridField>();
    step->coarse.size = {2, 2, 2};
    step->coarse.values.resize(12);
    step->coarse.normals.resize(12);
    return step;
}

/// Has the volume alone, until the test brings the rest.
class SlowSource final : public StepSource {
  public:
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                              std::uint32_t) override {
        return Error{ErrorCode::notFound, "dataset", dataset};
    }
    Result<storage::Catalogue::Entry> dataset(const std::string& name) override {
        return storage::Catalogue::Entry{name, "/nowhere", manifest_};
    }
    Result<Resident> resident(const AnyLoadable& what) override {
        const bool all = what.part != static_cast<int>(HybridRepresentation::volume);
        return Resident{all ? whole : volume};
    }
    bool played(const storage::Catalogue::Entry&) override { return inOrder; }

    std::shared_ptr<GridField> volume = smallStep();
    std::shared_ptr<GridField> whole;  ///< null: on its way
    bool inOrder = false;              ///< steps are played

  private:
    static std::shared_ptr<const proto::Manifest> manifestWithResidual() {
        auto manifest = std::make_shared<proto::Manifest>();
        manifest->set_kind("hybrid");
        manifest->mutable_hybrid()->set_residual(true);
        manifest->mutable_hybrid()->add_steps();
        return manifest;
    }
    const std::shared_ptr<const proto::Manifest> manifest_ = manifestWithResidual();
};

using Drawn = std::vector<std::shared_ptr<const GridField>>;

/// Notes which steps it drew.
class NotingDevice final : public render::Device {
  public:
    explicit NotingDevice(Drawn& drawn) : drawn_(drawn) {}
    std::string name() const override { return "noting"; }
    void trim() override {}
    void countTo(const std::shared_ptr<storage::BlockBudget>& budget) override { budget->takeAnyway(1000); }
    std::optional<render::Picture> render(const render::FramePlan& plan, render::PixelFormat format,
                                          std::stop_token) override {
        for (const auto& field : plan.fields) drawn_.push_back(field.grid()->grid);
        render::Picture picture{plan.width, plan.height, format, {}, 0};
        picture.pixels.resize(std::size_t{plan.width} * plan.height * render::bytesPerPixel(format));
        return picture;
    }

  private:
    Drawn& drawn_;
};

class HybridWaiting : public testing::Test {
  protected:
    Result<Making> make(Stage stage, bool moving = false) {
        auto task = std::make_shared<ViewTask>();
        task->moving = moving;
        task->view.width = 8;
        task->view.height = 8;
        task->view.layers.push_back({.dataset = "data/volume", .style = *parseHybridStyle({})});
        return maker_.make({.session = 1, .task = task, .stage = stage, .stop = {}}, history_);
    }

    SlowSource source_;
    Drawn drawn_;
    PictureMaker maker_{[this] { return std::make_unique<NotingDevice>(drawn_); }, source_};
    PictureHistory history_{QualityController(30.0)};
};

TEST_F(HybridWaiting, AViewInMotionIsDrawnFromTheVolumeAlone) {
    const auto made = make(Stage::quick);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(made->picture);
    EXPECT_THAT(drawn_, testing::ElementsAre(source_.volume));
}

TEST_F(HybridWaiting, TheExactPictureWaits) {
    const auto made = make(Stage::exact);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(made->waits);
    EXPECT_FALSE(made->picture);
    EXPECT_THAT(drawn_, testing::IsEmpty());
}

TEST_F(HybridWaiting, EachStepThatIsPlayedIsWaitedForUnlessAHandMovesTheView) {
    source_.inOrder = true;
    EXPECT_TRUE(make(Stage::quick)->waits);
    EXPECT_THAT(drawn_, testing::IsEmpty());
    EXPECT_TRUE(make(Stage::quick, true)->picture);
    EXPECT_THAT(drawn_, testing::ElementsAre(source_.volume));
}

TEST_F(HybridWaiting, WhatTheDeviceMakesCountsToTheData) {
    const auto data = std::make_shared<storage::BlockBudget>(10000);
    const auto memory = std::make_shared<PictureMemory>(10000, data);
    const PictureMaker maker([this] { return std::make_unique<NotingDevice>(drawn_); }, source_, {},
                             render::WorkInTurns::shortTurn, memory);
    EXPECT_EQ(data->resident(), 1000U);
}

TEST_F(HybridWaiting, BothAreDrawnFromTheWholeStepOnceItIsThere) {
    source_.whole = smallStep();
    ASSERT_TRUE(make(Stage::quick)->picture);
    ASSERT_TRUE(make(Stage::exact)->picture);
    EXPECT_THAT(drawn_, testing::ElementsAre(source_.whole, source_.whole));
}

}  // namespace
}  // namespace mote::server
