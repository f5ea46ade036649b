// SPDX-License-Identifier: GPL-3.0-or-later
//
// verifyDataset: everything that can be checked of a dataset on disk: its manifest, every file's size and
// hash, every block of every array, and what a kind's reader knows besides; and that no file is missing or
// there besides. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::storage {

/// What is wrong, one Error each (at most 1000); nothing if the dataset is whole. `progress` takes the
/// done share, 0 to 1; a `cancelled` error is the only one if `cancelled` said so.
std::vector<Error> verifyDataset(const std::filesystem::path& directory,
                                 const std::function<bool()>& cancelled = {},
                                 const std::function<void(double)>& progress = {});

/// What a kind of dataset verifies its files with; it gathers what is wrong.
class DatasetVerifier {
  public:
    /// The manifest was checked.
    DatasetVerifier(std::filesystem::path directory, proto::Manifest manifest,
                    std::function<bool()> cancelled, std::function<void(double)> progress)
        : directory_(std::move(directory)),
          manifest_(std::move(manifest)),
          cancelled_(std::move(cancelled)),
          progress_(std::move(progress)) {}

    const std::filesystem::path& directory() const { return directory_; }
    const proto::Manifest& manifest() const { return manifest_; }
    const std::function<bool()>& cancelled() const { return cancelled_; }
    /// Whether a cancellation has come between; nothing more is to be looked at.
    bool wasCancelled() const { return !errors_.empty() && errors_.back().code == ErrorCode::cancelled; }

    /// Calls `step` for each of them, until there is a cancellation or too much is wrong.
    void eachStep(int count, const std::function<void(std::uint32_t)>& step);
    /// Files against the manifest; whether all are whole, or nothing after a cancellation.
    std::optional<bool> files(const std::vector<std::string>& names);
    /// NAME.h5 and NAME.digest: whether the files and all blocks are whole.
    bool arrayFile(const std::string& name);
    /// The same, and what `readFile` (directory, manifest) says of it.
    template <class Read>
    void arrayFile(const char* name, const Read& readFile) {
        if (arrayFile(name)) read(readFile(directory_, manifest_));
        if (progress_) progress_(1.0);
    }
    /// What reading a file came to.
    template <class T>
    void read(const Result<T>& result) {
        if (!result.ok()) add({result.error()});
    }
    void add(const std::vector<Error>& more) { errors_.insert(errors_.end(), more.begin(), more.end()); }

    /// The whole dataset.
    std::vector<Error> run();

  private:
    void findExtra();
    std::optional<Error> checkFile(const std::string& name) const;

    std::filesystem::path directory_;
    proto::Manifest manifest_;
    std::function<bool()> cancelled_;
    std::function<void(double)> progress_;
    std::vector<Error> errors_;
};

}  // namespace mote::storage
