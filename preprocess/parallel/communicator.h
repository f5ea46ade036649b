// SPDX-License-Identifier: GPL-3.0-or-later
//
// Communicator: the processes that work on one job together, its ranks. All of them call the same functions
// in the same order, each from one thread at a time. A rank that fails says so by agree(), so that none waits
// for it. Owned by main; MPI itself appears in mpi_communicator.cpp alone.
//
// Long arrays between ranks, a piece at a time, so that none holds another's whole; work of all ranks in
// rounds of messages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "storage/dataset_writer.h"

namespace mote::prep {

/// Leaves new bytes as they are, which are about to be written.
template <class T>
struct PlainAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = PlainAllocator<U>;
    };
    template <class U>
    void construct(U* at) noexcept {
        static_assert(std::is_trivially_default_constructible_v<U>);
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
};

/// A message. Bytes that resize() adds have any content.
using Bytes = std::vector<std::byte, PlainAllocator<std::byte>>;

/// Messages that are under way.
class Exchange {
  public:
    virtual ~Exchange() = default;
    /// What each rank had for this one, in the order of the ranks; waits for it. Called once, by all ranks.
    /// Errors: cancelled, also if another rank was ended.
    virtual Result<std::vector<Bytes>> finish() = 0;
    /// Waits until the others have what this rank sent; called after finish(), before this goes. Errors: as
    /// finish().
    virtual Status settle() { return success(); }
};

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
    /// Begins to do so: who is earlier than the others need not wait yet. Each is finished in its turn.
    virtual std::unique_ptr<Exchange> begin(std::vector<Bytes> outgoing);
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

/// The values that a message is.
template <class T>
std::span<const T> spanOf(const Bytes& bytes) {
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

/// A message of these bytes.
inline Bytes bytesOf(std::span<const std::byte> values) {
    Bytes bytes(values.size());
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), values.size());
    return bytes;
}

template <class T>
Result<std::vector<std::vector<T>>> shareValues(Communicator& ranks, std::span<const T> mine) {
    MOTE_ASSIGN_OR_RETURN(auto shared, ranks.share(std::as_bytes(mine)));
    std::vector<std::vector<T>> values;
    values.reserve(shared.size());
    for (const auto& bytes : shared) {
        const auto of = spanOf<T>(bytes);
        values.emplace_back(of.begin(), of.end());
    }
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

// A message is a sequence of lists, each of which begins with its length and ends at a multiple of 8 bytes.

template <class T>
constexpr std::size_t listBytes(std::uint64_t length) {
    return sizeof length + (length * sizeof(T) + 7) / 8 * 8;
}

/// Room for a list at the end of a message, of any content: where its values begin.
template <class T>
std::size_t addRoom(Bytes& message, std::uint64_t length) {
    const std::size_t at = message.size();
    message.resize(at + listBytes<T>(length));
    std::memcpy(message.data() + at, &length, sizeof length);
    return at + sizeof length;
}

template <class T>
void addList(Bytes& message, std::span<const T> values) {
    const std::size_t at = addRoom<T>(message, values.size());
    if (!values.empty()) std::memcpy(message.data() + at, values.data(), values.size_bytes());
}

/// Takes a list off the front of a message.
template <class T>
std::span<const T> takeList(std::span<const std::byte>& message) {
    std::uint64_t length = 0;
    std::memcpy(&length, message.data(), sizeof length);
    const std::span values(reinterpret_cast<const T*>(message.data() + sizeof length), length);
    message = message.subspan(listBytes<T>(length));
    return values;
}

/// Work of all ranks in as many rounds on each: make(round) gives a Result of the messages to each rank, made
/// of lists, and use(round, messages) takes those of the same round from each and returns a Status, while
/// those of the next are under way. After an error of any rank there is no further round. Returns the first
/// rank's Error that is one, on all ranks.
template <class Make, class Use>
Status exchangeInRounds(Communicator& ranks, std::size_t rounds, const Make& make, const Use& use) {
    Status status = success();
    // Who has failed sends nothing, all others at least an empty list.
    const auto begin = [&](std::size_t round) {
        std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks.size()));
        if (status.ok()) {
            Result<std::vector<Bytes>> made = make(round);
            if (made.ok()) {
                outgoing = *std::move(made);
            } else {
                status = made.error();
            }
        }
        for (auto& bytes : outgoing) {
            if (status.ok() && bytes.empty()) addRoom<std::byte>(bytes, 0);
        }
        return ranks.begin(std::move(outgoing));
    };
    auto underWay = rounds > 0 ? begin(0) : nullptr;
    std::unique_ptr<Exchange> before;
    for (std::size_t round = 0; round < rounds; ++round) {
        MOTE_ASSIGN_OR_RETURN(auto incoming, underWay->finish());
        // Who has sent a message of this round has got those of the one before.
        if (before) MOTE_RETURN_IF_ERROR(before->settle());
        before = std::exchange(underWay, nullptr);
        if (std::ranges::any_of(incoming, &Bytes::empty)) break;
        if (round + 1 < rounds) underWay = begin(round + 1);
        if (status.ok()) status = use(round, incoming);
    }
    if (before) MOTE_RETURN_IF_ERROR(before->settle());
    return agree(ranks, status);
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
