// SPDX-License-Identifier: GPL-3.0-or-later
//
// SddsHeader: what the text before the first page of an SDDS data set declares: its parameters, arrays and
// columns, and how the pages are stored. A value, made once a file; one thread.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/text/stored_number.h"
#include "protocol/base/error.h"

namespace mote::prep {

enum class SddsType : std::uint8_t {
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    longDouble,  ///< in text only
    character,
    string,
};

/// A parameter, array or column.
struct SddsField {
    std::string name, units;  ///< as they are written, units with SDDS's marks for sub- and superscripts
    SddsType type = SddsType::float64;
    std::optional<std::string> fixedValue;  ///< of a parameter: then no page holds it
    std::uint32_t dimensions = 1;           ///< of an array
    std::optional<std::size_t> known;       ///< of a parameter: its place in SddsParameters

    /// Bytes of a value in binary pages; 0: as many as its text has.
    std::size_t bytes() const;
    std::optional<StoredNumber> stored() const;  ///< in a binary page; nothing of what is none there
    bool number() const { return type != SddsType::character && type != SddsType::string; }
};

/// The parameters that say something about a step; of others no value is kept.
inline constexpr std::string_view sddsParameterNames[] = {"Charge", "pCentral", "s",
                                                          "Step",   "Pass",     "PassCentralTime"};
using SddsParameters = std::array<double, std::size(sddsParameterNames)>;

/// No value: not a number.
inline SddsParameters noSddsParameters() {
    SddsParameters none;
    none.fill(std::numeric_limits<double>::quiet_NaN());
    return none;
}

struct SddsHeader {
    std::vector<SddsField> parameters, arrays, columns;
    bool ascii = false, columnMajor = false;
    std::optional<bool> bigEndian;  ///< nothing: the file does not say
    std::uint64_t linesPerRow = 1;  ///< of text; 0: rows end where their values do
    bool noRowCounts = false;       ///< a text page ends with an empty line
    std::uint64_t dataOffset = 0;   ///< bytes, of the first page in the file or what comes out of gunzip
    std::uint64_t dataLine = 0;     ///< lines before the first page

    /// Errors: those of ByteSource::open; corrupt (a command that is none), unsupported (`include`,
    /// longdouble in binary pages, a version above 5).
    static Result<SddsHeader> read(const std::filesystem::path& path);
};

/// Whether a file that begins with `text` is an SDDS data set: "SDDS" and its version.
bool looksLikeSdds(std::string_view text);

}  // namespace mote::prep
