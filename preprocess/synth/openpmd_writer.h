// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenPmdWriter: the run as openPMD 1.1.0 in HDF5: group-based iterations, one species "beam". All datasets
// are laid out when the file is made, so that its bytes do not depend on the order in which rows are written;
// nothing in it names the time or the machine. One owner, one thread.
//
// HDF5 objects of our own, made for writing: groups without times, attributes, contiguous columns. Functions
// return an invalid handle or false where HDF5 refuses; h5Failure() then says why. One thread at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/synth/channel_plan.h"
#include "preprocess/synth/tracker.h"
#include "protocol/scene/error.h"

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

    /// Why the file `where` could not be written: the kernel's own reason where HDF5 was told one.
    Error failure(const std::string& where) const;

  private:
    static herr_t keep(hid_t stack, void* self);

    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
    int number_ = 0;  ///< errno of the first failure that had one
};

/// A chunk of one step in the units of the file. One owner; disjoint rows may be filled by
/// different threads at once.
struct BeamColumns {
    explicit BeamColumns(std::size_t rows);

    std::array<std::vector<float>, 3> position;   ///< m; z is the distance from the synchronous particle
    std::array<std::vector<double>, 3> momentum;  ///< eV/c
    std::vector<std::uint64_t> id;
};

/// Rows [begin, end) of `particles`, whose row r is particle `first` + r, in the file's units.
void fillColumns(const ChannelPlan& plan, const ParticleArrays& particles, std::uint64_t first,
                 std::size_t begin, std::size_t end, BeamColumns& columns);

class OpenPmdWriter {
  public:
    /// Bytes of a finished file, to some KiB.
    static std::uint64_t fileBytes(const ChannelPlan& plan, std::uint64_t particles);

    /// An empty file over `path`. Errors: permissionDenied, resourceExhausted, internal.
    static Result<OpenPmdWriter> create(const std::filesystem::path& path);

    OpenPmdWriter(OpenPmdWriter&&) = default;
    OpenPmdWriter& operator=(OpenPmdWriter&&) = delete;
    /// Discards a file that was not closed: it is of no use to anyone.
    ~OpenPmdWriter();

    /// Makes all groups, attributes and (unwritten) columns. Errors: resourceExhausted (disk full), internal.
    Status layOut(const ChannelPlan& plan, std::uint64_t particles, std::uint64_t seed);

    /// Writes the first `rows` rows of `columns` at row `first` of step `step`. Errors: resourceExhausted,
    /// internal.
    Status write(std::size_t step, std::uint64_t first, std::size_t rows, const BeamColumns& columns);

    /// Writes what HDF5 still holds back; the writer is then done. Errors: resourceExhausted, internal.
    Status close();

  private:
    explicit OpenPmdWriter(const std::string& path);

    std::string name_;                  ///< for messages
    std::unique_ptr<H5Errors> errors_;  ///< outlives the file, whose closing may fail too
    H5Handle file_;
    std::vector<std::string> species_;  ///< by step: "/data/53/particles/beam"
};

}  // namespace mote::prep
