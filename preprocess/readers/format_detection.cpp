// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/format_detection.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <system_error>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/known_formats.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/sdds/sdds_header.h"
#include "preprocess/readers/text/byte_source.h"

namespace mote::prep {
namespace {

using Format = ParticleFormat;

constexpr std::size_t impactZColumns = 9;
constexpr std::size_t impactTColumns = 6;
constexpr std::size_t opalColumns = 6;
constexpr std::size_t astraColumns = 10;
constexpr std::size_t beginBytes = 4096;

struct Name {
    std::string_view name;
    Format format;
};
constexpr Name names[] = {
    {"openpmd", Format::openpmd}, {"h5part", Format::h5part},    {"impactz", Format::impactZ},
    {"impactt", Format::impactT}, {"sdds", Format::sdds},        {"csv", Format::csv},
    {"npy", Format::npy},         {"npz", Format::npz},          {"tracewin", Format::tracewin},
    {"astra", Format::astra},     {"genesis4", Format::genesis}, {"elegant", Format::elegant},
    {"tfs", Format::tfs},         {"json", Format::json},        {"gpt", Format::gpt},
    {"ocelot", Format::ocelot},   {"opal", Format::opal},        {"pyorbit", Format::pyorbit}};

Error unsupported(const std::filesystem::path& path, std::string message) {
    return {ErrorCode::unsupported, path.filename().string(), std::move(message)};
}

Result<Format> hdf5Format(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(const auto file, H5File::open(path));
    if (looksLikeOpenpmd(file)) return Format::openpmd;
    if (looksLikeH5Part(file)) return Format::h5part;
    if (looksLikeGenesis(file)) return Format::genesis;
    if (looksLikeSddsHdf5(file)) return Format::elegant;
    if (holdsOpenpmd(file)) return Format::openpmd;
    return unsupported(path,
                       "is an HDF5 file that is neither openPMD (no attribute 'openPMD' in its root, no such "
                       "particles in any group) nor H5Part (no group Step#0), of Genesis 4 (no slicelength) "
                       "or of elegant (no group page1/columns)");
}

/// A table of numbers without names. What its columns mean the deck beside it says.
Result<Format> numbersFormat(const proto::ParticlesJob& job, const std::filesystem::path& path,
                             const NumberTable::Shape& shape) {
    using Code = ImpactDeck::Code;
    const std::size_t columns = shape.columns;
    const bool deckZ = ImpactDeck::beside(path, Code::impactZ).has_value();
    const bool deckT = ImpactDeck::beside(path, Code::impactT).has_value();
    if (columns >= impactTColumns && deckZ != deckT) return deckZ ? Format::impactZ : Format::impactT;
    if (columns == impactZColumns && job.has_impact() && job.impact().has_frequency()) return Format::impactZ;
    // OPAL's and IMPACT-T's look alike, and mean the same but for the fifth column and the charge.
    const bool ofImpact = deckT || job.impact().has_frequency() || job.impact().has_current();
    if (columns == opalColumns && shape.declared && !ofImpact) return Format::opal;
    if (columns == impactTColumns && (ofImpact || job.has_impact())) return Format::impactT;
    if (columns == astraColumns && looksLikeAstra(path)) return Format::astra;
    return unsupported(
        path, "is a table of " + std::to_string(columns) +
                  " columns of numbers without names; say what they are with --map (x=1 [mm],px=2 [MeV/c]), "
                  "what it is with --format impactz or impactt, or put a line of names over it");
}

Result<Format> textFormat(const proto::ParticlesJob& job, const std::filesystem::path& path,
                          std::string_view begin) {
    MOTE_ASSIGN_OR_RETURN(const auto options, tableOptions(job));
    if (!options.map.empty()) return Format::csv;
    const std::size_t first = begin.find_first_not_of(" \t\r\n");
    if (first != std::string_view::npos) {
        if (begin.substr(first).starts_with("@ ")) return Format::tfs;
        if (begin[first] == '{' || begin[first] == '[') return Format::json;
    }
    if (looksLikePyorbit(begin)) return Format::pyorbit;
    if (looksLikeOpal(begin)) return Format::opal;
    if (looksLikeGptText(path)) return Format::gpt;
    MOTE_ASSIGN_OR_RETURN(const auto shape, NumberTable::probe(path));
    if (shape.columns == 0) return unsupported(path, "is empty");
    const auto header = readCsvHeader(path, options);
    if (header) return Format::csv;
    // A unit or a name that is wrong in a line of names says more than "not known".
    if (header.error().code != ErrorCode::notFound) return header.error();
    if (shape.numbers) return numbersFormat(job, path, shape);
    if (const auto known = knownFormat(begin, path.filename().string())) return unsupported(path, *known);
    return unsupported(
        path,
        "is of no known format: neither HDF5 (openPMD, H5Part), SDDS, .npy, .npz, a table with a line of "
        "names, nor a particle file of IMPACT; say what a table's columns are with --map (x=X [mm],...)");
}

Result<Format> detect(const proto::ParticlesJob& job, const std::filesystem::path& path) {
    std::error_code code;
    if (std::filesystem::is_directory(path, code)) {
        return unsupported(path, knownFolder(path).value_or("is a folder; name the files in it"));
    }
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    std::array<char, beginBytes> bytes{};
    std::size_t got = 0;
    while (got < bytes.size()) {
        MOTE_ASSIGN_OR_RETURN(const auto more, source->read(std::span(bytes).subspan(got)));
        if (more == 0) break;
        got += more;
    }
    const std::string_view begin(bytes.data(), got);
    if (begin.empty()) return unsupported(path, "is empty");
    if (H5File::looksLikeHdf5(path)) return hdf5Format(path);
    if (begin.starts_with("\x93NUMPY")) return Format::npy;
    if (looksLikeZip(begin)) return looksLikeOcelot(path) ? Format::ocelot : Format::npz;
    if (looksLikeGdf(begin)) return Format::gpt;
    if (looksLikeDst(begin)) return Format::tracewin;
    if (looksLikeSdds(begin)) return Format::sdds;
    // Bytes that are no text are of a format of their own; the first letters of a text may still be a name.
    const bool text = begin.find('\0') == std::string_view::npos;
    if (const auto known = knownFormat(begin, path.filename().string(), text))
        return unsupported(path, *known);
    if (begin.starts_with("ADIOS-BP") || path.extension() == ".bp")
        return unsupported(path, *knownFormat("ADIOS-BP", path.filename().string()));
    return textFormat(job, path, begin);
}

Result<Format> formatNamed(const std::string& name) {
    for (const Name& known : names) {
        if (known.name == name) return known.format;
    }
    std::string all = "auto";
    for (const Name& known : names) all += ", " + std::string(known.name);
    return Error{ErrorCode::invalidArgument, "format", "'" + name + "' is none of " + all};
}

/// What is not of the run: counted, the first one named.
struct LeftOut {
    std::size_t count = 0;
    std::string first;

    void add(const std::string& sentence) {
        if (count++ == 0) first = sentence;
    }
    void note(Progress& progress) const {
        if (count == 0) return;
        progress.note(std::to_string(count) + " of the files " + (count == 1 ? "is" : "are") +
                      " left out: " + first);
    }
};

/// What IMPACT writes of a run in files of these numbers: places, sizes and emittances, no particles.
bool isImpactStatistics(Format format, const std::filesystem::path& path) {
    constexpr std::int64_t first = 18, last = 36;
    if (format != Format::impactZ && format != Format::impactT) return false;
    const auto number = fileNumber(path);
    return path.filename().string().starts_with("fort.") && number && *number >= first && *number <= last;
}

/// A file and what its format is.
struct Told {
    const InputFile* file = nullptr;
    Format format = Format::csv;
};

std::string nameOf(Format format) {
    for (const Name& known : names) {
        if (known.format == format) return std::string(known.name);
    }
    return "";
}

/// Files that are named must be of one format. Of a folder it is that of most files: what lies beside a run
/// is no run.
Result<Format> formatOfRun(const std::vector<Told>& told) {
    const Told* named = nullptr;
    std::vector<std::pair<std::size_t, Format>> counts;
    for (const Told& one : told) {
        if (one.file->listed && named == nullptr) named = &one;
        if (one.file->listed && one.format != named->format) {
            return Error{ErrorCode::invalidArgument, one.file->path.filename().string(),
                         "is of another format than " + named->file->path.filename().string() + ": " +
                             nameOf(one.format) + ", not " + nameOf(named->format)};
        }
        auto found = std::find_if(counts.begin(), counts.end(),
                                  [&](const auto& count) { return count.second == one.format; });
        if (found == counts.end()) found = counts.insert(counts.end(), {0, one.format});
        ++found->first;
    }
    if (named != nullptr) return named->format;
    std::stable_sort(counts.begin(), counts.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    if (counts.size() < 2 || counts[0].first > counts[1].first) return counts.front().second;
    return Error{ErrorCode::invalidArgument, "inputs",
                 "are as many files of " + nameOf(counts[0].second) + " as of " + nameOf(counts[1].second) +
                     "; choose with --format, or name the files"};
}

/// The files of which a format can be told, by the job or by what they hold; at least one.
Result<std::vector<Told>> tellAll(const proto::ParticlesJob& job, const std::vector<InputFile>& files,
                                  LeftOut& leftOut) {
    const bool named = !job.format().empty() && job.format() != "auto";
    std::optional<Error> failed;
    std::vector<Told> told;
    for (const InputFile& file : files) {
        const auto format = named ? formatNamed(job.format()) : detect(job, file.path);
        if (!format.ok()) {
            const ErrorCode code = format.error().code;
            const bool odd = code == ErrorCode::corrupt || code == ErrorCode::unsupported;
            if (files.size() == 1 || !odd) return format.error();
            if (!failed) failed = format.error();
            leftOut.add(format.error().toString());
        } else if (!file.listed && isImpactStatistics(*format, file.path)) {
            leftOut.add(file.path.filename().string() + " is one of IMPACT's own tables, fort.18 to fort.36");
        } else {
            told.push_back({&file, *format});
        }
    }
    if (!told.empty()) return told;
    return failed ? *failed : Error{ErrorCode::unsupported, "inputs", "hold no particles: " + leftOut.first};
}

}  // namespace

Result<CsvOptions> tableOptions(const proto::ParticlesJob& job) {
    CsvOptions options;
    options.mass = job.impact().mass() > 0.0 ? job.impact().mass() : job.mass();
    MOTE_ASSIGN_OR_RETURN(options.map, TableMap::parse(job.map()));
    return options;
}

Result<ParticleFiles> detectFormat(const proto::ParticlesJob& job, const std::vector<InputFile>& files,
                                   Progress& progress) {
    LeftOut leftOut;
    MOTE_ASSIGN_OR_RETURN(const auto told, tellAll(job, files, leftOut));
    ParticleFiles found;
    MOTE_ASSIGN_OR_RETURN(found.format, formatOfRun(told));
    for (const Told& one : told) {
        const std::string name = one.file->path.filename().string();
        if (one.format == found.format)
            found.paths.push_back(one.file->path);
        else
            leftOut.add(name + " is " + nameOf(one.format) + ", not " + nameOf(found.format));
    }
    leftOut.note(progress);
    return found;
}

}  // namespace mote::prep
