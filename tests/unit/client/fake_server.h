// SPDX-License-Identifier: GPL-3.0-or-later
//
// FakeServer: the other end of a Connection, moved by the test step by step on its own thread: nothing
// happens here that the test did not say. Every step fails the test by an exception where it takes longer
// than 20 s.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"
#include "tests/support/temp_dir.h"

namespace mote::test {

class FakeServer {
  public:
    static constexpr const char* token = "00112233445566778899aabbccddeeff";

    /// Listens and writes the connection file.
    FakeServer();
    ~FakeServer();
    FakeServer(const FakeServer&) = delete;
    FakeServer& operator=(const FakeServer&) = delete;

    std::filesystem::path connectionFile() const { return folder_ / "connection.json"; }

    /// Accepts a connection and exchanges greetings.
    void accept();
    /// The two halves of it: hears the client's greeting, and says ours.
    void acceptUngreeted();
    void greet();
    /// accept(), Hello and Welcome.
    /// `minor`: of the protocol that it speaks.
    void welcome(std::uint32_t minor = 0);
    /// The same with whatever else the welcome is to say. Returns the hello.
    proto::Hello welcome(proto::Welcome welcome);
    /// Accepts a connection, sends greeting and `reason` at once and closes, without having read a byte.
    void turnAway(const proto::ServerMessage& reason);
    proto::ClientMessage read();
    /// The next message with this body; others (pings, credits) are let pass.
    proto::ClientMessage read(proto::ClientMessage::BodyCase body);
    /// Whether nothing more is to be read right now.
    bool quiet() const;
    void send(const proto::ServerMessage& message, const std::string& payload = {});
    void sendRaw(const std::string& bytes);
    /// Closes the half of the connection that the client writes to.
    void stopReading();
    /// Closes the connection, goes on listening.
    void drop();
    /// Ends as a killed server does: the socket's file stays.
    void stop();

  private:
    void acceptSocket();
    std::string receive(std::size_t size);

    TempDir folder_;
    int listener_ = -1;
    int client_ = -1;
};

}  // namespace mote::test
