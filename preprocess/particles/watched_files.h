// SPDX-License-Identifier: GPL-3.0-or-later
//
// WatchedFiles: the files of a run that is still written: which are there, and which of them their writer has
// done with. Looked at now and then, for network file systems tell of no change. One owner, one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "preprocess/readers/input_files.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// What tells a file's present content from another: size and times; of a folder that is a file to its
/// writer, those of all files in it. Empty: it is not there.
std::string stampOf(const std::filesystem::path& path);

class WatchedFiles {
  public:
    using Clock = std::chrono::steady_clock;

    /// How long a file must be as it is where nobody can say whether it is written to.
    static constexpr std::chrono::seconds patience{10};

    enum class State : std::uint8_t {
        changing,  ///< perhaps half-written
        open,      ///< somebody has it open to write
        complete,
    };
    struct File {
        InputFile file;
        std::string stamp;        ///< of the latest look
        Clock::time_point since;  ///< when it was as it is first
        State state = State::changing;

        bool still(Clock::time_point now) const { return now - since >= patience; }
    };

    explicit WatchedFiles(std::vector<std::filesystem::path> inputs) : inputs_(std::move(inputs)) {}

    /// Looks at all files of the inputs; none is no error. Errors: as inputFiles, but for notFound.
    Status look();
    /// As inputFiles orders them.
    const std::vector<File>& files() const { return files_; }

  private:
    std::vector<std::filesystem::path> inputs_;
    std::vector<File> files_;
};

}  // namespace mote::prep
