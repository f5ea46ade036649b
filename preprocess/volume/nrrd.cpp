// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/nrrd.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/mat3x3.hpp>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/header_fields.h"
#include "preprocess/volume/stream_volume.h"

namespace mote::prep {
namespace {

constexpr std::size_t mostAxes = 16;

constexpr std::array<ScalarTypeName, 30> typeNames{{
    {"signed char", ScalarType::i8},
    {"int8", ScalarType::i8},
    {"int8_t", ScalarType::i8},
    {"uchar", ScalarType::u8},
    {"unsigned char", ScalarType::u8},
    {"uint8", ScalarType::u8},
    {"uint8_t", ScalarType::u8},
    {"short", ScalarType::i16},
    {"short int", ScalarType::i16},
    {"signed short", ScalarType::i16},
    {"signed short int", ScalarType::i16},
    {"int16", ScalarType::i16},
    {"int16_t", ScalarType::i16},
    {"ushort", ScalarType::u16},
    {"unsigned short", ScalarType::u16},
    {"unsigned short int", ScalarType::u16},
    {"uint16", ScalarType::u16},
    {"uint16_t", ScalarType::u16},
    {"int", ScalarType::i32},
    {"signed int", ScalarType::i32},
    {"int32", ScalarType::i32},
    {"int32_t", ScalarType::i32},
    {"uint", ScalarType::u32},
    {"unsigned int", ScalarType::u32},
    {"uint32", ScalarType::u32},
    {"uint32_t", ScalarType::u32},
    {"float", ScalarType::f32},
    {"double", ScalarType::f64},
    {"float32", ScalarType::f32},
    {"float64", ScalarType::f64},
}};

/// One axis of the array, fastest first.
struct Axis {
    std::uint64_t size = 0;
    std::optional<glm::dvec3> direction;  ///< one voxel's step; none: no axis of space
    double origin = 0.0;                  ///< of the first voxel's centre along it, without directions
};

/// Whether the values along an axis of this kind are samples of a space, not the parts of one value.
bool isSpatial(std::string_view kind) {
    return kind.empty() || kind == "domain" || kind == "space" || kind == "none" || kind == "???";
}

/// Reads the lines of the header into fields. Returns where they end.
Result<std::size_t> readFields(std::string_view text, HeaderFields& fields) {
    std::size_t at = 0;
    for (bool first = true; at < text.size(); first = false) {
        const std::size_t end = text.find('\n', at);
        if (end == std::string_view::npos && text.size() >= NrrdHeader::maxBytes) {
            return fields.corrupt("header", "has no end");
        }
        const std::string_view line = trim(text.substr(at, end - at));
        at = end == std::string_view::npos ? text.size() : end + 1;
        if (line.empty()) return at;
        if (first || line.front() == '#') continue;
        const std::size_t colon = line.find(':');
        if (colon == std::string_view::npos) {
            return fields.corrupt("header", fmt::format("has the line \"{:.40}\", which is no field", line));
        }
        if (line.substr(colon).starts_with(":=")) continue;  // a key of the user's own
        MOTE_RETURN_IF_ERROR(fields.add(line.substr(0, colon), line.substr(colon + 1)));
        // What follows a list of files is no field.
        if (line.substr(0, colon).starts_with("data") && trim(line.substr(colon + 1)).starts_with("LIST")) {
            return at;
        }
    }
    return at;
}

class HeaderReader {
  public:
    HeaderReader(const HeaderFields& fields, NrrdHeader& header) : fields_(fields), header_(header) {}

    Status read() {
        MOTE_RETURN_IF_ERROR(readType());
        MOTE_RETURN_IF_ERROR(readEncoding());
        MOTE_RETURN_IF_ERROR(readSkips());
        MOTE_RETURN_IF_ERROR(readSizes());
        MOTE_RETURN_IF_ERROR(fields_.has("space directions") ? readDirections() : readSpacings());
        MOTE_RETURN_IF_ERROR(place());
        header_.shape.valueUnit = unitText(unquoted(fields_.text("sample units")));
        const std::string_view units = fields_.text("space units");
        header_.shape.worldUnit = unitText(unquoted(units.substr(0, units.find(' '))));
        return success();
    }

  private:
    static std::string_view unquoted(std::string_view text) {
        if (text.size() < 2 || text.front() != '"' || text.back() != '"') return text;
        return text.substr(1, text.size() - 2);
    }

    Status readType() {
        MOTE_ASSIGN_OR_RETURN(const auto type, fields_.type("type", typeNames));
        header_.shape.type = type;
        return success();
    }

    Status readEncoding() {
        const std::string_view said = fields_.text("encoding");
        if (said == "raw") {
            header_.encoding = NrrdHeader::Encoding::raw;
        } else if (said == "txt" || said == "text" || said == "ascii") {
            header_.encoding = NrrdHeader::Encoding::text;
        } else if (said == "gz" || said == "gzip") {
            header_.encoding = NrrdHeader::Encoding::gzip;
        } else {
            return fields_.unsupported("encoding",
                                       fmt::format("\"{:.20}\" is none of raw, gzip and text", said));
        }
        const std::string_view endian = fields_.text("endian");
        header_.bigEndian = endian == "big";
        const bool needed = header_.encoding != NrrdHeader::Encoding::text && bytesOf(header_.shape.type) > 1;
        if (endian == "big" || endian == "little" || (endian.empty() && !needed)) return success();
        return fields_.corrupt("endian", fmt::format("\"{:.20}\" is neither big nor little", endian));
    }

    Status readSkips() {
        MOTE_ASSIGN_OR_RETURN(const auto lines, fields_.wholeNumber("line skip", 0));
        header_.lineSkip = lines;
        if (fields_.text("byte skip") == "-1") {
            header_.byteSkip.reset();
            return success();
        }
        MOTE_ASSIGN_OR_RETURN(const auto bytes, fields_.wholeNumber("byte skip", 0));
        header_.byteSkip = bytes;
        return success();
    }

    Status readSizes() {
        MOTE_ASSIGN_OR_RETURN(const auto dimension, fields_.wholeNumber("dimension", 3));
        MOTE_ASSIGN_OR_RETURN(const auto sizes, fields_.wholeNumbers("sizes"));
        if (dimension != sizes.size() || sizes.size() > mostAxes) {
            return fields_.corrupt("sizes", "are not as many as dimension says");
        }
        for (const std::uint64_t size : sizes) axes_.push_back({size, std::nullopt, 0.0});
        return success();
    }

    /// "(1,0,0) (0,1,0) none (0,0,2)": a vector an axis.
    Status readDirections() {
        std::string_view rest = fields_.text("space directions");
        for (Axis& axis : axes_) {
            rest = trim(rest);
            if (rest.starts_with("none")) {
                rest.remove_prefix(4);
                continue;
            }
            MOTE_ASSIGN_OR_RETURN(auto direction, vector("space directions", rest));
            axis.direction = direction;
        }
        if (!trim(rest).empty()) return fields_.corrupt("space directions", "are more than the axes");
        if (!fields_.has("space origin")) return success();
        std::string_view text = fields_.text("space origin");
        MOTE_ASSIGN_OR_RETURN(const auto origin, vector("space origin", text));
        origin_ = origin;
        return success();
    }

    /// "(1,2,3)" at the beginning of `text`, which loses it.
    Result<glm::dvec3> vector(std::string_view field, std::string_view& text) const {
        const std::size_t end = text.find(')');
        std::array<std::string_view, 3> words;
        if (!text.starts_with('(') || end == std::string_view::npos ||
            splitFields(text.substr(1, end - 1), ',', words) != 3) {
            return fields_.corrupt(field, "is not three numbers in brackets for each axis");
        }
        glm::dvec3 vector;
        for (int i = 0; i < 3; ++i) {
            const auto number = parseNumber(words[static_cast<std::size_t>(i)]);
            if (!number) return fields_.corrupt(field, "has something else than numbers");
            vector[i] = *number;
        }
        text.remove_prefix(end + 1);
        return vector;
    }

    /// Axes without directions lie along x, y and z; a spacing that is not a number stands for none.
    Status readSpacings() {
        MOTE_ASSIGN_OR_RETURN(const auto spacings, fields_.numbers("spacings"));
        MOTE_ASSIGN_OR_RETURN(const auto least, fields_.numbers("axis mins"));
        if ((!spacings.empty() && spacings.size() != axes_.size()) ||
            (!least.empty() && least.size() != axes_.size())) {
            return fields_.corrupt(spacings.empty() ? "axis mins" : "spacings", "are not one an axis");
        }
        std::array<std::string_view, mostAxes> centers;
        splitFields(fields_.text(fields_.has("centers") ? "centers" : "centerings"), ' ', centers);
        const bool skipsNan = axes_.size() > 3;
        int along = 0;
        for (std::size_t i = 0; i < axes_.size(); ++i) {
            const double said = spacings.empty() ? 1.0 : spacings[i];
            if (skipsNan && !spacings.empty() && std::isnan(said)) continue;
            const double spacing = std::isnan(said) ? 1.0 : said;
            glm::dvec3 direction(0.0);
            if (along < 3) direction[along] = spacing;
            axes_[i].direction = direction;
            ++along;
            if (least.empty() || std::isnan(least[i])) continue;
            axes_[i].origin = least[i] + (centers[i] == "cell" ? 0.5 * spacing : 0.0);
        }
        return success();
    }

    /// Three axes are those of space; others may only have one value.
    Status place() {
        std::array<std::string_view, mostAxes> kinds;
        splitFields(fields_.text("kinds"), ' ', kinds);
        std::vector<Axis> space;
        for (std::size_t i = 0; i < axes_.size(); ++i) {
            const Axis& axis = axes_[i];
            if (axis.direction && isSpatial(kinds[i])) {
                space.push_back(axis);
            } else if (axis.size != 1) {
                return fields_.unsupported(
                    "sizes", fmt::format("says {} values for each voxel; only one is drawn", axis.size));
            }
        }
        while (space.size() > 3 && space.back().size == 1) space.pop_back();
        if (space.size() != 3) {
            return fields_.unsupported("sizes",
                                       fmt::format("says {} axes; a volume has three", space.size()));
        }
        MOTE_RETURN_IF_ERROR(setDimensions(header_.shape, space[0].size, space[1].size, space[2].size,
                                           fields_.where("sizes")));
        const bool directed = fields_.has("space directions");
        const glm::dvec3 origin =
            directed ? origin_ : glm::dvec3(space[0].origin, space[1].origin, space[2].origin);
        const glm::dmat3 steps(*space[0].direction, *space[1].direction, *space[2].direction);
        return setPlacement(header_.shape, steps, origin,
                            fields_.where(directed ? "space directions" : "spacings"));
    }

    const HeaderFields& fields_;
    NrrdHeader& header_;
    std::vector<Axis> axes_;
    glm::dvec3 origin_{0.0};
};

/// The number of bytes of the first `lines` lines. Errors: corrupt (there are fewer).
Result<std::uint64_t> bytesOfLines(ByteStream& stream, std::uint64_t lines) {
    std::uint64_t bytes = 0;
    MOTE_RETURN_IF_ERROR(stream.seek(0));
    std::string block(4096, '\0');
    while (lines > 0) {
        MOTE_ASSIGN_OR_RETURN(const auto got, stream.read(block));
        if (got == 0)
            return Error{ErrorCode::corrupt, stream.name() + ": line skip", "is more than its lines"};
        std::size_t at = 0;
        for (; at < got && lines > 0; ++at) lines -= block[at] == '\n' ? 1 : 0;
        bytes += at;
    }
    return bytes;
}

/// Turns a file's bytes into its `needed` bytes of numbers: lines skipped, decompressed, bytes skipped.
Result<ByteStreamPtr> unwrap(ByteStreamPtr stream, const NrrdHeader& header, std::uint64_t needed) {
    MOTE_ASSIGN_OR_RETURN(const auto lines, bytesOfLines(*stream, header.lineSkip));
    // A data file that is gzipped as a whole was decompressed when it was opened.
    const bool done = !header.dataFiles.empty() && !stream->size();
    auto unwrapped = partStream(std::move(stream), lines);
    if (unwrapped && header.encoding == NrrdHeader::Encoding::gzip && !done) {
        unwrapped = inflatedStream(std::move(unwrapped).value(), Inflater::Form::gzip);
    }
    if (!unwrapped) return unwrapped;
    unwrapped = skipHeader(std::move(unwrapped).value(), header.byteSkip, needed);
    if (!unwrapped || header.encoding != NrrdHeader::Encoding::text) return unwrapped;
    return numberStream(std::move(unwrapped).value());
}

}  // namespace

Result<NrrdHeader> NrrdHeader::parse(std::string_view text, const std::string& file) {
    HeaderFields fields(file);
    MOTE_ASSIGN_OR_RETURN(const auto bytes, readFields(text, fields));
    NrrdHeader header;
    header.bytes = bytes;
    if (fields.has("data file")) {
        MOTE_ASSIGN_OR_RETURN(auto names, dataFileNames(fields.text("data file"), text.substr(bytes),
                                                        fields.where("data file")));
        header.dataFiles = std::move(names);
    }
    MOTE_RETURN_IF_ERROR(HeaderReader(fields, header).read());
    return header;
}

Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(*file, NrrdHeader::maxBytes));
    MOTE_ASSIGN_OR_RETURN(auto header, NrrdHeader::parse(head, file->name()));
    SampleFormat samples;
    const bool text = header.encoding == NrrdHeader::Encoding::text;
    samples.type = text ? ScalarType::f64 : header.shape.type;
    samples.bigEndian = header.bigEndian && !text;
    const std::uint64_t needed = header.shape.voxels() * bytesOf(samples.type);
    DataFiles files{path, std::move(file), header.bytes, header.dataFiles};
    MOTE_ASSIGN_OR_RETURN(
        auto data, dataStream(std::move(files), needed, [header](ByteStreamPtr stream, std::uint64_t share) {
            return unwrap(std::move(stream), header, share);
        }));
    return StreamVolume::make("nrrd", std::move(header.shape), samples, std::move(data));
}

}  // namespace mote::prep
