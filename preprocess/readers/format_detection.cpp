// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/format_detection.h"

#include <algorithm>
#include <optional>
#include <system_error>

#include "preprocess/readers/adios2/bp_tree.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/joined_source.h"
#include "preprocess/readers/known_files.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/series_source.h"
#include "preprocess/readers/table/table_map.h"
#include "preprocess/readers/text/byte_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t beginBytes = 4096;

using ReaderKind = ParticleReader::Kind;

/// The first reader of a kind that takes the file for its own; null: none does.
Result<const ParticleReader*> readerOf(ReaderKind kind, const AskedFile& file) {
    for (const ParticleReader* reader : particleReaders()) {
        if (reader->kind != kind) continue;
        MOTE_ASSIGN_OR_RETURN(const bool own, reader->tells(file));
        if (own) return reader;
    }
    return nullptr;
}

Result<const ParticleReader*> tellHdf5(AskedFile file) {
    MOTE_ASSIGN_OR_RETURN(const auto opened, H5File::open(file.path));
    file.hdf5 = &opened;
    MOTE_ASSIGN_OR_RETURN(const auto* found, readerOf(ReaderKind::hdf5, file));
    if (found != nullptr) return found;
    if (opened.bp()) return unsupported(opened.name(), "is an ADIOS2 file without openPMD's particles");
    return unsupported(opened.name(),
                       "is an HDF5 file that is neither openPMD (no attribute 'openPMD' in its root, no such "
                       "particles in any group) nor H5Part (no group Step#0), of Genesis 4 (no slicelength) "
                       "or of elegant (no group page1/columns)");
}

Result<const ParticleReader*> tellText(AskedFile file) {
    const std::string name = file.path.filename().string();
    MOTE_ASSIGN_OR_RETURN(const auto map, TableMap::parse(file.job.map()));
    if (!map.empty()) return particleReader("csv");
    MOTE_ASSIGN_OR_RETURN(const auto* found, readerOf(ReaderKind::text, file));
    if (found != nullptr) return found;
    MOTE_ASSIGN_OR_RETURN(file.shape, NumberTable::probe(file.path));
    if (file.shape.columns == 0) return unsupported(name, "is empty");
    MOTE_ASSIGN_OR_RETURN(const auto* ofRows, readerOf(ReaderKind::rows, file));
    if (ofRows != nullptr) return ofRows;
    if (file.shape.numbers) {
        return unsupported(
            name,
            "is a table of " + std::to_string(file.shape.columns) +
                " columns of numbers without names; say what they are with --map (x=1 [mm],px=2 [MeV/c]), "
                "what it is with --format impactz or impactt, or put a line of names over it");
    }
    if (const auto known = knownFile(file.begin, name, WantedAs::particles)) return unsupported(name, *known);
    return unsupported(
        name,
        "is of no known format: neither HDF5 (openPMD, H5Part), SDDS, .npy, .npz, a table with a line of "
        "names, nor a particle file of IMPACT; say what a table's columns are with --map (x=X [mm],...)");
}

Result<const ParticleReader*> tell(const proto::ParticlesJob& job, const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    std::error_code code;
    if (BpTree::reads(path)) return tellHdf5({path, job, {}});
    if (std::filesystem::is_directory(path, code)) {
        return unsupported(
            name, knownFolder(path, WantedAs::particles).value_or("is a folder; name the files in it"));
    }
    MOTE_ASSIGN_OR_RETURN(const auto begin, beginningOf(path, beginBytes));
    if (begin.empty()) return unsupported(name, "is empty");
    const AskedFile file{path, job, begin};
    if (H5File::looksLikeHdf5(path)) return tellHdf5(file);
    MOTE_ASSIGN_OR_RETURN(const auto* found, readerOf(ReaderKind::bytes, file));
    if (found != nullptr) return found;
    // Bytes that are no text are of a format of their own; the first letters of a text may still be a name.
    const bool text = begin.find('\0') == std::string::npos;
    if (const auto known = knownFile(begin, name, WantedAs::particles, text))
        return unsupported(name, *known);
    if (path.extension() == ".bp")
        return unsupported(name, *knownFile("ADIOS-BP", name, WantedAs::particles));
    return tellText(file);
}

Result<const ParticleReader*> readerNamed(const std::string& name) {
    if (const auto* found = particleReader(name)) return found;
    std::string all;
    for (const std::string& known : particleFormats()) all += (all.empty() ? "" : ", ") + known;
    return invalid("format", "'" + name + "' is none of " + all);
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
bool isImpactStatistics(const ParticleReader& reader, const std::filesystem::path& path) {
    constexpr std::int64_t first = 18, last = 36;
    if (!reader.name.starts_with("impact")) return false;
    const auto number = fileNumber(path);
    return path.filename().string().starts_with("fort.") && number && *number >= first && *number <= last;
}

/// What a run of IMPACT was told, which its readers look for beside its dumps.
bool isImpactDeck(const std::filesystem::path& path) {
    const auto name = path.filename();
    return name == "ImpactZ.in" || name == "ImpactT.in";
}

/// A file and whose it is.
struct Told {
    const InputFile* file = nullptr;
    const ParticleReader* reader = nullptr;

    std::string name() const { return file->path.filename().string(); }
    std::string format() const { return std::string(reader->name); }
};

/// Files that are named must be of one format. Of a folder it is that of most files: what lies beside a run
/// is no run.
Result<const ParticleReader*> readerOfRun(const std::vector<Told>& told) {
    const Told* named = nullptr;
    std::vector<std::pair<std::size_t, const Told*>> counts;
    for (const Told& one : told) {
        if (one.file->listed && named == nullptr) named = &one;
        if (one.file->listed && one.format() != named->format()) {
            return invalid(one.name(), "is of another format than " + named->name() + ": " + one.format() +
                                           ", not " + named->format());
        }
        auto found = std::find_if(counts.begin(), counts.end(),
                                  [&](const auto& count) { return count.second->format() == one.format(); });
        if (found == counts.end()) found = counts.insert(counts.end(), {0, &one});
        ++found->first;
    }
    if (named != nullptr) return named->reader;
    std::stable_sort(counts.begin(), counts.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    if (counts.size() < 2 || counts[0].first > counts[1].first) return counts.front().second->reader;
    return invalid("inputs", "are as many files of " + counts[0].second->format() + " as of " +
                                 counts[1].second->format() + "; choose with --format, or name the files");
}

/// The files of which a format can be told, by the job or by what they hold; at least one.
Result<std::vector<Told>> tellAll(const proto::ParticlesJob& job, const std::vector<InputFile>& files,
                                  LeftOut& leftOut) {
    const bool named = !job.format().empty() && job.format() != "auto";
    std::optional<Error> failed;
    std::vector<Told> told;
    for (const InputFile& file : files) {
        if (!file.listed && isImpactDeck(file.path)) {
            leftOut.add(file.path.filename().string() + " is IMPACT's own input");
            continue;
        }
        const auto reader = named ? readerNamed(job.format()) : tell(job, file.path);
        if (!reader.ok()) {
            const ErrorCode code = reader.error().code;
            const bool odd = code == ErrorCode::corrupt || code == ErrorCode::unsupported;
            if (files.size() == 1 || !odd) return reader.error();
            if (!failed) failed = reader.error();
            leftOut.add(reader.error().toString());
        } else if (!file.listed && isImpactStatistics(**reader, file.path)) {
            leftOut.add(file.path.filename().string() + " is one of IMPACT's own tables, fort.18 to fort.36");
        } else {
            told.push_back({&file, *reader});
        }
    }
    if (!told.empty()) return told;
    return failed ? *failed : unsupported("inputs", "hold no particles: " + leftOut.first);
}

Status addSpecies(const std::filesystem::path& path, Progress& progress, std::vector<std::string>& names) {
    MOTE_ASSIGN_OR_RETURN(auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto root, findOpenpmdRoot(file));
    if (!root.empty()) MOTE_RETURN_IF_ERROR(file.enter(root));
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    for (const OpenpmdIteration& iteration : layout.iterations) {
        if (progress.cancelled()) return wasCancelled();
        const auto found = listSpecies(file, layout, iteration);
        if (!found.ok()) continue;  // who reads it says so
        for (const OpenpmdSpeciesPath& species : *found) {
            if (std::find(names.begin(), names.end(), species.name) == names.end())
                names.push_back(species.name);
        }
    }
    return success();
}

/// Each species by itself, then all as one.
Result<std::unique_ptr<ParticleSource>> openSpecies(const std::vector<std::string>& names,
                                                    const ParticleFiles& files,
                                                    const proto::ParticlesJob& job, Progress& progress) {
    std::vector<SpeciesPart> parts;
    for (const std::string& name : names) {
        proto::ParticlesJob one = job;
        one.set_species(name);
        SpeciesPart part;
        part.name = name;
        part.notes = std::make_unique<SpeciesNotes>(name, progress);
        MOTE_ASSIGN_OR_RETURN(part.source, files.reader->open({files.paths, one, massOf(job)}, *part.notes));
        parts.push_back(std::move(part));
    }
    return joinSpecies(std::move(parts), progress);
}

}  // namespace

Result<ParticleFiles> detectFormat(const proto::ParticlesJob& job, const std::vector<InputFile>& files,
                                   Progress& progress) {
    LeftOut leftOut;
    MOTE_ASSIGN_OR_RETURN(const auto told, tellAll(job, files, leftOut));
    ParticleFiles found;
    MOTE_ASSIGN_OR_RETURN(found.reader, readerOfRun(told));
    for (const Told& one : told) {
        if (one.reader->name == found.reader->name)
            found.paths.push_back(one.file->path);
        else
            leftOut.add(one.name() + " is " + one.format() + ", not " + std::string(found.reader->name));
    }
    leftOut.note(progress);
    return found;
}

Result<std::unique_ptr<ParticleSource>> openParticleSource(const proto::ParticlesJob& job,
                                                           const std::vector<std::filesystem::path>& inputs,
                                                           Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto files, inputFiles(inputs));
    MOTE_ASSIGN_OR_RETURN(const auto map, TableMap::parse(job.map()));
    MOTE_ASSIGN_OR_RETURN(auto found, detectFormat(job, files, progress));
    if (!job.species().empty() && found.reader->name != "openpmd") {
        return invalid("species", "only openPMD files have species");
    }
    if (!map.empty() && found.reader->name != "csv") {
        return invalid("map", "only tables of text have columns to be named");
    }
    MOTE_ASSIGN_OR_RETURN(const auto names, namesOfSpecies(job.species()));
    if (names.size() > 1) return openSpecies(names, found, job, progress);
    return found.reader->open({std::move(found.paths), job, massOf(job)}, progress);
}

Result<std::vector<std::string>> runSpecies(const proto::ParticlesJob& job,
                                            const std::vector<std::filesystem::path>& inputs,
                                            Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto files, inputFiles(inputs));
    MOTE_ASSIGN_OR_RETURN(const auto found, detectFormat(job, files, progress));
    std::vector<std::string> names;
    if (found.reader->name != "openpmd") return names;
    for (const std::filesystem::path& path : found.paths) {
        const Status added = addSpecies(path, progress, names);
        if (!added.ok() && added.error().code == ErrorCode::cancelled) return added.error();
    }
    return names;
}

}  // namespace mote::prep
