// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>
#include <asio/local/connect_pair.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/write.hpp>
#include <optional>
#include <random>

#include "protocol/mote.pb.h"
#include "protocol/wire/address.h"
#include "protocol/wire/framing.h"
#include "protocol/wire/message_stream.h"
#include "protocol/wire/silence.h"

namespace mote::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class T>
std::optional<ErrorCode> codeOf(const Result<T>& result) {
    return result.ok() ? std::nullopt : std::optional(result.error().code);
}

/// Two ends of one connection on one thread.
class MessageStreamTest : public testing::Test {
  protected:
    MessageStreamTest() { asio::local::connect_pair(near_, far_); }

    MessageStream stream() { return MessageStream(std::move(near_)); }

    template <class Coroutine>
    void spawn(Coroutine coroutine) {
        asio::co_spawn(context_, std::move(coroutine), [](std::exception_ptr error) {
            if (error) std::rethrow_exception(error);
        });
    }

    void sendRaw(const Bytes& bytes) { asio::write(far_, asio::buffer(bytes)); }

    asio::io_context context_;
    asio::local::stream_protocol::socket near_{context_};
    asio::local::stream_protocol::socket far_{context_};
};

proto::ServerMessage pong(std::int64_t sent) {
    proto::ServerMessage message;
    message.mutable_pong()->set_sent_ns(sent);
    return message;
}

TEST_F(MessageStreamTest, MessagesAndPayloadsArriveWholeAndInOrder) {
    MessageStream writer(std::move(near_)), reader(std::move(far_));
    std::mt19937 random(3);
    std::vector<Bytes> payloads(20);
    for (auto& payload : payloads) {
        payload.resize(random() % 300000);
        for (auto& byte : payload) byte = static_cast<std::uint8_t>(random());
    }
    payloads[5].clear();
    spawn([&]() -> asio::awaitable<void> {
        EXPECT_TRUE((co_await writer.greet()).ok());
        for (std::size_t i = 0; i < payloads.size(); ++i) {
            const auto message = pong(static_cast<std::int64_t>(i));
            const auto status = co_await writer.write(message, payloads[i], serverLimits);
            EXPECT_TRUE(status.ok());
        }
        writer.close();
    });
    std::size_t count = 0;
    spawn([&]() -> asio::awaitable<void> {
        const auto version = co_await reader.greet();
        EXPECT_TRUE(version.ok());
        EXPECT_EQ(*version, ownVersion);
        proto::ServerMessage message;
        Bytes payload;
        for (;;) {
            const auto status = co_await reader.read(message, payload, serverLimits);
            if (!status.ok()) {
                EXPECT_EQ(status.error().code, ErrorCode::cancelled);
                co_return;
            }
            EXPECT_EQ(message.pong().sent_ns(), static_cast<std::int64_t>(count));
            EXPECT_EQ(payload, payloads.at(count));
            ++count;
        }
    });
    context_.run();
    EXPECT_EQ(count, payloads.size());
}

TEST_F(MessageStreamTest, ForeignGreetingsAreRefused) {
    MessageStream reader = stream();
    const std::string http = "GET / HTTP/1.1\r\n\r\n";
    sendRaw(Bytes(http.begin(), http.end()));
    bool done = false;
    spawn([&]() -> asio::awaitable<void> {
        const auto version = co_await reader.greet();
        EXPECT_EQ(codeOf(version), ErrorCode::corrupt);
        done = true;
    });
    context_.run();
    EXPECT_TRUE(done);
}

TEST_F(MessageStreamTest, LengthsBeyondTheLimitAreRefusedUnread) {
    MessageStream reader = stream();
    sendRaw({0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff});
    bool done = false;
    spawn([&]() -> asio::awaitable<void> {
        proto::ClientMessage message;
        Bytes payload;
        const auto status = co_await reader.read(message, payload, clientLimits);
        EXPECT_EQ(codeOf(status), ErrorCode::resourceExhausted);
        EXPECT_EQ(payload.capacity(), 0u);
        done = true;
    });
    context_.run();  // ends although the other side stays open and silent
    EXPECT_TRUE(done);
}

TEST_F(MessageStreamTest, EndWithinAFrameIsAnEnd) {
    MessageStream reader = stream();
    sendRaw({10, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3});
    far_.close();
    bool done = false;
    spawn([&]() -> asio::awaitable<void> {
        proto::ClientMessage message;
        Bytes payload;
        const auto status = co_await reader.read(message, payload, clientLimits);
        EXPECT_EQ(codeOf(status), ErrorCode::cancelled);
        done = true;
    });
    context_.run();
    EXPECT_TRUE(done);
}

TEST_F(MessageStreamTest, TooLongMessageIsNotSentAndTheStreamGoesOn) {
    MessageStream writer(std::move(near_)), reader(std::move(far_));
    bool done = false;
    spawn([&]() -> asio::awaitable<void> {
        proto::ClientMessage huge;
        huge.mutable_hello()->set_client(std::string(5000, 'x'));
        const auto refused = co_await writer.write(huge, {}, helloLimits);
        EXPECT_FALSE(refused.ok());
        proto::ClientMessage small;
        small.set_request(9);
        const auto sent = co_await writer.write(small, {}, helloLimits);
        EXPECT_TRUE(sent.ok());
        proto::ClientMessage message;
        Bytes payload;
        const auto status = co_await reader.read(message, payload, helloLimits);
        EXPECT_TRUE(status.ok());
        EXPECT_EQ(message.request(), 9u);
        done = true;
    });
    context_.run();
    EXPECT_TRUE(done);
}

TEST_F(MessageStreamTest, CloseEndsWhatIsUnderWay) {
    MessageStream reader = stream();
    bool done = false;
    spawn([&]() -> asio::awaitable<void> {
        proto::ClientMessage message;
        Bytes payload;
        const auto status = co_await reader.read(message, payload, clientLimits);
        EXPECT_EQ(codeOf(status), ErrorCode::cancelled);
        done = true;
    });
    context_.poll();
    EXPECT_FALSE(done);
    reader.close();
    reader.close();
    context_.run();
    EXPECT_TRUE(done);
}

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

TEST(Address, GoodOnesGoThereAndBack) {
    for (const char* text : {"unix:/run/user/1000/mote.sock", "unix:relative", "tcp:localhost:0",
                             "tcp:127.0.0.1:65535", "tcp:[::1]:80"}) {
        const auto address = parseAddress(text);
        ASSERT_TRUE(address.ok()) << text;
        EXPECT_EQ(address->toString(), text);
    }
    EXPECT_EQ(parseAddress("tcp:[::1]:80")->host, "::1");
    EXPECT_EQ(parseAddress("tcp:[::1]:80")->port, 80);
}

TEST(Address, BadOnesAreRefused) {
    using namespace std::string_view_literals;
    for (const std::string_view text :
         {""sv, "unix"sv, "unix:"sv, "unix:a\0b"sv, "udp:host:1"sv, "tcp:"sv, "tcp:host"sv, "tcp:host:"sv,
          "tcp::80"sv, "tcp:host:65536"sv, "tcp:host:-1"sv, "tcp:host:8x"sv, "tcp:::1:80"sv, "/socket"sv}) {
        const auto address = parseAddress(text);
        ASSERT_FALSE(address.ok()) << text;
        EXPECT_EQ(address.error().code, ErrorCode::invalidArgument);
    }
}

TEST(Address, PathThatTheKernelCannotHoldIsRefused) {
    const std::string longest = "unix:/" + std::string(maxSocketPath - 1, 'x');
    EXPECT_TRUE(parseAddress(longest).ok());
    EXPECT_FALSE(parseAddress(longest + "x").ok());
}

using namespace std::chrono_literals;
using Verdict = Silence::Verdict;

const Silence::Time start{1h};

TEST(Silence, IsAskedOnceAndThenOver) {
    Silence silence(8s, start);
    EXPECT_EQ(silence.interval(), 1s);
    for (int s = 1; s < 4; ++s) EXPECT_EQ(silence.at(start + s * 1s, 0), Verdict::fine) << s;
    EXPECT_EQ(silence.at(start + 4s, 0), Verdict::ask);
    for (int s = 5; s < 8; ++s) EXPECT_EQ(silence.at(start + s * 1s, 0), Verdict::fine) << s;
    EXPECT_EQ(silence.at(start + 8s, 0), Verdict::gone);
}

TEST(Silence, AnyByteEndsIt) {
    Silence silence(8s, start);
    for (int s = 1; s < 100; ++s) {
        // One byte every seven seconds.
        const auto verdict = silence.at(start + s * 1s, static_cast<std::uint64_t>(s / 7));
        EXPECT_NE(verdict, Verdict::gone) << s;
    }
    EXPECT_EQ(silence.at(start + 100s, 1000), Verdict::fine);
    EXPECT_EQ(silence.at(start + 103s, 1000), Verdict::fine);
    EXPECT_EQ(silence.at(start + 104s, 1000), Verdict::ask) << "asked anew in a new silence";
}

TEST(Silence, OurOwnAbsenceIsNotTheirs) {
    Silence silence(8s, start);
    EXPECT_EQ(silence.at(start + 1h, 0), Verdict::fine);
    EXPECT_EQ(silence.at(start + 1h + 3s, 0), Verdict::fine);
    EXPECT_EQ(silence.at(start + 1h + 4s, 0), Verdict::ask);
    EXPECT_EQ(silence.at(start + 1h + 8s, 0), Verdict::gone);
}

TEST(Silence, WithoutALimitLastsForEver) {
    Silence silence(0s, start);
    EXPECT_EQ(silence.interval(), 0s);
    EXPECT_EQ(silence.at(start + 1000h, 0), Verdict::fine);
}

}  // namespace
}  // namespace mote::wire
