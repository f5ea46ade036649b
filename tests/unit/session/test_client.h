// SPDX-License-Identifier: GPL-3.0-or-later
//
// TestClient: a blocking client over a real Unix socket that can also misbehave. It shares the framing with
// the server but nothing of its transport. Throws std::runtime_error where the server hangs up in the midst
// of a message or says nothing for a long while (a test that waits for nothing would never end).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/wire/framing.h"

namespace mote::test {

struct Received {
    proto::ServerMessage message;
    std::vector<std::uint8_t> payload;
};

class TestClient {
  public:
    explicit TestClient(const std::filesystem::path& socket);
    ~TestClient();
    TestClient(const TestClient&) = delete;
    TestClient& operator=(const TestClient&) = delete;

    /// False where the server no longer takes it.
    bool sendBytes(std::span<const std::uint8_t> bytes);
    bool sendHeader(wire::FrameHeader header);
    bool send(const proto::ClientMessage& message);
    /// As send, but gives up where the socket is full: nothing or all is sent.
    bool trySend(const proto::ClientMessage& message);
    void shutdownSend();

    void greet(wire::Version version = wire::ownVersion);
    /// Greets and says hello; returns the first message.
    Received connect(const std::string& token, bool background = false);
    Received connect(const proto::Hello& hello);

    /// The next message; nothing where the server has closed.
    std::optional<Received> receive();
    /// Skips messages that do not fit. Throws at the end.
    Received receive(const std::function<bool(const proto::ServerMessage&)>& fits);
    Received receiveFrame();
    /// The answer to this request.
    Received receiveReply(std::uint64_t request);
    /// Sends and returns the answer.
    Received ask(proto::ClientMessage message);
    /// Everything sent before was handled by the server's reader.
    void barrier();
    /// Reads up to the end; false where bytes keep coming.
    bool atEnd();

    /// Asks for a layerless view of this size.
    void setView(std::uint64_t id, std::uint32_t width, bool moving = true, bool finalOnly = false,
                 proto::PixelFormat format = proto::SRGB8);
    /// Likewise, in its turn, exactly. Returns the request.
    std::uint64_t queueView(std::uint64_t id, std::uint32_t width, bool finalOnly = true);
    void credit(std::uint32_t frames);

  private:
    bool readAll(void* to, std::size_t size);

    int socket_ = -1;
    std::uint64_t request_ = 0;
};

}  // namespace mote::test
