// SPDX-License-Identifier: GPL-3.0-or-later
//
// The corpus of the table fuzzer, replayed: every ok- file is read, every bad- file is refused with a
// sentence, and no shortened or altered form of one does harm.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/fuzz/table_input.h"

namespace mote::test {
namespace {

std::vector<std::pair<std::string, std::string>> corpus() {
    std::vector<std::pair<std::string, std::string>> files;
    for (const auto& entry : std::filesystem::directory_iterator(MOTE_CORPUS "/table")) {
        std::ifstream file(entry.path(), std::ios::binary);
        files.emplace_back(entry.path().filename().string(), std::string(std::istreambuf_iterator<char>(file),
                                                                         std::istreambuf_iterator<char>()));
    }
    return files;
}

TEST(TableCorpus, isReadOrRefusedAsItsNamesSay) {
    int ok = 0, bad = 0;
    for (const auto& [name, bytes] : corpus()) {
        const std::string error = readTable(bytes);
        const bool shouldRead = name.starts_with("ok-");
        EXPECT_EQ(error.empty(), shouldRead) << name << ": " << error;
        (shouldRead ? ok : bad) += 1;
    }
    EXPECT_GE(ok, 10);
    EXPECT_GE(bad, 10);
}

TEST(TableCorpus, survivesBeingCutAndAltered) {
    std::mt19937_64 random(4711);
    for (const auto& [name, bytes] : corpus()) {
        if (bytes.size() < 2 || bytes.size() > 4096) continue;
        for (int i = 0; i < 150; ++i) {
            std::string altered = bytes;
            for (std::size_t flips = 1 + random() % 3; flips > 0; --flips) {
                const char byte = static_cast<char>(random());
                altered[random() % altered.size()] = byte;
            }
            if (i % 3 == 0) altered.resize(random() % altered.size());
            readTable(altered);  // must return: an abort ends the test
        }
    }
}

}  // namespace
}  // namespace mote::test
