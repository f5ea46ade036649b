// SPDX-License-Identifier: GPL-3.0-or-later
//
// A piece of what tests/reliability/own_files.py tries, in a process that may die of it: the script starts
// it, reads how far it came, and goes on behind what ended it. MOTE_OWN_FILES says which piece:
//
//     SAMPLE old|anew|rewritten FIRST END RECORD
//
// Changes FIRST to END (not with it) of a sample dataset, with its hashes as they were or made anew; or so
// many questions while it is rewritten. END 0: none, which tells how many there are. Before each the file
// RECORD becomes one line of JSON: its number, and what came of those before.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tests/unit/damage/damaged_dataset.h"
#include "tests/unit/damage/forged_hashes.h"
#include "tests/unit/damage/rewritten_dataset.h"

namespace mote::test {
namespace {

constexpr std::uint64_t strideOfLarge = 4093, strideOfSmall = 1;

struct Piece {
    std::string sample, way;
    std::uint64_t first = 0, end = 0;
    std::string record;
};

Piece wantedPiece() {
    const char* const words = std::getenv("MOTE_OWN_FILES");
    if (words == nullptr) throw std::invalid_argument("MOTE_OWN_FILES is not set");
    Piece piece;
    std::istringstream(words) >> piece.sample >> piece.way >> piece.first >> piece.end >> piece.record;
    return piece;
}

const SampleDataset& sampleOf(const std::string& name) {
    for (const auto* all : {&sampleDatasets(), &largeDatasets()}) {
        for (const auto& sample : *all) {
            if (sample.name == name) return sample;
        }
    }
    throw std::invalid_argument(name + " is no sample");
}

/// What is known of a piece if the process ends now.
class Record {
  public:
    Record(const std::string& path, std::uint64_t total)
        : file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600)), total_(total) {}
    ~Record() { ::close(file_); }
    Record(const Record&) = delete;
    Record& operator=(const Record&) = delete;

    void write(std::uint64_t next, const Tally& tally) const {
        const auto line = fmt::format(
            R"({{"next": {}, "total": {}, "tried": {}, "errors": {}, "same": {}, "other": {}, "asked": {}, )"
            R"("answers": {}, "slowestRead": {:.6f}, "slowestAnswer": {:.6f}, "mostMemory": {}}})",
            next, total_, tally.tried, tally.errors, tally.same, tally.other, tally.asked, tally.answers,
            tally.slowestRead, tally.slowestAnswer, mostMemory());
        // As long as any, so that nothing of a longer one before it stays.
        const auto padded = fmt::format("{:<400}\n", line);
        ASSERT_EQ(::pwrite(file_, padded.data(), padded.size(), 0), static_cast<ssize_t>(padded.size()));
    }

  private:
    int file_;
    std::uint64_t total_;
};

void tryOld(DamagedDataset& dataset, const Change& change) {
    dataset.apply(change);
    EXPECT_NE(dataset.load(), Outcome::other) << change.text() << ": another picture without an error";
    dataset.restore();
}

/// Which question is asked, and how, depends on the change alone.
void tryAnew(DamagedDataset& dataset, const Change& change, std::uint64_t number) {
    Random random(number, 23);
    dataset.apply(change);
    forgeHashes(dataset.path());
    dataset.loadAndAsk(random);
    dataset.restore();
}

void tryChanges(DamagedDataset& dataset, const Piece& piece, std::uint64_t stride) {
    const auto changes = changesOf(dataset.files(), stride);
    const Record record(piece.record, changes.size());
    const auto end = std::min<std::uint64_t>(piece.end, changes.size());
    for (auto i = piece.first; i < end; ++i) {
        record.write(i, dataset.tally());
        if (piece.way == "old") {
            tryOld(dataset, changes[i]);
        } else {
            tryAnew(dataset, changes[i], i);
        }
    }
    record.write(end, dataset.tally());
}

void askRewritten(DamagedDataset& dataset, const Piece& piece) {
    const Record record(piece.record, piece.end);
    for (auto i = piece.first; i < piece.end; ++i) {
        record.write(i, dataset.tally());
        askWhileRewritten(dataset, 1, i);
    }
    record.write(piece.end, dataset.tally());
}

TEST(OwnFiles, DISABLED_Piece) {
    const auto piece = wantedPiece();
    const auto& sample = sampleOf(piece.sample);
    DamagedDataset dataset(sample);
    if (piece.way == "rewritten") return askRewritten(dataset, piece);
    tryChanges(dataset, piece, sample.large ? strideOfLarge : strideOfSmall);
}

}  // namespace
}  // namespace mote::test
