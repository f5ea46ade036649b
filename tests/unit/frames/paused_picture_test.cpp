// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures that give way to others' are gone on with, and dropped where nobody wants them any more.
#include <gtest/gtest.h>

#include "server/frames/picture_maker.h"
#include "server/frames/planning.h"
#include "server/render/plan/grid_field.h"

namespace mote::server {
namespace {

/// A small volume, always there.
class VolumeSource final : public StepSource {
  public:
    VolumeSource() {
        auto manifest = std::make_shared<proto::Manifest>();
        manifest->set_kind("hybrid");
        manifest->mutable_hybrid()->add_steps();
        manifest->mutable_hybrid()->add_steps();
        manifest_ = std::move(manifest);
        volume_->coarse.size = {2, 2, 2};
        volume_->coarse.values.resize(12);
        volume_->coarse.normals.resize(12);
    }
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& dataset,
                                                              std::uint32_t) override {
        return Error{ErrorCode::notFound, "dataset", dataset};
    }
    Result<storage::Catalogue::Entry> dataset(const std::string& name) override {
        return storage::Catalogue::Entry{name, "/nowhere", manifest_};
    }
    Result<Resident> resident(const AnyLoadable& what) override {
        return what.step == missing_ ? Resident{} : Resident{volume_};
    }
    std::uint32_t missing_ = ~0U;  ///< a step that is on its way

  private:
    std::shared_ptr<const proto::Manifest> manifest_;
    std::shared_ptr<render::GridField> volume_ = std::make_shared<render::GridField>();
};

/// What became of the device's pictures.
struct Counts {
    int devices = 0, begun = 0, turns = 0, gone = 0;
    bool fails = false;
};

/// A picture of three pieces, a turn each where it is to give way.
class ThreePieces final : public render::UnfinishedPicture {
  public:
    ThreePieces(Counts& counts, const render::FramePlan& plan, render::PixelFormat format)
        : counts_(counts), picture_{plan.width, plan.height, format, {}, 0} {
        picture_.pixels.resize(std::size_t{plan.width} * plan.height * render::bytesPerPixel(format));
    }
    ~ThreePieces() override { ++counts_.gone; }

    bool advance(const std::stop_token& pause) override {
        ++counts_.turns;
        if (counts_.fails) throw render::DeviceError("its memory is lost");
        do {
            ++pieces_;
        } while (pieces_ < 3 && !pause.stop_requested());
        return pieces_ == 3;
    }
    render::Picture take() override {
        std::fill(picture_.pixels.begin(), picture_.pixels.end(), pieces_);
        return std::move(picture_);
    }
    std::uint64_t bytes() const override { return picture_.pixels.size(); }

  private:
    Counts& counts_;
    std::uint8_t pieces_ = 0;
    render::Picture picture_;
};

class PiecewiseDevice final : public render::Device {
  public:
    explicit PiecewiseDevice(Counts& counts) : counts_(counts) { ++counts_.devices; }
    std::string name() const override { return "piecewise"; }
    void trim() override {}
    std::optional<render::Picture> render(const render::FramePlan& plan, render::PixelFormat format,
                                          std::stop_token stop) override {
        const auto picture = begin(plan, format, stop);
        if (picture == nullptr || !picture->advance(stop)) return std::nullopt;
        return picture->take();
    }
    std::unique_ptr<render::UnfinishedPicture> begin(const render::FramePlan& plan,
                                                     render::PixelFormat format,
                                                     std::stop_token stop) override {
        if (stop.stop_requested()) return nullptr;
        ++counts_.begun;
        return std::make_unique<ThreePieces>(counts_, plan, format);
    }

  private:
    Counts& counts_;
};

class PausedPicture : public testing::Test {
  protected:
    PausedPicture() { pause_.request_stop(); }

    static std::shared_ptr<const ViewTask> taskOf(std::uint32_t width) {
        auto task = std::make_shared<ViewTask>();
        task->finalOnly = true;
        task->view.width = width;
        task->view.height = 8;
        task->view.layers.push_back({.dataset = "data/volume", .style = *parseHybridStyle({})});
        return task;
    }
    RenderJob jobOf(std::shared_ptr<const ViewTask> task, bool paused, Stage stage = Stage::exact) const {
        return {1, std::move(task), stage, {}, paused ? pause_.get_token() : std::stop_token()};
    }

    Counts counts_;
    VolumeSource source_;
    std::shared_ptr<PictureMemory> memory_ = std::make_shared<PictureMemory>(1 << 16, nullptr);
    PictureMaker maker_{[this] { return std::make_unique<PiecewiseDevice>(counts_); }, source_,
                        render::DeviceCosts{}, render::WorkInTurns::shortTurn, memory_};
    PictureHistory history_{QualityController(30.0)}, others_{QualityController(30.0)};
    std::stop_source pause_;
};

TEST_F(PausedPicture, IsGoneOnWithThoughOthersWereDrawnMeanwhile) {
    const auto large = taskOf(16);
    for (int turn = 0; turn < 2; ++turn) {
        const auto made = maker_.make(jobOf(large, true), history_);
        ASSERT_TRUE(made.ok()) << made.error().toString();
        EXPECT_FALSE(made->picture);
        EXPECT_FALSE(made->waits);
        const auto other = maker_.make(jobOf(taskOf(4), false, Stage::quick), others_);
        ASSERT_TRUE(other.ok() && other->picture);
    }
    const auto made = maker_.make(jobOf(large, true), history_);
    ASSERT_TRUE(made.ok() && made->picture);
    EXPECT_EQ(made->picture->picture.width, 16u);
    EXPECT_EQ(made->picture->picture.pixels[0], 3);
    EXPECT_TRUE(made->picture->message.final());
    EXPECT_EQ(counts_.begun, 3) << "the large one once, and the two others";
    EXPECT_EQ(counts_.gone, 3);
}

/// It is made of two, each of three turns.
TEST_F(PausedPicture, BetweenStepsIsGoneOnWithWhereverItWas) {
    auto task = std::make_shared<ViewTask>(*taskOf(16));
    task->view.layers[0].towards = Towards{1, 0.5};
    // Bytes of what is finished of it, and of one under way with what it becomes.
    constexpr std::uint64_t part = 16 * 8 * 8, whole = 16 * 8 * (8 + 5);
    for (const std::uint64_t kept : {whole, whole, part, part + whole, part + whole}) {
        const auto made = maker_.make(jobOf(task, true), history_);
        ASSERT_TRUE(made.ok()) << made.error().toString();
        EXPECT_FALSE(made->picture || made->waits);
        EXPECT_EQ(memory_->taken(), kept);
        ASSERT_TRUE(maker_.make(jobOf(taskOf(4), false, Stage::quick), others_)->picture);
    }
    const auto made = maker_.make(jobOf(task, true), history_);
    ASSERT_TRUE(made.ok() && made->picture);
    EXPECT_EQ(made->picture->picture.width, 16U);
    EXPECT_EQ(made->picture->picture.pixels.size(), 16U * 8 * 4);
    EXPECT_EQ(counts_.begun, 7) << "two of it, and the five others";
    EXPECT_EQ(memory_->taken(), made->picture->memory.bytes());
    // Nobody wants the next one any more.
    ASSERT_FALSE(maker_.make(jobOf(std::make_shared<ViewTask>(*task), true), history_)->picture);
    ASSERT_TRUE(maker_.make(jobOf(taskOf(4), false), history_)->picture);
    EXPECT_EQ(counts_.gone, counts_.begun);
    EXPECT_EQ(memory_->taken(), made->picture->memory.bytes());
}

TEST_F(PausedPicture, BetweenStepsWaitsForTheOneThatIsNotThere) {
    auto task = std::make_shared<ViewTask>(*taskOf(16));
    task->view.layers[0].towards = Towards{1, 0.5};
    for (const std::uint32_t step : {0U, 1U}) {
        const int before = counts_.begun;
        source_.missing_ = step;
        auto made = maker_.make(jobOf(task, false), history_);
        ASSERT_TRUE(made.ok()) << made.error().toString();
        EXPECT_TRUE(made->waits && !made->picture);
        source_.missing_ = ~0U;
        made = maker_.make(jobOf(task, false), history_);
        ASSERT_TRUE(made.ok() && made->picture);
        EXPECT_EQ(counts_.begun, before + 2) << "what was drawn before it waited is not drawn again";
    }
}

TEST_F(PausedPicture, IsDroppedForANewerView) {
    ASSERT_FALSE(maker_.make(jobOf(taskOf(16), true), history_)->picture);
    EXPECT_EQ(counts_.gone, 0);
    const auto made = maker_.make(jobOf(taskOf(4), false), history_);
    ASSERT_TRUE(made.ok() && made->picture);
    EXPECT_EQ(made->picture->picture.width, 4u);
    EXPECT_EQ(counts_.gone, 2);
}

TEST_F(PausedPicture, IsBegunAnewOnANewDevice) {
    const auto large = taskOf(16);
    ASSERT_FALSE(maker_.make(jobOf(large, true), history_)->picture);
    counts_.fails = true;
    // A device that failed twice is made anew.
    for (int times = 0; times < 2; ++times) EXPECT_FALSE(maker_.make(jobOf(taskOf(4), false), others_).ok());
    counts_.fails = false;
    const auto made = maker_.make(jobOf(large, false), history_);
    ASSERT_TRUE(made.ok() && made->picture);
    EXPECT_EQ(made->picture->picture.pixels[0], 3);
    EXPECT_EQ(counts_.devices, 2);
    EXPECT_EQ(counts_.begun, 4);
}

TEST_F(PausedPicture, IsCountedUntilItIsSent) {
    const auto large = taskOf(16);
    ASSERT_FALSE(maker_.make(jobOf(large, true), history_)->picture);
    const std::uint64_t most = memory_->taken();
    EXPECT_GE(most, 16u * 8 * 4);
    ASSERT_FALSE(maker_.make(jobOf(large, true), history_)->picture);
    EXPECT_EQ(memory_->taken(), most);
    auto made = maker_.make(jobOf(large, true), history_);
    ASSERT_TRUE(made->picture);
    EXPECT_GE(memory_->taken(), 16u * 8 * 4);
    made->picture.reset();
    EXPECT_EQ(memory_->taken(), 0u);
}

TEST_F(PausedPicture, WaitsWhileOthersHaveTheMemory) {
    auto others = *memory_->take(1 << 16);
    const auto large = taskOf(16);
    const auto made = maker_.make(jobOf(large, false), history_);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(made->waits && !made->picture && made->until);
    EXPECT_EQ(counts_.begun, 0);
    int told = 0;
    memory_->whenGivenBack([&] { ++told; });
    others = {};
    EXPECT_EQ(told, 1);
    EXPECT_TRUE(maker_.make(jobOf(large, false), history_)->picture);
}

TEST_F(PausedPicture, ThatTakesMoreThanThereIsIsRefusedBeforeItIsBegun) {
    const auto made = maker_.make(jobOf(taskOf(1 << 12), false), history_);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted);
    EXPECT_NE(made.error().message.find("4096 x 8 pixels"), std::string::npos) << made.error().message;
    EXPECT_EQ(counts_.begun, 0);
    EXPECT_EQ(memory_->taken(), 0u);
}

TEST_F(PausedPicture, IsPlannedInTurnsWhereThatTakesLong) {
    const auto inked = std::make_shared<ViewTask>(*taskOf(16));
    inked->view.layers[0].style = *parseInkStyle({}, glm::dvec3(0.0));
    const auto job = jobOf(inked, true);
    EXPECT_TRUE(isPlannedInTurns(job));
    EXPECT_FALSE(isPlannedInTurns(jobOf(inked, true, Stage::quick)));
    EXPECT_FALSE(isPlannedInTurns(jobOf(taskOf(16), true))) << "the device draws a volume";
    const auto make = [](PictureHistory& history, Making&) {
        history.exactPoints = 7.0;
        return Result<std::unique_ptr<Draft>>(std::make_unique<Draft>());
    };
    Planning planning(job, history_, make, render::WorkInTurns::Duration(0));
    EXPECT_TRUE(planning.advance({}));
    EXPECT_EQ(history_.exactPoints, 0.0);
    Making why;
    const auto draft = planning.take(history_, why);
    EXPECT_TRUE(draft.ok() && *draft);
    EXPECT_EQ(history_.exactPoints, 7.0);
}

TEST_F(PausedPicture, ThatIsStoppedBeforeItBeganLeavesNothing) {
    const auto large = taskOf(16);
    RenderJob job = jobOf(large, true);
    job.stop = pause_.get_token();
    ASSERT_FALSE(maker_.make(job, history_)->picture);
    EXPECT_EQ(history_.draft, nullptr);
    EXPECT_EQ(counts_.begun, 0);
}

}  // namespace
}  // namespace mote::server
