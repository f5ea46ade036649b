// SPDX-License-Identifier: GPL-3.0-or-later
//
// A CrashRecord holds what must be known of a server process after it died: whether it was ready, which view
// it was drawing, and what its device costs. It lies in memory that the serving process shares with the
// supervisor, which reads it when the process is gone and counts what each view has ended; the process that
// is forked next finds the counts.
//
// Views are known by the bytes of their message. The thread that renders calls begin(), end(), learn() and
// costs(); ready() is called once, shortOfMemory() and deaths() on any thread; the rest is the supervisor's.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/render/device.h"

namespace mote::server {

/// A view that has ended so many servers is not drawn again.
inline constexpr unsigned refusedAfterDeaths = 2;

class CrashRecord {
  public:
    /// Throws std::system_error where there is no memory to share.
    CrashRecord();
    ~CrashRecord();
    CrashRecord(const CrashRecord&) = delete;
    CrashRecord& operator=(const CrashRecord&) = delete;

    // The serving process ------------------------------------------------------------------------------

    void ready();
    /// From now on this view is to blame.
    void begin(std::string_view view);
    void end();
    /// Measuring a device takes longer than all else that a server does before it is ready.
    void learn(const render::DeviceCosts& costs);
    std::optional<render::DeviceCosts> costs() const;
    /// It ends, as there is no memory left. Takes none.
    void shortOfMemory() noexcept;
    /// How many servers it has ended.
    unsigned deaths(std::string_view view) const;

    // The supervisor -----------------------------------------------------------------------------------

    /// Forgets the last process; called before one is forked.
    void clear();
    bool wasReady() const;
    bool wasShortOfMemory() const;
    /// What was being drawn when the process died.
    std::optional<std::string> view() const;
    /// Counts one more server that the view has ended; returns how many that makes.
    unsigned count(const std::string& view);

  private:
    struct Shared;
    Shared* shared_ = nullptr;  // owned: a mapping
    std::map<std::string, unsigned, std::less<>> deaths_;
};

}  // namespace mote::server
