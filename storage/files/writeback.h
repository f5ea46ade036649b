// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writeback: brings files to the disk while others are made, so that publishing need not wait for all of them
// at once. One thread's; it has threads of its own, which only wait for the disk.
#pragma once

#include <deque>
#include <filesystem>
#include <future>

#include "protocol/base/error.h"

namespace mote::storage {

class Writeback {
  public:
    /// What has been written of a file so far. Waits if many are under way.
    void begin(std::filesystem::path path);
    /// Waits for all. Errors: as syncPath, of the first that failed; they are told once.
    Status finish();

  private:
    void finishFirst();

    std::deque<std::future<Status>> underWay_;  // oldest first
    Status failed_ = success();
};

}  // namespace mote::storage
