// SPDX-License-Identifier: GPL-3.0-or-later
//
// Servers that do not send the pictures that they were asked for.
#include "client/frames/picture_server.h"

#include <gmock/gmock.h>

#include "tests/unit/client/fake_server.h"

namespace mote::client {
namespace {

using testing::HasSubstr;

class PictureServerTest : public testing::Test {
  protected:
    /// Asks for one picture of 6 x 4 pixels. Its number.
    std::uint64_t ask(std::chrono::milliseconds patience = std::chrono::hours(1)) {
        auto opened = PictureServer::open({fake_.connectionFile()}, patience, wakeup_, interrupt_);
        EXPECT_TRUE(opened.ok());
        pictures_ = *std::move(opened);
        fake_.welcome(3);
        EXPECT_TRUE(pictures_->waitUntilConnected().ok());
        const auto view = pictures_->ask(viewOfWidth(6), proto::SRGB8, {});
        fake_.read(proto::ClientMessage::kSetView);
        return view;
    }

    void send(std::uint64_t view, bool final) {
        proto::ServerMessage message;
        *message.mutable_frame() = test::frameMessage(6, 4, proto::SRGB8, proto::Frame::ZSTD);
        message.mutable_frame()->set_view_id(view);
        message.mutable_frame()->set_final(final);
        fake_.send(message, test::zstdPayload(test::samplePixels(6, 4, proto::SRGB8), 6, proto::SRGB8));
    }

    /// Polls until there are answers, or the server is lost.
    std::vector<Answer> answers() {
        while (true) {
            auto found = pictures_->poll();
            if (!found.empty() || pictures_->lost()) return found;
            wakeup_.wait(signalPatience);
        }
    }

    Wakeup wakeup_;
    Interrupt interrupt_;
    FakeServer fake_;
    std::unique_ptr<PictureServer> pictures_;
};

TEST_F(PictureServerTest, APictureIsItsAnswer) {
    const auto view = ask();
    send(view, true);
    const auto found = answers();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].view, view);
    EXPECT_TRUE(found[0].frame.ok());
    EXPECT_EQ(pictures_->open(), 0U);
}

TEST_F(PictureServerTest, APictureThatNobodyAskedForEndsIt) {
    send(ask() + 1, true);
    EXPECT_TRUE(answers().empty());
    ASSERT_TRUE(pictures_->lost());
    EXPECT_THAT(pictures_->lost()->message, HasSubstr("nobody asked for"));
}

TEST_F(PictureServerTest, APictureThatIsNotExactIsAFailure) {
    send(ask(), false);
    const auto found = answers();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].frame.error().code, ErrorCode::corrupt);
}

TEST_F(PictureServerTest, AServerThatOnlyAnswersPingsIsGivenUp) {
    ask(std::chrono::milliseconds(50));
    EXPECT_TRUE(answers().empty());
    ASSERT_TRUE(pictures_->lost());
    EXPECT_THAT(pictures_->lost()->message, HasSubstr("nothing of a picture for 0.05 s"));
}

}  // namespace
}  // namespace mote::client
