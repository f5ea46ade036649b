// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/message_stream.h"

#include <array>
#include <asio/buffer.hpp>
#include <asio/error.hpp>
#include <asio/experimental/as_tuple.hpp>
#include <asio/read.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>

namespace mote::wire {
namespace {

constexpr auto awaitTuple = asio::experimental::as_tuple(asio::use_awaitable);

Error connectionError(const asio::error_code& code) {
    if (code == asio::error::eof || code == asio::error::connection_reset ||
        code == asio::error::broken_pipe) {
        return {ErrorCode::cancelled, "connection", "the other side closed it"};
    }
    if (code == asio::error::operation_aborted || code == asio::error::bad_descriptor) {
        return {ErrorCode::cancelled, "connection", "closed"};
    }
    return {ErrorCode::internal, "connection", code.message()};
}

}  // namespace

asio::awaitable<Result<Version>> MessageStream::greet(Version own) {
    const Greeting ours = encodeGreeting(own);
    const auto [writeCode, written] = co_await asio::async_write(socket_, asio::buffer(ours), awaitTuple);
    // Who closes at once has greeted before, and said why.
    const bool closed = writeCode == asio::error::broken_pipe || writeCode == asio::error::connection_reset;
    if (writeCode && !closed) co_return connectionError(writeCode);
    Greeting theirs{};
    const auto [readCode, count] = co_await asio::async_read(socket_, asio::buffer(theirs), awaitTuple);
    if (readCode) co_return connectionError(readCode);
    co_return decodeGreeting(theirs, own);
}

asio::awaitable<Status> MessageStream::read(google::protobuf::MessageLite& message,
                                            std::vector<std::uint8_t>& payload, FrameLimits limits) {
    Header bytes{};
    const auto [headerCode, headerCount] =
        co_await asio::async_read(socket_, asio::buffer(bytes), awaitTuple);
    if (headerCode) co_return connectionError(headerCode);
    const auto header = decodeHeader(bytes, limits);
    if (!header.ok()) co_return header.error();
    readBuffer_.resize(header->message);
    payload.resize(header->payload);
    const std::array<asio::mutable_buffer, 2> parts{asio::buffer(readBuffer_), asio::buffer(payload)};
    const auto [code, count] = co_await asio::async_read(socket_, parts, awaitTuple);
    if (code) co_return connectionError(code);
    co_return decodeMessage(readBuffer_, message);
}

asio::awaitable<Status> MessageStream::write(const google::protobuf::MessageLite& message,
                                             std::span<const std::uint8_t> payload, FrameLimits limits) {
    const auto framed = encodeFrame(message, payload.size(), limits, writeBuffer_);
    if (!framed.ok()) co_return framed.error();
    const std::array<asio::const_buffer, 2> parts{asio::buffer(writeBuffer_),
                                                  asio::buffer(payload.data(), payload.size())};
    const auto [code, count] = co_await asio::async_write(socket_, parts, awaitTuple);
    if (code) co_return connectionError(code);
    co_return success();
}

void MessageStream::close() {
    asio::error_code ignored;
    socket_.close(ignored);
}

}  // namespace mote::wire
