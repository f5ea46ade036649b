// SPDX-License-Identifier: GPL-3.0-or-later
//
// SddsPages: the pages of an SDDS data set, found once and then read from any row on. Nothing of them is kept
// but numeric parameters, places, and marks (24 bytes for each 65536 rows of variable length). Owned by the
// SDDS reader; one thread at a time; `progress` must outlive it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/sdds/sdds_header.h"
#include "protocol/base/error.h"

namespace mote::prep {

class H5File;

struct SddsPage {
    std::uint64_t rows = 0;
    SddsParameters parameters = noSddsParameters();
};

/// Values of some columns of consecutive rows.
struct SddsRows {
    std::vector<std::vector<double>> columns;  ///< in the order that was asked for
    std::vector<std::uint64_t> ids;            ///< of the id column, all 64 bits
};

class SddsPages {
  public:
    virtual ~SddsPages() = default;
    const std::vector<SddsPage>& pages() const { return pages_; }

    /// Reads rows [begin, begin + count) of a page, which must be there: columns by their numbers in the
    /// header, all of them numbers, and one of ids. Errors: corrupt, cancelled, those of ByteSource.
    virtual Status read(std::size_t page, std::uint64_t begin, std::size_t count,
                        const std::vector<std::size_t>& columns, std::optional<std::size_t> idColumn,
                        SddsRows& rows) = 0;

  protected:
    std::vector<SddsPage> pages_;
};

/// Finds all pages. Errors: corrupt (cut short, a length that the file cannot hold), cancelled, those of
/// ByteSource::open.
Result<std::unique_ptr<SddsPages>> openSddsBinary(const std::filesystem::path& path, const SddsHeader& header,
                                                  Progress& progress);
Result<std::unique_ptr<SddsPages>> openSddsAscii(const std::filesystem::path& path, const SddsHeader& header,
                                                 Progress& progress);

/// The same of an HDF5 file with groups page1, page2, ... as sdds2hdf makes it of a data set: what a header
/// would say, from the first page. Errors: those of H5File; corrupt.
bool looksLikeSddsHdf5(const H5File& file);  ///< a group /page1/columns stands
Result<SddsHeader> readSddsHdf5Header(const std::filesystem::path& path);
Result<std::unique_ptr<SddsPages>> openSddsHdf5(const std::filesystem::path& path, const SddsHeader& header,
                                                Progress& progress);

constexpr std::uint64_t sddsRowsPerMark = 1u << 16;
constexpr std::size_t maxSddsPages = 100'000;

}  // namespace mote::prep
