// SPDX-License-Identifier: GPL-3.0-or-later
//
// Progress: where a job says how far it is and learns that it should stop. One owner; report() and
// cancelled() may be called from any thread.
#pragma once

#include <string_view>

namespace mote::prep {

class Progress {
  public:
    virtual ~Progress() = default;
    /// `fraction` of the whole job, 0 to 1, never falling; `phase` for people: "reading step 3 of 10".
    virtual void report(double fraction, std::string_view phase) = 0;
    /// Something the user should know and that is no error: "12 particles lie outside the bounds".
    virtual void note(std::string_view sentence) = 0;
    /// True once the job should stop: asked at least every few hundred milliseconds.
    virtual bool cancelled() const = 0;
};

}  // namespace mote::prep
