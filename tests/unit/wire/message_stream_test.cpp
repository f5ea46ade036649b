// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/message_stream.h"

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

}  // namespace
}  // namespace mote::wire
