// SPDX-License-Identifier: GPL-3.0-or-later
//
// A sample dataset of which a bit is changed or a file is cut off, which is loaded and asked then, and put
// back; and what came of all that. One owner, one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/damage/sample_datasets.h"

namespace mote::test {

// Whole files as strings. Plain functions.

/// Of a file that is not there: nothing.
std::string bytesOfFile(const std::filesystem::path& path);

/// Writes anew what lies there, or what does not.
void writeFile(const std::filesystem::path& path, std::string_view bytes);

// A DatasetAsker asks of a sample dataset what clients ask the server: small pictures, by the server's own
// way from a view to pixels, and numbers. All is opened anew for each question. One thread.

class DatasetAsker {
  public:
    /// `folder` has "sample.mote" and its companions.
    DatasetAsker(const SampleDataset& sample, const std::filesystem::path& folder);
    ~DatasetAsker();
    DatasetAsker(const DatasetAsker&) = delete;
    DatasetAsker& operator=(const DatasetAsker&) = delete;

    std::size_t questions() const;
    /// How it is asked is left to `random`: with a bound on memory or without, for a view at rest or in
    /// motion. Throws storage::StorageError, as what is damaged does, and nothing else.
    void ask(std::size_t question, Random& random);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

using DatasetFiles = std::map<std::string, std::string>;  ///< by name: their bytes

/// A bit that is the other one, or a file that ends too early.
struct Change {
    std::string file;
    std::uint64_t at = 0;         ///< byte of the file
    std::optional<unsigned> bit;  ///< of that byte; nothing: the file ends there

    std::string text() const;
};

/// In each file every `stride`-th byte in each of its bits, and a cut at each of them.
std::vector<Change> changesOf(const DatasetFiles& files, std::uint64_t stride);
/// A few of them, an even distance apart, from anywhere on.
std::vector<Change> someChangesOf(const DatasetFiles& files, Random& random);

/// What a dataset gives.
enum class Outcome {
    error,
    same,  ///< the content that it had when it was made
    other  ///< some other content
};

struct Tally {
    std::uint64_t tried = 0, errors = 0, same = 0, other = 0;
    std::uint64_t asked = 0, answers = 0;           ///< pictures and numbers
    double slowestRead = 0.0, slowestAnswer = 0.0;  ///< seconds
};

class DamagedDataset {
  public:
    /// Made in a folder of its own.
    explicit DamagedDataset(const SampleDataset& sample);

    const std::filesystem::path& path() const { return dataset_; }
    const DatasetFiles& files() const { return files_; }
    DatasetAsker& asker() { return asker_; }

    void apply(const Change& change) const;
    /// All files as they were made.
    void restore() const;

    /// Loads all that is there now.
    Outcome load();
    /// Asks one question, any as likely as another.
    void ask(Random& random);
    /// Loads it, and asks a question of other content; where that is an error, of one in eight, which may be
    /// about what is not damaged.
    void loadAndAsk(Random& random);

    const Tally& tally() const { return tally_; }

  private:
    const TempDir folder_;
    const std::filesystem::path dataset_ = folder_ / "sample.mote";
    DatasetFiles files_;
    std::string content_;
    DatasetAsker asker_;
    Tally tally_;
};

/// The most memory that the process ever had, in MiB.
long mostMemory();

}  // namespace mote::test
