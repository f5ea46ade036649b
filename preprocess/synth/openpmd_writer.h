// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenPmdWriter: the run as openPMD 1.1.0 in HDF5: group-based iterations, one species "beam". All datasets
// are laid out when the file is made, so that its bytes do not depend on the order in which rows are written;
// nothing in it names the time or the machine. One owner, one thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/openpmd/h5_output.h"
#include "preprocess/synth/channel_plan.h"
#include "preprocess/synth/tracker.h"
#include "protocol/base/error.h"

namespace mote::prep {

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
