// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/client/fake_server.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <turbojpeg.h>
#include <unistd.h>
#include <zstd.h>
#include <cstring>
#include <stdexcept>

#include "protocol/wire/connection_file.h"
#include "protocol/wire/framing.h"
#include "protocol/wire/row_filter.h"

namespace mote::test {
namespace {

void require(bool condition, const char* what) {
    if (!condition) throw std::runtime_error(what);
}

}  // namespace

std::vector<std::uint8_t> samplePixels(std::uint32_t width, std::uint32_t height, proto::PixelFormat format) {
    const std::size_t size = wire::pixelSize(format), channel = size / 4;
    std::vector<std::uint8_t> bytes(size * width * height);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const std::size_t pixel = i / size, row = pixel / width, column = pixel % width;
        // A slope, a slope across it, and steps: differences of both signs and zero. As halves all these
        // are positive and finite.
        bytes[i] = static_cast<std::uint8_t>((3 * column + 5 * row + 17 * ((i % size) / channel)) % 61);
        if (i % size < 3 * channel) continue;
        bytes[i] = format == proto::SRGB8 ? 255 : (i % 2 == 0 ? 0x00 : 0x3c);
    }
    return bytes;
}

proto::Frame frameMessage(std::uint32_t width, std::uint32_t height, proto::PixelFormat format,
                          proto::Frame::Encoding encoding) {
    proto::Frame frame;
    frame.set_width(width);
    frame.set_height(height);
    frame.set_format(format);
    frame.set_encoding(encoding);
    frame.set_final(true);
    return frame;
}

std::string zstdPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width,
                        proto::PixelFormat format) {
    const std::size_t pixels = rgba.size() / wire::pixelSize(format);
    std::vector<std::uint8_t> filtered(pixels * wire::filteredPixelSize(format));
    wire::filterRows(format, width, rgba, filtered);
    std::string packed(ZSTD_compressBound(filtered.size()), '\0');
    const auto size = ZSTD_compress(packed.data(), packed.size(), filtered.data(), filtered.size(), 1);
    require(!ZSTD_isError(size), "zstd");
    packed.resize(size);
    return packed;
}

std::string jpegPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width) {
    const tjhandle jpeg = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    const int rows = static_cast<int>(rgba.size() / (4 * width));
    const int status = tjCompress2(jpeg, rgba.data(), static_cast<int>(width), 0, rows, TJPF_RGBA, &bytes,
                                   &size, TJSAMP_444, 100, 0);
    std::string payload(reinterpret_cast<char*>(bytes), status == 0 ? size : 0);
    tjFree(bytes);
    tjDestroy(jpeg);
    require(status == 0, "libjpeg-turbo");
    return payload;
}

namespace {

constexpr int patienceMs = 20'000;

void awaitReadable(int descriptor, const char* what) {
    pollfd readable{descriptor, POLLIN, 0};
    require(::poll(&readable, 1, patienceMs) == 1, what);
}

}  // namespace

FakeServer::FakeServer() {
    const auto path = (folder_ / "socket").string();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    require(path.size() < sizeof(address.sun_path), "the temporary folder's path is too long");
    std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
    listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    require(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0, "bind");
    require(::listen(listener_, 8) == 0, "listen");
    proto::ConnectionFile file;
    file.set_address("unix:" + path);
    file.set_token(token);
    file.set_pid(::getpid());
    file.set_protocol_major(wire::ownVersion.major);
    file.set_protocol_minor(wire::ownVersion.minor);
    require(wire::writeConnectionFile(connectionFile(), file).ok(), "connection file");
}

FakeServer::~FakeServer() {
    drop();
    stop();
}

void FakeServer::acceptSocket() {
    drop();
    awaitReadable(listener_, "nobody connects");
    client_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    require(client_ >= 0, "accept");
}

void FakeServer::turnAway(const proto::ServerMessage& reason) {
    acceptSocket();
    const auto greeting = wire::encodeGreeting(wire::ownVersion);
    std::vector<std::uint8_t> frame;
    require(wire::encodeFrame(reason, 0, wire::serverLimits, frame).ok(), "too long");
    std::string bytes(greeting.begin(), greeting.end());
    bytes.append(frame.begin(), frame.end());
    sendRaw(bytes);
    drop();
}

void FakeServer::accept() {
    acceptUngreeted();
    greet();
}

void FakeServer::acceptUngreeted() {
    acceptSocket();
    const auto greeting = wire::encodeGreeting(wire::ownVersion);
    const std::string theirs = receive(greeting.size());
    require(std::equal(theirs.begin(), theirs.end(), greeting.begin(),
                       [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }),
            "not our greeting");
}

void FakeServer::greet() {
    const auto greeting = wire::encodeGreeting(wire::ownVersion);
    sendRaw({greeting.begin(), greeting.end()});
}

void FakeServer::welcome(std::uint32_t minor) {
    proto::Welcome welcome;
    welcome.set_minor(minor);
    this->welcome(std::move(welcome));
}

proto::Hello FakeServer::welcome(proto::Welcome welcome) {
    accept();
    const auto hello = read(proto::ClientMessage::kHello);
    require(hello.hello().token() == token, "the token is another");
    proto::ServerMessage message;
    message.set_reply_to(hello.request());
    welcome.set_server("fake 1");
    welcome.set_device("paper");
    welcome.set_frame_credits(wire::frameCredits);
    *message.mutable_welcome() = std::move(welcome);
    send(message);
    return hello.hello();
}

std::string FakeServer::receive(std::size_t size) {
    std::string bytes(size, '\0');
    std::size_t done = 0;
    while (done < size) {
        awaitReadable(client_, "the client sends nothing");
        const auto count = ::read(client_, bytes.data() + done, size - done);
        require(count > 0, "the client closed the connection");
        done += static_cast<std::size_t>(count);
    }
    return bytes;
}

proto::ClientMessage FakeServer::read() {
    wire::Header header{};
    const auto bytes = receive(header.size());
    std::memcpy(header.data(), bytes.data(), header.size());
    const auto lengths = wire::decodeHeader(header, wire::clientLimits);
    require(lengths.ok() && lengths->payload == 0, "a header beyond the limits");
    proto::ClientMessage message;
    require(message.ParseFromString(receive(lengths->message)), "no message");
    return message;
}

proto::ClientMessage FakeServer::read(proto::ClientMessage::BodyCase body) {
    auto message = read();
    while (message.body_case() != body) message = read();
    return message;
}

bool FakeServer::quiet() const {
    pollfd readable{client_, POLLIN, 0};
    return ::poll(&readable, 1, 0) == 0;
}

void FakeServer::send(const proto::ServerMessage& message, const std::string& payload) {
    std::vector<std::uint8_t> bytes;
    require(wire::encodeFrame(message, payload.size(), wire::serverLimits, bytes).ok(), "too long");
    sendRaw({bytes.begin(), bytes.end()});
    sendRaw(payload);
}

void FakeServer::sendRaw(const std::string& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const auto count = ::send(client_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
        require(count > 0, "cannot send");
        done += static_cast<std::size_t>(count);
    }
}

void FakeServer::stopReading() {
    require(::shutdown(client_, SHUT_RD) == 0, "shutdown");
}

void FakeServer::drop() {
    if (client_ >= 0) ::close(client_);
    client_ = -1;
}

void FakeServer::stop() {
    if (listener_ >= 0) ::close(listener_);
    listener_ = -1;
}

}  // namespace mote::test
