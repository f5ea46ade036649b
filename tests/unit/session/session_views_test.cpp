// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views and frames: credits, latest wins, refinement, and that nobody waits for a client that does not read.
#include <zstd.h>

#include <algorithm>

#include "storage/storage_error.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

using SessionViews = SessionFixture;

TEST_F(SessionViews, WelcomeSaysWhoServes) {
    start();
    TestClient client(socket());
    const auto first = client.connect(connection_.token());
    ASSERT_TRUE(first.message.has_welcome());
    EXPECT_EQ(first.message.reply_to(), 1u);
    EXPECT_EQ(first.message.welcome().frame_credits(), 2u);
    EXPECT_EQ(first.message.welcome().device(), "fake");
    EXPECT_TRUE(first.message.welcome().server().starts_with("mote-server "));
}

TEST_F(SessionViews, ViewAtRestEndsWithTheExactPictureAndThenNothing) {
    start();
    const auto one = client();
    one->setView(7, 640, false);
    const auto quick = one->receiveFrame();
    const auto exact = one->receiveFrame();
    EXPECT_EQ(quick.message.frame().encoding(), proto::Frame::JPEG);
    EXPECT_FALSE(quick.message.frame().final());
    const auto& frame = exact.message.frame();
    EXPECT_TRUE(frame.final());
    EXPECT_EQ(frame.encoding(), proto::Frame::ZSTD);
    EXPECT_EQ(frame.format(), proto::SRGB8);
    EXPECT_EQ(frame.view_id(), 7u);
    EXPECT_EQ(frame.asked_ns(), 1007);
    EXPECT_EQ(frame.sequence(), 2u);
    EXPECT_EQ(frame.width(), 640u);
    EXPECT_EQ(frame.height(), 640u);
    EXPECT_EQ(frame.point_fraction(), 1.0);
    EXPECT_EQ(frame.device(), "fake");
    EXPECT_GE(frame.total_ms(), frame.queued_ms() + frame.plan_ms() + frame.render_ms());
    EXPECT_EQ(ZSTD_getFrameContentSize(exact.payload.data(), exact.payload.size()), 640u * 640 * 3);
    EXPECT_EQ(control_->renders().back().quality, render::Quality::exact());
    // Both credits come back; another client's picture passes the renderer; nothing was drawn in between.
    one->credit(2);
    one->barrier();
    const auto other = client();
    other->setView(1, 32);
    other->receiveFrame();
    EXPECT_EQ(control_->renders().size(), 3u);
}

TEST_F(SessionViews, MovingViewIsNotRefined) {
    settings_.render.schedule.restDelay = {};
    start();
    const auto one = client();
    one->setView(1, 64, true);
    one->receiveFrame();
    const auto other = client();
    other->setView(1, 32, true, true);
    other->receiveFrame();
    EXPECT_EQ(control_->renders().size(), 2u);
}

TEST_F(SessionViews, FinalOnlyGivesOnePictureInTheAskedFormat) {
    start();
    const auto one = client();
    one->setView(1, 48, false, true, proto::LINEAR_HALF);
    const auto received = one->receiveFrame();
    EXPECT_TRUE(received.message.frame().final());
    EXPECT_EQ(received.message.frame().format(), proto::LINEAR_HALF);
    EXPECT_EQ(ZSTD_getFrameContentSize(received.payload.data(), received.payload.size()), 48u * 48 * 6);
    const auto renders = control_->renders();
    ASSERT_EQ(renders.size(), 1u);
    EXPECT_EQ(renders[0].format, render::PixelFormat::linearHalf);
}

TEST_F(SessionViews, WithoutCreditsNothingIsRenderedAndThenTheLatestView) {
    start();
    const auto one = client();
    for (std::uint64_t id = 1; id <= 2; ++id) {
        one->setView(id, 64);
        EXPECT_EQ(one->receiveFrame().message.frame().view_id(), id);
    }
    for (std::uint64_t id = 3; id <= 9; ++id) one->setView(id, 64);
    one->barrier();
    const auto other = client();
    other->setView(1, 32);
    other->receiveFrame();
    EXPECT_EQ(control_->renders().size(), 3u);
    one->credit(1);
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 9u);
}

TEST_F(SessionViews, LatestViewWinsWhileTheDeviceWorks) {
    start();
    control_->closeGate();
    const auto one = client();
    one->setView(1, 64);
    control_->awaitBegun(1);
    for (std::uint64_t id = 2; id <= 50; ++id) one->setView(id, 64);
    one->barrier();
    control_->openGate();
    // A quick picture is never stopped: the first is seen, unless the latest takes its place before it is
    // sent; then the latest, and none in between.
    auto seen = one->receiveFrame().message.frame().view_id();
    if (seen == 1u) seen = one->receiveFrame().message.frame().view_id();
    EXPECT_EQ(seen, 50u);
    EXPECT_EQ(control_->renders().size(), 2u);
}

TEST_F(SessionViews, NewerViewStopsTheRefinementOfTheOlder) {
    start();
    control_->closeGate();
    const auto one = client();
    one->setView(1, 64, false, true);
    control_->awaitBegun(1);
    one->setView(2, 65, false, true);
    control_->awaitBegun(2);  // without a stop, the first would wait at the gate for ever
    control_->openGate();
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 2u);
    const auto renders = control_->renders();
    EXPECT_TRUE(renders[0].stopped);
    EXPECT_EQ(renders.size(), 2u);
}

TEST_F(SessionViews, MovingHandGoesBeforeAnothersRefinement) {
    start();
    control_->closeGate();
    const auto script = client();
    const auto hand = client();
    script->setView(1, 64, false, true);
    control_->awaitBegun(1);
    hand->setView(1, 65, true);
    control_->awaitBegun(2);
    control_->openGate();
    EXPECT_EQ(hand->receiveFrame().message.frame().view_id(), 1u);
    EXPECT_EQ(script->receiveFrame().message.frame().view_id(), 1u);
    const auto renders = control_->renders();
    ASSERT_EQ(renders.size(), 3u);
    EXPECT_TRUE(renders[0].stopped);
    EXPECT_EQ(renders[1].width, 65u);
    EXPECT_EQ(renders[2].width, 64u);
}

TEST_F(SessionViews, StalledClientQueuesTwoFramesAndSlowsNobody) {
    start();
    const auto stalled = client();
    const auto other = client();
    // 1000 x 1000 noise is far more than a socket's buffer: the server's write cannot end.
    for (std::uint64_t id = 1; id <= 5; ++id) {
        stalled->setView(id, 1000);
        for (std::uint64_t k = 0; k < 10; ++k) {
            other->setView(100 * id + k, 40);
            EXPECT_EQ(other->receiveFrame().message.frame().view_id(), 100 * id + k);
            other->credit(1);
        }
    }
    // Questions whose answers nobody reads: the server stops reading them before they take memory.
    proto::ClientMessage ping;
    ping.mutable_ping();
    for (int i = 0; i < 5000; ++i) stalled->trySend(ping);
    other->barrier();
    const auto renders = control_->renders();
    const auto ofStalled =
        std::count_if(renders.begin(), renders.end(), [](const auto& r) { return r.width == 1000; });
    EXPECT_LE(ofStalled, 2);
    // It reads again: all is whole, and the latest view comes once it returns its credits.
    EXPECT_EQ(stalled->receiveFrame().payload.empty(), false);
    stalled->receiveFrame();
    stalled->credit(2);
    stalled->setView(77, 30);
    stalled->receive([](const auto& message) { return message.frame().view_id() == 77; });
}

TEST_F(SessionViews, AClientThatReadsAgainSeesTheNewestOnly) {
    settings_.staleAfter = {};
    settings_.render.encodeThreads = 1;  // what others receive was encoded after what was drawn before it
    start();
    const auto stalled = client(), other = client();
    // Far more than a socket's buffer: the first is being written, the second waits, and no credit is left.
    for (std::uint64_t id = 1; id <= 4; ++id) {
        stalled->setView(id, 1000);
        other->setView(id, 40);
        other->receiveFrame();
        other->credit(1);
        other->barrier();
    }
    EXPECT_EQ(control_->renders().size(), 4u + 2u);
    EXPECT_EQ(stalled->receiveFrame().message.frame().view_id(), 1u);
    EXPECT_EQ(stalled->receiveFrame().message.frame().view_id(), 4u);
    EXPECT_EQ(control_->renders().size(), 4u + 3u);
}

TEST_F(SessionViews, TooManyCreditsAreAnError) {
    start();
    const auto one = client();
    one->credit(1);
    const auto failure = one->receive([](const auto& message) { return message.has_failure(); });
    EXPECT_EQ(failure.message.failure().where(), "credit.frames");
    EXPECT_TRUE(failure.message.failure().fatal());
    EXPECT_TRUE(one->atEnd());
}

TEST_F(SessionViews, ViewThatIsWrongIsOneErrorWithItsField) {
    start();
    const auto one = client();
    const std::pair<std::uint32_t, const char*> cases[] = {{0, "view.width"}, {100000, "view.width"}};
    for (const auto& [width, field] : cases) {
        proto::ClientMessage message;
        message.mutable_set_view()->mutable_view()->set_width(width);
        message.mutable_set_view()->mutable_view()->set_height(100);
        const auto reply = one->ask(message);
        EXPECT_EQ(reply.message.failure().code(), "invalid_argument");
        EXPECT_EQ(reply.message.failure().where(), field);
        EXPECT_FALSE(reply.message.failure().fatal());
    }
    proto::ClientMessage unknown;
    auto& view = *unknown.mutable_set_view()->mutable_view();
    view.set_width(64);
    view.set_height(64);
    view.add_layers()->set_dataset("data/nowhere");
    view.mutable_layers(0)->mutable_particles();
    const auto reply = one->ask(unknown);
    EXPECT_EQ(reply.message.failure().code(), "not_found");
    EXPECT_EQ(reply.message.failure().where(), "layers[0].dataset");
    EXPECT_NE(reply.message.failure().message().find("data/nowhere"), std::string::npos);
    one->setView(5, 32);
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 5u);
}

TEST_F(SessionViews, DamagedDataIsOneErrorAndTheServerGoesOn) {
    start();
    const auto one = client();
    control_->failNext([] {
        throw storage::StorageError(
            {ErrorCode::corrupt, "/data/beam.mote/step-000000.h5:/points/position@1048576", "differs"});
    });
    one->setView(1, 64);
    const auto failure = one->receive([](const auto& message) { return message.has_failure(); });
    EXPECT_EQ(failure.message.failure().code(), "corrupt");
    EXPECT_NE(failure.message.failure().where().find("step-000000.h5:/points/position@1048576"),
              std::string::npos);
    EXPECT_FALSE(failure.message.failure().fatal());
    EXPECT_NE(failure.message.reply_to(), 0u);
    one->setView(2, 64);
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 2u);
    EXPECT_EQ(control_->devices(), 1u);
}

TEST_F(SessionViews, DeviceThatFailsTwiceIsMadeAnew) {
    start();
    const auto one = client();
    for (std::uint64_t id = 1; id <= 2; ++id) {
        control_->failNext([] { throw render::DeviceError("the driver was reset"); });
        one->setView(id, 64);
        const auto failure = one->receive([](const auto& message) { return message.has_failure(); });
        EXPECT_EQ(failure.message.failure().code(), "internal");
        EXPECT_EQ(failure.message.failure().message(), "the driver was reset");
    }
    one->setView(3, 64);
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 3u);
    EXPECT_EQ(control_->devices(), 2u);
}

TEST_F(SessionViews, ABrokenInvariantIsOneErrorAndANewDeviceDrawsTheNext) {
    start();
    const auto one = client(), other = client();
    control_->failNext([] { MOTE_CHECK(1 + 1 == 3); });
    one->setView(1, 64);
    const auto failure = one->receive([](const auto& message) { return message.has_failure(); });
    EXPECT_EQ(failure.message.failure().code(), "internal");
    EXPECT_NE(failure.message.failure().message().find("1 + 1 == 3"), std::string::npos);
    EXPECT_FALSE(failure.message.failure().fatal());
    other->setView(2, 65);
    EXPECT_EQ(other->receiveFrame().message.frame().width(), 65u);
    one->setView(3, 64);
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 3u);
    EXPECT_EQ(control_->devices(), 2u);
}

TEST_F(SessionViews, AViewThatEndedServersBeforeComesLateAndThenNeverAgain) {
    server::CrashRecord crashes;
    settings_.render.crashes = &crashes;
    proto::View view;
    for (const std::uint32_t width : {64, 65, 65}) {
        view.set_width(width);
        view.set_height(width);
        crashes.count(view.SerializeAsString());
    }
    start();
    const auto one = client();
    one->setView(1, 65);
    const auto failure = one->receive([](const auto& message) { return message.has_failure(); });
    EXPECT_EQ(failure.message.failure().code(), "internal");
    EXPECT_NE(failure.message.failure().message().find("not drawn again"), std::string::npos);
    EXPECT_EQ(control_->renders().size(), 0u);
    one->setView(2, 64);
    one->barrier();
    const auto other = client();
    other->setView(1, 66);
    other->receiveFrame();
    EXPECT_EQ(control_->renders().front().width, 66u) << "it waits until others had their turn";
    EXPECT_EQ(one->receiveFrame().message.frame().width(), 64u);
    EXPECT_FALSE(crashes.view()) << "nothing is drawn any more";
}

TEST_F(SessionViews, SessionThatEndsStopsItsPicture) {
    start();
    control_->closeGate();
    auto gone = client();
    gone->setView(1, 64, true);
    control_->awaitBegun(1);
    gone.reset();
    const auto other = client();
    other->setView(1, 65);
    control_->awaitBegun(2);  // the picture of the one that left would block the device for ever
    control_->openGate();
    EXPECT_EQ(other->receiveFrame().message.frame().width(), 65u);
}

}  // namespace
}  // namespace mote::test
