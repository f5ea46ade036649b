// SPDX-License-Identifier: GPL-3.0-or-later
//
// What jobs of all kinds share: the resources that they may use, Progress, by which they say how far they are
// and learn that they should stop, and how a manifest names their inputs. A Progress has one owner; report()
// and cancelled() may be called from any thread.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "protocol/scene/error.h"

namespace mote::prep {

/// Where what is made will lie in the end: a server's jobs make FOLDER/NAME as FOLDER/NAME.partial-ID/NAME.
inline std::filesystem::path finalFolder(const std::filesystem::path& output) {
    const auto folder = output.parent_path();
    const auto draft = output.filename().string() + ".partial-";
    return folder.filename().string().starts_with(draft) ? folder.parent_path() : folder;
}

/// The input as seen from the folder that is to hold the dataset `output`, so that a manifest does not depend
/// on where or how it was made.
inline std::string portableInput(const std::filesystem::path& input, const std::filesystem::path& output) {
    namespace fs = std::filesystem;
    std::error_code code;
    const auto folder = fs::weakly_canonical(finalFolder(fs::absolute(output, code)), code);
    return fs::weakly_canonical(fs::absolute(input, code), code).lexically_relative(folder).string();
}

/// Bytes: the limit that the job was given, or three quarters of the machine's memory where it is 0.
inline std::uint64_t memoryFor(std::uint64_t limit) {
    if (limit > 0) return limit;
    const long pages = ::sysconf(_SC_PHYS_PAGES);
    const long bytes = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || bytes <= 0) return 0;
    return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(bytes) / 4 * 3;
}

class Communicator;

/// What a job of any kind may use. It changes how the job works, and never what it makes.
struct JobResources {
    int threads = 0;                ///< 0: as many as there are cores
    std::uint64_t memory = 0;       ///< bytes that this process may take; 0: three quarters of the machine's
    Communicator* ranks = nullptr;  ///< the processes that do this job together; null: this one alone
};

/// What a job says that was told to stop.
inline Error cancelledError() {
    return {ErrorCode::cancelled, "", "cancelled"};
}

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
