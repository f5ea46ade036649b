// SPDX-License-Identifier: GPL-3.0-or-later
//
// What tests of the job share: a request, a run of it, and a look at what it made; and a disk that is full.
#pragma once

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "preprocess/particles/particles_job.h"
#include "tests/unit/particles/fake_source.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {

inline proto::JobRequest requestFor(const char* a = "x", const char* b = "px", const char* c = "y") {
    proto::JobRequest request;
    auto& job = *request.mutable_particles();
    job.add_inputs("fake.h5");
    for (const char* axis : {a, b, c}) job.add_axes(axis);
    return request;
}

inline Result<proto::Manifest> make(const proto::JobRequest& request, FakeSource& source,
                                    const std::filesystem::path& output, prep::JobResources options = {}) {
    QuietProgress progress;
    return prep::runParticlesJob(request, source, {output.parent_path() / "fake.h5"}, output, options,
                                 progress);
}

inline std::map<std::string, std::string> contentOf(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files[entry.path().filename()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return files;
}

inline std::size_t entriesOf(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

/// A limit on the size of files for as long as the object lives: the kernel then refuses writes as on a full
/// disk.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        auto limit = before_;
        limit.rlim_cur = bytes;
        std::signal(SIGXFSZ, SIG_IGN);
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, SIG_DFL);
    }

  private:
    rlimit before_{};
};

}  // namespace mote::test
