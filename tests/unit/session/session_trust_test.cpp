// SPDX-License-Identifier: GPL-3.0-or-later
//
// What strangers and broken clients send: one clear failure where possible, and the server goes on.
#include <random>

#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

class SessionTrust : public SessionFixture {
  protected:
    /// The stream holds one fatal failure of that code, and ends.
    static void expectFailure(TestClient& client, const std::string& code, const std::string& where) {
        const auto received = client.receive();
        ASSERT_TRUE(received.has_value());
        const auto& failure = received->message.failure();
        EXPECT_EQ(failure.code(), code) << failure.ShortDebugString();
        EXPECT_EQ(failure.where(), where);
        EXPECT_FALSE(failure.message().empty());
        EXPECT_TRUE(failure.fatal());
        EXPECT_TRUE(client.atEnd());
    }

    void expectServing() {
        const auto good = client();
        good->setView(1, 16);
        EXPECT_EQ(good->receiveFrame().message.frame().view_id(), 1u);
    }
};

TEST_F(SessionTrust, WrongTokenIsRefused) {
    start();
    std::string almost = connection_.token();
    almost.back() = almost.back() == '0' ? '1' : '0';
    for (const std::string& token : {std::string(), std::string("00"), almost, connection_.token() + "0"}) {
        TestClient client(socket());
        const auto first = client.connect(token);
        EXPECT_EQ(first.message.failure().code(), "permission_denied");
        EXPECT_EQ(first.message.failure().where(), "hello.token");
        EXPECT_TRUE(first.message.failure().fatal());
        EXPECT_TRUE(client.atEnd());
    }
    EXPECT_EQ(connection_.token().size(), 64u);
    expectServing();
}

TEST_F(SessionTrust, NobodyIsServedWithoutHello) {
    start();
    TestClient client(socket());
    client.greet();
    proto::ClientMessage list;
    list.mutable_list_datasets();
    client.send(list);
    expectFailure(client, "permission_denied", "hello.token");
    expectServing();
}

TEST_F(SessionTrust, AnotherMajorVersionIsOneClearError) {
    start();
    TestClient client(socket());
    client.greet({static_cast<std::uint16_t>(wire::ownVersion.major + 1), 0});
    expectFailure(client, "unsupported", "greeting");
    expectServing();
}

TEST_F(SessionTrust, AnotherMinorVersionIsWelcome) {
    start();
    TestClient client(socket());
    client.greet({wire::ownVersion.major, 77});
    proto::ClientMessage hello;
    hello.mutable_hello()->set_token(connection_.token());
    client.send(hello);
    EXPECT_TRUE(client.receive()->message.has_welcome());
    // A message of that version: known to have no body that we know.
    EXPECT_EQ(client.ask({}).message.failure().code(), "unsupported");
    client.barrier();
}

TEST_F(SessionTrust, LengthsBeyondTheLimitsAreRefused) {
    start();
    for (const wire::FrameHeader header : {wire::FrameHeader{4097, 0}, {0, 1}, {UINT32_MAX, UINT32_MAX}}) {
        TestClient client(socket());
        client.greet();
        client.sendHeader(header);
        expectFailure(client, "resource_exhausted", header.message > 4096 ? "message" : "payload");
    }
    for (const wire::FrameHeader header : {wire::FrameHeader{(1u << 20) + 1, 0}, {0, 1}}) {
        const auto known = client();
        known->sendHeader(header);
        expectFailure(*known, "resource_exhausted", header.payload == 0 ? "message" : "payload");
    }
    expectServing();
}

TEST_F(SessionTrust, BytesThatAreNoMessageAreRefused) {
    start();
    const auto known = client();
    known->sendHeader({3, 0});
    known->sendBytes(std::vector<std::uint8_t>{0xff, 0xff, 0xff});
    expectFailure(*known, "corrupt", "message");
    expectServing();
}

TEST_F(SessionTrust, HelloTwiceIsRefused) {
    start();
    const auto known = client();
    proto::ClientMessage hello;
    hello.mutable_hello()->set_token(connection_.token());
    known->send(hello);
    expectFailure(*known, "invalid_argument", "hello");
}

TEST_F(SessionTrust, SilentClientIsNotWaitedFor) {
    settings_.handshakeTimeout = std::chrono::milliseconds(1);
    start();
    TestClient greeted(socket());
    greeted.greet();
    expectFailure(greeted, "cancelled", "hello");
    TestClient silent(socket());
    EXPECT_TRUE(silent.atEnd());
}

TEST_F(SessionTrust, TooManyClientsAreTurnedAwayWithAReason) {
    settings_.maxSessions = 2;
    start();
    const auto one = client();
    const auto two = client();
    TestClient third(socket());
    const auto refused = third.connect(connection_.token());
    EXPECT_EQ(refused.message.failure().code(), "resource_exhausted");
    EXPECT_EQ(refused.message.failure().where(), "server");
    EXPECT_TRUE(third.atEnd());
    one->barrier();
    two->barrier();
}

/// Random bytes at every stage of a connection. Whatever they are, the connection ends and the server does
/// not.
TEST_F(SessionTrust, RandomBytesEndOneConnectionAlone) {
    start();
    std::mt19937_64 random(20260731);
    for (int i = 0; i < 300; ++i) {
        TestClient client(socket());
        const auto stage = random() % 4;
        if (stage == 1) client.greet();
        if (stage >= 2) client.connect(connection_.token());
        std::vector<std::uint8_t> bytes(random() % 3000);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
        if (stage == 3) {
            // Whole frames of random messages: they pass the framing and meet the parser and the sessions.
            const auto size = static_cast<std::uint32_t>(random() % 40);
            client.sendHeader({size, 0});
            bytes.resize(size);
        }
        client.sendBytes(bytes);
        client.shutdownSend();
        EXPECT_TRUE(client.atEnd()) << i;
    }
    expectServing();
}

/// Well-formed messages with random content: views, commands and credits that nobody would send.
TEST_F(SessionTrust, RandomMessagesNeverEndTheServer) {
    start();
    std::mt19937_64 random(7);
    const auto number = [&] { return static_cast<double>(random() % 2000) - 1000.0; };
    for (int i = 0; i < 200; ++i) {
        const auto known = client();
        for (int k = 0; k < 10; ++k) {
            proto::ClientMessage message;
            message.set_request(random());
            switch (random() % 6) {
                case 0: {
                    auto& view = *message.mutable_set_view()->mutable_view();
                    view.set_width(static_cast<std::uint32_t>(random() % 300));
                    view.set_height(static_cast<std::uint32_t>(random() % 300));
                    for (int n = 0; n < 3; ++n) view.mutable_camera()->add_eye(number());
                    if (random() % 2 == 0) view.add_layers()->set_dataset("data/../../etc");
                    message.mutable_set_view()->set_format(static_cast<proto::PixelFormat>(random() % 5));
                    message.mutable_set_view()->set_final_only(random() % 2 == 0);
                    break;
                }
                case 1:
                    message.mutable_credit()->set_frames(static_cast<std::uint32_t>(random() % 2));
                    break;
                case 2:
                    message.mutable_describe()->set_dataset(std::string(random() % 100, '/'));
                    break;
                case 3:
                    message.mutable_cancel_job()->set_id("../" + std::to_string(random()));
                    break;
                case 4:
                    message.mutable_submit_job()->mutable_job()->set_output("data/x");
                    break;
                default:
                    message.mutable_list_datasets();
            }
            if (!known->send(message)) break;
        }
        known->shutdownSend();
        EXPECT_TRUE(known->atEnd());
    }
    expectServing();
}

}  // namespace
}  // namespace mote::test
