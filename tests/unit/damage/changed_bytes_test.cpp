// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets of every kind with bytes changed in eight ways and files cut off, the hashes old or made anew.
// With old ones a change is an error, or what is loaded is the same; with new ones it is an error or some
// content, never a death, and little memory. Of files that are longer than that, bytes an even distance apart
// are changed, beginning anywhere.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

#include "storage/manifest.h"
#include "storage/storage_error.h"
#include "storage/verify.h"
#include "tests/support/dataset_content.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/damage/forged_hashes.h"
#include "tests/unit/damage/sample_datasets.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t bytesOfAFile = 24, cutsOfAFile = 12;

void write(const fs::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// The most memory that the process ever had, in MiB.
long mostMemory() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss >> 10;
}

/// Places an even distance apart, about so many, beginning anywhere.
std::vector<std::size_t> placesIn(std::size_t size, std::size_t wanted, Random& random) {
    const std::size_t stride = std::max<std::size_t>(1, size / wanted);
    std::vector<std::size_t> places;
    for (std::size_t at = random.below(stride); at < size; at += stride) places.push_back(at);
    return places;
}

class ChangedBytes : public testing::TestWithParam<SampleDataset> {
  protected:
    ChangedBytes() {
        GetParam().write(dataset_);
        for (const auto& entry : fs::directory_iterator(dataset_)) {
            std::ifstream file(entry.path(), std::ios::binary);
            files_[entry.path().filename()] = {std::istreambuf_iterator<char>(file), {}};
        }
        content_ = contentOfDataset(dataset_);
    }

    void restore() const {
        for (const auto& [name, bytes] : files_) write(dataset_ / name, bytes);
    }
    /// The content, or nothing where there was an error.
    std::optional<std::string> load() {
        try {
            return contentOfDataset(dataset_);
        } catch (const storage::StorageError& error) {
            EXPECT_FALSE(error.error().message.empty());
            ++errors_;
            return std::nullopt;
        }
    }
    /// Calls look(name, what) for each file changed in each way; what it was is put back.
    template <class Look>
    void eachChange(const Look& look) {
        Random random(1, GetParam().name.size());
        for (const auto& [name, bytes] : files_) {
            for (const auto at : placesIn(bytes.size(), bytesOfAFile, random)) {
                for (unsigned bit = 0; bit < 8; ++bit) {
                    auto changed = bytes;
                    changed[at] = static_cast<char>(static_cast<unsigned char>(changed[at]) ^ (1U << bit));
                    write(dataset_ / name, changed);
                    look(name, fmt::format("{}: bit {} of byte {}", name, bit, at));
                    ++changes_;
                    restore();
                }
            }
            for (const auto size : placesIn(bytes.size(), cutsOfAFile, random)) {
                write(dataset_ / name, std::string_view(bytes).substr(0, size));
                look(name, fmt::format("{} cut off at byte {}", name, size));
                ++changes_;
                restore();
            }
        }
    }
    void print(const char* hashes, const char* rest) const {
        fmt::print("{}, {}: {} changes, {} errors, {} {}, 0 deaths, at most {} MiB\n", GetParam().name,
                   hashes, changes_, errors_, changes_ - errors_, rest, mostMemory());
    }

    TempDir folder_;
    const fs::path dataset_ = folder_ / "a.mote";
    std::map<std::string, std::string> files_;
    std::string content_;
    std::uint64_t changes_ = 0, errors_ = 0;
};

TEST_P(ChangedBytes, WithOldHashesAreAnErrorOrChangeNothing) {
    eachChange([&](const std::string& name, const std::string& what) {
        const auto loaded = load();
        if (!loaded) return;
        EXPECT_EQ(*loaded, content_) << what << ": another picture without an error";
        if (name != storage::manifestDigestName) {
            EXPECT_FALSE(storage::verifyDataset(dataset_).empty()) << what;
        }
    });
    print("hashes as they were", "the same");
    EXPECT_GT(errors_, 0U);
}

TEST_P(ChangedBytes, WithHashesMadeAnewAreAnErrorOrTheirOwnContent) {
    const auto before = mostMemory();
    eachChange([&](const std::string&, const std::string&) {
        forgeHashes(dataset_);
        load();
    });
    print("hashes made anew", "loaded");
    EXPECT_GT(errors_, 0U);
    // Beyond 64 MiB it is refused. A sanitizer keeps 256 MiB of what was freed.
    EXPECT_LT(mostMemory(), before + 512);
}

INSTANTIATE_TEST_SUITE_P(All, ChangedBytes, testing::ValuesIn(sampleDatasets()),
                         [](const auto& sample) { return sample.param.name; });

}  // namespace
}  // namespace mote::test
