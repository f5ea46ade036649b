// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/data_memory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace mote::server {
namespace {

constexpr std::uint64_t mib = std::uint64_t{1} << 20;
constexpr std::uint64_t program = 384 * mib;    // itself, and pictures of a few clients
constexpr std::uint64_t itself = 64 * mib;      // with small pictures, threads and what libraries keep
constexpr std::uint64_t leastData = 128 * mib;  // the octree of some 10^7 particles
/// Plans and the device's own form of leaves and volumes grow with the data.
constexpr std::uint64_t ownShare = 4;

std::uint64_t ofMachine() {
    const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

std::uint64_t pictureMemory(std::uint64_t memory) {
    return std::max(program, (memory == 0 ? ofMachine() : memory) / ownShare) - itself;
}

Result<std::uint64_t> dataMemory(std::uint64_t memory) {
    if (memory == 0) return std::max(leastData, ofMachine() / 2);
    if (memory >= program + leastData) return memory - std::max(program, memory / ownShare);
    return Error{ErrorCode::invalidArgument, "",
                 fmt::format("{} MiB are not enough: the server needs {} MiB for itself and {} MiB for data, "
                             "so --memory {}M at least, and more for more than some 10 million particles",
                             memory / mib, program / mib, leastData / mib, (program + leastData) / mib)};
}

}  // namespace mote::server
