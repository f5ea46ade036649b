// SPDX-License-Identifier: GPL-3.0-or-later
//
// A fuzzer's corpus, replayed: files whose names begin with ok- are read, those with bad- are refused with a
// sentence, and no shortened or altered form of one does harm. Functions without state.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace mote::test {

/// The error's sentence, "" where all was read; aborts where a reader breaks its contract.
using ReadInput = std::function<std::string(std::string_view)>;

inline std::vector<std::pair<std::string, std::string>> corpus(const std::string& folder) {
    std::vector<std::pair<std::string, std::string>> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files.emplace_back(entry.path().filename().string(), std::string(std::istreambuf_iterator<char>(file),
                                                                         std::istreambuf_iterator<char>()));
    }
    return files;
}

inline void expectAsNamed(const std::string& folder, const ReadInput& read) {
    int ok = 0, bad = 0;
    for (const auto& [name, bytes] : corpus(folder)) {
        const std::string error = read(bytes);
        const bool shouldRead = name.starts_with("ok-");
        EXPECT_EQ(error.empty(), shouldRead) << name << ": " << error;
        (shouldRead ? ok : bad) += 1;
    }
    EXPECT_GE(ok, 10);
    EXPECT_GE(bad, 10);
}

/// Must return: an abort ends the test.
inline void readAltered(const std::string& folder, const ReadInput& read) {
    std::mt19937_64 random(4711);
    for (const auto& [name, bytes] : corpus(folder)) {
        if (bytes.size() < 2 || bytes.size() > 4096) continue;
        for (int i = 0; i < 150; ++i) {
            std::string altered = bytes;
            for (std::size_t flips = 1 + random() % 3; flips > 0; --flips) {
                const char byte = static_cast<char>(random());
                altered[random() % altered.size()] = byte;
            }
            if (i % 3 == 0) altered.resize(random() % altered.size());
            read(altered);
        }
    }
}

}  // namespace mote::test
