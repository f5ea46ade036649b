// SPDX-License-Identifier: GPL-3.0-or-later
//
// Damaged HDF5 files: bytes flipped and files cut at seeded places. Every one is read or refused; none may
// crash or hang. HDF5 itself is part of what is tested, so each attempt runs in a child process with limits:
// the job process is the sandbox.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <random>

#include "tests/support/temp_dir.h"
#include "tests/unit/readers/h5_test_file.h"
#include "tests/unit/readers/source_test.h"

namespace mote::test {
namespace {

enum class Outcome { read, refused, crashed, stopped };

// In the child: exit codes that neither the sanitizers nor the C library use.
constexpr int exitRead = 40, exitRefused = 41, exitThrown = 42;

void limitChild() {
    const rlimit noCore{0, 0}, seconds{20, 20};
    setrlimit(RLIMIT_CORE, &noCore);
    setrlimit(RLIMIT_CPU, &seconds);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    const rlimit memory{2ul << 30, 2ul << 30};
    setrlimit(RLIMIT_AS, &memory);
#endif
}

Outcome attempt(const std::filesystem::path& path) {
    const pid_t child = fork();
    if (child == 0) {
        limitChild();
        try {
            _exit(errorOf({path}).empty() ? exitRead : exitRefused);
        } catch (...) {
            _exit(exitThrown);
        }
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGXCPU ? Outcome::stopped : Outcome::crashed;
    if (WEXITSTATUS(status) == exitRead) return Outcome::read;
    return WEXITSTATUS(status) == exitRefused ? Outcome::refused : Outcome::crashed;
}

std::string bytesOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Everything that the reader looks at: gzipped and plain datasets, constants, texts of both kinds, links.
std::string wholeFile(const std::filesystem::path& path) {
    {
        H5TestFile file(path);
        file.variableText("/", "openPMD", "2.0.0");
        file.text("/", "basePath", "/data/%T/");
        file.variableText("/", "particlesPath", "particles/");
        for (const char* iteration : {"/data/1", "/data/2"}) {
            const std::string e = std::string(iteration) + "/particles/e";
            std::vector<double> values(300);
            for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i * i % 101);
            file.gzipped(e + "/position/x", values, 64);
            file.data(e + "/position/y", values);
            file.constant(e + "/position/z", 1.0, 300);
            file.data(e + "/momentum/x", std::vector<float>(300, 1.0f));
            file.attribute(e + "/momentum", "macroWeighted", std::int64_t{1});
            file.data(e + "/weighting", std::vector<float>(300, 2.0f));
            file.data(e + "/id", std::vector<std::uint64_t>(300, 5));
            file.data(e + "/particleStatus", std::vector<std::int64_t>(300, 1));
            file.variableText(e, "speciesType", "electron");
        }
        H5Lcreate_soft("2", file.id(), "/data/3", H5P_DEFAULT, H5P_DEFAULT);
    }
    return bytesOf(path);
}

using H5Damage = SourceTest;
TEST_F(H5Damage, flippedBytesAreReadOrRefused) {
    const std::filesystem::path path = folder / "run.h5";
    const std::string whole = wholeFile(path);
    ASSERT_EQ(attempt(path), Outcome::read);
    std::mt19937_64 random(20240607);
    int read = 0, refused = 0;
    for (int i = 0; i < 600; ++i) {
        std::string damaged = whole;
        // One byte, or a few: more of them at the beginning, where the structure lies.
        const int flips = 1 + static_cast<int>(random() % 4);
        for (int k = 0; k < flips; ++k) {
            const std::size_t end = k % 2 == 0 ? whole.size() : std::min<std::size_t>(whole.size(), 4096);
            damaged[random() % end] = static_cast<char>(random());
        }
        writeFile(path, damaged);
        const Outcome outcome = attempt(path);
        EXPECT_NE(outcome, Outcome::crashed) << "attempt " << i;
        EXPECT_NE(outcome, Outcome::stopped) << "attempt " << i;
        (outcome == Outcome::read ? read : refused) += 1;
    }
    // Both must occur, or the flips hit nothing (or everything).
    EXPECT_GT(read, 50);
    EXPECT_GT(refused, 50);
}

TEST_F(H5Damage, filesCutAnywhereAreReadOrRefused) {
    const std::filesystem::path path = folder / "run.h5";
    const std::string whole = wholeFile(path);
    for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 150) {
        writeFile(path, std::string_view(whole).substr(0, size));
        const Outcome outcome = attempt(path);
        EXPECT_EQ(outcome, Outcome::refused) << "cut to " << size << " of " << whole.size();
    }
}

}  // namespace
}  // namespace mote::test

#if defined(__SANITIZE_ADDRESS__)
/// A size that a damaged file names is asked for by HDF5 itself, and it takes no for an answer.
extern "C" const char* __asan_default_options() {
    return "allocator_may_return_null=1";
}

/// HDF5 1.10 itself reads beyond its buffers where it decodes some damaged headers (H5Aexists). What is
/// looked for here is what our own code does.
extern "C" const char* __asan_default_suppressions() {
    return "interceptor_via_lib:libhdf5";
}
#endif
