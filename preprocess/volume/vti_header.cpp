// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/vti_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/mat3x3.hpp>

#include "preprocess/volume/vti_document.h"

namespace mote::prep {
namespace {

constexpr std::array<ScalarTypeName, 8> typeNames{{{"Int8", ScalarType::i8},
                                                   {"UInt8", ScalarType::u8},
                                                   {"Int16", ScalarType::i16},
                                                   {"UInt16", ScalarType::u16},
                                                   {"Int32", ScalarType::i32},
                                                   {"UInt32", ScalarType::u32},
                                                   {"Float32", ScalarType::f32},
                                                   {"Float64", ScalarType::f64}}};

class HeaderReader {
  public:
    HeaderReader(const VtiDocument& document, const VtiArray& array, VtiHeader& header)
        : document_(document), array_(array), header_(header) {}

    Status read() {
        MOTE_RETURN_IF_ERROR(readFile());
        MOTE_RETURN_IF_ERROR(readExtent());
        return readArray();
    }

  private:
    Status readFile() {
        const HeaderFields& file = document_.vtkFile;
        if (file.text("type") != "ImageData") return file.unsupported("type", "is not ImageData");
        const auto order = file.text("byte_order");
        if (order != "LittleEndian" && order != "BigEndian") {
            return file.corrupt("byte_order", "is neither LittleEndian nor BigEndian");
        }
        header_.bigEndian = order == "BigEndian";
        const auto sizes = file.text("header_type");
        if (!sizes.empty() && sizes != "UInt32" && sizes != "UInt64") {
            return file.corrupt("header_type", "is neither UInt32 nor UInt64");
        }
        header_.wideSizes = sizes == "UInt64";
        const auto compressor = file.text("compressor");
        header_.compressed = compressor == "vtkZLibDataCompressor";
        if (header_.compressed || compressor.empty()) return success();
        return file.unsupported(
            "compressor", fmt::format("\"{:.40}\" is not read, only vtkZLibDataCompressor", compressor));
    }

    /// Samples lie on points, or in the middle of cells; an axis of one point has one cell, without
    /// thickness.
    Status readExtent() {
        const HeaderFields& piece = document_.piece;
        const auto extent = piece.numbers("Extent", 6);
        if (!extent) return extent.error();
        const auto whole = document_.imageData.numbers("WholeExtent", 6);
        if (!whole) return whole.error();
        if (*extent != *whole) return piece.unsupported("Extent", "is only a part of WholeExtent");
        std::array<std::uint64_t, 3> sizes;
        glm::dvec3 first;
        for (std::size_t i = 0; i < 3; ++i) {
            const double from = (*extent)[2 * i], steps = (*extent)[2 * i + 1] - from;
            if (!(std::abs(from) < 0x1p31 && steps >= 0 && steps < 0x1p31 && steps == std::floor(steps))) {
                return piece.corrupt("Extent", fmt::format("says {} to {}", from, (*extent)[2 * i + 1]));
            }
            const bool cells = array_.ofCells && steps > 0;
            sizes[i] = static_cast<std::uint64_t>(steps) + (cells ? 0 : 1);
            first[static_cast<int>(i)] = from + (cells ? 0.5 : 0.0);
        }
        MOTE_RETURN_IF_ERROR(
            setDimensions(header_.shape, sizes[0], sizes[1], sizes[2], piece.where("Extent")));
        return readPlacement(first);
    }

    /// `first`: indices of the first sample.
    Status readPlacement(const glm::dvec3& first) {
        const HeaderFields& image = document_.imageData;
        glm::dmat3 steps(1.0);
        if (image.has("Direction")) {
            const auto rows = image.numbers("Direction", 9);
            if (!rows) return rows.error();
            for (int i = 0; i < 9; ++i) steps[i % 3][i / 3] = (*rows)[static_cast<std::size_t>(i)];
        }
        glm::dvec3 origin(0.0);
        if (image.has("Origin")) {
            const auto said = image.numbers("Origin", 3);
            if (!said) return said.error();
            origin = {(*said)[0], (*said)[1], (*said)[2]};
        }
        if (image.has("Spacing")) {
            const auto said = image.numbers("Spacing", 3);
            if (!said) return said.error();
            for (int i = 0; i < 3; ++i) steps[i] *= (*said)[static_cast<std::size_t>(i)];
        }
        return setPlacement(header_.shape, steps, origin + steps * first,
                            image.where("Spacing and Direction"));
    }

    Status readArray() {
        const HeaderFields& array = array_.attributes;
        if (!array_.isScalar()) {
            return array.unsupported("NumberOfComponents", "is not 1; vectors are not drawn");
        }
        const auto type = array.type("type", typeNames);
        if (!type) return type.error();
        header_.shape.type = *type;
        const auto format = array.text("format");
        if (format == "appended") return readAppended();
        if (format != "ascii" && format != "binary" && !format.empty()) {
            return array.corrupt("format", "is none of ascii, binary and appended");
        }
        header_.encoding = format == "binary" ? VtiHeader::Encoding::base64 : VtiHeader::Encoding::ascii;
        header_.dataAt = array_.contentAt;
        return success();
    }

    Status readAppended() {
        const HeaderFields& appended = document_.appended;
        if (document_.appendedAt == 0) {
            return array_.attributes.corrupt("format", "is appended, and nothing is");
        }
        const auto encoding = appended.text("encoding");
        if (encoding != "raw" && encoding != "base64") {
            return appended.corrupt("encoding", "is neither raw nor base64");
        }
        header_.encoding = encoding == "raw" ? VtiHeader::Encoding::raw : VtiHeader::Encoding::base64;
        const auto offset = array_.attributes.wholeNumber("offset", 0);
        if (!offset) return offset.error();
        header_.dataAt = document_.appendedAt + *offset;
        return success();
    }

    const VtiDocument& document_;
    const VtiArray& array_;
    VtiHeader& header_;
};

/// Appended data begin behind an underscore.
Result<std::uint64_t> behindUnderscore(ByteStream& file, std::uint64_t at) {
    MOTE_RETURN_IF_ERROR(file.seek(at));
    std::string blanks(256, '\0');
    const auto got = file.read(blanks);
    if (!got) return got.error();
    blanks.resize(*got);
    const std::size_t mark = blanks.find_first_not_of(" \t\r\n");
    if (mark == std::string::npos || blanks[mark] != '_') {
        return Error{ErrorCode::corrupt, file.name() + ": AppendedData", "does not begin with _"};
    }
    return at + mark + 1;
}

}  // namespace

bool VtiHeader::begins(std::string_view bytes) {
    return bytes.find("<VTKFile") != std::string_view::npos;
}

Result<VtiHeader> VtiHeader::parse(ByteStream& file, std::string_view field, const Progress& progress) {
    auto document = VtiDocument::parse(file, field, progress);
    if (!document) return document.error();
    const VtiArray* const array = document->chosen(field);
    if (array == nullptr) {
        return Error{ErrorCode::notFound, file.name(),
                     field.empty() ? "has no array with one value for each point or cell"
                                   : fmt::format("has no array of the name \"{:.40}\"", field)};
    }
    if (document->appendedAt > 0) {
        const auto at = behindUnderscore(file, document->appendedAt);
        if (!at) return at.error();
        document->appendedAt = *at;
    }
    VtiHeader header;
    MOTE_RETURN_IF_ERROR(HeaderReader(*document, *array, header).read());
    return header;
}

}  // namespace mote::prep
