// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views that break a server, and what everybody else sees of it: next to nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "protocol/wire/connection_file.h"
#include "tests/e2e/orbiters.h"
#include "tests/e2e/station.h"

namespace mote::test {
namespace {

using client::Connection;
using testing::HasSubstr;

/// The bar on a quiet machine is a second (docs/PERFORMANCE.md); tests run beside others.
constexpr Orbiters::Seconds longestGap{4.0};

constexpr int deadlyWidth = 13, brokenWidth = 17;

proto::View plain(std::uint32_t width) {
    proto::View view;
    view.set_width(width);
    view.set_height(16);
    return view;
}

class Survival : public testing::Test {
  protected:
    Survival() { station_.startServer("test-deadly-server"); }

    pid_t servingProcess() const {
        return static_cast<pid_t>(wire::readConnectionFile(station_.connection()).value().pid());
    }

    /// What a client that asks for this view is told in the end.
    std::string refusal(const proto::View& view) {
        Connection connection(station_.connection(), {});
        std::string said;
        connection.onViewFailed([&](std::uint64_t, const Error& error) { said = error.toString(); });
        connection.setView(view, {});
        EXPECT_TRUE(eventually(connection, [&] { return !said.empty(); }));
        EXPECT_EQ(connection.state(), Connection::State::connected);
        return said;
    }

    Station station_;
};

TEST_F(Survival, AViewThatEndsTheServerTwiceIsRefusedAndOthersGoOn) {
    Orbiters others(station_.connection(), beamView(160), 4);
    ASSERT_TRUE(others.awaitPictures(5));
    EXPECT_THAT(refusal(plain(deadlyWidth)), HasSubstr("not drawn again"));
    ASSERT_TRUE(others.awaitPictures(5));
    const auto gap = others.longestGap();
    EXPECT_EQ(others.complaint(), "");
    EXPECT_LT(gap, longestGap);
    RecordProperty("longestGapMs", static_cast<int>(1e3 * gap.count()));
    std::printf("longest gap of four orbiting clients: %.0f ms\n", 1e3 * gap.count());
    // At once, the next time.
    EXPECT_THAT(refusal(plain(deadlyWidth)), HasSubstr("not drawn again"));
    station_.server().signal(SIGTERM);
    EXPECT_EQ(station_.server().wait(), 0);
    EXPECT_THAT(station_.server().errors(), HasSubstr("\"width\":13"));
    EXPECT_THAT(station_.server().errors(), HasSubstr("refused from now on"));
    EXPECT_FALSE(std::filesystem::exists(station_.connection()));
}

TEST_F(Survival, ABrokenInvariantIsAnErrorOfItsViewAlone) {
    const pid_t serving = servingProcess();
    EXPECT_THAT(refusal(plain(brokenWidth)), HasSubstr("broken invariant"));
    EXPECT_EQ(station_.frames(scriptOf({beamView(64)})).status, 0);
    EXPECT_EQ(servingProcess(), serving);
}

TEST_F(Survival, AScriptGoesOnWhereTheServerWasKilledAndHasTheSameBytes) {
    std::vector<std::string> views;
    for (int i = 0; i < 100; ++i) views.push_back(beamView(160, i % 2, 3.0 + 0.001 * i));
    ASSERT_EQ(station_.frames(scriptOf(views)).status, 0);
    std::map<std::string, std::string> pictures;
    for (const auto& name : namesIn(station_.out())) pictures[name] = bytesOf(station_.out() / name);
    ASSERT_EQ(pictures.size(), 100u);
    std::filesystem::remove_all(station_.out());
    Process frames(program("mote-frames"), station_.framesArguments(scriptOf(views), {"--json"}));
    ASSERT_TRUE(frames.waitForOutput("\n")) << frames.errors();
    const pid_t first = servingProcess();
    ::kill(first, SIGKILL);
    EXPECT_EQ(frames.wait(), 0) << frames.errors();
    EXPECT_NE(servingProcess(), first);
    for (const auto& [name, bytes] : pictures) EXPECT_EQ(bytesOf(station_.out() / name), bytes) << name;
}

TEST_F(Survival, AScriptIsToldWhichViewIsRefused) {
    const auto deadly = beamView(deadlyWidth);
    const auto done = station_.frames(scriptOf({beamView(64), deadly, beamView(64)}));
    EXPECT_EQ(done.status, 1);
    EXPECT_THAT(done.errors, HasSubstr("views[1]"));
    EXPECT_THAT(done.errors, HasSubstr("not drawn again"));
    EXPECT_TRUE(std::filesystem::exists(station_.out() / "frame-000000.png"));
    EXPECT_FALSE(std::filesystem::exists(station_.out() / "frame-000001.png"));
}

TEST_F(Survival, ASupervisorThatIsKilledTakesItsServerAlong) {
    const pid_t serving = servingProcess();
    station_.server().signal(SIGKILL);
    EXPECT_EQ(station_.server().wait(), 128 + SIGKILL);
    EXPECT_TRUE(waitForEnd(serving));
    station_.startServer();
    EXPECT_EQ(station_.frames(scriptOf({beamView(64)})).status, 0);
}

}  // namespace
}  // namespace mote::test
