// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/header_fields.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// MetaImage volumes (itk.org/Wiki/ITK/MetaIO/Documentation): .mha, or .mhd with data beside it, zlib or not,
// or text. MetaImageHeader: what the text at the beginning says, checked. Parsed from bytes that nobody
// vouches for. Called from one thread.

struct MetaImageHeader {
    VolumeShape shape;
    VolumeParts parts;     ///< how many there are; the first one is chosen
    SampleFormat samples;  ///< f64 where the values are written as text
    bool text = false, compressed = false;
    std::vector<std::string> dataFiles;  ///< as they stand there; none: the data follow the header
    /// Bytes before the numbers in a data file; none: they end with the file.
    std::optional<std::uint64_t> headerSize = 0;
    std::size_t bytes = 0;  ///< of the header

    /// How many bytes of a file's beginning parse() may need.
    static constexpr std::size_t maxBytes = 1u << 20;

    /// `text` is the beginning of the file. Errors, at the file's name and the field: corrupt, unsupported.
    static Result<MetaImageHeader> parse(std::string_view text, const std::string& file);
};

/// MET_LONG is four bytes in files, whatever the machine (metaTypes.h).
constexpr std::array<ScalarTypeName, 12> metaTypes{{
    {"MET_LONG_LONG", ScalarType::i64},
    {"MET_ULONG_LONG", ScalarType::u64},
    {"MET_CHAR", ScalarType::i8},
    {"MET_UCHAR", ScalarType::u8},
    {"MET_SHORT", ScalarType::i16},
    {"MET_USHORT", ScalarType::u16},
    {"MET_INT", ScalarType::i32},
    {"MET_UINT", ScalarType::u32},
    {"MET_LONG", ScalarType::i32},
    {"MET_ULONG", ScalarType::u32},
    {"MET_FLOAT", ScalarType::f32},
    {"MET_DOUBLE", ScalarType::f64},
}};

/// Reads the lines of the header, of which the last one names the data. Returns where they end.
Result<std::size_t> readMetaFields(std::string_view text, HeaderFields& fields) {
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = trim(text.substr(at, end - at));
        at = std::min(end + 1, text.size());
        if (line.empty()) continue;
        const std::size_t equals = line.find('=');
        if (equals == std::string_view::npos) {
            return fields.corrupt("header", fmt::format("has the line \"{:.40}\", which is no field", line));
        }
        MOTE_RETURN_IF_ERROR(fields.add(line.substr(0, equals), line.substr(equals + 1)));
        if (fields.has("ElementDataFile")) return at;
    }
    return fields.corrupt("ElementDataFile", "is missing");
}

class MetaReader {
  public:
    MetaReader(const HeaderFields& fields, MetaImageHeader& header) : fields_(fields), header_(header) {}

    Status read() {
        MOTE_RETURN_IF_ERROR(readSize());
        MOTE_RETURN_IF_ERROR(readPlacement());
        MOTE_RETURN_IF_ERROR(readType());
        MOTE_RETURN_IF_ERROR(readIntensity());
        return readHeaderSize();
    }

  private:
    /// The first of several names that a field has in different versions.
    std::string_view present(std::initializer_list<std::string_view> names) const {
        for (const auto name : names) {
            if (fields_.has(name)) return name;
        }
        return *names.begin();
    }

    Status readSize() {
        MOTE_ASSIGN_OR_RETURN(const auto sizes, fields_.wholeNumbers("DimSize"));
        MOTE_ASSIGN_OR_RETURN(const auto axes, fields_.wholeNumber("NDims", 3));
        if (axes != sizes.size()) {
            return fields_.corrupt("DimSize", "is not as many numbers as NDims says");
        }
        if (sizes.size() < 3) return fields_.unsupported("DimSize", "is not that of a volume");
        for (std::size_t i = 3; i < sizes.size(); ++i) {
            if (sizes[i] < 1 || sizes[i] > VolumeShape::maxDimension ||
                header_.parts.volumes > VolumeShape::maxDimension) {
                return fields_.unsupported("DimSize", "says no volumes, or more than are counted");
            }
            header_.parts.volumes *= sizes[i];
        }
        axes_ = sizes.size();
        return setDimensions(header_.shape, sizes[0], sizes[1], sizes[2], fields_.where("DimSize"));
    }

    /// The matrix has the direction of one axis in each row, and the world is in mm.
    Status readPlacement() {
        const auto spacingName = present({"ElementSpacing", "ElementSize"});
        const auto originName = present({"Offset", "Position", "Origin"});
        const auto matrixName = present({"TransformMatrix", "Rotation", "Orientation"});
        glm::dmat3 steps(1.0);
        glm::dvec3 origin(0.0);
        if (fields_.has(matrixName)) {
            MOTE_ASSIGN_OR_RETURN(const auto matrix, fields_.numbers(matrixName, axes_ * axes_));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (std::size_t i = 0; i < 3; ++i) {
                    steps[static_cast<int>(axis)][static_cast<int>(i)] = matrix[axis * axes_ + i];
                }
            }
        }
        if (fields_.has(spacingName)) {
            MOTE_ASSIGN_OR_RETURN(const auto spacing, fields_.numbers(spacingName, axes_));
            for (int i = 0; i < 3; ++i) steps[i] *= spacing[static_cast<std::size_t>(i)];
        }
        if (fields_.has(originName)) {
            MOTE_ASSIGN_OR_RETURN(const auto said, fields_.numbers(originName, axes_));
            origin = {said[0], said[1], said[2]};
        }
        header_.shape.worldUnit = "mm";
        readSpace(fields_.has(matrixName));
        return setPlacement(header_.shape, steps, origin,
                            fields_.where(fields_.has(matrixName) ? matrixName : spacingName));
    }

    /// The world is ITK's: left, posterior, superior. AnatomicalOrientation says once more what the matrix
    /// does, by where the axes come from; if there is no matrix, ITK does not look at it either.
    void readSpace(bool directed) {
        const auto said = fields_.text("AnatomicalOrientation");
        header_.shape.space = "left-posterior-superior";
        const bool known = !said.empty() && said.find('?') == std::string_view::npos;
        if (known && !directed && said != "RAI") {
            header_.shape.notes.push_back(fmt::format(
                "{}: is {:.8}, which was not used: voxels lie as TransformMatrix says, or by default",
                fields_.where("AnatomicalOrientation"), said));
        }
        if (!known) {
            header_.shape.notes.push_back(
                fields_.file() + ": its world was taken for left, posterior, superior, as ITK has it");
        }
    }

    Status readType() {
        MOTE_ASSIGN_OR_RETURN(const auto type, fields_.type("ElementType", metaTypes));
        MOTE_ASSIGN_OR_RETURN(const auto channels, fields_.wholeNumber("ElementNumberOfChannels", 1));
        if (channels < 1) return fields_.corrupt("ElementNumberOfChannels", "says no values");
        header_.parts.components = channels;
        header_.text = !fields_.flag("BinaryData", true);
        header_.compressed = fields_.flag("CompressedData", false);
        header_.shape.type = type;
        header_.samples.type = header_.text ? ScalarType::f64 : type;
        const auto order = present({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"});
        header_.samples.bigEndian = !header_.text && fields_.flag(order, false);
        return success();
    }

    Status readIntensity() {
        const auto number = [this](std::string_view name, double& value) -> Status {
            if (!fields_.has(name)) return success();
            MOTE_ASSIGN_OR_RETURN(const auto said, fields_.numbers(name, 1));
            value = said.front();
            return success();
        };
        MOTE_RETURN_IF_ERROR(number("ElementToIntensityFunctionSlope", header_.samples.slope));
        return number("ElementToIntensityFunctionOffset", header_.samples.intercept);
    }

    Status readHeaderSize() {
        if (fields_.text("HeaderSize") == "-1") {
            header_.headerSize.reset();
            return success();
        }
        MOTE_ASSIGN_OR_RETURN(const auto bytes, fields_.wholeNumber("HeaderSize", 0));
        header_.headerSize = bytes;
        return success();
    }

    const HeaderFields& fields_;
    MetaImageHeader& header_;
    std::size_t axes_ = 3;
};

/// Turns a file's bytes into its `needed` bytes of numbers: a header skipped, decompressed.
Result<ByteStreamPtr> unwrap(ByteStreamPtr stream, const MetaImageHeader& header, std::uint64_t needed) {
    auto unwrapped = skipHeader(std::move(stream), header.headerSize, needed);
    if (unwrapped && header.compressed)
        unwrapped = inflatedStream(std::move(unwrapped).value(), Inflater::Form::zlib);
    if (!unwrapped || !header.text) return unwrapped;
    return numberStream(std::move(unwrapped).value());
}

Result<MetaImageHeader> MetaImageHeader::parse(std::string_view text, const std::string& file) {
    HeaderFields fields(file);
    MOTE_ASSIGN_OR_RETURN(const auto bytes, readMetaFields(text, fields));
    MetaImageHeader header;
    header.bytes = bytes;
    MOTE_RETURN_IF_ERROR(MetaReader(fields, header).read());
    const std::string_view said = fields.text("ElementDataFile");
    if (said != "LOCAL" && said != "Local" && said != "local") {
        MOTE_ASSIGN_OR_RETURN(auto names,
                              dataFileNames(said, text.substr(bytes), fields.where("ElementDataFile")));
        header.dataFiles = std::move(names);
    }
    return header;
}

}  // namespace

bool beginsAsMetaImage(std::string_view bytes) {
    const std::string_view first = trim(bytes.substr(0, std::min(bytes.find('='), bytes.size())));
    return first == "ObjectType" || first == "NDims" || first == "Comment";
}

Result<std::unique_ptr<VolumeSource>> openMetaImage(const std::filesystem::path& path,
                                                    const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(*file, MetaImageHeader::maxBytes));
    MOTE_ASSIGN_OR_RETURN(auto header, MetaImageHeader::parse(head, file->name()));
    MOTE_ASSIGN_OR_RETURN(const auto parts, chooseParts(field, header.parts, file->name()));
    const std::uint64_t needed = header.shape.voxels() * bytesOf(header.samples.type) * parts.count();
    DataFiles files{path, std::move(file), header.bytes, std::move(header.dataFiles)};
    MOTE_ASSIGN_OR_RETURN(
        auto data, dataStream(std::move(files), needed, [header](ByteStreamPtr stream, std::uint64_t share) {
            return unwrap(std::move(stream), header, share);
        }));
    return StreamVolume::make("metaimage", std::move(header.shape), header.samples, std::move(data),
                              header.text ? StreamVolume::Ending::exact : StreamVolume::Ending::end, parts);
}

Result<VolumeParts> partsOfMetaImage(const std::filesystem::path& path) {
    return partsOfHeader<MetaImageHeader>(path);
}

}  // namespace mote::prep
