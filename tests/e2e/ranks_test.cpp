// SPDX-License-Identifier: GPL-3.0-or-later
//
// A server of several ranks under the real mpirun: its pictures, its end, and what becomes of it when a rank
// is lost or cannot read what the first one reads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include "client/shared/connection.h"
#include "protocol/wire/connection_file.h"
#include "tests/e2e/station.h"
#include "tests/golden/comparison.h"
#include "tests/unit/hybrid/small_hybrid.h"

namespace mote::test {
namespace {

using testing::HasSubstr;

bool mpirunIsThere() {
    return std::filesystem::exists("/usr/bin/mpirun");
}

/// Of a view without its braces: what it shows, and how.
std::string viewOf(const std::string& camera, const std::vector<std::string>& layers) {
    std::string text = "{'width': 320, 'height': 240, 'camera': " + camera + ", 'layers': [";
    for (std::size_t i = 0; i < layers.size(); ++i) text += (i == 0 ? "" : ", ") + layers[i];
    return text + "]}";
}

std::string layerOf(int step, const std::string& particles) {
    return "{'dataset': 'data/beam', 'step': " + std::to_string(step) + ", 'particles': " + particles + "}";
}

/// A hybrid volume, cut and lit from one side.
std::string hybridView(const std::string& representation) {
    return "{'width': 320, 'height': 240, 'layers': [{'dataset': 'data/small', 'hybrid': {'representation': "
           "'" +
           representation +
           "', 'curve': [{'value': -10, 'opacity': 0.001}, {'value': 245, 'opacity': 0.9}], 'clipPlanes': "
           "[{'normal': [1, 0, 0], 'distance': 20}], 'light': {'direction': [1, 0, 0], 'specular': 0.4}}}]}";
}

/// A layer of what a lasso surrounds that was drawn in another plot.
std::string lassoed(const std::string& layer) {
    return "{'select': {'lasso': {'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}, 'aspect': 1.5, "
           "'points': "
           "[[0.3, 0.3], [0.6, 0.3], [0.5, 0.8]], 'axes': ['x', 'r', 'z'], 'bounds': [[-0.01, 0.01], [0, "
           "0.02], "
           "[-0.1, 0.1]]}}, " +
           layer.substr(1);
}

/// Points alone, discs alone, points and volume, two layers, without perspective, from within; hybrid
/// volumes; a hidden layer and what a lasso holds.
std::string allKinds() {
    const std::string far = "{'eye': [2, 1, 3], 'target': [0, 0, 0], 'up': [0, 1, 0]}";
    const std::string near = "{'eye': [0.2, 0.1, 0.6], 'target': [0, 0, 0], 'up': [0, 1, 0]}";
    const std::string flat =
        "{'eye': [2, 1, 3], 'target': [0, 0, 0], 'up': [0, 1, 0], 'orthographicHeight': 2.5}";
    const std::string points =
        "{'volume': {'curve': [{'density': 0, 'opacity': 0}]}, 'points': {'linked': false, 'curve': "
        "[{'density': 0, 'fraction': 1}], 'opacity': 0.3}}";
    const std::string discs =
        "{'volume': {'curve': [{'density': 0, 'opacity': 0}]}, "
        "'points': {'linked': false, 'curve': [{'density': 0, 'fraction': 1}], 'opacity': 0.3, 'sizePixels': "
        "3.5}}";
    const std::string mixed =
        "{'volume': {'curve': [{'density': 0.4, 'opacity': 0}, {'density': 0.8, 'opacity': 0.3}]}, "
        "'points': {'linked': false, 'curve': [{'density': 0, 'fraction': 1}], 'opacity': 0.6}}";
    return scriptOf(
        {viewOf(far, {layerOf(0, points)}), viewOf(far, {layerOf(0, discs)}),
         viewOf(far, {layerOf(0, mixed)}), viewOf(far, {layerOf(0, mixed), layerOf(1, discs)}),
         viewOf(flat, {layerOf(1, mixed)}), viewOf(near, {layerOf(0, mixed)}), hybridView("residual"),
         hybridView("points"),
         viewOf(far, {"{'hidden': true, " + layerOf(1, discs).substr(1), lassoed(layerOf(0, mixed))})});
}

std::vector<Image> picturesOf(Station& station) {
    const auto done = station.frames(allKinds());
    if (done.status != 0) throw std::runtime_error("mote-frames: " + done.errors);
    std::vector<Image> images;
    for (const auto& name : namesIn(station.out())) images.push_back(readPng(station.out() / name).value());
    return images;
}

/// The process of a rank, a child of mpirun.
pid_t processOf(const Process& mpirun, int rank) {
    const auto parent = std::to_string(mpirun.id());
    std::ifstream children("/proc/" + parent + "/task/" + parent + "/children");
    const std::string wanted = "OMPI_COMM_WORLD_RANK=" + std::to_string(rank);
    for (pid_t child = 0; children >> child;) {
        std::ifstream environment("/proc/" + std::to_string(child) + "/environ");
        for (std::string entry; std::getline(environment, entry, '\0');)
            if (entry == wanted) return child;
    }
    throw std::runtime_error("rank " + std::to_string(rank) + " is not there");
}

pid_t serverOf(const Station& station) {
    return static_cast<pid_t>(wire::readConnectionFile(station.connection()).value().pid());
}

class Ranks : public testing::Test {
  protected:
    void SetUp() override {
        if (!mpirunIsThere()) GTEST_SKIP() << "there is no mpirun";
    }
};

class RanksPictures : public Ranks, public testing::WithParamInterface<int> {};

TEST_P(RanksPictures, AreThoseOfOneProcess) {
    Station alone, together;
    for (const Station* station : {&alone, &together})
        writeSmallHybrid(station->root() / "small.mote", smallPoints(5), smallManifest(5, 8));
    alone.startServer();
    together.startRanks(GetParam());
    const auto expected = picturesOf(alone), actual = picturesOf(together);
    ASSERT_EQ(expected.size(), 9u);
    ASSERT_EQ(actual.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        // Sums in another order: ranked_device_test.cpp says why they are one step apart at most.
        const auto result = compare(actual[i], expected[i]);
        EXPECT_TRUE(result.sameShape) << "picture " << i;
        EXPECT_LE(result.worst, 1) << "picture " << i << ": " << result.toString();
    }
    EXPECT_EQ(actual[0], expected[0]) << "of points alone, whole numbers are added";
    for (const std::size_t hybrid : {6u, 7u})
        EXPECT_EQ(actual[hybrid], expected[hybrid]) << "each rank draws its tiles as one alone does";
    ::kill(serverOf(together), SIGTERM);
    EXPECT_EQ(together.server().wait(), 0) << together.server().errors();
    EXPECT_FALSE(std::filesystem::exists(together.connection()));
}

INSTANTIATE_TEST_SUITE_P(Sizes, RanksPictures, testing::Values(1, 2, 4));

TEST_F(Ranks, ALostRankEndsThemAll) {
    Station station;
    station.startRanks(3);
    const pid_t first = serverOf(station);
    ::kill(processOf(station.server(), 1), SIGKILL);
    const auto status = station.server().wait();
    ASSERT_TRUE(status.has_value());
    EXPECT_NE(*status, 0);
    EXPECT_TRUE(waitForEnd(first));
    EXPECT_NE(station.frames(scriptOf({beamView(64)})).status, 0);
}

TEST_F(Ranks, ARankThatSeesOtherFilesFailsTheViewAndNoMore) {
    Station station, elsewhere;
    std::filesystem::remove_all(elsewhere.root() / "beam.mote");
    std::filesystem::copy(station.root() / "beam.mote", station.root() / "both.mote",
                          std::filesystem::copy_options::recursive);
    std::filesystem::copy(station.root() / "both.mote", elsewhere.root() / "both.mote",
                          std::filesystem::copy_options::recursive);
    station.startRanks(1, {elsewhere.root()});
    const auto failed = station.frames(scriptOf({beamView(64)}));
    EXPECT_NE(failed.status, 0);
    EXPECT_THAT(failed.errors, HasSubstr("rank 1: "));
    EXPECT_THAT(failed.errors, HasSubstr("beam.mote"));
    const auto drawn = station.frames(scriptOf({beamView(64, 0, 4.0, "data/both")}));
    EXPECT_EQ(drawn.status, 0) << drawn.errors;
}

TEST_F(Ranks, JobsAreNoneOfThem) {
    Station station;
    station.startRanks(2);
    client::Connection connection(station.connection(), {});
    proto::JobRequest request;
    request.set_output("data/more.mote");
    request.mutable_particles()->add_inputs("data/run.h5");
    for (const char* axis : {"x", "y", "z"}) request.mutable_particles()->add_axes(axis);
    proto::JobStatus latest;
    connection.onJob([&](const proto::JobStatus& status) { latest = status; });
    connection.watchJobs([](const auto&) {});
    connection.submitJob(request, [](const auto& job) { EXPECT_TRUE(job.ok()); });
    const auto end = std::chrono::steady_clock::now() + Process::patience;
    while (latest.state() < proto::JobStatus::SUCCEEDED && std::chrono::steady_clock::now() < end) {
        connection.wait(std::chrono::milliseconds(50));
        connection.poll();
    }
    EXPECT_EQ(latest.state(), proto::JobStatus::SUCCEEDED) << latest.error();
}

}  // namespace
}  // namespace mote::test
