// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a child that looks at foreign files may do, and what is said where it dies.
#include "preprocess/look/confined_child.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

using prep::runConfined;
using testing::HasSubstr;

class ConfinedChild : public testing::Test {
  protected:
    const prep::CancelSignal signal_;
};

TEST_F(ConfinedChild, GivesItsStatus) {
    for (const int status : {0, 1, 75}) {
        const auto ended = runConfined([&] { return status; }, {}, signal_);
        ASSERT_TRUE(ended.ok());
        EXPECT_EQ(*ended, status);
    }
}

TEST_F(ConfinedChild, DeathIsASentence) {
    const auto ended = runConfined(
        [] {
            std::raise(SIGSEGV);
            return 0;
        },
        {}, signal_);
    ASSERT_FALSE(ended.ok());
    EXPECT_EQ(ended.error().code, ErrorCode::corrupt);
    EXPECT_THAT(ended.error().message, HasSubstr("signal 11"));
}

TEST_F(ConfinedChild, TakesNoMoreTimeThanItIsGiven) {
    const auto ended = runConfined(
        [] {
            for (std::atomic<std::uint64_t> i{0};;) ++i;
            return 0;
        },
        {0, 1}, signal_);
    ASSERT_FALSE(ended.ok());
    EXPECT_EQ(ended.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(ended.error().message, HasSubstr("more than 1 s"));
}

TEST_F(ConfinedChild, ReadsAndDoesNotWrite) {
    if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, 1U) < 1) GTEST_SKIP() << "there is no Landlock";
    const TempDir folder;
    std::ofstream(folder / "read") << "here";
    const auto ended = runConfined(
        [&] {
            const bool reads = ::open((folder / "read").c_str(), O_RDONLY) >= 0;
            const bool writes = ::open((folder / "read").c_str(), O_WRONLY) >= 0;
            const bool makes = ::open((folder / "made").c_str(), O_CREAT | O_WRONLY, 0600) >= 0;
            const bool removes = ::unlink((folder / "read").c_str()) == 0;
            return (reads ? 1 : 0) + (writes ? 2 : 0) + (makes ? 4 : 0) + (removes ? 8 : 0);
        },
        {}, signal_);
    ASSERT_TRUE(ended.ok());
    EXPECT_EQ(*ended, 1);
}

}  // namespace
}  // namespace mote::test
