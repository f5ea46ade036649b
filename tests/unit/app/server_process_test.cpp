// SPDX-License-Identifier: GPL-3.0-or-later
//
// The program itself: its one line, its signals and what it leaves behind.
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/session/test_client.h"

#include <gtest/gtest.h>

extern char** environ;

namespace mote::test {
namespace {

namespace fs = std::filesystem;

/// A child process and what it says on stdout; ended with the object.
class Process {
  public:
    explicit Process(std::vector<std::string> words) {
        std::array<int, 2> pipe{};
        if (::pipe(pipe.data()) != 0) throw std::runtime_error("no pipe");
        posix_spawn_file_actions_t actions;
        ::posix_spawn_file_actions_init(&actions);
        ::posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
        ::posix_spawn_file_actions_addclose(&actions, pipe[0]);
        std::vector<char*> pointers;
        for (auto& word : words) pointers.push_back(word.data());
        pointers.push_back(nullptr);
        const int failed = ::posix_spawn(&pid_, pointers[0], &actions, nullptr, pointers.data(), environ);
        ::posix_spawn_file_actions_destroy(&actions);
        ::close(pipe[1]);
        output_ = pipe[0];
        if (failed != 0) throw std::runtime_error("cannot start " + words[0]);
    }
    ~Process() {
        if (pid_ > 0 && !ended_) {
            ::kill(pid_, SIGKILL);
            wait();
        }
        ::close(output_);
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    /// Up to the end of a line or of the output.
    std::string line() {
        std::string text;
        char c = 0;
        while (::read(output_, &c, 1) == 1 && c != '\n') text += c;
        return text;
    }
    void signal(int number) { ::kill(pid_, number); }
    /// The exit code, or minus the signal.
    int wait() {
        int status = 0;
        while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        ended_ = true;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

  private:
    pid_t pid_ = -1;
    int output_ = -1;
    bool ended_ = false;
};

class ServerProcess : public testing::Test {
  protected:
    ServerProcess() { fs::create_directory(folder_ / "data"); }

    std::vector<std::string> command() const {
        return {MOTE_BIN "/mote-server",
                "--root",
                "data=" + (folder_ / "data").string(),
                "--state",
                (folder_ / "state").string(),
                "--connection",
                file().string()};
    }
    fs::path file() const { return folder_ / "connection.json"; }

    TempDir folder_;
};

TEST_F(ServerProcess, SaysReadyServesAndEndsCleanlyOnASignal) {
    for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
        Process server(command());
        const std::string line = server.line();
        ASSERT_TRUE(line.starts_with("ready ")) << line;
        const auto connection = wire::readConnectionFile(file());
        ASSERT_TRUE(connection.ok()) << connection.error().toString();
        const fs::path socket = wire::parseAddress(connection->address())->path;
        TestClient client(socket);
        EXPECT_TRUE(client.connect(connection->token()).message.has_welcome());
        client.setView(1, 64, false, true);
        EXPECT_TRUE(client.receiveFrame().message.frame().final());
        server.signal(number);
        EXPECT_EQ(server.wait(), 0);
        EXPECT_TRUE(client.atEnd());
        EXPECT_FALSE(fs::exists(socket));
        EXPECT_FALSE(fs::exists(file()));
    }
}

TEST_F(ServerProcess, KilledOneIsReplaced) {
    {
        Process server(command());
        ASSERT_TRUE(server.line().starts_with("ready "));
        server.signal(SIGKILL);
        EXPECT_EQ(server.wait(), -SIGKILL);
        EXPECT_TRUE(fs::exists(file()));
    }
    Process server(command());
    EXPECT_TRUE(server.line().starts_with("ready "));
    const auto connection = wire::readConnectionFile(file());
    ASSERT_TRUE(connection.ok());
    TestClient client(wire::parseAddress(connection->address())->path);
    EXPECT_TRUE(client.connect(connection->token()).message.has_welcome());
    // A second one next to it is refused and changes nothing.
    Process second(command());
    EXPECT_EQ(second.line(), "");
    EXPECT_EQ(second.wait(), 1);
    client.barrier();
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait(), 0);
}

/// A library that is no library is found in the place of the one that is installed.
TEST_F(ServerProcess, WhereThereIsNoEglTheProcessorDraws) {
    const fs::path libraries = folder_ / "libraries";
    fs::create_directory(libraries);
    std::ofstream(libraries / "libEGL.so.1") << "none";
    ::setenv("LD_LIBRARY_PATH", libraries.c_str(), 1);
    const auto line = [&](const char* device) {
        auto words = command();
        words.insert(words.end(), {"--device", device});
        Process server(words);
        const auto said = server.line();
        server.signal(SIGTERM);
        return std::pair(said, server.wait());
    };
    const auto best = line("auto");
    const auto egl = line("egl");
    ::unsetenv("LD_LIBRARY_PATH");
    EXPECT_TRUE(best.first.starts_with("ready ")) << best.first;
    EXPECT_NE(best.first.find(" cpu "), std::string::npos) << best.first;
    EXPECT_EQ(best.second, 0);
    EXPECT_EQ(egl, std::pair(std::string(), 1));
}

TEST_F(ServerProcess, WrongUsageIsTwo) {
    Process server({MOTE_BIN "/mote-server", "--listen", "tcp:127.0.0.1"});
    EXPECT_EQ(server.wait(), 2);
}

}  // namespace
}  // namespace mote::test
