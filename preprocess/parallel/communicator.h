// SPDX-License-Identifier: GPL-3.0-or-later
//
// Communicator: the processes that work on one job together, its ranks. All of them call the same functions
// in the same order, each from one thread at a time. A rank that fails says so by agree(), so that none waits
// for it. Owned by main; MPI itself appears in mpi_communicator.cpp alone.
//
// Long arrays between ranks, a piece at a time, so that none holds another's whole.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "storage/dataset_writer.h"

namespace mote::prep {

using Bytes = std::vector<std::byte>;

class Communicator {
  public:
    virtual ~Communicator() = default;
    virtual int rank() const = 0;
    virtual int size() const = 0;
    bool first() const { return rank() == 0; }
    /// Whether all ranks are on one machine, so that each reads at once what another has written to a file.
    virtual bool onOneMachine() const = 0;

    /// Gives `outgoing[r]` to rank r; returns what each rank had for this one, in the order of the ranks.
    /// Errors: cancelled, also if another rank was ended.
    virtual Result<std::vector<Bytes>> exchange(std::vector<Bytes> outgoing) = 0;
    /// Gives `mine` to all; returns everyone's, in the order of the ranks. Errors: as exchange.
    virtual Result<std::vector<Bytes>> share(std::span<const std::byte> mine) = 0;
};

/// A communicator of this process alone.
std::unique_ptr<Communicator> singleProcess();

/// The first rank's Error that is one, on all ranks.
Status agree(Communicator& ranks, const Status& mine);
template <class T>
Status agree(Communicator& ranks, const Result<T>& mine) {
    return agree(ranks, mine.ok() ? success() : Status(mine.error()));
}

/// Everyone's numbers, one rank's after another's; T is trivially copyable.
template <class T>
Result<std::vector<std::vector<T>>> shareValues(Communicator& ranks, std::span<const T> mine);

/// `text` of rank 0, on all ranks.
Result<std::string> fromFirst(Communicator& ranks, const std::string& text);

template <class T>
std::vector<T> valuesOf(const Bytes& bytes) {
    std::vector<T> values(bytes.size() / sizeof(T));
    const auto* from = reinterpret_cast<const std::byte*>(bytes.data());
    std::copy_n(from, values.size() * sizeof(T), reinterpret_cast<std::byte*>(values.data()));
    return values;
}

template <class T>
Result<std::vector<std::vector<T>>> shareValues(Communicator& ranks, std::span<const T> mine) {
    MOTE_ASSIGN_OR_RETURN(auto shared, ranks.share(std::as_bytes(mine)));
    std::vector<std::vector<T>> values;
    values.reserve(shared.size());
    for (const auto& bytes : shared) values.push_back(valuesOf<T>(bytes));
    return values;
}

/// All ranks call it. take(rank, first, values) gets everyone's values, the ranks in order and each one's in
/// ascending `first`, but not all of a rank at once. Errors: as Communicator::share.
template <class T, class Take>
Status sharePieces(Communicator& ranks, std::span<const T> mine, const Take& take) {
    constexpr std::uint64_t most = (std::uint64_t{1} << 22) / sizeof(T);
    const std::uint64_t length = mine.size();
    MOTE_ASSIGN_OR_RETURN(const auto lengths, shareValues<std::uint64_t>(ranks, std::span(&length, 1)));
    std::uint64_t longest = 0;
    for (const auto& of : lengths) longest = std::max(longest, of.front());
    for (std::uint64_t first = 0; first < longest; first += most) {
        const auto begin = std::min(first, length);
        MOTE_ASSIGN_OR_RETURN(const auto all,
                              shareValues<T>(ranks, mine.subspan(begin, std::min(most, length - begin))));
        for (std::size_t rank = 0; rank < all.size(); ++rank) {
            take(rank, first, std::span<const T>(all[rank]));
        }
    }
    return success();
}

/// A dataset that all ranks of a job make. Rank 0 makes its folder and publishes it; whoever
/// is left removes it where that did not happen. Move-only; one owner, one thread.
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

// Processes that a launcher of MPI started, mpirun or srun; called from main, once. In mpi_communicator.cpp.

/// Whether the environment says that a launcher of MPI started this process and others with it. Touches no
/// MPI.
bool startedByMpi();

/// Joins the others; leaves them when it goes. Whoever waits for the others asks `cancelled` now and then.
/// Errors: internal (MPI does not start).
Result<std::unique_ptr<Communicator>> joinMpi(std::function<bool()> cancelled);

}  // namespace mote::prep
