// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/session/test_client.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace mote::test {
namespace {

constexpr int patienceMs = 60'000;  // only a server that hangs takes so long

}  // namespace

TestClient::TestClient(const std::filesystem::path& socket) {
    socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, socket.c_str(), sizeof(address.sun_path) - 1);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
        ::close(socket_);
        throw std::runtime_error(std::string("cannot connect: ") + std::strerror(errno));
    }
}

TestClient::~TestClient() {
    ::close(socket_);
}

bool TestClient::sendBytes(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return true;
}

bool TestClient::sendHeader(wire::FrameHeader header) {
    return sendBytes(wire::encodeHeader(header, {UINT32_MAX, UINT32_MAX}).value());
}

bool TestClient::send(const proto::ClientMessage& message) {
    std::vector<std::uint8_t> bytes;
    if (!wire::encodeFrame(message, 0, {UINT32_MAX, 0}, bytes).ok()) throw std::runtime_error("too long");
    return sendBytes(bytes);
}

bool TestClient::trySend(const proto::ClientMessage& message) {
    pollfd writable{socket_, POLLOUT, 0};
    // A Unix stream socket is writable where at least a quarter of its buffer is free: room for a small one.
    return ::poll(&writable, 1, 0) == 1 && (writable.revents & POLLOUT) != 0 && send(message);
}

void TestClient::shutdownSend() {
    ::shutdown(socket_, SHUT_WR);
}

bool TestClient::readAll(void* to, std::size_t size) {
    auto* bytes = static_cast<std::uint8_t*>(to);
    std::size_t done = 0;
    while (done < size) {
        pollfd readable{socket_, POLLIN, 0};
        if (::poll(&readable, 1, patienceMs) == 0) throw std::runtime_error("the server says nothing");
        const ssize_t count = ::recv(socket_, bytes + done, size - done, 0);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0 && done == 0) return false;
        if (count <= 0) throw std::runtime_error("the server hung up in the midst of a message");
        done += static_cast<std::size_t>(count);
    }
    return true;
}

void TestClient::greet(wire::Version version) {
    sendBytes(wire::encodeGreeting(version));
    wire::Greeting theirs{};
    if (!readAll(theirs.data(), theirs.size())) throw std::runtime_error("no greeting");
    if (!wire::decodeGreeting(theirs).ok()) throw std::runtime_error("a bad greeting");
}

Received TestClient::connect(const std::string& token, bool background) {
    proto::Hello hello;
    hello.set_token(token);
    hello.set_client("test");
    hello.set_background(background);
    return connect(hello);
}

Received TestClient::connect(const proto::Hello& hello) {
    greet();
    proto::ClientMessage message;
    message.set_request(++request_);
    *message.mutable_hello() = hello;
    send(message);
    auto first = receive();
    if (!first) throw std::runtime_error("no answer to hello");
    return *std::move(first);
}

std::optional<Received> TestClient::receive() {
    wire::Header bytes{};
    if (!readAll(bytes.data(), bytes.size())) return std::nullopt;
    const auto header = wire::decodeHeader(bytes, wire::serverLimits);
    if (!header.ok()) throw std::runtime_error(header.error().toString());
    Received received;
    std::vector<std::uint8_t> message(header->message);
    received.payload.resize(header->payload);
    if (!message.empty() && !readAll(message.data(), message.size())) return std::nullopt;
    if (header->payload > 0 && !readAll(received.payload.data(), header->payload)) return std::nullopt;
    if (!wire::decodeMessage(message, received.message).ok()) throw std::runtime_error("a bad message");
    return received;
}

Received TestClient::receive(const std::function<bool(const proto::ServerMessage&)>& fits) {
    for (;;) {
        auto received = receive();
        if (!received) throw std::runtime_error("the server closed the connection");
        if (fits(received->message)) return *std::move(received);
    }
}

Received TestClient::receiveFrame() {
    return receive([](const proto::ServerMessage& message) { return message.has_frame(); });
}

Received TestClient::receiveReply(std::uint64_t request) {
    return receive([request](const proto::ServerMessage& message) { return message.reply_to() == request; });
}

Received TestClient::ask(proto::ClientMessage message) {
    message.set_request(++request_);
    send(message);
    return receiveReply(request_);
}

void TestClient::barrier() {
    proto::ClientMessage ping;
    ping.mutable_ping();
    ask(ping);
}

bool TestClient::atEnd() {
    for (int i = 0; i < 1000; ++i) {
        std::uint8_t bytes[4096];
        pollfd readable{socket_, POLLIN, 0};
        if (::poll(&readable, 1, patienceMs) == 0) return false;
        if (::recv(socket_, bytes, sizeof bytes, 0) <= 0) return true;
    }
    return false;
}

void TestClient::setView(std::uint64_t id, std::uint32_t width, bool moving, bool finalOnly,
                         proto::PixelFormat format) {
    proto::ClientMessage message;
    message.set_request(++request_);
    auto& view = *message.mutable_set_view();
    view.set_view_id(id);
    view.set_moving(moving);
    view.set_final_only(finalOnly);
    view.set_format(format);
    view.set_asked_ns(static_cast<std::int64_t>(1000 + id));
    view.mutable_view()->set_width(width);
    view.mutable_view()->set_height(width);
    send(message);
}

std::uint64_t TestClient::queueView(std::uint64_t id, std::uint32_t width, bool finalOnly) {
    proto::ClientMessage message;
    message.set_request(++request_);
    auto& view = *message.mutable_set_view();
    view.set_view_id(id);
    view.set_final_only(finalOnly);
    view.set_queued(true);
    view.mutable_view()->set_width(width);
    view.mutable_view()->set_height(width);
    send(message);
    return request_;
}

void TestClient::credit(std::uint32_t frames) {
    proto::ClientMessage message;
    message.mutable_credit()->set_frames(frames);
    send(message);
}

}  // namespace mote::test
