// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/path_beneath.h"

#include <fcntl.h>

#include "storage/files/real_path.h"

namespace mote::storage {

FileDescriptor PathBeneath::open(int flags) const {
    if (beneath_.empty()) return FileDescriptor(::open(top_.c_str(), flags | O_NOFOLLOW | O_CLOEXEC));
    const FileDescriptor top(::open(top_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (!top.valid()) return {};
    return openRealAt(top.get(), beneath_, flags);
}

}  // namespace mote::storage
