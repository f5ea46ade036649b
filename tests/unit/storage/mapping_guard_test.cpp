// SPDX-License-Identifier: GPL-3.0-or-later

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <thread>
#include <vector>

#include "storage/blocks/mapped_file.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/storage/file_time.h"

namespace mote::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::uint64_t page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));

void fill(const fs::path& path, std::uint64_t bytes) {
    std::ofstream(path, std::ios::binary) << std::string(bytes, 'x');
}

std::uint64_t sum(std::span<const std::byte> bytes) {
    std::uint64_t total = 0;
    for (const auto byte : bytes) total += static_cast<std::uint64_t>(byte);
    return total;
}

/// A mapping that nobody guards, of a file that has lost its bytes since.
const volatile char* lostMapping(const fs::path& path) {
    fill(path, 2 * page);
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    void* address = ::mmap(nullptr, 2 * page, PROT_READ, MAP_SHARED, file, 0);
    ::close(file);
    fs::resize_file(path, 0);
    return static_cast<const volatile char*>(address);
}

class MappingGuardTest : public testing::Test {
  protected:
    MappingGuardTest() { catchMappingFaults(); }
    test::TempDir folder_;
    const fs::path path_ = folder_ / "file";
};

using MappingGuardDeathTest = MappingGuardTest;

TEST_F(MappingGuardTest, BytesThatAreGoneAreZerosAndTheFaultIsKnown) {
    fill(path_, 8 * page);
    const auto file = MappedFile::open(path_, 8 * page);
    ASSERT_TRUE(file.ok());
    EXPECT_EQ(sum(file->bytes()), 8 * page * 'x');
    EXPECT_FALSE(file->damage());
    fs::resize_file(path_, 3 * page);
    EXPECT_EQ(sum(file->bytes()), 3 * page * 'x');
    EXPECT_TRUE(file->faulted());
    const auto damage = file->damage();
    ASSERT_TRUE(damage);
    EXPECT_EQ(damage->code, ErrorCode::corrupt);
    EXPECT_EQ(damage->where, path_.string());
    EXPECT_THAT(damage->message, HasSubstr("byte " + std::to_string(3 * page)));
}

TEST_F(MappingGuardTest, TheFirstOfSeveralFaultsIsToldWhateverTheOrder) {
    fill(path_, 8 * page);
    const auto file = MappedFile::open(path_, 8 * page);
    fs::resize_file(path_, 0);
    EXPECT_EQ(file->bytes()[6 * page], std::byte{0});
    EXPECT_EQ(file->bytes()[2 * page + 1], std::byte{0});
    EXPECT_EQ(file->bytes()[7 * page], std::byte{0});
    EXPECT_THAT(file->damage()->message, HasSubstr("byte " + std::to_string(2 * page)));
}

TEST_F(MappingGuardTest, AFileThatEndsWithinAPageFaultsNowhereButIsDamaged) {
    fill(path_, page);
    const auto file = MappedFile::open(path_, page);
    fs::resize_file(path_, page / 2);
    EXPECT_EQ(sum(file->bytes()), page / 2 * 'x');  // the kernel clears the rest of the page
    EXPECT_FALSE(file->faulted());
    EXPECT_THAT(file->damage()->message, HasSubstr("ends at byte " + std::to_string(page / 2)));
}

TEST_F(MappingGuardTest, AFileThatIsWrittenToIsDamaged) {
    fill(path_, page);
    const auto file = MappedFile::open(path_, page);
    // A time of its own, however coarse the file system's clock is.
    fs::last_write_time(path_, fs::last_write_time(path_) + std::chrono::seconds(1));
    EXPECT_THAT(file->damage()->message, HasSubstr("written to"));
}

TEST_F(MappingGuardTest, AFileThatIsWrittenToIsDamagedThoughItsTimeIsPutBack) {
    fill(path_, page);
    const auto file = MappedFile::open(path_, page);
    const auto before = fs::last_write_time(path_);
    test::awaitNextTime(path_);
    std::fstream(path_, std::ios::in | std::ios::out | std::ios::binary) << "other";
    fs::last_write_time(path_, before);
    ASSERT_EQ(fs::last_write_time(path_), before);
    const auto damage = file->damage();
    ASSERT_TRUE(damage);
    EXPECT_THAT(damage->message, HasSubstr("written to"));
}

TEST_F(MappingGuardTest, EachMappingHasItsOwnFaults) {
    fill(path_, 2 * page);
    fill(folder_ / "other", 2 * page);
    const auto file = MappedFile::open(path_, 2 * page);
    const auto other = MappedFile::open(folder_ / "other", 2 * page);
    fs::resize_file(path_, 0);
    EXPECT_EQ(sum(file->bytes()), 0U);
    EXPECT_EQ(sum(other->bytes()), 2 * page * 'x');
    EXPECT_TRUE(file->faulted());
    EXPECT_FALSE(other->faulted());
    EXPECT_FALSE(other->damage());
}

TEST_F(MappingGuardTest, ManyThreadsMayFaultAtOnceWhileOthersMapAndUnmap) {
    fill(path_, 64 * page);
    fill(folder_ / "other", page);
    const auto file = MappedFile::open(path_, 64 * page);
    fs::resize_file(path_, 0);
    std::vector<std::thread> threads;
    for (std::uint64_t i = 0; i < 4; ++i) {
        threads.emplace_back([&, i] {
            for (std::uint64_t at = 0; at < 64; ++at) {
                EXPECT_EQ(file->bytes()[(at * 7 + i * 16) % 64 * page], std::byte{0});
            }
        });
        threads.emplace_back([&] {
            for (int turn = 0; turn < 50; ++turn) {
                const auto other = MappedFile::open(folder_ / "other", page);
                EXPECT_EQ(sum(other->bytes()), page * 'x');
                EXPECT_FALSE(other->faulted());
            }
        });
    }
    for (auto& thread : threads) thread.join();
    EXPECT_TRUE(file->faulted());
}

TEST_F(MappingGuardTest, ThereAreManyButNotEndlesslyMany) {
    fill(path_, page);
    std::vector<MappingGuard> guards;
    const std::vector<std::byte> bytes(1);
    for (;;) {
        auto guard = MappingGuard::make(bytes);
        if (!guard.ok()) {
            EXPECT_EQ(guard.error().code, ErrorCode::resourceExhausted);
            break;
        }
        guards.push_back(*std::move(guard));
        ASSERT_LE(guards.size(), MappingGuard::most);
    }
    EXPECT_FALSE(MappedFile::open(path_, page).ok());
    guards.clear();
    EXPECT_TRUE(MappedFile::open(path_, page).ok());
}

TEST_F(MappingGuardDeathTest, AFaultElsewhereEndsTheProcessAsEver) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_DEATH(static_cast<void>(lostMapping(path_)[page]), "");
}

TEST_F(MappingGuardDeathTest, ASignalThatSomebodySentEndsTheProcessAsEver) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_DEATH(::raise(SIGBUS), "");
}

// By itself, as the handler is installed once a process: run by the test below.
TEST(EarlierHandler, DISABLED_TakesFaultsElsewhere) {
    struct sigaction action {};
    action.sa_handler = [](int) { ::_exit(42); };
    ::sigaction(SIGBUS, &action, nullptr);
    catchMappingFaults();
    test::TempDir folder;
    static_cast<void>(lostMapping(folder / "file")[page]);
}

TEST_F(MappingGuardDeathTest, AFaultElsewhereGoesToTheHandlerThatWasThereBefore) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto self = fs::read_symlink("/proc/self/exe").string();
    EXPECT_EXIT(::execl(self.c_str(), self.c_str(), "--gtest_filter=EarlierHandler.*",
                        "--gtest_also_run_disabled_tests", nullptr),
                testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace mote::storage
