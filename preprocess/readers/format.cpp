// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/format.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>

#include "preprocess/readers/csv/csv_header.h"
#include "preprocess/readers/h5part/h5part_source.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/text/byte_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t impactZColumns = 9;
constexpr std::size_t impactTColumns = 6;

struct Name {
    std::string_view name;
    Format format;
};
constexpr Name names[] = {{"openpmd", Format::openpmd}, {"h5part", Format::h5part},
                          {"impactz", Format::impactZ}, {"impactt", Format::impactT},
                          {"csv", Format::csv},         {"npy", Format::npy}};

Error unsupported(const std::filesystem::path& path, std::string message) {
    return {ErrorCode::unsupported, path.filename().string(), std::move(message)};
}

Error adios(const std::filesystem::path& path, std::string_view version) {
    return unsupported(path, "is an ADIOS2 " + std::string(version) +
                                 " file, which is not read; convert it with: openpmd-pipe --infile " +
                                 path.filename().string() + " --outfile " + path.stem().string() + ".h5");
}

Error sdds(const std::filesystem::path& path) {
    return unsupported(
        path,
        "is an SDDS file, which is not read yet; convert it, for example with sdds2stream to a "
        "table with a line of names");
}

/// A directory is no input of ours, but ADIOS2 writes its files as one.
Error directory(const std::filesystem::path& path) {
    std::error_code code;
    const bool index = std::filesystem::exists(path / "md.idx", code);
    const bool data = std::filesystem::exists(path / "data.0", code);
    if (index || data || path.extension() == ".bp" || path.extension() == ".bp4" ||
        path.extension() == ".bp5") {
        return adios(path, std::filesystem::exists(path / "mmd.0", code) ? "BP5" : "BP4");
    }
    return unsupported(path, "is a folder; name the files in it");
}

Result<Format> hdf5Format(const std::filesystem::path& path) {
    const auto file = H5File::open(path);
    if (!file) return file.error();
    if (looksLikeOpenpmd(*file)) return Format::openpmd;
    if (looksLikeH5Part(*file)) return Format::h5part;
    return unsupported(path,
                       "is an HDF5 file that is neither openPMD (no attribute 'openPMD' in its root) nor "
                       "H5Part (no group Step#0)");
}

/// A table of numbers without names. What its columns mean the deck beside it says.
Result<Format> numbersFormat(const proto::ParticlesJob& job, const std::filesystem::path& path,
                             std::size_t columns) {
    using Code = ImpactDeck::Code;
    const bool deckZ = ImpactDeck::beside(path, Code::impactZ).has_value();
    const bool deckT = ImpactDeck::beside(path, Code::impactT).has_value();
    if (columns >= impactTColumns && deckZ != deckT) return deckZ ? Format::impactZ : Format::impactT;
    if (columns == impactZColumns && job.has_impact() && job.impact().has_frequency()) return Format::impactZ;
    if (columns == impactTColumns && (job.has_impact() || deckT)) return Format::impactT;
    return unsupported(
        path, "is a table of " + std::to_string(columns) +
                  " columns of numbers without names; say what it is with --format impactz or impactt, or "
                  "put a line of names over it");
}

Result<Format> textFormat(const proto::ParticlesJob& job, const std::filesystem::path& path) {
    const auto shape = NumberTable::probe(path);
    if (!shape) return shape.error();
    if (shape->columns == 0) return unsupported(path, "is empty");
    const auto header = readCsvHeader(path, job.impact().mass());
    if (header) return Format::csv;
    // A unit or a name that is wrong in a line of names says more than "not known".
    if (header.error().code != ErrorCode::notFound) return header.error();
    if (!shape->numbers) {
        return unsupported(
            path,
            "is of no known format: neither HDF5 (openPMD, H5Part), .npy, a table with a line of "
            "names, nor a particle file of IMPACT");
    }
    return numbersFormat(job, path, shape->columns);
}

Result<Format> detect(const proto::ParticlesJob& job, const std::filesystem::path& path) {
    std::error_code code;
    const auto status = std::filesystem::status(path, code);
    if (std::filesystem::is_directory(status)) return directory(path);
    const auto source = ByteSource::open(path);
    if (!source) return source.error();
    std::array<char, 16> bytes{};
    const auto got = (*source)->read(bytes);
    if (!got) return got.error();
    const std::string_view begin(bytes.data(), *got);
    if (begin.empty()) return unsupported(path, "is empty");
    if (H5File::looksLikeHdf5(path)) return hdf5Format(path);
    if (begin.starts_with("\x93NUMPY")) return Format::npy;
    if (begin.starts_with("PK\x03\x04")) {
        return unsupported(path, "is a zip archive (.npz?); save each array by itself with numpy.save");
    }
    if (begin.starts_with("SDDS")) return sdds(path);
    if (begin.starts_with("ADIOS-BP") || path.extension() == ".bp") return adios(path, "BP");
    return textFormat(job, path);
}

}  // namespace

Result<Format> formatOf(const proto::ParticlesJob& job, const std::vector<std::filesystem::path>& files) {
    if (!job.format().empty() && job.format() != "auto") {
        if (job.format() == "sdds") return sdds(files.front());
        for (const Name& known : names) {
            if (known.name == job.format()) return known.format;
        }
        return Error{ErrorCode::invalidArgument, "format",
                     "'" + job.format() + "' is none of auto, openpmd, h5part, impactz, impactt, csv, npy"};
    }
    const auto first = detect(job, files.front());
    if (!first) return first.error();
    for (const std::filesystem::path& file : files) {
        const auto other = detect(job, file);
        if (!other) return other.error();
        if (*other != *first) {
            return Error{ErrorCode::invalidArgument, file.filename().string(),
                         "is of another format than " + files.front().filename().string()};
        }
    }
    return first;
}

}  // namespace mote::prep
