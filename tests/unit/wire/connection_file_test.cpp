// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/connection_file.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <fstream>

namespace mote::wire {
namespace {

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
