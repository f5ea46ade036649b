// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "preprocess/readers/csv/csv_source.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/particle_source.h"
#include "preprocess/readers/sdds/sdds_header.h"
#include "preprocess/readers/text/byte_source.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {
namespace {

// Format: which reader a file needs, by the name that the user gives or by what the file holds.

enum class Format : std::uint8_t {
    openpmd,
    h5part,
    impactZ,
    impactT,
    sdds,
    csv,
    npy,
    npz,
    tracewin,
    astra,
    genesis,
    elegant,
};

constexpr std::size_t impactZColumns = 9;
constexpr std::size_t impactTColumns = 6;
constexpr std::size_t astraColumns = 10;

struct Name {
    std::string_view name;
    Format format;
};
constexpr Name names[] = {
    {"openpmd", Format::openpmd}, {"h5part", Format::h5part},    {"impactz", Format::impactZ},
    {"impactt", Format::impactT}, {"sdds", Format::sdds},        {"csv", Format::csv},
    {"npy", Format::npy},         {"npz", Format::npz},          {"tracewin", Format::tracewin},
    {"astra", Format::astra},     {"genesis4", Format::genesis}, {"elegant", Format::elegant}};

Error unsupported(const std::filesystem::path& path, std::string message) {
    return {ErrorCode::unsupported, path.filename().string(), std::move(message)};
}

Error adios(const std::filesystem::path& path, std::string_view version) {
    return unsupported(
        path, "is an ADIOS2 " + std::string(version) +
                  " file, and this mote was built without ADIOS2; convert it with: openpmd-pipe --infile " +
                  path.filename().string() + " --outfile " + path.stem().string() + ".h5");
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
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    if (looksLikeOpenpmd(file)) return Format::openpmd;
    if (looksLikeH5Part(file)) return Format::h5part;
    if (looksLikeGenesis(file)) return Format::genesis;
    if (looksLikeSddsHdf5(file)) return Format::elegant;
    return unsupported(path,
                       "is an HDF5 file that is neither openPMD (no attribute 'openPMD' in its root) nor "
                       "H5Part (no group Step#0), of Genesis 4 (no slicelength) or of elegant (no group "
                       "page1/columns)");
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
    if (columns == astraColumns && looksLikeAstra(path)) return Format::astra;
    return unsupported(
        path, "is a table of " + std::to_string(columns) +
                  " columns of numbers without names; say what it is with --format impactz or impactt, or "
                  "put a line of names over it");
}

Result<Format> textFormat(const proto::ParticlesJob& job, const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto shape, NumberTable::probe(path));
    if (shape.columns == 0) return unsupported(path, "is empty");
    const auto header = readCsvHeader(path, job.impact().mass());
    if (header) return Format::csv;
    // A unit or a name that is wrong in a line of names says more than "not known".
    if (header.error().code != ErrorCode::notFound) return header.error();
    if (!shape.numbers) {
        return unsupported(
            path,
            "is of no known format: neither HDF5 (openPMD, H5Part), SDDS, .npy, .npz, a table with a line of "
            "names, nor a particle file of IMPACT");
    }
    return numbersFormat(job, path, shape.columns);
}

Result<Format> detect(const proto::ParticlesJob& job, const std::filesystem::path& path) {
    std::error_code code;
    const auto status = std::filesystem::status(path, code);
    if (std::filesystem::is_directory(status)) return directory(path);
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    std::array<char, 16> bytes{};
    MOTE_ASSIGN_OR_RETURN(const auto got, source->read(bytes));
    const std::string_view begin(bytes.data(), got);
    if (begin.empty()) return unsupported(path, "is empty");
    if (H5File::looksLikeHdf5(path)) return hdf5Format(path);
    if (begin.starts_with("\x93NUMPY")) return Format::npy;
    if (looksLikeZip(begin)) return Format::npz;
    if (looksLikeDst(begin)) return Format::tracewin;
    if (looksLikeSdds(begin)) return Format::sdds;
    if (begin.starts_with("ADIOS-BP") || path.extension() == ".bp") return adios(path, "BP");
    return textFormat(job, path);
}

/// The format that the job names, or what the first file holds and the others begin like. Errors: notFound,
/// unsupported (with what may be done), invalidArgument (an unknown name, files of different formats).
Result<Format> formatOf(const proto::ParticlesJob& job, const std::vector<std::filesystem::path>& files) {
    if (!job.format().empty() && job.format() != "auto") {
        for (const Name& known : names) {
            if (known.name == job.format()) return known.format;
        }
        return Error{
            ErrorCode::invalidArgument, "format",
            "'" + job.format() +
                "' is none of auto, openpmd, h5part, impactz, impactt, astra, tracewin, genesis4, sdds, "
                "elegant, csv, npy, npz"};
    }
    const auto first = detect(job, files.front());
    if (!first) return first.error();
    for (const std::filesystem::path& file : files) {
        MOTE_ASSIGN_OR_RETURN(const auto other, detect(job, file));
        if (other != *first) {
            return Error{ErrorCode::invalidArgument, file.filename().string(),
                         "is of another format than " + files.front().filename().string()};
        }
    }
    return first;
}

constexpr std::size_t maxFiles = 100'000;

/// The files that a name with %T or %06T stands for ("run_%T.h5"), by their numbers, or the name itself.
Result<std::vector<std::filesystem::path>> expand(const std::filesystem::path& input) {
    std::error_code code;
    const std::string pattern = input.filename().string();
    if (std::filesystem::exists(input, code) || pattern.find('%') == std::string::npos) return {{input}};
    std::vector<std::pair<std::int64_t, std::filesystem::path>> found;
    const std::filesystem::path folder = input.parent_path().empty() ? "." : input.parent_path();
    for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
         entry.increment(code)) {
        if (const auto number = matchIteration(pattern, entry->path().filename().string())) {
            found.emplace_back(*number, entry->path());
        }
        if (found.size() > maxFiles) break;
    }
    if (found.empty()) return Error{ErrorCode::notFound, pattern, "no file has a name like this"};
    std::sort(found.begin(), found.end());
    std::vector<std::filesystem::path> files;
    for (auto& [number, path] : found) files.push_back(std::move(path));
    return files;
}

Result<std::vector<std::filesystem::path>> allFiles(const std::vector<std::filesystem::path>& inputs) {
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& input : inputs) {
        MOTE_ASSIGN_OR_RETURN(const auto some, expand(input));
        files.insert(files.end(), some.begin(), some.end());
        if (files.size() > maxFiles) {
            return Error{ErrorCode::resourceExhausted, "inputs", "are more than 100000 files"};
        }
    }
    if (files.empty()) return Error{ErrorCode::invalidArgument, "inputs", "no input was given"};
    return files;
}

}  // namespace

Result<std::unique_ptr<ParticleSource>> openParticleSource(const proto::ParticlesJob& job,
                                                           const std::vector<std::filesystem::path>& inputs,
                                                           Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto files, allFiles(inputs));
    MOTE_ASSIGN_OR_RETURN(const auto format, formatOf(job, files));
    if (!job.species().empty() && format != Format::openpmd) {
        return Error{ErrorCode::invalidArgument, "species", "only openPMD files have species"};
    }
    const double mass = job.impact().mass();
    switch (format) {
        case Format::openpmd:
            return openOpenpmd(files, job.species(), progress);
        case Format::h5part:
            return openH5Part(files, mass, progress);
        case Format::impactZ:
            return openImpact(ImpactDeck::Code::impactZ, files, job.impact(), progress);
        case Format::impactT:
            return openImpact(ImpactDeck::Code::impactT, files, job.impact(), progress);
        case Format::sdds:
            return openSdds("sdds", files, mass, progress);
        case Format::elegant:
            return openSdds("elegant", files, mass, progress);
        case Format::tracewin:
            return openDst(files, mass, progress);
        case Format::astra:
            return openAstra(files, mass, progress);
        case Format::genesis:
            return openGenesis(files, mass, progress);
        case Format::csv:
            return openCsv(files, mass, progress);
        case Format::npy:
            return openNpy("npy", files, mass, progress);
        case Format::npz:
            return openNpy("npz", files, mass, progress);
    }
    return Error{ErrorCode::internal, "", "no reader is known for this format"};
}

}  // namespace mote::prep
