// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-frames --spawn: a private server that leaves nothing behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "protocol/wire/connection_file.h"
#include "tests/e2e/station.h"

namespace mote::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class Spawn : public testing::Test {
  protected:
    ProcessOptions options() const { return {{{"TMPDIR", station_.temporary().string()}}, {}}; }
    std::vector<std::string> spawn(std::vector<std::string> more = {}) const {
        more.insert(more.end(), {"--spawn", "data=" + station_.root().string()});
        return more;
    }

    /// A script that takes long enough to be interrupted: a minute and more on any device.
    static std::string longScript() {
        std::vector<std::string> views;
        for (int i = 0; i < 5000; ++i) views.push_back(beamView(320, i % 2, 3.0 + 0.0001 * i));
        return scriptOf(views);
    }

    /// The private server's process, while mote-frames runs.
    pid_t serverOf() const {
        for (const auto& name : namesIn(station_.temporary())) {
            const auto file = wire::readConnectionFile(station_.temporary() / name / "connection.json");
            if (file.ok()) return static_cast<pid_t>(file->pid());
        }
        ADD_FAILURE() << "no private server to be found";
        return -1;
    }

    Station station_;
};

TEST_F(Spawn, DrawsTheSameBytesAsAServerThatRuns) {
    const auto script = scriptOf({beamView(160), beamView(160, 1)});
    const auto done = station_.frames(script, spawn(), options());
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_EQ(done.output, "");
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
    const auto first = bytesOf(station_.out() / "frame-000000.png");
    EXPECT_FALSE(first.empty());
    station_.startServer();
    ASSERT_EQ(station_.frames(script).status, 0);
    EXPECT_EQ(bytesOf(station_.out() / "frame-000000.png"), first);
}

TEST_F(Spawn, TakesSeveralRootsAndADevice) {
    const auto second = station_.root() / "inner";
    std::filesystem::create_directory(second);
    std::filesystem::rename(station_.root() / "beam.mote", second / "moved.mote");
    const auto done =
        station_.frames(scriptOf({beamView(32, 0, 4, "more/moved")}),
                        spawn({"--spawn", "more=" + second.string(), "--device", "egl"}), options());
    EXPECT_EQ(done.status, 0) << done.errors;
    const auto wrong = station_.frames(scriptOf({beamView(32)}), spawn({"--device", "abacus"}), options());
    EXPECT_NE(wrong.status, 0);
    EXPECT_THAT(wrong.errors, HasSubstr("abacus"));
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
}

TEST_F(Spawn, CleansUpAfterErrors) {
    const auto done = station_.frames(scriptOf({beamView(32, 0, 4, "data/none")}), spawn(), options());
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("views[0].layers[0].dataset"));
    const auto root =
        station_.frames(scriptOf({beamView(32)}), {"--spawn", "data=/no/such/folder"}, options());
    EXPECT_EQ(root.status, 1);
    EXPECT_THAT(root.errors, HasSubstr("/no/such/folder"));
    EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
    EXPECT_FALSE(std::filesystem::exists(station_.out()));
}

TEST_F(Spawn, CleansUpAfterCtrlC) {
    for (const int signal : {SIGINT, SIGTERM}) {
        Process frames(program("mote-frames"), station_.framesArguments(longScript(), spawn({"--json"})),
                       options());
        ASSERT_TRUE(frames.waitForOutput("\n")) << frames.errors();
        const pid_t server = serverOf();
        frames.signal(signal);
        EXPECT_EQ(frames.wait(), 128 + signal);
        EXPECT_THAT(namesIn(station_.temporary()), IsEmpty());
        EXPECT_EQ(::kill(server, 0), -1) << "the private server still runs";
        // What was finished stays, and is whole.
        const auto names = namesIn(station_.out());
        ASSERT_FALSE(names.empty());
        for (const auto& name : names) EXPECT_THAT(name, testing::StartsWith("frame-"));
    }
}

TEST_F(Spawn, TheServerEndsWhereItsClientIsKilled) {
    Process frames(program("mote-frames"), station_.framesArguments(longScript(), spawn({"--json"})),
                   options());
    ASSERT_TRUE(frames.waitForOutput("\n")) << frames.errors();
    const pid_t server = serverOf();
    frames.signal(SIGKILL);
    frames.wait();
    EXPECT_TRUE(waitForEnd(server));
}

}  // namespace
}  // namespace mote::test
