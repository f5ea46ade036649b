// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures of stipple and mesh layers wait until their data are there, which are read by other threads than
// the one that makes pictures, and counted.
#include <gmock/gmock.h>

#include <filesystem>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "server/data/load_image.h"
#include "server/data/load_mesh.h"
#include "server/data/load_stipple.h"
#include "server/frames/picture_maker.h"
#include "storage/dataset_writer.h"
#include "storage/image/image_file.h"
#include "storage/manifest.h"
#include "tests/support/ball_surface.h"
#include "tests/support/temp_dir.h"
#include "tests/support/view_text.h"
#include "tests/unit/frames/fake_device.h"
#include "tests/unit/frames/gated_source.h"
#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::server {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::Not;

void writeImage(const std::filesystem::path& output) {
    const storage::Luminance picture{2, 2, {0.0F, 0.3F, 0.6F, 1.0F}};
    proto::Manifest manifest;
    manifest.set_kind("image");
    manifest.set_format(1);
    manifest.mutable_image()->set_width(2);
    manifest.mutable_image()->set_height(2);
    manifest.mutable_image()->set_color_space("linear");
    auto writer = storage::DatasetWriter::create(output);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(storage::writeImage(writer->directory(), picture).ok());
    for (const char* file : {"image.h5", "image.digest"}) ASSERT_TRUE(writer->add(file).ok());
    ASSERT_TRUE(writer->publish(manifest).ok());
}

class StippleWaiting : public testing::Test {
  protected:
    StippleWaiting() {
        test::writeBall(data_ / "ball.mote", 3000);
        test::writeBallMesh(data_ / "solid.mote");
        const auto plane = test::jitteredGrid(40);
        test::writeDataset(data_ / "plane.mote", plane, test::manifestOf(plane));
        writeImage(data_ / "image.mote");
        for (const char* name : {"ball", "solid", "plane", "image"}) EXPECT_TRUE(source_.dataset(name).ok());
    }
    Result<Making> make(const std::string& layers, Stage stage) {
        auto task = std::make_shared<ViewTask>();
        task->view = test::viewOf("{'width': 60, 'height': 40, 'layers': [" + layers + "]}");
        return maker_.make({.session = 1, .task = task, .stage = stage, .stop = {}}, history_);
    }
    /// While the files are away and nothing can be read, the picture waits; then it is there.
    void expectWaits(const std::string& layers, Stage stage) {
        std::filesystem::rename(data_, away_);
        const auto first = make(layers, stage);
        ASSERT_TRUE(first.ok()) << first.error().toString();
        EXPECT_TRUE(first->waits);
        EXPECT_FALSE(first->picture);
        std::filesystem::rename(away_, data_);
        source_.open();
        source_.awaitRest();
        const auto then = make(layers, stage);
        ASSERT_TRUE(then.ok()) << then.error().toString();
        ASSERT_TRUE(then->picture);
        EXPECT_THAT(source_.threads(), Each(Not(std::this_thread::get_id())));
    }
    template <class T>
    std::uint64_t bytesOf(const Result<Loadable<T>>& what) {
        const auto loaded = what->load(0, [] { return false; });
        EXPECT_LE(loaded->bytes, what->expected(0)) << "an estimate of what it takes at most";
        EXPECT_GE(4 * loaded->bytes, what->expected(0)) << "and not far from it";
        return loaded->bytes;
    }

    test::TempDir folder_;
    const std::filesystem::path data_ = folder_ / "data", away_ = folder_ / "away";
    const bool made_ = std::filesystem::create_directory(data_);
    GatedSource source_{data_};
    std::shared_ptr<test::FakeControl> control_ = std::make_shared<test::FakeControl>();
    PictureMaker maker_{[this] { return std::make_unique<test::FakeDevice>(control_); }, source_,
                        render::DeviceCosts{}};
    PictureHistory history_{QualityController(30.0)};
};

const std::string ball = "{'dataset': 'ball', 'stipple': {'spacingPixels': 3}}";
const std::string photograph = "{'dataset': 'plane', 'stipple': {'image': 'image'}}";

TEST_F(StippleWaiting, ASurfaceIsNotReadByTheThreadThatDraws) {
    expectWaits(ball, Stage::exact);
    EXPECT_EQ(source_.threads().size(), 1U);
    EXPECT_EQ(source_.counted(), bytesOf(stippleSurface(*source_.dataset("ball"))));
}

TEST_F(StippleWaiting, NorAPhotograph) {
    expectWaits(photograph, Stage::exact);
    EXPECT_EQ(source_.threads().size(), 2U);
    EXPECT_EQ(source_.counted(), bytesOf(stipplePlane(*source_.dataset("plane"))) +
                                     bytesOf(imageLuminance(*source_.dataset("image"))));
}

TEST_F(StippleWaiting, NorAMesh) {
    expectWaits("{'dataset': 'solid', 'mesh': {}}", Stage::exact);
    EXPECT_EQ(source_.threads().size(), 1U);
    EXPECT_EQ(source_.counted(), bytesOf(meshSurface(*source_.dataset("solid"))));
}

TEST_F(StippleWaiting, NorAnImage) {
    expectWaits("{'dataset': 'image', 'image': {}}", Stage::quick);
    EXPECT_EQ(source_.threads().size(), 1U);
    EXPECT_EQ(source_.counted(), bytesOf(imageColors(*source_.dataset("image"))));
}

TEST_F(StippleWaiting, AViewInMotionWaitsForAllOfItsLayersAtOnce) {
    expectWaits(ball + ", " + photograph, Stage::quick);
    EXPECT_EQ(source_.threads().size(), 3U);
}

TEST_F(StippleWaiting, SoDoesWhatStipplesADrawing) {
    source_.open();
    const auto layers = "{'dataset': 'plane', 'stipple': {'source': 'layers'}}";
    const auto first = make(layers, Stage::exact);
    ASSERT_TRUE(first.ok()) << first.error().toString();
    EXPECT_TRUE(first->waits);
    source_.awaitRest();
    EXPECT_TRUE(make(layers, Stage::exact)->picture);
}

/// Pictures of the cpu device that are planned in turns, each as short as can be.
class PlannedInTurns : public StippleWaiting {
  protected:
    PlannedInTurns() {
        source_.open();
        others_.request_stop();
    }
    static std::shared_ptr<const ViewTask> taskOf(const std::string& layers) {
        auto task = std::make_shared<ViewTask>();
        task->view = test::viewOf("{'width': 60, 'height': 40, 'layers': [" + layers + "]}");
        return task;
    }
    /// What comes of one turn, once its data are there.
    Making turn(PictureMaker& maker, const std::shared_ptr<const ViewTask>& task, PictureHistory& history,
                const std::stop_token& pause) {
        for (;;) {
            auto made = maker.make(
                {.session = 1, .task = task, .stage = Stage::exact, .stop = {}, .pause = pause}, history);
            if (!made.ok()) throw std::runtime_error(made.error().toString());
            if (!made->waits) return *std::move(made);
            source_.awaitRest();
        }
    }
    std::vector<std::uint8_t> drawnAtOnce(PictureMaker& maker, const std::string& layers) {
        return turn(maker, taskOf(layers), another_, {}).picture.value().picture.pixels;
    }

    std::stop_source others_;
    const DeviceFactory cpu_ = [] { return render::createDevice(render::DeviceKind::cpu, 2); };
    std::shared_ptr<PictureMemory> memory_ = std::make_shared<PictureMemory>(1 << 24, nullptr);
    PictureMaker inTurns_{cpu_, source_, render::DeviceCosts{}, render::WorkInTurns::Duration(0), memory_};
    PictureMaker expected_{cpu_, source_, render::DeviceCosts{}};  // which keeps what it made to itself
    PictureHistory another_{QualityController(30.0)};
};

const std::string mesh = "{'dataset': 'solid', 'mesh': {}}";
const std::string inked = "{'dataset': 'solid', 'ink': {'hatch': {'strength': 1}}}";
const std::string stippled = mesh + ", {'dataset': 'plane', 'stipple': {'source': 'layers'}}";

TEST_F(PlannedInTurns, SurfacesInkAndDotsThatGaveWayAreTheSameBytes) {
    const auto between = drawnAtOnce(expected_, ball);
    for (const auto& layers : {ball, photograph, mesh, inked, stippled, mesh + ", " + inked}) {
        const auto expected = drawnAtOnce(expected_, layers);
        const auto task = taskOf(layers);
        Making made;
        int turns = 0;
        for (; !made.picture; ++turns) {
            made = turn(inTurns_, task, history_, others_.get_token());
            // Others' pictures, of the same data too, leave no trace in it.
            const bool other = turns % 256 == 1;
            if (!other && turns % 256 != 33) continue;
            EXPECT_TRUE(drawnAtOnce(inTurns_, other ? ball : layers) == (other ? between : expected))
                << layers;
        }
        EXPECT_TRUE(made.picture->picture.pixels == expected) << layers;
        EXPECT_GT(turns, layers == mesh ? 1 : 3) << layers;
    }
}

TEST_F(PlannedInTurns, IsGivenUpWhereverItIs) {
    for (const auto& layers : {photograph, mesh, inked, stippled}) {
        // Step by step where lists are made, then further and further apart.
        for (int turns = 1, all = 1 << 12; turns < all; turns += 1 + turns / 16) {
            const auto task = taskOf(layers);
            for (int i = 0; i < turns; ++i) {
                if (turn(inTurns_, task, history_, others_.get_token()).picture) all = turns;
            }
            history_.draft.reset();
        }
    }
}

TEST_F(PlannedInTurns, APlanThatNobodyWantsAnyMoreIsGivenUp) {
    const auto expected = drawnAtOnce(inTurns_, mesh);
    EXPECT_FALSE(turn(inTurns_, taskOf(inked), history_, others_.get_token()).picture);
    ASSERT_NE(history_.draft, nullptr);
    EXPECT_GT(memory_->taken(), 0U) << "what it may need is counted while it waits";
    EXPECT_EQ(turn(inTurns_, taskOf(mesh), history_, {}).picture.value().picture.pixels, expected);
    EXPECT_EQ(history_.draft, nullptr);
    EXPECT_EQ(memory_->taken(), 0U);
}

TEST_F(StippleWaiting, WrongDatasetsAreSaidAtOnce) {
    const auto expectError = [&](const std::string& layers, const std::string& where,
                                 const std::string& text) {
        const auto made = make(layers, Stage::exact);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().where, "layers[0]." + where);
        EXPECT_THAT(made.error().message, HasSubstr(text));
    };
    expectError("{'dataset': 'none', 'stipple': {}}", "dataset", "none");
    expectError("{'dataset': 'image', 'stipple': {}}", "dataset", "not a stipple hierarchy");
    expectError("{'dataset': 'ball', 'image': {}}", "dataset", "not an image");
    expectError("{'dataset': 'plane', 'stipple': {}}", "dataset", "an image, which is not given");
    expectError("{'dataset': 'ball', 'stipple': {'image': 'image'}}", "dataset", "of the plane");
    expectError("{'dataset': 'image', 'mesh': {}}", "dataset", "not a mesh");
    expectError("{'dataset': 'plane', 'mesh': {}}", "dataset", "there is no mesh");
    expectError("{'dataset': 'plane', 'stipple': {'image': 'none'}}", "stipple.image", "none");
    expectError("{'dataset': 'plane', 'stipple': {'image': 'ball'}}", "stipple.image", "not an image");
}

TEST_F(StippleWaiting, DamageIsSaidWhereTheDataWereAskedFor) {
    source_.open();
    std::filesystem::resize_file(data_ / "ball.mote" / "mesh.h5", 5000);
    auto failed = make(ball, Stage::quick);
    if (failed.ok()) {  // it had not been read yet
        EXPECT_TRUE(failed->waits);
        source_.awaitRest();
        failed = make(ball, Stage::quick);
    }
    ASSERT_FALSE(failed.ok());
    EXPECT_THAT(failed.error().where, HasSubstr("mesh.h5"));
    EXPECT_EQ(source_.counted(), 0U);
}

}  // namespace
}  // namespace mote::server
