// SPDX-License-Identifier: GPL-3.0-or-later
//
// CancelSignal: SIGINT and SIGTERM ask the job to stop instead of ending the process, so that it can remove
// what it has begun. One object in a program, made in main before any thread.
#pragma once

namespace mote::prep {

class CancelSignal {
  public:
    /// Takes SIGINT and SIGTERM; ignores SIGPIPE and SIGXFSZ, which become errors of the write. A second
    /// signal of the same kind ends the process at once.
    CancelSignal();

    /// The signal that came, or 0.
    int received() const;
};

}  // namespace mote::prep
