// SPDX-License-Identifier: GPL-3.0-or-later
//
// Orbiters: clients, each on a thread of its own, whose hands never rest, and the longest time that one of
// them saw no new picture.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace mote::test {

class Orbiters {
  public:
    using Seconds = std::chrono::duration<double>;

    /// `view`: a script's view as JSON with apostrophes for quotation marks; its camera is theirs.
    Orbiters(const std::filesystem::path& connectionFile, const std::string& view, int count);
    /// Stops them.
    ~Orbiters();
    Orbiters(const Orbiters&) = delete;
    Orbiters& operator=(const Orbiters&) = delete;

    /// Until each has had `count` pictures since now; false after a long while.
    bool awaitPictures(int count);
    /// What was so far does not count.
    void forget() { since_ = std::chrono::steady_clock::now().time_since_epoch().count(); }
    /// Stops them. The longest time between two pictures of one of them, both since its first.
    Seconds longestGap();
    /// What any of them was told that is no picture: failures, a lost connection; empty where all is well.
    std::string complaint() const;

  private:
    void orbit(const std::filesystem::path& connectionFile, const std::string& view, std::size_t index);
    void stop();
    void complain(const std::string& what);

    std::atomic<bool> stopping_ = false;
    std::atomic<std::int64_t> since_ = 0;  // steady_clock's ticks
    std::vector<std::atomic<int>> pictures_;
    mutable std::mutex mutex_;
    Seconds longest_{0.0};
    std::string complaint_;
    std::vector<std::thread> threads_;
};

}  // namespace mote::test
