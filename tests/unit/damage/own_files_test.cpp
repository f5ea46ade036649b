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

#include "storage/manifest.h"
#include "storage/verify.h"
#include "tests/unit/damage/damaged_dataset.h"
#include "tests/unit/damage/rewritten_file.h"

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

// Datasets of every kind with bytes changed in eight ways and files cut off, the hashes old or made anew.
// With old ones a change is an error, or what is loaded is the same; with new ones it is an error or some
// content, which can be drawn and counted, never a death, and little memory. Of files that are longer than
// that, bytes an even distance apart are changed; tests/reliability/own_files.py changes every byte.

class ChangedBytes : public testing::TestWithParam<SampleDataset> {
  protected:
    std::vector<Change> changes() const {
        Random random(1, GetParam().name.size());
        return someChangesOf(dataset_.files(), random);
    }
    void print(const char* hashes) const {
        const auto& tally = dataset_.tally();
        fmt::print(
            "{}, {}: {} changes, {} errors, {} the same, {} other; {} of {} questions answered; 0 deaths, at "
            "most "
            "{} MiB\n",
            GetParam().name, hashes, tally.tried, tally.errors, tally.same, tally.other, tally.answers,
            tally.asked, mostMemory());
    }

    DamagedDataset dataset_{GetParam()};
};

TEST_P(ChangedBytes, OfWhatIsIntactEveryQuestionIsAnswered) {
    EXPECT_EQ(dataset_.load(), Outcome::same);
    Random random(3);
    for (std::size_t question = 0; question < dataset_.asker().questions(); ++question) {
        // At rest and in motion, and with and without a bound on memory.
        for (int time = 0; time < 6; ++time) EXPECT_NO_THROW(dataset_.asker().ask(question, random));
    }
}

TEST_P(ChangedBytes, WithOldHashesAreAnErrorOrChangeNothing) {
    for (const auto& change : changes()) {
        dataset_.apply(change);
        const auto outcome = dataset_.load();
        EXPECT_NE(outcome, Outcome::other) << change.text() << ": another picture without an error";
        if (outcome == Outcome::same && change.file != storage::manifestDigestName) {
            EXPECT_FALSE(storage::verifyDataset(dataset_.path()).empty()) << change.text();
        }
        dataset_.restore();
    }
    print("hashes as they were");
    EXPECT_GT(dataset_.tally().errors, 0U);
}

TEST_P(ChangedBytes, WithHashesMadeAnewAreAnErrorOrTheirOwnContent) {
    const auto before = mostMemory();
    Random random(2);
    for (const auto& change : changes()) {
        dataset_.apply(change);
        forgeHashes(dataset_.path());
        dataset_.loadAndAsk(random);
        dataset_.restore();
    }
    print("hashes made anew");
    EXPECT_GT(dataset_.tally().errors, 0U);
    EXPECT_GT(dataset_.tally().answers, 0U);
    // Beyond 64 MiB it is refused. A sanitizer keeps 256 MiB of what was freed.
    EXPECT_LT(mostMemory(), before + 512);
}

INSTANTIATE_TEST_SUITE_P(All, ChangedBytes, testing::ValuesIn(sampleDatasets()),
                         [](const auto& sample) { return sample.param.name; });

// Datasets of every kind that are rewritten and cut off in place while they are read, drawn and counted:
// errors are right, and so are pictures; a death is not. tests/reliability/own_files.py asks more.

class RewrittenDataset : public testing::TestWithParam<SampleDataset> {};

TEST_P(RewrittenDataset, IsAnErrorOrAPictureAndInTheEndItself) {
    DamagedDataset dataset(GetParam());
    const auto writes = askWhileRewritten(dataset, 40, 1);
    const auto& tally = dataset.tally();
    fmt::print("{}: {} of {} questions answered, {} changes meanwhile, 0 deaths\n", GetParam().name,
               tally.answers, tally.asked, writes);
    EXPECT_EQ(dataset.load(), Outcome::same);
}

INSTANTIATE_TEST_SUITE_P(All, RewrittenDataset, testing::ValuesIn(sampleDatasets()),
                         [](const auto& sample) { return sample.param.name; });

}  // namespace
}  // namespace mote::test
