// SPDX-License-Identifier: GPL-3.0-or-later
//
// The corpora of the fuzzers, replayed: files whose names begin with ok- are read, those with bad- are
// refused with a sentence, and no shortened or altered form of one does harm.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/fuzz/inputs.h"

// OpenImageIO's reader of PNG jumps over the end of a text where a file is cut short.
extern "C" const char* __lsan_default_suppressions();  // NOLINT: the name is LeakSanitizer's
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libOpenImageIO\n";
}

namespace mote::test {
namespace {

struct Fuzzed {
    const char* name;  ///< of the corpus' folder
    std::string (*read)(std::string_view);
    int altered;  ///< forms of each file

    friend void PrintTo(const Fuzzed& fuzzed, std::ostream* out) { *out << fuzzed.name; }
};

constexpr std::size_t longest = 32768;  // bytes of a file that is altered

std::vector<std::pair<std::string, std::string>> corpus(const Fuzzed& fuzzed) {
    std::vector<std::pair<std::string, std::string>> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(MOTE_CORPUS "/") + fuzzed.name)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files.emplace_back(entry.path().filename().string(),
                           std::string(std::istreambuf_iterator<char>(file), {}));
    }
    return files;
}

class Corpus : public testing::TestWithParam<Fuzzed> {};

TEST_P(Corpus, IsReadOrRefusedAsItsNamesSay) {
    int ok = 0, bad = 0;
    for (const auto& [name, bytes] : corpus(GetParam())) {
        const std::string error = GetParam().read(bytes);
        const bool shouldRead = name.starts_with("ok-");
        EXPECT_EQ(error.empty(), shouldRead) << name << ": " << error;
        (shouldRead ? ok : bad) += 1;
    }
    EXPECT_GE(ok, 5);
    EXPECT_GE(bad, 5);
}

// Must return: an abort ends the test.
TEST_P(Corpus, SurvivesBeingCutAndAltered) {
    std::mt19937_64 random(4711);
    for (const auto& [name, bytes] : corpus(GetParam())) {
        if (bytes.size() < 2 || bytes.size() > longest) continue;
        for (int i = 0; i < GetParam().altered; ++i) {
            std::string altered = bytes;
            for (std::size_t flips = 1 + random() % 3; flips > 0; --flips) {
                const char byte = static_cast<char>(random());
                altered[random() % altered.size()] = byte;
            }
            if (i % 3 == 0) altered.resize(random() % altered.size());
            GetParam().read(altered);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Of, Corpus,
                         testing::Values(Fuzzed{"dataset", datasetInput, 8}, Fuzzed{"files", filesInput, 20},
                                         Fuzzed{"hdf5", hdf5Input, 6}, Fuzzed{"mesh", meshInput, 50},
                                         Fuzzed{"pictures", picturesInput, 5},
                                         Fuzzed{"scene", sceneInput, 150}, Fuzzed{"table", tableInput, 30},
                                         Fuzzed{"volume", volumeInput, 80}, Fuzzed{"wire", wireInput, 1000}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace mote::test
