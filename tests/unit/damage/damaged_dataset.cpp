// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/damaged_dataset.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>

#include "storage/storage_error.h"
#include "tests/support/dataset_content.h"
#include "tests/unit/damage/file_bytes.h"

namespace mote::test {
namespace {

constexpr std::uint64_t bytesOfAFile = 24, cutsOfAFile = 12;

struct Places {
    std::uint64_t first, stride;
};

/// About so many of a file, beginning anywhere.
Places someOf(std::uint64_t size, std::uint64_t wanted, Random& random) {
    const auto stride = std::max<std::uint64_t>(1, size / wanted);
    return {random.below(stride), stride};
}

void addBits(const std::string& file, std::uint64_t size, Places places, std::vector<Change>& changes) {
    for (auto at = places.first; at < size; at += places.stride) {
        for (unsigned bit = 0; bit < 8; ++bit) changes.push_back({file, at, bit});
    }
}

void addCuts(const std::string& file, std::uint64_t size, Places places, std::vector<Change>& changes) {
    for (auto at = places.first; at < size; at += places.stride) changes.push_back({file, at, std::nullopt});
}

DatasetFiles filesOf(const std::filesystem::path& dataset) {
    DatasetFiles files;
    for (const auto& entry : std::filesystem::directory_iterator(dataset))
        files[entry.path().filename()] = bytesOfFile(entry.path());
    return files;
}

/// Calls what(), and keeps the most seconds that it ever took. False where it threw the error of damage,
/// which tells what is wrong.
template <class What>
bool goesWell(const What& what, double& slowest) {
    using Clock = std::chrono::steady_clock;
    const auto begun = Clock::now();
    bool well = true;
    try {
        what();
    } catch (const storage::StorageError& error) {
        EXPECT_FALSE(error.error().message.empty());
        well = false;
    }
    slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - begun).count());
    return well;
}

std::filesystem::path madeIn(const std::filesystem::path& folder, const SampleDataset& sample) {
    sample.write(folder / "sample.mote");
    writeCompanions(folder);
    return folder;
}

}  // namespace

std::string Change::text() const {
    return bit ? fmt::format("{}: bit {} of byte {}", file, *bit, at)
               : fmt::format("{} cut off at byte {}", file, at);
}

std::vector<Change> changesOf(const DatasetFiles& files, std::uint64_t stride) {
    std::vector<Change> changes;
    for (const auto& [name, bytes] : files) {
        addBits(name, bytes.size(), {0, stride}, changes);
        addCuts(name, bytes.size(), {0, stride}, changes);
    }
    return changes;
}

std::vector<Change> someChangesOf(const DatasetFiles& files, Random& random) {
    std::vector<Change> changes;
    for (const auto& [name, bytes] : files) {
        addBits(name, bytes.size(), someOf(bytes.size(), bytesOfAFile, random), changes);
        addCuts(name, bytes.size(), someOf(bytes.size(), cutsOfAFile, random), changes);
    }
    return changes;
}

DamagedDataset::DamagedDataset(const SampleDataset& sample) : asker_(sample, madeIn(folder_.path(), sample)) {
    files_ = filesOf(dataset_);
    content_ = contentOfDataset(dataset_);
}

void DamagedDataset::apply(const Change& change) const {
    auto bytes = files_.at(change.file);
    if (change.bit) {
        bytes[change.at] =
            static_cast<char>(static_cast<unsigned char>(bytes[change.at]) ^ (1U << *change.bit));
    } else {
        bytes.resize(change.at);
    }
    writeFile(dataset_ / change.file, bytes);
}

void DamagedDataset::restore() const {
    for (const auto& [name, bytes] : files_) writeFile(dataset_ / name, bytes);
}

Outcome DamagedDataset::load() {
    ++tally_.tried;
    std::string loaded;
    if (!goesWell([&] { loaded = contentOfDataset(dataset_); }, tally_.slowestRead)) {
        ++tally_.errors;
        return Outcome::error;
    }
    const bool same = loaded == content_;
    ++(same ? tally_.same : tally_.other);
    return same ? Outcome::same : Outcome::other;
}

void DamagedDataset::ask(Random& random) {
    ++tally_.asked;
    const auto question = random.below(asker_.questions());
    if (goesWell([&] { asker_.ask(question, random); }, tally_.slowestAnswer)) ++tally_.answers;
}

void DamagedDataset::loadAndAsk(Random& random) {
    const auto outcome = load();
    if (outcome == Outcome::other || (outcome == Outcome::error && random.below(8) == 0)) ask(random);
}

long mostMemory() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss >> 10;
}

}  // namespace mote::test
