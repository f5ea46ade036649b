// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-supervise under a limit of file sizes: what cannot be written is an error that is told, and no death.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

#include "tests/support/temp_dir.h"

namespace mote::server {
namespace {

/// Runs it to its end over /bin/true; its status as waitpid tells it.
int superviseWithin(const std::string& directory, rlim_t bytes, const std::string& errors) {
    std::array<int, 2> gate{};
    EXPECT_EQ(::pipe(gate.data()), 0);
    EXPECT_EQ(::write(gate[1], "g", 1), 1);
    // A pipe: the limit is one of files.
    std::array<int, 2> said{};
    EXPECT_EQ(::pipe(said.data()), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit limit{bytes, bytes};
        ::dup2(said[1], STDERR_FILENO);
        ::dup2(gate[0], 3);
        ::setrlimit(RLIMIT_FSIZE, &limit);
#ifdef __SANITIZE_THREAD__
        ::setenv("TMPDIR", "/nowhere", 1);  // ThreadSanitizer begins with a file of its own, where it can
#endif
        ::execl(MOTE_BIN "/mote-supervise", "mote-supervise", "--directory", directory.c_str(), "--",
                "/bin/true", nullptr);
        ::_exit(99);
    }
    ::close(said[1]);
    std::string text(4096, '\0');
    const auto got = ::read(said[0], text.data(), text.size());
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    for (const int each : {gate[0], gate[1], said[0]}) ::close(each);
    EXPECT_NE(text.find(errors), std::string::npos) << text;
    return status;
}

TEST(SuperviseLimit, AResultThatCannotBeWrittenIsToldAndNoDeath) {
    const test::TempDir folder;
    const int status = superviseWithin(folder.path().string(), 0, "result cannot be written");
    ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    EXPECT_EQ(WEXITSTATUS(status), 1);
    EXPECT_FALSE(std::filesystem::exists(folder / "result"));
}

TEST(SuperviseLimit, WhereThereIsRoomItIsWritten) {
    const test::TempDir folder;
    const int status = superviseWithin(folder.path().string(), 4096, "");
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "result"));
}

}  // namespace
}  // namespace mote::server
