// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <string_view>

#include "preprocess/job.h"
#include "preprocess/readers/adios2/bp_tree.h"
#include "preprocess/readers/known_files.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/dicom/dicom_files.h"
#include "preprocess/volume/dicom/dicom_header.h"
#include "preprocess/volume/dicom/dicom_volume.h"
#include "preprocess/volume/openpmd_mesh.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t headBytes = 4096;
constexpr std::uint64_t mostEntries = 1u << 16;  // of an archive

/// Messages may quote the file, which need not be text.
Error quotable(Error error) {
    error.message = printableText(error.message);
    return error;
}

/// A volume as the job sees it: in the place that the options say, with messages that can be shown.
class PlacedVolume : public VolumeSource {
  public:
    PlacedVolume(std::unique_ptr<VolumeSource> source, VolumeShape shape, Progress& progress)
        : source_(std::move(source)), shape_(std::move(shape)), progress_(progress) {}
    std::string format() const override { return source_->format(); }
    const VolumeShape& shape() const override { return shape_; }
    std::optional<double> time() const override { return source_->time(); }
    bool sequential() const override { return source_->sequential(); }
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        auto status = source_->read(z0, z1, values);
        for (const auto& note : source_->takeNotes()) progress_.note(printableText(note));
        return status ? std::move(status) : Status(quotable(status.error()));
    }

  private:
    std::unique_ptr<VolumeSource> source_;
    VolumeShape shape_;
    Progress& progress_;
};

class SilentProgress : public Progress {
  public:
    void report(double, std::string_view) override {}
    void note(std::string_view) override {}
    bool cancelled() const override { return false; }
};

Status place(VolumeShape& shape, const proto::VolumeSourceOptions& options) {
    MOTE_RETURN_IF_ERROR(bringTo(options.space(), shape));
    glm::dmat3 steps(shape.indexToWorld);
    glm::dvec3 origin(shape.indexToWorld[3]);
    for (int i = 0; i < options.spacing_size(); ++i) {
        if (!(options.spacing(i) > 0.0)) return invalid("spacing", "is not over 0");
        steps[i] *= options.spacing(i) / glm::length(steps[i]);
    }
    for (int i = 0; i < options.origin_size(); ++i) origin[i] = options.origin(i);
    const auto status = setPlacement(shape, steps, origin, "spacing and origin");
    return status.ok() ? success() : Status(invalid(status.error().where, status.error().message));
}

DicomInput dicomOf(const VolumeStep& step) {
    DicomInput input{{step.input}, step.options.series()};
    input.paths.insert(input.paths.end(), step.others.begin(), step.others.end());
    return input;
}

using Source = Result<std::unique_ptr<VolumeSource>>;

/// What is known of a format: a row is all that openVolumeSource needs of a reader.
struct VolumeReader {
    std::string_view name;                   ///< as in --format
    std::string_view told;                   ///< what tells it, for people
    bool (*begins)(std::string_view bytes);  ///< null: not told by the first bytes of a file
    Source (*open)(const VolumeStep& step, Progress& progress);
    /// The volumes in a file; null: one, or those that stepsOf() knows of.
    Result<VolumeParts> (*parts)(const VolumeStep& step, Progress& progress) = nullptr;
};

/// Counts the volumes of a format whose header says how many there are.
template <Result<VolumeParts> (*parts)(const std::filesystem::path& path)>
Result<VolumeParts> partsOf(const VolumeStep& step, Progress&) {
    return parts(step.input);
}

/// Opens by a reader that needs the file and the field alone.
template <Source (*open)(const std::filesystem::path& path, const std::string& field)>
Source openField(const VolumeStep& step, Progress&) {
    return open(step.input, step.options.field());
}

// In the order in which a file's first bytes are looked at.
constexpr VolumeReader volumeReaders[] = {
    {"nrrd", "its first bytes NRRD", beginsAsNrrd, openField<openNrrd>, partsOf<partsOfNrrd>},
    {"nifti", "NIfTI's mark in its header", beginsAsNifti, openField<openNifti>, partsOf<partsOfNifti>},
    {"vdb", "OpenVDB's mark", beginsAsVdb, openField<openVdb>},
    {"pictures", "pictures, each a slice", beginsAsPicture,
     [](const VolumeStep& step, Progress& progress) {
         return openPictureStack(step.input, step.options.field(), progress);
     },
     [](const VolumeStep& step, Progress& progress) {
         return partsOfPictures(step.input, step.options.field(), progress);
     }},
    {"metaimage", "MetaImage's fields", beginsAsMetaImage, openField<openMetaImage>,
     partsOf<partsOfMetaImage>},
    {"vti", "XML of a VTK image", beginsAsVti,
     [](const VolumeStep& step, Progress& progress) {
         return openVti(step.input, step.options.field(), progress);
     }},
    {"npy", "NumPy's mark of one array", beginsAsNpy, openField<openNpy>},
    {"mrc", "MRC's mark MAP in its header", beginsAsMrc, openField<openMrc>, partsOf<partsOfMrc>},
    {"dicom", "DICOM's mark", DicomHeader::begins,
     [](const VolumeStep& step, Progress& progress) {
         const auto look = step.look ? Result(step.look) : lookAtDicom(dicomOf(step), progress);
         return look ? openDicom(*look, step.options.field()) : look.error();
     }},
    {"openpmd", "HDF5 or ADIOS2 with openPMD's attributes", nullptr, openField<openOpenpmdMesh>},
    {"raw", "its dimensions, which were given or are in its name", nullptr,
     [](const VolumeStep& step, Progress&) { return openRaw(step.options, step.input); }}};

const VolumeReader* volumeReader(std::string_view name) {
    const auto* const found = std::find_if(std::begin(volumeReaders), std::end(volumeReaders),
                                           [&](const VolumeReader& reader) { return reader.name == name; });
    return found == std::end(volumeReaders) ? nullptr : found;
}

/// A folder of a patient's files, or of pictures.
Result<std::string_view> formatOfFolder(const std::filesystem::path& folder) {
    SilentProgress silent;
    MOTE_ASSIGN_OR_RETURN(const bool dicom, holdsDicom(folder, silent));
    if (dicom) return std::string_view("dicom");
    if (BpTree::reads(folder)) return std::string_view("openpmd");
    if (const auto known = knownFolder(folder, WantedAs::volume)) {
        return unsupported(folder.filename().string(), *known);
    }
    return std::string_view("pictures");
}

/// An archive of arrays, or of a patient's files.
Result<std::string_view> formatOfArchive(const std::filesystem::path& input) {
    SilentProgress silent;
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(input));
    MOTE_ASSIGN_OR_RETURN(const auto entries, readZipDirectory(*source, mostEntries));
    const auto isArray = [](const ZipEntry& entry) { return entry.name.ends_with(".npy"); };
    if (std::any_of(entries.begin(), entries.end(), isArray)) return std::string_view("npy");
    MOTE_ASSIGN_OR_RETURN(const bool dicom, holdsDicom(input, silent));
    if (dicom) return std::string_view("dicom");
    return unsupported(input.filename().string(), "is a zip archive without arrays (.npy) or DICOM files");
}

Result<std::string_view> formatOf(const proto::VolumeSourceOptions& options,
                                  const std::filesystem::path& input) {
    if (!options.format().empty() && options.format() != "auto") return std::string_view(options.format());
    if (options.dimensions_size() > 0) return std::string_view("raw");
    std::error_code code;
    if (std::filesystem::is_directory(input, code)) return formatOfFolder(input);
    if (namesPictures(input)) {
        SilentProgress silent;
        MOTE_ASSIGN_OR_RETURN(const bool dicom, holdsDicom(input, silent));
        return std::string_view(dicom ? "dicom" : "pictures");
    }
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(input));
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(*file, headBytes));
    for (const VolumeReader& reader : volumeReaders) {
        if (reader.begins != nullptr && reader.begins(head)) return reader.name;
    }
    if (looksLikeZip(head)) return formatOfArchive(input);
    if (beginsAsHdf5(head)) {
        MOTE_ASSIGN_OR_RETURN(const bool openpmd, holdsOpenpmd(input));
        if (openpmd) return std::string_view("openpmd");
    }
    if (saidByName(input)) return std::string_view("raw");
    if (const auto known = knownFile(head, file->name(), WantedAs::volume)) {
        return unsupported(file->name(), *known);
    }
    return unsupported(
        file->name(),
        "is no NRRD, MetaImage, NIfTI, VTI, OpenVDB, openPMD (HDF5), DICOM, NumPy, MRC, PNG or TIFF "
        "file; a raw one is read by mote-prep volume, with --dimensions NX NY NZ and --type, or by a name "
        "like "
        "NAME_256x256x128_uint8.raw");
}

Source openAs(std::string_view format, const VolumeStep& step, Progress& progress) {
    if (const auto* reader = volumeReader(format)) return reader->open(step, progress);
    std::string names = "auto";
    for (const VolumeReader& reader : volumeReaders) names += fmt::format(", {}", reader.name);
    return invalid("format", fmt::format("\"{:.20}\" is none of {}", format, names));
}

/// The fields of the steps that an input is. What is wrong with it is said when it is opened.
Result<std::vector<std::string>> stepsOf(VolumeStep& step) {
    const auto format = formatOf(step.options, step.input);
    const std::string& field = step.options.field();
    if (format.ok() && *format == "openpmd") return meshSteps(step.input, field);
    if (format.ok() && *format == "npy") return npySteps(step.input, field);
    if (!format.ok() || *format == "raw") return std::vector<std::string>{field};
    SilentProgress silent;
    if (*format == "dicom") {
        // Thousands of files, perhaps, of hundreds of steps: they are looked at once.
        auto look = lookAtDicom(dicomOf(step), silent);
        if (!look) return quotable(look.error());
        step.look = std::move(look).value();
        return fieldsOfSeries(field, partsOfDicom(*step.look));
    }
    const auto* reader = volumeReader(*format);
    const auto parts =
        reader == nullptr || reader->parts == nullptr ? Result(VolumeParts{}) : reader->parts(step, silent);
    return parts.ok() ? fieldsOfSeries(field, *parts) : std::vector<std::string>{field};
}

Result<std::vector<VolumeField>> fieldsOfFormat(std::string_view format, const std::filesystem::path& input,
                                                const Progress& progress) {
    if (format == "vti") return vtiFields(input, progress);
    if (format == "vdb") return vdbFields(input);
    if (format == "npy") return npyFields(input);
    std::vector<VolumeField> fields;
    if (format != "openpmd") return fields;
    MOTE_ASSIGN_OR_RETURN(const auto names, meshFields(input));
    for (const auto& name : names) fields.push_back({name});
    return fields;
}

/// Pictures of a patient, each a file, are one input.
bool areOneInput(const proto::VolumeSourceOptions& options,
                 const std::vector<std::filesystem::path>& inputs) {
    const bool may = options.format().empty() || options.format() == "auto" || options.format() == "dicom";
    return may && inputs.size() > 1 && options.dimensions_size() == 0 && areDicomSlices(inputs);
}

}  // namespace

std::string_view toldOfVolume(std::string_view format) {
    const auto* reader = volumeReader(format);
    return reader == nullptr ? "its content" : reader->told;
}

Result<std::unique_ptr<VolumeSource>> openVolumeSource(const VolumeStep& step, Progress& progress) {
    const auto& options = step.options;
    if (options.spacing_size() != 0 && options.spacing_size() != 3) {
        return invalid("spacing", "needs three numbers");
    }
    if (options.origin_size() != 0 && options.origin_size() != 3) {
        return invalid("origin", "needs three numbers");
    }
    if (progress.cancelled()) return wasCancelled();
    MOTE_ASSIGN_OR_RETURN(const auto format,
                          step.look ? Result(std::string_view("dicom")) : formatOf(options, step.input));
    if (!options.series().empty() && format != "dicom") {
        return invalid("series", "is one of DICOM files, and these are none");
    }
    auto source = openAs(format, step, progress);
    if (!source) return quotable(source.error());
    VolumeShape shape = (*source)->shape();
    MOTE_RETURN_IF_ERROR(place(shape, options));
    for (const auto& note : shape.notes) progress.note(printableText(note));
    return std::unique_ptr<VolumeSource>(
        std::make_unique<PlacedVolume>(std::move(source).value(), std::move(shape), progress));
}

Result<std::unique_ptr<VolumeSource>> openVolumeSource(const proto::VolumeSourceOptions& options,
                                                       const std::filesystem::path& input,
                                                       Progress& progress) {
    return openVolumeSource(VolumeStep{input, options, {}, {}}, progress);
}

VolumeFields volumeFields(const proto::VolumeSourceOptions& options, const std::filesystem::path& input,
                          const Progress& progress) {
    const auto format = formatOf(options, input);
    if (!format) return {};
    auto fields = fieldsOfFormat(*format, input, progress);
    if (!fields || fields->size() < 2) return {};
    return {std::string(*format), std::move(fields).value()};
}

Result<std::vector<VolumeStep>> volumeSteps(const proto::VolumeSourceOptions& options,
                                            const std::vector<std::filesystem::path>& inputs) {
    std::vector<VolumeStep> whole;
    if (areOneInput(options, inputs)) {
        whole.push_back({inputs.front(), options, {inputs.begin() + 1, inputs.end()}, {}});
    } else {
        for (const auto& input : inputs) whole.push_back({input, options, {}, {}});
    }
    std::vector<VolumeStep> steps;
    for (auto& input : whole) {
        MOTE_ASSIGN_OR_RETURN(auto fields, stepsOf(input));
        for (auto& field : fields) {
            steps.push_back(input);
            steps.back().options.set_field(std::move(field));
        }
    }
    return steps;
}

}  // namespace mote::prep
