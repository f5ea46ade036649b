// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/data_limit.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace mote::prep {
namespace {

/// Bytes of data that the process has mapped; 0 where that is not known.
std::uint64_t mappedData() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t size = 0, resident = 0, shared = 0, text = 0, library = 0, data = 0;
    file >> size >> resident >> shared >> text >> library >> data;
    return file ? data * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

DataLimit::DataLimit(std::uint64_t more) {
    const auto now = mappedData();
    if (now == 0 || ::getrlimit(RLIMIT_DATA, &before_) != 0) return;
    rlimit limit = before_;
    limit.rlim_cur = std::min<rlim_t>(before_.rlim_cur, now + more);
    set_ = ::setrlimit(RLIMIT_DATA, &limit) == 0;
}

DataLimit::~DataLimit() {
    if (set_) ::setrlimit(RLIMIT_DATA, &before_);
}

}  // namespace mote::prep
