// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the fuzzers' inputs hold readers to, and how an input begins. Functions without state.
#pragma once

#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "preprocess/job.h"

namespace mote::test {

/// Aborts, which a fuzzer and a test both notice, whatever the build defines, and says where.
inline void require(bool condition, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    if (condition) return;
    std::fprintf(stderr, "%s:%d: what is required does not hold\n", file, line);
    std::abort();
}

/// The first line without its end, and what follows it.
inline std::pair<std::string_view, std::string_view> firstLine(std::string_view input) {
    const std::size_t end = std::min(input.find('\n'), input.size());
    return {input.substr(0, end), input.substr(std::min(end + 1, input.size()))};
}

/// The progress of a job that nobody looks at. Any thread.
class Silent final : public prep::Progress {
  public:
    void report(double, std::string_view) override {}
    void note(std::string_view) override {}
    bool cancelled() const override { return false; }
};

/// Those of a line of an input, one after the other. A value; any thread.
class Words {
  public:
    explicit Words(std::string_view line, char between = ' ') : rest_(line), between_(between) {}

    bool atEnd() const { return rest_.empty(); }
    /// "" behind the last one.
    std::string next() {
        const auto end = std::min(rest_.find(between_), rest_.size());
        std::string word = rest_.substr(0, end);
        rest_.erase(0, end + 1);
        return word;
    }
    /// `missing` where the next word is no number.
    template <class Number>
    Number number(Number missing) {
        const std::string word = next();
        Number value{};
        const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
        return code == std::errc() ? value : missing;
    }
    const std::string& rest() const { return rest_; }

  private:
    std::string rest_;
    char between_;
};

/// An input as a file that never touches the disk, with a path. Any thread.
class MemoryFile {
  public:
    explicit MemoryFile(std::string_view bytes) : descriptor_(memfd_create("fuzz", MFD_CLOEXEC)) {
        if (descriptor_ < 0 ||
            write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
            std::abort();
        }
    }
    ~MemoryFile() { close(descriptor_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  private:
    int descriptor_;
};

}  // namespace mote::test
