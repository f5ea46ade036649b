// SPDX-License-Identifier: GPL-3.0-or-later
//
// Tables in text with a line of names: comma, semicolon, tab or blanks between the fields; one file a step.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// The first line of a table, with the names of its columns. Values and functions without state.
struct CsvHeader {
    struct Field {
        std::size_t index = 0;  ///< of the field in a row
        FieldMeaning meaning;
    };
    char separator = ',';      ///< ' ': runs of blanks
    std::size_t fields = 0;    ///< of a row
    std::vector<Field> known;  ///< those that mean something to us
    std::vector<std::string> names;
    std::uint64_t rows = 1;  ///< that it takes: 0 where it stands in a comment line

    const Field* find(Column column) const;
};

/// Errors, at `where`: notFound (no name that is known, more than 1024 fields), corrupt (a name twice),
/// unsupported, invalidArgument (units).
Result<CsvHeader> parseCsvHeader(std::string_view line, double mass, const std::string& where);

/// Whether a line can be a header: a field of it is no number and another has a known name.
bool looksLikeHeader(std::string_view line);

/// The header of a file: its first row, or the comment line before its first row where that has numbers only.
/// Errors: those of parseCsvHeader and of LineReader.
Result<CsvHeader> readCsvHeader(const std::filesystem::path& path, double mass);

/// Steps in the order of the numbers in the files' names. `mass` in eV/c^2, 0: unknown. Errors: notFound,
/// corrupt, unsupported, invalidArgument, cancelled.
Result<std::unique_ptr<ParticleSource>> openCsv(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress);

}  // namespace mote::prep
