// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ranks: the processes that draw one picture together. All of them call the same functions in the same order,
// but for the stop of a picture, each from one thread at a time. Whoever waits for the others sleeps. A rank
// that is lost ends them all, by the launcher's hand; so does one that cannot take part for want of memory:
// these functions throw nothing. Owned by main; MPI itself appears in mpi_ranks.cpp alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace mote::render {

using Bytes = std::vector<std::byte>;

class Ranks {
  public:
    virtual ~Ranks() = default;
    virtual int rank() const = 0;  ///< 0 serves the clients
    virtual int size() const = 0;

    /// Gives rank 0's bytes to all.
    virtual void broadcast(Bytes& bytes) noexcept = 0;
    /// Gives outgoing[r] to rank r; returns what each rank had for this one, in the order of the ranks.
    virtual std::vector<Bytes> exchange(const std::vector<Bytes>& outgoing) noexcept = 0;
    /// The greatest, and the sum, of everyone's numbers, on all ranks.
    virtual std::uint64_t greatest(std::uint64_t mine) noexcept = 0;
    virtual std::uint64_t sum(std::uint64_t mine) noexcept = 0;

    /// Rank 0: tells the others, who may be busy, to stop a picture.
    virtual void sendStop(std::uint64_t picture) noexcept = 0;
    /// The others: whether that came. Forgets what concerns earlier pictures.
    virtual bool stopArrived(std::uint64_t picture) noexcept = 0;
};

/// The Ranks that a launcher of MPI started (mpirun, srun), for main, once. Joins the others, and leaves them
/// when it goes; null if this process was not started as one of several. Touches no MPI if no launcher
/// is about. Throws std::runtime_error if MPI does not start.
std::unique_ptr<Ranks> joinRanks();

}  // namespace mote::render
