// SPDX-License-Identifier: GPL-3.0-or-later
//
// HDF5 objects of our own, made for writing: groups without times, attributes, contiguous columns. Functions
// return an invalid handle or false where HDF5 refuses; h5Failure() then says why. One thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/readers/hdf5/h5_handle.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// A new file over `path`; its root keeps no times.
H5Handle createFile(const std::string& path);

/// A new group at `path` below `parent`, with all groups on the way.
H5Handle createGroup(hid_t parent, const std::string& path);

/// A column of `rows` values of a file type, contiguous, its place in the file taken at once and not filled.
H5Handle createColumn(hid_t parent, const char* name, hid_t type, std::uint64_t rows);

/// Writes values [first, first + rows) of a column; `type` is that of `values`.
bool writeColumn(hid_t file, const std::string& path, hid_t type, std::uint64_t first, std::size_t rows,
                 const void* values);

bool setText(hid_t object, const char* name, std::string_view text);
bool setDouble(hid_t object, const char* name, double value);
bool setDoubles(hid_t object, const char* name, std::span<const double> values);
bool setUnsigned32(hid_t object, const char* name, std::uint32_t value);
bool setUnsigned64(hid_t object, const char* name, std::uint64_t value);
/// As an array of one element.
bool setExtent(hid_t object, const char* name, std::uint64_t value);

/// What HDF5's error stack of this thread says: the kernel's own reason where it holds one.
Error h5Failure(const std::string& where);

/// Keeps HDF5 from printing its errors while it lives.
class QuietH5 {
  public:
    QuietH5();
    ~QuietH5();
    QuietH5(const QuietH5&) = delete;
    QuietH5& operator=(const QuietH5&) = delete;

  private:
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

}  // namespace mote::prep
