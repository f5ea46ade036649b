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
    expectError(station_.frames(script, {"--detach", "--chroma", "halved"}), {"--chroma"}, 2);
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

}  // namespace
}  // namespace mote::test
