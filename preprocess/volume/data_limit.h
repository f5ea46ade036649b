// SPDX-License-Identifier: GPL-3.0-or-later
//
// DataLimit: while it lives, the process gets no more than some memory beyond what it has: an allocation that
// would need it throws std::bad_alloc. For libraries that believe every length in a file. The limit is the
// process's own (RLIMIT_DATA): one at a time, while no other thread needs much.
#pragma once

#include <sys/resource.h>

#include <cstdint>

namespace mote::prep {

class DataLimit {
  public:
    /// `more` in bytes. Where the system does not say what the process has, nothing is limited.
    explicit DataLimit(std::uint64_t more);
    ~DataLimit();
    DataLimit(const DataLimit&) = delete;
    DataLimit& operator=(const DataLimit&) = delete;

  private:
    rlimit before_{};
    bool set_ = false;
};

}  // namespace mote::prep
