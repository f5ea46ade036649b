// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <array>
#include <asio/co_spawn.hpp>
#include <asio/io_context.hpp>
#include <asio/local/connect_pair.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/write.hpp>
#include <fstream>
#include <optional>
#include <random>

#include "protocol/mote.pb.h"
#include "protocol/wire/connection_file.h"
#include "protocol/wire/message_stream.h"
#include "protocol/wire/tls.h"

namespace mote::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

TlsIdentity identity() {
    return TlsIdentity::parse(TlsIdentity::makePem().value()).value();
}

/// The two ends of one connection on one thread.
class Tls : public testing::Test {
  protected:
    Tls() { asio::local::connect_pair(near_, far_); }

    MessageStream server() { return MessageStream(tlsServerStream(std::move(near_), identity_)); }
    MessageStream client(const std::string& fingerprint) {
        return MessageStream(tlsClientStream(std::move(far_), fingerprint));
    }

    template <class Coroutine>
    void spawn(Coroutine coroutine) {
        asio::co_spawn(context_, std::move(coroutine), [](std::exception_ptr error) {
            if (error) std::rethrow_exception(error);
        });
    }

    const TlsIdentity identity_ = identity();
    asio::io_context context_;
    asio::local::stream_protocol::socket near_{context_}, far_{context_};
};

TEST_F(Tls, FramesArriveAsTheyWereSent) {
    MessageStream sender = server(), receiver = client(identity_.fingerprint());
    std::mt19937 random(5);
    std::array<Bytes, 6> payloads;
    for (const std::size_t i : {1, 2, 3, 4, 5}) {
        payloads[i].resize(random() % 300000);
        for (auto& byte : payloads[i]) byte = static_cast<std::uint8_t>(random());
    }
    spawn([&]() -> asio::awaitable<void> {
        EXPECT_TRUE((co_await sender.greet()).ok());
        for (std::size_t i = 0; i < payloads.size(); ++i) {
            proto::ServerMessage message;
            message.set_reply_to(i);
            EXPECT_TRUE((co_await sender.write(message, payloads[i], serverLimits)).ok());
        }
        sender.close();
    });
    std::size_t count = 0;
    spawn([&]() -> asio::awaitable<void> {
        EXPECT_TRUE((co_await receiver.greet()).ok());
        proto::ServerMessage message;
        Bytes payload;
        for (;;) {
            const auto status = co_await receiver.read(message, payload, serverLimits);
            if (!status.ok()) {
                EXPECT_EQ(status.error().code, ErrorCode::cancelled) << status.error().toString();
                co_return;
            }
            EXPECT_EQ(message.reply_to(), count);
            EXPECT_EQ(payload, payloads[count]);
            ++count;
        }
    });
    context_.run();
    EXPECT_EQ(count, payloads.size());
}

TEST_F(Tls, AnotherCertificateIsTalkedToNoFurther) {
    MessageStream impostor = server(), victim = client(identity().fingerprint());
    std::optional<Error> reason;
    spawn([&]() -> asio::awaitable<void> {
        const auto version = co_await victim.greet();
        if (!version.ok()) reason = version.error();
        victim.close();
    });
    spawn([&]() -> asio::awaitable<void> {
        const auto version = co_await impostor.greet();
        EXPECT_FALSE(version.ok());  // nothing was said to it
    });
    context_.run();
    ASSERT_TRUE(reason);
    EXPECT_EQ(reason->code, ErrorCode::permissionDenied) << reason->toString();
    EXPECT_FALSE(victim.hasGreeted());
}

TEST_F(Tls, WhoIsTurnedAwayHearsThatThereIsNoPlace) {
    MessageStream full = server(), late = client(identity_.fingerprint());
    full.turnAway(proto::ServerMessage());
    std::optional<Error> reason;
    spawn([&]() -> asio::awaitable<void> {
        const auto version = co_await late.greet();
        if (!version.ok()) reason = version.error();
    });
    context_.run();
    ASSERT_TRUE(reason);
    EXPECT_EQ(reason->code, ErrorCode::resourceExhausted) << reason->toString();
}

TEST_F(Tls, AServerWithoutTlsIsNoneForAClientWithIt) {
    MessageStream plain(std::move(near_)), tls = client(identity_.fingerprint());
    spawn([&]() -> asio::awaitable<void> {
        EXPECT_FALSE((co_await plain.greet()).ok());
        plain.close();
    });
    std::optional<Error> reason;
    spawn([&]() -> asio::awaitable<void> {
        const auto version = co_await tls.greet();
        if (!version.ok()) reason = version.error();
        tls.close();
    });
    context_.run();
    ASSERT_TRUE(reason);
    EXPECT_FALSE(tls.hasGreeted());
}

TEST_F(Tls, ByteStreamsThatAreNoTlsEndTheirOwnConnection) {
    std::mt19937 random(9);
    for (int i = 0; i < 200; ++i) {
        asio::local::stream_protocol::socket near(context_), far(context_);
        asio::local::connect_pair(near, far);
        MessageStream stream(tlsServerStream(std::move(near), identity_));
        Bytes bytes(random() % 2000);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
        if (i % 2 == 0 && bytes.size() > 6) std::copy_n(Bytes{22, 3, 1, 2, 0, 1}.begin(), 6, bytes.begin());
        asio::write(far, asio::buffer(bytes));
        far.shutdown(asio::socket_base::shutdown_send);
        bool refused = false;
        spawn([&]() -> asio::awaitable<void> { refused = !(co_await stream.greet()).ok(); });
        context_.restart();
        context_.run();
        EXPECT_TRUE(refused) << i;
    }
}

TEST(TlsIdentityTest, IsWhatItsTextSays) {
    const auto pem = TlsIdentity::makePem().value();
    const auto one = TlsIdentity::parse(pem).value();
    EXPECT_TRUE(isFingerprint(one.fingerprint())) << one.fingerprint();
    EXPECT_EQ(TlsIdentity::parse(pem).value().fingerprint(), one.fingerprint());
    EXPECT_NE(identity().fingerprint(), one.fingerprint());
}

TEST(TlsIdentityTest, DamagedTextIsAnError) {
    const auto pem = TlsIdentity::makePem().value();
    const auto other = TlsIdentity::makePem().value();
    const auto cut = pem.find("-----BEGIN CERTIFICATE");
    const auto otherCut = other.find("-----BEGIN CERTIFICATE");
    for (const auto& text : {std::string(), pem.substr(0, cut), pem.substr(cut),
                             pem.substr(0, pem.size() / 2), pem.substr(0, cut) + other.substr(otherCut)}) {
        const auto parsed = TlsIdentity::parse(text);
        ASSERT_FALSE(parsed.ok());
        EXPECT_EQ(parsed.error().code, ErrorCode::corrupt);
    }
}

TEST(Fingerprint, Is64SmallHexadecimalDigits) {
    EXPECT_TRUE(isFingerprint(std::string(64, 'a')));
    for (const auto& text : {std::string(), std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'A'),
                             std::string(64, 'g')}) {
        EXPECT_FALSE(isFingerprint(text)) << text;
    }
}

namespace fs = std::filesystem;

class ConnectionFileTest : public testing::Test {
  protected:
    ConnectionFileTest() {
        std::string folder = (fs::temp_directory_path() / "mote-wire-XXXXXX").string();
        folder_ = ::mkdtemp(folder.data());
        content_.set_address("unix:/tmp/mote.sock");
        content_.set_token("0123456789abcdef");
        content_.set_pid(4711);
        content_.set_protocol_major(1);
        content_.set_protocol_minor(0);
    }
    ~ConnectionFileTest() override { fs::remove_all(folder_); }

    fs::path file() const { return folder_ / "connection.json"; }

    void write(const std::string& text, mode_t mode = 0600) {
        std::ofstream(file()) << text;
        ::chmod(file().c_str(), mode);
    }

    std::size_t filesInFolder() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
    }

    fs::path folder_;
    proto::ConnectionFile content_;
};

TEST_F(ConnectionFileTest, GoesThereAndBackForItsOwnerAlone) {
    ASSERT_TRUE(writeConnectionFile(file(), content_).ok());
    struct stat status {};
    ASSERT_EQ(::stat(file().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0600u);
    const auto read = readConnectionFile(file());
    ASSERT_TRUE(read.ok()) << read.error().toString();
    EXPECT_EQ(read->SerializeAsString(), content_.SerializeAsString());
    EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(ConnectionFileTest, TcpIsNothingWithoutAFingerprint) {
    content_.set_address("tcp:127.0.0.1:4711");
    for (const auto& fingerprint : {std::string(), std::string(63, 'a'), std::string(64, 'A')}) {
        content_.set_certificate_fingerprint(fingerprint);
        ASSERT_TRUE(writeConnectionFile(file(), content_).ok());
        const auto read = readConnectionFile(file());
        ASSERT_FALSE(read.ok()) << fingerprint;
        EXPECT_EQ(read.error().code, ErrorCode::invalidArgument);
    }
    content_.set_certificate_fingerprint(std::string(64, 'a'));
    ASSERT_TRUE(writeConnectionFile(file(), content_).ok());
    EXPECT_TRUE(readConnectionFile(file()).ok());
}

TEST_F(ConnectionFileTest, ReplacesAnOlderOneAndItsMode) {
    write("old", 0644);
    ASSERT_TRUE(writeConnectionFile(file(), content_).ok());
    EXPECT_TRUE(readConnectionFile(file()).ok());
    EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(ConnectionFileTest, OneThatOthersMayReadIsRefused) {
    ASSERT_TRUE(writeConnectionFile(file(), content_).ok());
    for (const mode_t mode : {0640, 0604, 0602, 0644}) {
        ::chmod(file().c_str(), mode);
        const auto read = readConnectionFile(file());
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error().code, ErrorCode::permissionDenied);
        EXPECT_NE(read.error().message.find("chmod 600"), std::string::npos);
    }
}

TEST_F(ConnectionFileTest, BadContentIsOneErrorThatNamesFileAndField) {
    const std::string good = R"("token": "00ff", "protocolMajor": 1)";
    const std::pair<std::string, std::string> cases[] = {
        {"", "connection.json"},
        {"nonsense", "connection.json"},
        {"{" + good + R"(, "colour": 3})", "colour"},
        {"{" + good + R"(, "address": "ftp:x"})", "address"},
        {R"({"address": "unix:/x", "protocolMajor": 1})", "token"},
        {R"({"address": "unix:/x", "token": "00 ff", "protocolMajor": 1})", "token"},
        {R"({"address": "unix:/x", "token": "00ff", "protocolMajor": 2})", "protocolMajor"},
        {std::string(100000, ' '), "connection.json"},
    };
    for (const auto& [text, word] : cases) {
        write(text);
        const auto read = readConnectionFile(file());
        ASSERT_FALSE(read.ok()) << text;
        EXPECT_NE(read.error().toString().find(word), std::string::npos) << read.error().toString();
        EXPECT_NE(read.error().toString().find("connection.json"), std::string::npos);
    }
}

TEST_F(ConnectionFileTest, WhatIsNoFileIsRefused) {
    EXPECT_EQ(readConnectionFile(file()).error().code, ErrorCode::notFound);
    EXPECT_EQ(readConnectionFile(folder_).error().code, ErrorCode::invalidArgument);
    ASSERT_EQ(::mkfifo(file().c_str(), 0600), 0);
    EXPECT_EQ(readConnectionFile(file()).error().code, ErrorCode::invalidArgument);
}

TEST_F(ConnectionFileTest, FailureToWriteLeavesNothing) {
    const auto nowhere = writeConnectionFile(folder_ / "absent" / "file", content_);
    ASSERT_FALSE(nowhere.ok());
    EXPECT_EQ(nowhere.error().code, ErrorCode::notFound);
    fs::create_directory(file());
    const auto occupied = writeConnectionFile(file(), content_);
    EXPECT_FALSE(occupied.ok());
    EXPECT_EQ(filesInFolder(), 1u);
}

}  // namespace
}  // namespace mote::wire
