// SPDX-License-Identifier: GPL-3.0-or-later
//
// HDF5 objects of our own, made for writing: groups without times, attributes, contiguous columns. Functions
// return an invalid handle or false if HDF5 refuses; H5Errors then says why. One thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/base/error.h"

namespace mote::prep {

/// A new file over `path`; its root keeps no times.
H5Handle createFile(const std::string& path);

/// Makes the close of a file that is not wanted any more succeed, whatever the disk says: what HDF5 still
/// holds back goes into memory that goes with the file.
void forgetUnwritten(hid_t file);

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
/// Sets an array of one element.
bool setExtent(hid_t object, const char* name, std::uint64_t value);

/// While it lives, HDF5's errors on this thread are kept here and not printed. One at a time.
class H5Errors {
  public:
    H5Errors();
    ~H5Errors();
    H5Errors(const H5Errors&) = delete;
    H5Errors& operator=(const H5Errors&) = delete;

    /// Why the file `where` could not be written: the kernel's own reason if HDF5 was told one.
    Error failure(const std::string& where) const;

  private:
    static herr_t keep(hid_t stack, void* self);

    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
    int number_ = 0;  ///< errno of the first failure that had one
};

}  // namespace mote::prep
