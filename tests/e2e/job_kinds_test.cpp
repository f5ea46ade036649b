// SPDX-License-Identifier: GPL-3.0-or-later
//
// Volumes and stipples as jobs that a client submits: their progress, their result in the catalogue and
// drawn, and what is left of one that was cancelled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/e2e/conversation.h"
#include "tests/e2e/station.h"
#include "tests/support/image.h"

namespace mote::test {
namespace {

using client::Connection;
using testing::Contains;
using testing::HasSubstr;

constexpr std::uint32_t side = 40;  // of a volume, voxels

/// A ball of descending values in a raw file.
void writeBallFile(const std::filesystem::path& file) {
    std::string voxels;
    for (std::uint32_t z = 0; z < side; ++z) {
        for (std::uint32_t y = 0; y < side; ++y) {
            for (std::uint32_t x = 0; x < side; ++x) {
                const auto off = [](std::uint32_t i) { return (i + 0.5) / side * 2.0 - 1.0; };
                const double r2 = off(x) * off(x) + off(y) * off(y) + off(z) * off(z);
                voxels.push_back(static_cast<char>(r2 < 0.6 ? 250.0 - 200.0 * r2 : 0.0));
            }
        }
    }
    std::ofstream(file, std::ios::binary) << voxels;
}

proto::JobRequest volumeRequest(const std::string& input, std::uint32_t samples) {
    proto::JobRequest request;
    request.set_output("data/volume.mote");
    auto& volume = *request.mutable_volume();
    volume.add_inputs(input);
    for (int axis = 0; axis < 3; ++axis) volume.mutable_source()->add_dimensions(samples);
    volume.set_low(10);
    volume.set_threshold(0.0);
    volume.set_representation("both");
    return request;
}

class JobKinds : public testing::Test {
  protected:
    void SetUp() override {
        station_.startServer();
        connection_.emplace(station_.connection(), client::ConnectionSettings{});
    }
    /// Of a picture of a view, those that are not black.
    int litPixels(const std::string& view) const {
        const auto done = station_.frames(scriptOf({view}));
        EXPECT_EQ(done.status, 0) << done.errors;
        if (done.status != 0) return 0;
        const auto image = readPng(station_.out() / "frame-000000.png").value();
        int lit = 0;
        for (std::size_t i = 0; i < image.pixels.size(); i += 4) lit += image.pixels[i] > 0 ? 1 : 0;
        return lit;
    }

    Station station_;
    std::optional<Connection> connection_;
};

TEST_F(JobKinds, AVolumeIsMadeListedAndDrawn) {
    writeBallFile(station_.root() / "ball.raw");
    std::vector<double> progress;
    const auto job =
        ended(*connection_, submit(*connection_, volumeRequest("data/ball.raw", side)), &progress);
    ASSERT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end())) << testing::PrintToString(progress);
    EXPECT_EQ(progress.back(), 1.0);
    EXPECT_THAT(datasets(*connection_), Contains("data/volume"));
    for (const std::string representation : {"points", "residual", "volume"}) {
        const auto lit = litPixels(
            "{'width': 80, 'height': 80, 'layers': [{'dataset': 'data/volume', 'hybrid': {'representation': "
            "'" +
            representation + "'}}]}");
        // The ball's disc has a diameter of more than a quarter of the fitted picture's.
        EXPECT_GT(lit, 300) << representation;
    }
}

TEST_F(JobKinds, AVolumesBadRequestNamesItsField) {
    writeBallFile(station_.root() / "ball.raw");
    auto request = volumeRequest("data/ball.raw", side);
    request.mutable_volume()->set_filter("sharp");
    const auto refused =
        answer<proto::JobStatus>(*connection_, [&](auto reply) { connection_->submitJob(request, reply); });
    if (refused.ok()) {
        const auto job = ended(*connection_, refused->id());
        EXPECT_EQ(job.state(), proto::JobStatus::FAILED);
        EXPECT_THAT(job.error(), HasSubstr("filter"));
    } else {
        EXPECT_THAT(refused.error().where, HasSubstr("filter"));
    }
    const auto job = ended(*connection_, submit(*connection_, volumeRequest("data/ball.raw", side + 1)));
    EXPECT_EQ(job.state(), proto::JobStatus::FAILED);
    EXPECT_THAT(job.error(), HasSubstr("bytes"));
}

TEST_F(JobKinds, ACancelledVolumeLeavesNothing) {
    constexpr std::uint32_t large = 512;  // takes seconds; a hole takes no room on the disk
    std::ofstream(station_.root() / "hole.raw").close();
    std::filesystem::resize_file(station_.root() / "hole.raw", std::uint64_t{large} * large * large);
    const auto before = namesIn(station_.root());
    const auto id = submit(*connection_, volumeRequest("data/hole.raw", large));
    EXPECT_EQ(reached(*connection_, id, proto::JobStatus::RUNNING).state(), proto::JobStatus::RUNNING);
    const auto cancelled =
        answer<proto::JobStatus>(*connection_, [&](auto reply) { connection_->cancelJob(id, reply); });
    ASSERT_TRUE(cancelled.ok()) << cancelled.error().toString();
    EXPECT_EQ(ended(*connection_, id).state(), proto::JobStatus::CANCELLED);
    EXPECT_EQ(namesIn(station_.root()), before);
    EXPECT_THAT(datasets(*connection_), testing::Not(Contains("data/volume")));
}

TEST_F(JobKinds, AStippledSurfaceIsMadeListedAndDrawn) {
    std::ofstream(station_.root() / "octahedron.obj")
        << "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
           "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    proto::JobRequest request;
    request.set_output("data/dots.mote");
    request.mutable_stipple()->set_mesh("data/octahedron.obj");
    request.mutable_stipple()->set_points(600);
    request.mutable_stipple()->set_seed(1);
    std::vector<double> progress;
    const auto job = ended(*connection_, submit(*connection_, request), &progress);
    ASSERT_EQ(job.state(), proto::JobStatus::SUCCEEDED) << job.error();
    EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end())) << testing::PrintToString(progress);
    EXPECT_THAT(datasets(*connection_), Contains("data/dots"));
    EXPECT_GT(litPixels("{'width': 120, 'height': 120, 'layers': [{'dataset': 'data/dots', 'stipple': {}}]}"),
              30);
}

}  // namespace
}  // namespace mote::test
