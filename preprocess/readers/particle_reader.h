// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleReader: what mote-prep knows of a format of particles: its name, how a file of it is told, and how
// a run of such files is opened. One row a format, in the reader's own file; particle_readers.cpp lists them.
// Constants; any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

class H5File;

/// A file whose format is asked for.
struct AskedFile {
    const std::filesystem::path& path;
    const proto::ParticlesJob& job;
    std::string_view begin;         ///< its first 4096 bytes, unpacked
    const H5File* hdf5 = nullptr;   ///< of a reader whose files are HDF5
    NumberTable::Shape shape = {};  ///< of a reader of rows

    /// Its beginning without what is blank before the first word.
    std::string_view words() const {
        return begin.substr(std::min(begin.find_first_not_of(" \t\r\n"), begin.size()));
    }
};

/// What the job says of the mass of one particle, eV/c^2; 0: nothing.
inline double massOf(const proto::ParticlesJob& job) {
    return job.impact().mass() > 0.0 ? job.impact().mass() : job.mass();
}

/// A run's files, of one format, and what the job says of them.
struct AskedRun {
    std::vector<std::filesystem::path> files;
    const proto::ParticlesJob& job;
    double mass = 0.0;  ///< eV/c^2, of one particle; 0: as the files say
};

struct ParticleReader {
    /// Those of one kind are asked in turn, the kinds in this order.
    enum class Kind : std::uint8_t {
        hdf5,
        bytes,  ///< told by the first bytes
        text,
        rows,  ///< a text that nothing else tells
    };
    std::string_view name;  ///< as in --format
    std::string_view told;  ///< what tells the format, for people: "its first line SDDS"
    Kind kind = Kind::bytes;
    /// Whether the reader's own. An error: it is, but for a fault that says more than "not known".
    Result<bool> (*tells)(const AskedFile& file) = nullptr;
    /// Errors: those of openParticleSource.
    Result<std::unique_ptr<ParticleSource>> (*open)(const AskedRun& run, Progress& progress) = nullptr;
};

/// In the order in which they are asked; a format with several ways to be told has a row for each.
std::span<const ParticleReader* const> particleReaders();

/// The first of a name; null: there is none.
const ParticleReader* particleReader(std::string_view name);

/// "auto" and all names, as --format takes them.
std::vector<std::string> particleFormats();

}  // namespace mote::prep
