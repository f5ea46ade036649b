// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a user may get wrong: one clear error each, exit code not 0, nothing half-written, and the server goes
// on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <cstring>
#include <fstream>
#include <random>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "tests/e2e/station.h"
#include "tests/support/image.h"

namespace mote::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class BadInput : public testing::Test {
  protected:
    void SetUp() override { station_.startServer(); }
    void TearDown() override {
        const auto done = station_.frames(scriptOf({beamView(32)}));
        EXPECT_EQ(done.status, 0) << "the server did not go on: " << done.errors;
    }

    /// One line on stderr that holds all of `words`.
    static void expectError(const Finished& done, const std::vector<std::string>& words, int status = 1) {
        EXPECT_EQ(done.status, status) << done.errors;
        for (const auto& word : words) EXPECT_THAT(done.errors, HasSubstr(word));
        if (status == 1) {
            EXPECT_EQ(std::count(done.errors.begin(), done.errors.end(), '\n'), 1) << done.errors;
        }
        EXPECT_EQ(done.output, "");
    }

    Station station_;
};

TEST_F(BadInput, ScriptsNameTheirFault) {
    const std::pair<const char*, const char*> table[] = {
        {"", "script.json"},
        {"{'views': []}", "views"},
        {"{'views': [{'width': 32, 'height': 24, 'colour': 1}]}", "colour"},
        {"{'views': [{'width': 32, 'height': 24}, {'width': 0, 'height': 24}]}", "views[1].width"},
        {"{'views': [{'width': 100000, 'height': 24}]}", "views[0].width"},
        {"{'views': [{'width': 32, 'height': 24, 'camera': {'eye': [0, 0, 0], 'target': [0, 0, 0], 'up': [0, "
         "1, 0]}}]}",
         "views[0].camera"},
        {"{'keyframes': []}", "keyframes"},
    };
    for (const auto& [script, word] : table) expectError(station_.frames(script), {"script.json", word});
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(BadInput, DatasetsAndStepsThatAreNotThere) {
    // The good view before it is not drawn either.
    expectError(station_.frames(scriptOf({beamView(32), beamView(32, 0, 4, "data/none")})),
                {"script.json", "views[1].layers[0].dataset", "data/none", "data/beam"});
    expectError(station_.frames(scriptOf({beamView(32), beamView(32, 2)})),
                {"script.json", "views[1].layers[0].step", "2 steps"});
    expectError(station_.frames(scriptOf({beamView(32, 0, 4, "../etc")})), {"views[0].layers[0].dataset"});
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(BadInput, WrongUsage) {
    const auto script = scriptOf({beamView(32)});
    expectError(station_.frames(script, {"--format", "bmp"}),
                {"there are png, png16, exr, jpg, svg, eps and pdf"}, 2);
    expectError(station_.frames(script, {"--format", "pdf", "--page", "large"}), {"--page", "WIDTHxHEIGHT"},
                2);
    expectError(station_.frames(script, {"--format", "pdf", "--page", "20x20", "--margin", "10"}),
                {"--margin"}, 2);
    expectError(station_.frames(script, {"--plotter"}), {"need svg, eps or pdf"}, 2);
    expectError(station_.frames(script, {"--crf", "20"}), {"--crf", "--video"}, 2);
    expectError(station_.frames(script, {"--detach", "--fetch", "12"}), {"--detach"}, 2);
    expectError(station_.frames(script, {"--again"}), {"--again"}, 2);
    expectError(station_.frames(script, {"--detach", "--chroma", "quartered"}), {"--chroma"}, 2);
    expectError(station_.frames(script, {"--spawn", "data=x", "--connect", "y"}), {"--spawn"}, 2);
    expectError(runProcess(program("mote-frames"), {"--connect", "x"}), {"SCRIPT"}, 2);
    expectError(station_.frames(script, {"--no-such-option"}), {"no-such-option"}, 2);
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(BadInput, AWrongTokenOpensNothing) {
    auto file = *wire::readConnectionFile(station_.connection());
    file.set_token(std::string(file.token().size(), '0'));
    const auto wrong = station_.temporary() / "wrong.json";
    ASSERT_TRUE(wire::writeConnectionFile(wrong, file).ok());
    const auto script = station_.writeScript(scriptOf({beamView(32)}));
    expectError(runProcess(program("mote-frames"), {script, "--connect", wrong, "--out", station_.out()}),
                {"token"});
    expectError(
        runProcess(program("mote-frames"), {script, "--connect", "/no/file", "--out", station_.out()}),
        {"/no/file"});
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(BadInput, RandomBytesOnTheSocket) {
    const auto path = wire::parseAddress(wire::readConnectionFile(station_.connection())->address())->path;
    std::mt19937 random(5);
    for (int round = 0; round < 20; ++round) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
        const int file = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        ASSERT_EQ(::connect(file, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
        std::string bytes(round * 400, '\0');
        for (auto& byte : bytes) byte = static_cast<char>(random());
        if (round % 2 == 0) bytes.insert(0, std::string("MOTE\1\0\0\0", 8));
        ::send(file, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        ::close(file);
    }
}

TEST_F(BadInput, AFlippedBitIsSaidAndNotDrawn) {
    std::filesystem::copy(station_.root() / "beam.mote", station_.root() / "broken.mote");
    const auto step = station_.root() / "broken.mote" / "step-000000.h5";
    auto bytes = bytesOf(step);
    // In what is drawn: the octree lies first.
    const auto place = bytes.size() / 50;
    bytes[place] = static_cast<char>(bytes[place] ^ 4);
    std::ofstream(step, std::ios::binary) << bytes;
    // Known from the next start on at the latest.
    station_.server().signal(SIGTERM);
    ASSERT_EQ(station_.server().wait(), 0);
    station_.startServer();
    const auto done = station_.frames(scriptOf({beamView(32), beamView(32, 0, 4, "data/broken")}));
    expectError(done, {"views[1]", "step-000000.h5"});
    EXPECT_THAT(done.errors, testing::ContainsRegex("/(octree|leaves|points|volume)/"));
    EXPECT_EQ(namesIn(station_.out()), std::vector<std::string>{"frame-000000.png"});
}

TEST_F(BadInput, AFullDisk) {
    // A file may have 4 KiB: the first picture of noise is larger.
    const auto done = station_.frames(scriptOf({beamView(320)}), {}, {{}, 4096});
    expectError(done, {"frame-000000.png", "too large"});
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(BadInput, AReallyFullDisk) {
    if (runProcess("/usr/bin/unshare", {"-rm", "mount", "-t", "tmpfs", "none", station_.temporary()})
            .status != 0) {
        GTEST_SKIP() << "no file system can be mounted here";
    }
    const auto script = station_.writeScript(scriptOf({beamView(320), beamView(320, 1)}));
    const auto out = station_.temporary().string();
    // One page is less than one picture.
    const auto command = "mount -t tmpfs -o size=4k none '" + out + "' && '" +
                         program("mote-frames").string() + "' '" + script.string() + "' --connect '" +
                         station_.connection().string() + "' --out '" + out + "'; status=$?; ls -A '" + out +
                         "'; exit $status";
    const auto done = runProcess("/usr/bin/unshare", {"-rm", "sh", "-c", command});
    expectError(done, {"frame-000000.png", "No space left"});
}

TEST_F(BadInput, OutputsThatCannotBe) {
    const auto script = station_.writeScript(scriptOf({beamView(32)}));
    const auto frames = [&](const std::filesystem::path& out) {
        return runProcess(program("mote-frames"), {script, "--connect", station_.connection(), "--out", out});
    };
    expectError(frames(script), {"script.json"});
    expectError(frames("/proc/none/out"), {"/proc/none/out"});
    std::filesystem::create_directories(station_.temporary() / "frame-000000.png");
    expectError(frames(station_.temporary()), {"frame-000000.png"});
    EXPECT_EQ(namesIn(station_.temporary()), std::vector<std::string>{"frame-000000.png"});
}

// Volumes and stipples as jobs that a client submits: their progress, their result in the catalogue and
// drawn, and what is left of one that was cancelled.

using client::Connection;
using testing::Contains;

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
    EXPECT_GT(litPixels("{'width': 120, 'height': 120, 'background': [0, 0, 0], 'layers': [{'dataset': "
                        "'data/dots', 'stipple': {}}]}"),
              30);
}

}  // namespace
}  // namespace mote::test
