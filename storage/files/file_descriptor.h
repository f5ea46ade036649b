// SPDX-License-Identifier: GPL-3.0-or-later
//
// FileDescriptor: an open file of the kernel, closed when it goes. Move-only; one owner; any thread.
#pragma once

#include <unistd.h>

#include <utility>

namespace mote::storage {

class FileDescriptor {
  public:
    FileDescriptor() = default;
    explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
    FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    ~FileDescriptor() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }

    int get() const { return descriptor_; }
    /// It is another's from now on.
    int release() { return std::exchange(descriptor_, -1); }
    bool valid() const { return descriptor_ >= 0; }

  private:
    int descriptor_ = -1;
};

}  // namespace mote::storage
