// SPDX-License-Identifier: GPL-3.0-or-later
//
// A picture of a film that is stopped, however often, becomes what it would have been: ink that follows the
// picture before it must not follow the one that was not finished.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "server/data/load_mesh.h"
#include "server/frames/picture_maker.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
#include "tests/support/view_text.h"
#include "tests/unit/frames/fake_device.h"

namespace mote::server {
namespace {

/// Quads in a ball, each with borders all around: many lines to choose from.
std::shared_ptr<const render::MeshSurface> leaves() {
    test::Random random(3);
    storage::SurfaceMesh mesh;
    for (std::uint32_t i = 0; i < 800; ++i) {
        const glm::dvec3 middle = std::cbrt(random.between(0.0, 1.0)) * random.direction();
        const glm::dvec3 normal = random.direction();
        const glm::dvec3 right = 0.06 * glm::normalize(glm::cross(normal, random.direction()));
        const glm::dvec3 up = glm::cross(normal, right);
        for (const auto& at : {-right - up, right - up, right + up, up - right}) {
            mesh.positions.emplace_back(middle + at);
            mesh.normals.emplace_back(normal);
        }
        mesh.triangles.push_back({4 * i, 4 * i + 1, 4 * i + 2});
        mesh.triangles.push_back({4 * i, 4 * i + 2, 4 * i + 3});
    }
    mesh.edges = test::edgesOf(mesh);
    const Bounds bounds{glm::dvec3(-1.2), glm::dvec3(1.2)};
    return std::make_shared<const render::MeshSurface>(std::move(mesh), bounds);
}

/// The one mesh, always there.
class LeavesSource final : public StepSource {
  public:
    Result<storage::Catalogue::Entry> dataset(const std::string& name) override {
        return storage::Catalogue::Entry{name, "/nowhere", manifest_};
    }
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& name,
                                                              std::uint32_t) override {
        return Error{ErrorCode::notFound, "dataset", name};
    }
    Result<Resident> resident(const AnyLoadable&) override { return Resident{leaves_, 1}; }

  private:
    static std::shared_ptr<const proto::Manifest> meshManifest() {
        auto manifest = std::make_shared<proto::Manifest>();
        manifest->set_kind("mesh");
        manifest->mutable_mesh();
        return manifest;
    }
    std::shared_ptr<const proto::Manifest> manifest_ = meshManifest();
    std::shared_ptr<const render::MeshSurface> leaves_ = leaves();
};

class RepeatedPicture : public testing::Test {
  protected:
    /// A view of a turn, as a document: what is drawn of it stays strokes.
    static std::shared_ptr<const ViewTask> taskOf(int frame) {
        const double angle = 0.01 * frame;
        auto task = std::make_shared<ViewTask>();
        task->view = test::viewOf(
            "{'width': 160, 'height': 160, 'background': [1, 1, 1], 'camera': {'eye': [" +
            std::to_string(8.0 * std::sin(angle)) + ", 0.5, " + std::to_string(8.0 * std::cos(angle)) +
            "], 'target': [0, 0, 0], 'up': [0, 1, 0], 'fovYDegrees': 20}, "
            "'layers': [{'dataset': 'data/leaves', 'ink': {'coherent': true, 'hatch': {'strength': 1}}}]}");
        task->finalOnly = task->queued = true;
        task->page = Page{};
        return task;
    }

    struct Maker {
        LeavesSource source;
        std::shared_ptr<test::FakeControl> control = std::make_shared<test::FakeControl>();
        PictureMaker maker{[this] { return std::make_unique<test::FakeDevice>(control); }, source,
                           render::DeviceCosts{}};
        PictureHistory history{QualityController(30.0)};

        std::vector<render::Strokes> make(int frame) {
            const auto made =
                maker.make({.session = 1, .task = taskOf(frame), .stage = Stage::exact, .stop = {}}, history);
            if (!made.ok()) throw std::runtime_error(made.error().toString());
            std::vector<render::Strokes> strokes;
            for (const auto& layer : made->picture->strokes) strokes.push_back(*layer);
            return strokes;
        }

        /// Stops it when all is planned and the device has begun.
        void stopInTheMidst(int frame) {
            control->closeGate();
            const auto begun = control->renders().size();
            std::stop_source stop;
            std::thread stopper([&] {
                control->awaitBegun(begun + 1);
                stop.request_stop();
            });
            const auto made = maker.make(
                {.session = 1, .task = taskOf(frame), .stage = Stage::exact, .stop = stop.get_token()},
                history);
            stopper.join();
            control->openGate();
            EXPECT_TRUE(made.ok() && !made->picture);
        }
    };
};

TEST_F(RepeatedPicture, IsTheSameHoweverOftenItWasStopped) {
    Maker undisturbed, disturbed;
    for (int frame = 0; frame < 6; ++frame) {
        const auto wanted = undisturbed.make(frame);
        ASSERT_FALSE(wanted.empty());
        for (int times = 0; times < frame % 3; ++times) disturbed.stopInTheMidst(frame);
        EXPECT_EQ(disturbed.make(frame), wanted) << frame;
    }
}

}  // namespace
}  // namespace mote::server
