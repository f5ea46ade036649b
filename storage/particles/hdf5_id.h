// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hdf5Id: an identifier of the HDF5 library with the call that closes it. Move-only; one thread.
#pragma once

#include <hdf5.h>

#include <utility>

namespace mote::storage {

class Hdf5Id {
  public:
    using Close = herr_t (*)(hid_t);

    Hdf5Id(hid_t id, Close closing) : id_(id), close_(closing) {}
    Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Hdf5Id& operator=(Hdf5Id&&) = delete;
    ~Hdf5Id() {
        if (id_ >= 0) close_(id_);
    }

    hid_t get() const { return id_; }
    bool valid() const { return id_ >= 0; }
    /// Closes now; whether that went well.
    bool close() { return close_(std::exchange(id_, -1)) >= 0; }

  private:
    hid_t id_;
    Close close_;
};

}  // namespace mote::storage
