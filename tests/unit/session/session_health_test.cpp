// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server says of its health by HTTP: while its device fails, afterwards, and when it ends.
#include <asio/io_context.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>

#include "server/render/device.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

class SessionHealth : public SessionFixture {
  protected:
    SessionHealth() { settings_.metrics = "unix:" + place().string(); }

    std::filesystem::path place() const { return folder_ / "metrics.sock"; }

    std::string get(const std::string& page) {
        asio::io_context io;
        asio::local::stream_protocol::socket socket(io);
        socket.connect(place().string());
        asio::error_code end;
        asio::write(socket, asio::buffer("GET " + page + " HTTP/1.1\r\n\r\n"), end);
        std::string answer;
        asio::read(socket, asio::dynamic_buffer(answer), end);
        return answer;
    }
    bool well() { return get("/healthz").starts_with("HTTP/1.1 200"); }

    /// A view of which the device fails.
    void failToDraw(TestClient& client, std::uint64_t id) {
        control_->failNext([] { throw render::DeviceError("the driver was reset"); });
        client.setView(id, 64);
        client.receive([](const auto& message) { return message.has_failure(); });
    }
};

TEST_F(SessionHealth, OfADeviceThatFailedItIsBadUntilItDraws) {
    settings_.deviceFailureTold = std::chrono::hours(1);
    start();
    const auto one = client();
    EXPECT_TRUE(well());
    failToDraw(*one, 1);
    EXPECT_NE(get("/healthz").find("the device failed at the latest picture"), std::string::npos);
    EXPECT_NE(get("/metrics").find("\nmote_healthy 0\n"), std::string::npos);
    one->setView(2, 64);
    EXPECT_EQ(one->receiveFrame().message.frame().view_id(), 2u);
    EXPECT_TRUE(well());
}

TEST_F(SessionHealth, AnIdleServerDoesNotStayIllForEver) {
    settings_.deviceFailureTold = std::chrono::milliseconds(0);
    start();
    const auto one = client();
    failToDraw(*one, 1);
    EXPECT_TRUE(well()) << "its time is over, and nobody asks for a picture that would tell";
}

TEST_F(SessionHealth, AServerThatEndsIsNotThereAnyMore) {
    start();
    EXPECT_TRUE(well());
    server_->stop();
    thread_.join();
    EXPECT_FALSE(std::filesystem::exists(place())) << "it is still listened at, with nobody to answer";
}

}  // namespace
}  // namespace mote::test
