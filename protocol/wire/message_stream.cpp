// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/message_stream.h"

#include <sys/socket.h>

#include <array>
#include <asio/error.hpp>

#include "protocol/wire/await_tuple.h"

namespace mote::wire {

asio::awaitable<Result<Version>> MessageStream::greet(Version own, std::function<void()> said) {
    const auto ready = co_await bytes_->shakeHands();
    if (!ready.ok()) co_return ready.error();
    const Greeting ours = encodeGreeting(own);
    greeted_ = true;
    const ByteStream::ToWrite ourBytes{asio::buffer(ours)};
    const auto writeCode = co_await bytes_->write(ourBytes);
    // Who closes at once has greeted before, and said why.
    const bool closed = writeCode == asio::error::broken_pipe || writeCode == asio::error::connection_reset;
    if (writeCode && !closed) co_return connectionError(writeCode);
    if (said && !closed) said();
    Greeting theirs{};
    const ByteStream::ToRead theirBytes{asio::buffer(theirs)};
    const auto readCode = co_await bytes_->read(theirBytes);
    if (readCode) co_return connectionError(readCode);
    co_return decodeGreeting(theirs, own);
}

asio::awaitable<Status> MessageStream::read(google::protobuf::MessageLite& message,
                                            std::vector<std::uint8_t>& payload, FrameLimits limits) {
    Header bytes{};
    const ByteStream::ToRead headerBytes{asio::buffer(bytes)};
    const auto headerCode = co_await bytes_->read(headerBytes);
    if (headerCode) co_return connectionError(headerCode);
    const auto header = decodeHeader(bytes, limits);
    if (!header.ok()) co_return header.error();
    readBuffer_.resize(header->message);
    payload.resize(header->payload);
    const ByteStream::ToRead parts{asio::buffer(readBuffer_), asio::buffer(payload)};
    const auto code = co_await bytes_->read(parts);
    if (code) co_return connectionError(code);
    co_return decodeMessage(readBuffer_, message);
}

asio::awaitable<Status> MessageStream::write(const google::protobuf::MessageLite& message,
                                             std::span<const std::uint8_t> payload, FrameLimits limits) {
    const auto framed = encodeFrame(message, payload.size(), limits, writeBuffer_);
    if (!framed.ok()) co_return framed.error();
    const ByteStream::ToWrite parts{asio::buffer(writeBuffer_), asio::buffer(payload.data(), payload.size())};
    const auto code = co_await bytes_->write(parts);
    if (code) co_return connectionError(code);
    co_return success();
}

void MessageStream::turnAway(const google::protobuf::MessageLite& message) {
    std::vector<std::uint8_t> frame;
    if (encodeFrame(message, 0, serverLimits, frame).ok()) {
        const Greeting ours = encodeGreeting(ownVersion);
        if (!greeted_) frame.insert(frame.begin(), ours.begin(), ours.end());
        bytes_->tryWrite(frame);
    }
    close();
}

asio::awaitable<void> MessageStream::finish() {
    asio::error_code code;
    socket().shutdown(Socket::shutdown_send, code);
    std::array<std::uint8_t, 4096> unwanted;
    while (!code) {
        std::tie(code) = co_await socket().async_wait(Socket::wait_read, awaitTuple);
        if (code) co_return;
        if (::recv(socket().native_handle(), unwanted.data(), unwanted.size(), MSG_DONTWAIT) <= 0) co_return;
    }
}

void MessageStream::close() {
    asio::error_code ignored;
    socket().close(ignored);
}

}  // namespace mote::wire
