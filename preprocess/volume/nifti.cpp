// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>
#include <string_view>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// NIfTI-1 and NIfTI-2 volumes (nifti.nimh.nih.gov): .nii, or .hdr with the numbers in the .img file beside
// it. NiftiHeader: what the first 348 or 540 bytes say, checked. Parsed from bytes that nobody vouches for.
// Called from one thread.

struct NiftiHeader {
    VolumeShape shape;
    VolumeParts parts;  ///< how many there are; the first one is chosen
    SampleFormat samples;
    bool beside = false;                     ///< the numbers lie in the .img file beside the .hdr
    std::uint64_t offset = 0;                ///< bytes before the numbers, in the file that has them
    double timeStep = 0.0, firstTime = 0.0;  ///< s, of the volumes of a series; 0: not known

    /// How many bytes of a file's beginning parse() needs.
    static constexpr std::size_t maxBytes = 540;

    /// `bytes` is the beginning of a file that begins() holds for. Errors, at the file's name and the field:
    /// corrupt, unsupported.
    static Result<NiftiHeader> parse(std::string_view bytes, const std::string& file);
};

constexpr std::size_t firstBytes = 348, secondBytes = 540;  // of the header of either version
constexpr std::size_t firstMagicAt = 344, secondMagicAt = 4;

struct TypeCode {
    int code;
    ScalarType type;
};
/// nifti1.h: DT_UINT8 and so on.
constexpr std::array<TypeCode, 10> typeCodes{{{1024, ScalarType::i64},
                                              {1280, ScalarType::u64},
                                              {2, ScalarType::u8},
                                              {4, ScalarType::i16},
                                              {8, ScalarType::i32},
                                              {16, ScalarType::f32},
                                              {64, ScalarType::f64},
                                              {256, ScalarType::i8},
                                              {512, ScalarType::u16},
                                              {768, ScalarType::u32}}};

/// The header's fields under their names of nifti1.h, whatever version and byte order they have.
struct NiftiFields {
    bool bigEndian = false, beside = false;
    std::array<std::int64_t, 8> dim{};
    std::array<double, 8> pixdim{};
    int datatype = 0, qformCode = 0, sformCode = 0, units = 0;
    double voxOffset = 0.0, slope = 0.0, intercept = 0.0, timeOffset = 0.0;
    std::array<double, 6> quatern{};  ///< b, c, d and the offsets along x, y, z
    std::array<double, 12> srow{};    ///< the rows of an affine map
};

class Bytes {
  public:
    Bytes(std::string_view bytes, bool bigEndian) : bytes_(bytes), bigEndian_(bigEndian) {}
    template <class Number>
    Number at(std::size_t offset) const {
        return loadNumber<Number>(bytes_.data() + offset, bigEndian_);
    }
    template <class Number, class To, std::size_t count>
    void array(std::size_t offset, std::array<To, count>& to) const {
        for (std::size_t i = 0; i < count; ++i) {
            to[i] = static_cast<To>(at<Number>(offset + i * sizeof(Number)));
        }
    }

  private:
    std::string_view bytes_;
    bool bigEndian_;
};

NiftiFields firstVersion(const Bytes& bytes) {
    NiftiFields fields;
    bytes.array<std::int16_t>(40, fields.dim);
    fields.datatype = bytes.at<std::int16_t>(70);
    bytes.array<float>(76, fields.pixdim);
    fields.voxOffset = bytes.at<float>(108);
    fields.slope = bytes.at<float>(112);
    fields.intercept = bytes.at<float>(116);
    fields.units = bytes.at<std::uint8_t>(123);
    fields.timeOffset = bytes.at<float>(136);
    fields.qformCode = bytes.at<std::int16_t>(252);
    fields.sformCode = bytes.at<std::int16_t>(254);
    bytes.array<float>(256, fields.quatern);
    bytes.array<float>(280, fields.srow);
    return fields;
}

NiftiFields secondVersion(const Bytes& bytes) {
    NiftiFields fields;
    fields.datatype = bytes.at<std::int16_t>(12);
    bytes.array<std::int64_t>(16, fields.dim);
    bytes.array<double>(104, fields.pixdim);
    fields.voxOffset = static_cast<double>(bytes.at<std::int64_t>(168));
    fields.slope = bytes.at<double>(176);
    fields.intercept = bytes.at<double>(184);
    fields.timeOffset = bytes.at<double>(216);
    fields.qformCode = bytes.at<std::int32_t>(344);
    fields.sformCode = bytes.at<std::int32_t>(348);
    bytes.array<double>(352, fields.quatern);
    bytes.array<double>(400, fields.srow);
    fields.units = bytes.at<std::int32_t>(500);
    return fields;
}

/// The byte order in which the first number is the header's size; that of neither is no NIfTI file.
bool hasSize(std::string_view bytes, std::size_t size, bool bigEndian) {
    return bytes.size() >= size &&
           loadNumber<std::int32_t>(bytes.data(), bigEndian) == static_cast<int>(size);
}

NiftiFields readNiftiFields(std::string_view bytes) {
    const bool first = hasSize(bytes, firstBytes, false) || hasSize(bytes, firstBytes, true);
    const bool big = hasSize(bytes, first ? firstBytes : secondBytes, true);
    NiftiFields fields = first ? firstVersion(Bytes(bytes, big)) : secondVersion(Bytes(bytes, big));
    fields.bigEndian = big;
    fields.beside = bytes[(first ? firstMagicAt : secondMagicAt) + 1] == 'i';
    return fields;
}

class NiftiReader {
  public:
    NiftiReader(const NiftiFields& fields, const std::string& file, NiftiHeader& header)
        : fields_(fields), file_(file), header_(header) {}

    Status read() {
        MOTE_RETURN_IF_ERROR(readSize());
        MOTE_RETURN_IF_ERROR(readValues());
        MOTE_RETURN_IF_ERROR(readPlacement());
        static constexpr std::array<const char*, 4> units{"", "m", "mm", "um"};
        const auto unit = static_cast<std::size_t>(fields_.units & 7);
        header_.shape.worldUnit = unit < units.size() ? units[unit] : "";
        return success();
    }

  private:
    std::string where(const char* field) const { return file_ + ": " + field; }
    Error corrupt(const char* field, std::string message) const {
        return {ErrorCode::corrupt, where(field), std::move(message)};
    }

    Status readSize() {
        const std::int64_t axes = fields_.dim[0];
        if (axes < 1 || axes > 7) return corrupt("dim", fmt::format("says {} axes", axes));
        std::array<std::uint64_t, 7> sizes;
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            const std::int64_t size = static_cast<std::int64_t>(i) < axes ? fields_.dim[i + 1] : 1;
            if (size < 0) return corrupt("dim", fmt::format("says {} voxels", size));
            sizes[i] = static_cast<std::uint64_t>(size);
        }
        for (std::size_t i = 3; i < sizes.size(); ++i) {
            if (sizes[i] <= 1) continue;
            if (sizes[i] > VolumeShape::maxDimension || header_.parts.volumes > VolumeShape::maxDimension) {
                return Error{ErrorCode::resourceExhausted, where("dim"),
                             fmt::format("says {} volumes, more than are counted", sizes[i])};
            }
            header_.parts.volumes *= sizes[i];
        }
        readTimes(sizes[3] > 1 && sizes[3] == header_.parts.volumes);
        return setDimensions(header_.shape, sizes[0], sizes[1], sizes[2], where("dim"));
    }

    /// nifti1.h: NIFTI_UNITS_SEC, MSEC and USEC.
    void readTimes(bool series) {
        const int unit = fields_.units & 0x38;
        const double seconds = unit == 8 ? 1.0 : unit == 16 ? 1e-3 : unit == 24 ? 1e-6 : 0.0;
        const double step = fields_.pixdim[4] * seconds, first = fields_.timeOffset * seconds;
        if (!series || !(step > 0.0 && std::isfinite(step) && std::isfinite(first))) return;
        header_.timeStep = step;
        header_.firstTime = first;
    }

    Status readValues() {
        const auto found = std::find_if(typeCodes.begin(), typeCodes.end(),
                                        [&](const TypeCode& type) { return type.code == fields_.datatype; });
        if (found == typeCodes.end()) {
            return unsupported(
                where("datatype"),
                fmt::format("{} is no integer of 8 to 64 bits, float or double", fields_.datatype));
        }
        header_.shape.type = header_.samples.type = found->type;
        header_.samples.bigEndian = fields_.bigEndian;
        // A slope of 0 says that there is none.
        if (std::isfinite(fields_.slope) && std::isfinite(fields_.intercept) && fields_.slope != 0.0) {
            header_.samples.slope = fields_.slope;
            header_.samples.intercept = fields_.intercept;
        }
        header_.beside = fields_.beside;
        if (!(fields_.voxOffset >= 0.0 && fields_.voxOffset < 0x1p53)) {
            return corrupt("vox_offset", fmt::format("is {}", fields_.voxOffset));
        }
        header_.offset = static_cast<std::uint64_t>(fields_.voxOffset);
        return success();
    }

    /// nifti1.h: the affine map of the sform is the better known one, then the rotation of the qform, then
    /// nothing but the spacings, whose axes are nobody's.
    Status readPlacement() {
        const auto& row = fields_.srow;
        const bool sform = fields_.sformCode > 0 && isMap();
        if (fields_.sformCode > 0 && !sform) {
            header_.shape.notes.push_back(where("srow") + ": is no map, and was not used");
        }
        const bool turned = !sform && fields_.qformCode > 0;
        if (sform || turned) header_.shape.space = "right-anterior-superior";
        if (sform) {
            const glm::dmat3 steps(row[0], row[4], row[8], row[1], row[5], row[9], row[2], row[6], row[10]);
            return setPlacement(header_.shape, steps, {row[3], row[7], row[11]}, where("srow"));
        }
        if (!turned) header_.shape.notes.push_back(file_ + ": says no orientation, only voxel sizes");
        glm::dmat3 steps(1.0);
        glm::dvec3 origin(0.0);
        if (turned) {
            steps = rotation();
            origin = {fields_.quatern[3], fields_.quatern[4], fields_.quatern[5]};
            if (fields_.pixdim[0] < 0.0) steps[2] = -steps[2];
        }
        for (int i = 0; i < 3; ++i) steps[i] *= spacing(static_cast<std::size_t>(i));
        return setPlacement(header_.shape, steps, origin, where(turned ? "quatern and pixdim" : "pixdim"));
    }

    double spacing(std::size_t axis) {
        const double said = std::abs(fields_.pixdim[axis + 1]);
        if (said != 0.0) return said;
        header_.shape.notes.push_back(
            fmt::format("{}: is 0 along {}, and was taken as 1", where("pixdim"), "xyz"[axis]));
        return 1.0;
    }

    /// Whether the sform says three steps at all: some programs leave zeros behind its code.
    bool isMap() const {
        const auto& row = fields_.srow;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (row[axis] == 0.0 && row[axis + 4] == 0.0 && row[axis + 8] == 0.0) return false;
        }
        return true;
    }

    /// nifti1.h, "METHOD 2": by a unit quaternion whose first number follows from the others.
    glm::dmat3 rotation() const {
        double b = fields_.quatern[0], c = fields_.quatern[1], d = fields_.quatern[2];
        double a = 1.0 - (b * b + c * c + d * d);
        if (a < 1e-7) {  // a half turn, rounded
            const double length = std::sqrt(b * b + c * c + d * d);
            b /= length, c /= length, d /= length;
            a = 0.0;
        }
        a = std::sqrt(a);
        return {a * a + b * b - c * c - d * d, 2 * (b * c + a * d),           2 * (b * d - a * c),
                2 * (b * c - a * d),           a * a + c * c - b * b - d * d, 2 * (c * d + a * b),
                2 * (b * d + a * c),           2 * (c * d - a * b),           a * a + d * d - b * b - c * c};
    }

    const NiftiFields& fields_;
    const std::string& file_;
    NiftiHeader& header_;
};

namespace fs = std::filesystem;

/// "brain.hdr" or "brain.hdr.gz": the file "brain.img", or "brain.img.gz", beside it.
Result<ByteStreamPtr> imageBeside(const fs::path& header) {
    fs::path image = header;
    if (image.extension() == ".gz") image.replace_extension();
    image.replace_extension(".img");
    std::error_code code;
    if (fs::exists(image, code)) return fileStream(image);
    image += ".gz";
    if (fs::exists(image, code)) return fileStream(image);
    return notFound(header.filename().string(), "has no .img file beside it");
}

Result<NiftiHeader> NiftiHeader::parse(std::string_view bytes, const std::string& file) {
    if (!beginsAsNifti(bytes)) return Error{ErrorCode::corrupt, file, "does not begin as a NIfTI file"};
    const NiftiFields fields = readNiftiFields(bytes);
    NiftiHeader header;
    MOTE_RETURN_IF_ERROR(NiftiReader(fields, file, header).read());
    // Where the offset says less than the header and its extension flag, there is no extension.
    const bool first = hasSize(bytes, firstBytes, fields.bigEndian);
    if (!header.beside)
        header.offset = std::max<std::uint64_t>(header.offset, (first ? firstBytes : secondBytes) + 4);
    return header;
}

}  // namespace

bool beginsAsNifti(std::string_view bytes) {
    for (const bool big : {false, true}) {
        if (hasSize(bytes, firstBytes, big)) {
            const auto magic = bytes.substr(firstMagicAt, 3);
            return magic == "n+1" || magic == "ni1";
        }
        if (hasSize(bytes, secondBytes, big)) {
            const auto magic = bytes.substr(secondMagicAt, 3);
            return magic == "n+2" || magic == "ni2";
        }
    }
    return false;
}

Result<std::unique_ptr<VolumeSource>> openNifti(const fs::path& path, const std::string& field) {
    auto file = fileStream(path);
    if (!file) return file.error();
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(**file, NiftiHeader::maxBytes));
    MOTE_ASSIGN_OR_RETURN(auto header, NiftiHeader::parse(head, (*file)->name()));
    MOTE_ASSIGN_OR_RETURN(const auto parts, chooseParts(field, header.parts, (*file)->name() + ": dim"));
    if (header.timeStep > 0.0) {
        header.shape.time = header.firstTime + static_cast<double>(parts.volume) * header.timeStep;
    }
    if (header.beside) file = imageBeside(path);
    if (!file) return file.error();
    MOTE_ASSIGN_OR_RETURN(auto data, partStream(std::move(file).value(), header.offset));
    return StreamVolume::make("nifti", std::move(header.shape), header.samples, std::move(data),
                              StreamVolume::Ending::end, parts);
}

Result<VolumeParts> partsOfNifti(const std::filesystem::path& path) {
    return partsOfHeader<NiftiHeader>(path);
}

}  // namespace mote::prep
