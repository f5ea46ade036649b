// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/byte_stream.h"

#include <asio/error.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>

#include "protocol/wire/await_tuple.h"

namespace mote::wire {

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

asio::awaitable<Status> ByteStream::shakeHands() {
    co_return success();
}

asio::awaitable<asio::error_code> ByteStream::read(ToRead parts) {
    std::size_t done = 0;
    const auto [code, count] = co_await asio::async_read(socket_, parts, countRead(done), awaitTuple);
    countRead(done, count);
    co_return code;
}

asio::awaitable<asio::error_code> ByteStream::write(ToWrite parts) {
    const auto [code, count] =
        co_await asio::async_write(socket_, parts, countWritten(asio::buffer_size(parts)), awaitTuple);
    co_return code;
}

void ByteStream::tryWrite(std::span<const std::uint8_t> bytes) {
    asio::error_code ignored;
    socket_.non_blocking(true, ignored);
    if (!ignored) socket_.write_some(asio::buffer(bytes.data(), bytes.size()), ignored);
}

}  // namespace mote::wire
