// SPDX-License-Identifier: GPL-3.0-or-later
//
// H5Handle: an HDF5 identifier, closed when it goes. One owner, one thread at a time.
#pragma once

#include <hdf5.h>

#include <utility>

namespace mote::prep {

/// HDF5's messages on stderr, off for this thread: what goes wrong becomes an Error of ours.
inline void silenceHdf5() {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

class H5Handle {
  public:
    using Close = herr_t (*)(hid_t);

    H5Handle() = default;
    /// Takes `id`, negative where HDF5 refused to make it.
    H5Handle(hid_t id, Close close) : id_(id), close_(close) {}
    ~H5Handle() { reset(); }
    H5Handle(H5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    H5Handle& operator=(H5Handle&& other) noexcept {
        if (this != &other) {
            reset();
            id_ = std::exchange(other.id_, -1);
            close_ = other.close_;
        }
        return *this;
    }

    bool ok() const { return id_ >= 0; }
    hid_t get() const { return id_; }

  private:
    void reset() {
        if (id_ >= 0) close_(id_);
        id_ = -1;
    }

    hid_t id_ = -1;
    Close close_ = nullptr;
};

}  // namespace mote::prep
