// SPDX-License-Identifier: GPL-3.0-or-later
//
// SharedDataset: a dataset that all ranks of a job make. Rank 0 makes its folder and publishes it; whoever is
// left removes it where that did not happen. Move-only; one owner, one thread.
#pragma once

#include <filesystem>
#include <optional>

#include "preprocess/parallel/communicator.h"
#include "protocol/scene/error.h"
#include "storage/dataset_writer.h"

namespace mote::prep {

class SharedDataset {
  public:
    /// All ranks call it. Errors: as DatasetWriter::create, on all of them.
    static Result<SharedDataset> create(Communicator& ranks, const std::filesystem::path& output);

    SharedDataset(SharedDataset&& other) noexcept;
    SharedDataset& operator=(SharedDataset&&) = delete;
    /// Removes what was not published. Of rank 0 the writer does so, unless it was this rank that was killed.
    ~SharedDataset();

    /// Where the dataset's files are to be made.
    const std::filesystem::path& directory() const { return directory_; }
    /// The writer, on rank 0 alone.
    storage::DatasetWriter& writer() { return *writer_; }
    /// Says, on every rank, that all ranks know of its end: the folder is no more theirs.
    void finish() { directory_.clear(); }

  private:
    SharedDataset(std::filesystem::path directory, std::optional<storage::DatasetWriter> writer)
        : directory_(std::move(directory)), writer_(std::move(writer)) {}

    std::filesystem::path directory_;
    std::optional<storage::DatasetWriter> writer_;
};

}  // namespace mote::prep
