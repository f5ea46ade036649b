// SPDX-License-Identifier: GPL-3.0-or-later
//
// Queued views: each is drawn and each frame is taken, in order, whatever the line does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "protocol/wire/framing.h"
#include "tests/unit/client/connection_fixture.h"

namespace mote::client {
namespace {

using testing::ElementsAre;

class ConnectionQueueTest : public ConnectionTest {
  protected:
    static constexpr std::uint32_t minor = 2;  // from which on servers keep a queue

    void connect(const ConnectionSettings& settings = quietSettings()) {
        ConnectionTest::connect(settings, minor);
    }

    std::uint64_t queue(std::uint32_t width) {
        ViewRequest request;
        request.finalOnly = true;
        request.queued = true;
        return connection_->setView(viewOfWidth(width), request);
    }

    std::uint32_t widthOfNextView() {
        const auto message = server_.read(proto::ClientMessage::kSetView).set_view();
        EXPECT_TRUE(message.queued());
        return message.view().width();
    }
};

TEST_F(ConnectionQueueTest, AllAreSentAndAllFramesAreTakenInOrder) {
    connect();
    std::vector<std::uint64_t> ids;
    for (std::uint32_t width = 1; width <= 3; ++width) ids.push_back(queue(width));
    for (std::uint32_t width = 1; width <= 3; ++width) EXPECT_EQ(widthOfNextView(), width);
    for (std::uint32_t i = 0; i < 3; ++i) sendFrame(ids[i], i + 1);
    settle();
    for (std::uint32_t i = 0; i < 3; ++i) {
        const auto frame = frameOf(*connection_);
        EXPECT_EQ(frame.message.view_id(), ids[i]);
        const auto pixels = test::samplePixels(i + 1, 4, proto::SRGB8);
        EXPECT_EQ(frame.pixels.bytes, pixels);
        const auto travelled = test::zstdPayload(pixels, i + 1, proto::SRGB8);
        EXPECT_EQ(std::string(frame.payload.begin(), frame.payload.end()), travelled);
    }
    EXPECT_FALSE(connection_->takeFrame());
}

TEST_F(ConnectionQueueTest, NoMoreAreSentThanAServerKeeps) {
    connect();
    std::vector<std::uint64_t> ids;
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews + 2; ++i) ids.push_back(queue(i));
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews; ++i) EXPECT_EQ(widthOfNextView(), i);
    settle();
    sendFrame(ids[0], 1);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), ids[0]);
    EXPECT_EQ(widthOfNextView(), wire::maxQueuedViews + 1);
}

TEST_F(ConnectionQueueTest, AFailureLeavesTheOthers) {
    connect();
    std::vector<std::uint64_t> failed;
    connection_->onViewFailed([&](std::uint64_t id, const Error&) { failed.push_back(id); });
    const auto first = queue(1), second = queue(2);
    proto::ServerMessage failure;
    failure.set_reply_to(server_.read(proto::ClientMessage::kSetView).request());
    failure.mutable_failure()->set_code("not_found");
    server_.send(failure);
    ASSERT_TRUE(eventually(*connection_, [&] { return !failed.empty(); }));
    EXPECT_THAT(failed, ElementsAre(first));
    sendFrame(second, 2);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), second);
}

TEST_F(ConnectionQueueTest, AfterALineBrokeOnlyUnansweredOnesAreAskedForAgain) {
    auto settings = quietSettings();
    settings.returnPatience = std::chrono::seconds(20);
    connect(settings);
    const auto first = queue(1), second = queue(2);
    EXPECT_EQ(widthOfNextView(), 1U);
    EXPECT_EQ(widthOfNextView(), 2U);
    sendFrame(first, 1);
    settle();
    server_.drop();
    server_.welcome(minor);
    EXPECT_EQ(widthOfNextView(), 2U);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), first);  // it had arrived
    sendFrame(second, 2);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), second);
    // The first one's credit was of the old line.
    std::uint32_t credits = 0;
    while (!server_.quiet()) credits += server_.read(proto::ClientMessage::kCredit).credit().frames();
    EXPECT_LE(credits, 1U);
}

TEST_F(ConnectionQueueTest, AnOlderServerGetsOneAtATime) {
    ConnectionTest::connect(quietSettings(), 1);
    const auto first = queue(1);
    queue(2);
    EXPECT_EQ(widthOfNextView(), 1U);
    settle();
    sendFrame(first, 1);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), first);
    EXPECT_EQ(widthOfNextView(), 2U);
}

TEST_F(ConnectionQueueTest, AViewThatIsNotQueuedTakesTheirPlace) {
    connect();
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews + 1; ++i) queue(i);
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews; ++i) widthOfNextView();
    const auto id = connection_->setView(viewOfWidth(99), {});
    const auto message = server_.read(proto::ClientMessage::kSetView).set_view();
    EXPECT_FALSE(message.queued());
    EXPECT_EQ(message.view().width(), 99U);
    sendFrame(id, 99);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), id);
}

}  // namespace
}  // namespace mote::client
