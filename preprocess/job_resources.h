// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobResources: what a job of any kind may use. It changes how the job works, and never what it makes. A
// value.
#pragma once

#include <cstdint>

namespace mote::prep {

class Communicator;

struct JobResources {
    int threads = 0;                ///< 0: as many as there are cores
    std::uint64_t memory = 0;       ///< bytes that this process may take; 0: three quarters of the machine's
    Communicator* ranks = nullptr;  ///< the processes that do this job together; null: this one alone
};

}  // namespace mote::prep
