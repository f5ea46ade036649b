// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/framing.h"

#include <gtest/gtest.h>

#include <random>

#include "protocol/mote.pb.h"

namespace mote::wire {
namespace {

TEST(Greeting, LiesInTheStreamAsDocumented) {
    const Greeting expected{'M', 'O', 'T', 'E', 0x01, 0x00, 0x34, 0x12};
    EXPECT_EQ(encodeGreeting({1, 0x1234}), expected);
    const auto version = decodeGreeting(expected);
    ASSERT_TRUE(version.ok());
    EXPECT_EQ(*version, (Version{1, 0x1234}));
}

TEST(Greeting, AnotherMajorIsOneClearError) {
    const auto version = decodeGreeting(encodeGreeting({7, 3}), {1, 0});
    ASSERT_FALSE(version.ok());
    EXPECT_EQ(version.error().code, ErrorCode::unsupported);
    EXPECT_NE(version.error().message.find("7.3"), std::string::npos);
    EXPECT_NE(version.error().message.find("1.0"), std::string::npos);
}

TEST(Greeting, ForeignBytesAreNoVersion) {
    for (std::size_t i = 0; i < 4; ++i) {
        Greeting bytes = encodeGreeting(ownVersion);
        bytes[i] ^= 0x20;
        EXPECT_EQ(decodeGreeting(bytes).error().code, ErrorCode::corrupt);
    }
}

TEST(FrameHeader, LiesInTheStreamAsDocumented) {
    const auto bytes = encodeHeader({0x00012345, 0x0a0b0c0d}, serverLimits);
    ASSERT_TRUE(bytes.ok());
    EXPECT_EQ(*bytes, (Header{0x45, 0x23, 0x01, 0x00, 0x0d, 0x0c, 0x0b, 0x0a}));
    EXPECT_EQ(*decodeHeader(*bytes, serverLimits), (FrameHeader{0x00012345, 0x0a0b0c0d}));
}

TEST(FrameHeader, EveryLimitHoldsOnBothSides) {
    for (const FrameLimits limits : {helloLimits, clientLimits, serverLimits}) {
        const FrameHeader greatest{limits.message, limits.payload};
        ASSERT_TRUE(encodeHeader(greatest, limits).ok());
        EXPECT_EQ(*decodeHeader(*encodeHeader(greatest, limits), limits), greatest);
        const FrameLimits lax{UINT32_MAX, UINT32_MAX};
        for (const FrameHeader over : {FrameHeader{limits.message + 1, 0}, FrameHeader{0, limits.payload + 1},
                                       FrameHeader{UINT32_MAX, UINT32_MAX}}) {
            EXPECT_EQ(encodeHeader(over, limits).error().code, ErrorCode::resourceExhausted);
            const auto decoded = decodeHeader(*encodeHeader(over, lax), limits);
            ASSERT_FALSE(decoded.ok());
            EXPECT_EQ(decoded.error().code, ErrorCode::resourceExhausted);
        }
    }
}

TEST(FrameHeader, LimitsAreTheDocumentedOnes) {
    EXPECT_EQ(helloLimits, (FrameLimits{4096, 0}));
    EXPECT_EQ(clientLimits, (FrameLimits{1048576, 0}));
    EXPECT_EQ(serverLimits.message, 16777216u);
    EXPECT_GE(serverLimits.payload, 8 * View::maxPixels);
}

TEST(FrameHeader, RandomBytesNeverPassALimit) {
    std::mt19937_64 random(2026);
    for (int i = 0; i < 100000; ++i) {
        Header bytes{};
        // Most random lengths are far too great: clear some upper bytes, so that both ways are taken.
        for (std::size_t k = 0; k < bytes.size(); ++k) {
            bytes[k] = random() % 4 == 0 ? 0 : static_cast<std::uint8_t>(random());
        }
        const auto header = decodeHeader(bytes, serverLimits);
        if (!header.ok()) continue;
        EXPECT_LE(header->message, serverLimits.message);
        EXPECT_LE(header->payload, serverLimits.payload);
        EXPECT_EQ(*encodeHeader(*header, serverLimits), bytes);
    }
}

TEST(Frame, HeaderAndMessageStandTogether) {
    proto::ClientMessage message;
    message.set_request(7);
    message.mutable_hello()->set_token("secret");
    std::vector<std::uint8_t> bytes{1, 2, 3};
    ASSERT_TRUE(encodeFrame(message, 0, helloLimits, bytes).ok());
    Header header{};
    std::copy_n(bytes.begin(), header.size(), header.begin());
    const auto lengths = decodeHeader(header, helloLimits);
    ASSERT_TRUE(lengths.ok());
    EXPECT_EQ(lengths->message + header.size(), bytes.size());
    EXPECT_EQ(lengths->payload, 0u);
    proto::ClientMessage again;
    ASSERT_TRUE(decodeMessage(std::span(bytes).subspan(header.size()), again).ok());
    EXPECT_EQ(again.SerializeAsString(), message.SerializeAsString());
}

TEST(Frame, TooLongMessageLeavesTheBytesAlone) {
    proto::ClientMessage message;
    message.mutable_hello()->set_client(std::string(helloLimits.message, 'x'));
    std::vector<std::uint8_t> bytes{1, 2, 3};
    EXPECT_EQ(encodeFrame(message, 0, helloLimits, bytes).error().code, ErrorCode::resourceExhausted);
    EXPECT_EQ(encodeFrame(proto::ClientMessage(), 1, helloLimits, bytes).error().code,
              ErrorCode::resourceExhausted);
    EXPECT_EQ(bytes, (std::vector<std::uint8_t>{1, 2, 3}));
}

TEST(Message, EmptyOneIsAMessageWithoutABody) {
    proto::ClientMessage message;
    message.mutable_ping();
    ASSERT_TRUE(decodeMessage({}, message).ok());
    EXPECT_EQ(message.body_case(), proto::ClientMessage::BODY_NOT_SET);
}

TEST(Message, RandomBytesBecomeAMessageOrAnError) {
    std::mt19937_64 random(4);
    int refused = 0;
    for (int i = 0; i < 20000; ++i) {
        std::vector<std::uint8_t> bytes(random() % 64);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
        proto::ClientMessage message;
        const auto status = decodeMessage(bytes, message);
        if (!status.ok()) {
            EXPECT_EQ(status.error().code, ErrorCode::corrupt);
            ++refused;
        }
    }
    EXPECT_GT(refused, 10000);
}

/// A view's bytes with any bit flipped or any tail missing: what a broken line would give.
TEST(Message, DamagedViewBecomesAMessageOrAnError) {
    proto::ClientMessage message;
    auto& view = *message.mutable_set_view()->mutable_view();
    view.set_width(1280);
    view.set_height(720);
    view.add_layers()->set_dataset("data/beam");
    const std::string good = message.SerializeAsString();
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        std::vector<std::uint8_t> bytes(good.begin(), good.end());
        bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
        proto::ClientMessage damaged;
        const auto status = decodeMessage(bytes, damaged);
        EXPECT_TRUE(status.ok() || status.error().code == ErrorCode::corrupt);
    }
    const std::vector<std::uint8_t> cut(good.begin(), good.end() - 1);
    EXPECT_FALSE(decodeMessage(cut, message).ok());
}

TEST(Message, BottomlessNestingIsRefused) {
    // A group that opens 200 times and never closes: parsers that recurse without a limit overflow here.
    const std::vector<std::uint8_t> bytes(100000, 0x0b);
    proto::ClientMessage message;
    EXPECT_FALSE(decodeMessage(bytes, message).ok());
}

}  // namespace
}  // namespace mote::wire
