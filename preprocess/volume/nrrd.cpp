// SPDX-License-Identifier: GPL-3.0-or-later
#include <bzlib.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/header_fields.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "protocol/base/utf8.h"

namespace mote::prep {
namespace {

// NRRD volumes, versions 1 to 5 (teem.sourceforge.net/nrrd/format.html): raw, gzip, bzip2, hex and text
// encoding, data in the same file or beside it. NrrdHeader: what the text at the beginning says, checked.
// Parsed from bytes that nobody vouches for. Called from one thread.

struct NrrdHeader {
    enum class Encoding : std::uint8_t { raw, text, hex, gzip, bzip2 };

    VolumeShape shape;
    VolumeParts parts;  ///< how many there are; the first one is chosen
    bool bigEndian = false;
    Encoding encoding = Encoding::raw;
    std::vector<std::string> dataFiles;  ///< as they stand there; none: the data follow the header
    std::uint64_t lineSkip = 0;          ///< lines before the data, compressed or not
    /// Bytes before the numbers, after decompression; none: they end with the file.
    std::optional<std::uint64_t> byteSkip = 0;
    std::size_t bytes = 0;  ///< of the header with the empty line behind it

    /// How many bytes of a file's beginning parse() may need.
    static constexpr std::size_t maxBytes = 1u << 20;

    /// `text` is the beginning of the file. Errors, at the file's name and the field: corrupt, unsupported.
    static Result<NrrdHeader> parse(std::string_view text, const std::string& file);
};

constexpr std::array<ScalarTypeName, 42> nrrdTypes{{
    {"longlong", ScalarType::i64},
    {"long long", ScalarType::i64},
    {"long long int", ScalarType::i64},
    {"signed long long", ScalarType::i64},
    {"signed long long int", ScalarType::i64},
    {"int64", ScalarType::i64},
    {"int64_t", ScalarType::i64},
    {"ulonglong", ScalarType::u64},
    {"unsigned long long", ScalarType::u64},
    {"unsigned long long int", ScalarType::u64},
    {"uint64", ScalarType::u64},
    {"uint64_t", ScalarType::u64},
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

struct NrrdEncodingName {
    std::string_view name;
    NrrdHeader::Encoding encoding;
};
constexpr std::array<NrrdEncodingName, 9> nrrdEncodings{{{"raw", NrrdHeader::Encoding::raw},
                                                         {"txt", NrrdHeader::Encoding::text},
                                                         {"text", NrrdHeader::Encoding::text},
                                                         {"ascii", NrrdHeader::Encoding::text},
                                                         {"hex", NrrdHeader::Encoding::hex},
                                                         {"gz", NrrdHeader::Encoding::gzip},
                                                         {"gzip", NrrdHeader::Encoding::gzip},
                                                         {"bz2", NrrdHeader::Encoding::bzip2},
                                                         {"bzip2", NrrdHeader::Encoding::bzip2}}};

// Streams that NRRD alone wraps its numbers in: bzip2, and hexadecimal text. Each owns the one it reads; one
// thread at a time.

constexpr std::size_t packedBuffer = std::size_t{256} * 1024;
// Blocks of 900,000 bytes, of which runs of 255 are five bytes before they are packed, take 32 bytes at
// least.
constexpr std::uint64_t bzip2Ratio = 900'000 / 5 * 255 / 32;

class Bzip2Stream : public ForwardStream {
  public:
    explicit Bzip2Stream(ByteStreamPtr compressed)
        : compressed_(std::move(compressed)), input_(packedBuffer) {}
    ~Bzip2Stream() override { end(); }
    Bzip2Stream(const Bzip2Stream&) = delete;
    Bzip2Stream& operator=(const Bzip2Stream&) = delete;

    std::string name() const override { return compressed_->name(); }
    std::uint64_t mostBytes() const override {
        const auto bytes = compressed_->mostBytes();
        constexpr auto most = std::numeric_limits<std::uint64_t>::max();
        return bytes > most / bzip2Ratio ? most : bytes * bzip2Ratio;
    }

    Status begin() {
        stream_ = {};
        open_ = BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK;
        return open_ ? success() : Status(Error{ErrorCode::internal, name(), "bzip2 could not be started"});
    }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size() && !finished_) {
            if (left_ == 0) {
                MOTE_ASSIGN_OR_RETURN(left_, compressed_->read(input_));
                at_ = 0;
                if (left_ == 0) {
                    if (betweenMembers_) break;
                    return corrupt("ends in the middle of its bzip2 data");
                }
            }
            if (betweenMembers_ && members_ > 0 && input_[at_] != 'B') break;
            MOTE_RETURN_IF_ERROR(step(bytes, done));
        }
        finished_ = finished_ || done < bytes.size();
        return done;
    }

    Status restart() override {
        MOTE_RETURN_IF_ERROR(compressed_->seek(0));
        left_ = at_ = members_ = 0;
        betweenMembers_ = true;
        finished_ = false;
        end();
        return begin();
    }

  private:
    Status step(std::span<char> bytes, std::size_t& done) {
        const auto piece = std::min<std::size_t>(bytes.size() - done, 1u << 30);
        stream_.next_in = input_.data() + at_;
        stream_.avail_in = static_cast<unsigned>(left_);
        stream_.next_out = bytes.data() + done;
        stream_.avail_out = static_cast<unsigned>(piece);
        const int code = BZ2_bzDecompress(&stream_);
        betweenMembers_ = false;
        at_ += left_ - stream_.avail_in;
        left_ = stream_.avail_in;
        done += piece - stream_.avail_out;
        if (code == BZ_OK) return success();
        if (code != BZ_STREAM_END) return corrupt("has damaged bzip2 data");
        ++members_;
        betweenMembers_ = true;
        end();
        return begin();
    }

    void end() {
        if (open_) BZ2_bzDecompressEnd(&stream_);
        open_ = false;
    }

    Error corrupt(std::string message) const { return {ErrorCode::corrupt, name(), std::move(message)}; }

    ByteStreamPtr compressed_;
    std::vector<char> input_;
    std::size_t at_ = 0, left_ = 0;  // of input_
    bz_stream stream_{};
    bool open_ = false, betweenMembers_ = true, finished_ = false;
    std::size_t members_ = 0;
};

int digitOf(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

class HexStream : public ForwardStream {
  public:
    explicit HexStream(ByteStreamPtr text) : text_(std::move(text)), buffer_(packedBuffer) {}
    std::string name() const override { return text_->name(); }
    std::uint64_t mostBytes() const override { return text_->mostBytes() / 2; }

  protected:
    Result<std::size_t> next(std::span<char> bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            MOTE_ASSIGN_OR_RETURN(const int high, nextDigit());
            if (high < 0) break;
            MOTE_ASSIGN_OR_RETURN(const int low, nextDigit());
            if (low < 0) return Error{ErrorCode::corrupt, name(), "ends with half a byte of its hex text"};
            bytes[done++] = static_cast<char>(high * 16 + low);
        }
        return done;
    }

    Status restart() override {
        begin_ = end_ = 0;
        return text_->seek(0);
    }

  private:
    /// -1 at the end of the text.
    Result<int> nextDigit() {
        for (;;) {
            if (begin_ == end_) {
                MOTE_ASSIGN_OR_RETURN(end_, text_->read(buffer_));
                begin_ = 0;
                if (end_ == 0) return -1;
            }
            const char c = buffer_[begin_++];
            if (const int digit = digitOf(c); digit >= 0) return digit;
            if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
            return Error{ErrorCode::corrupt, name(), "has a character in its hex text that is no digit"};
        }
    }

    ByteStreamPtr text_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;
};

/// What comes out of bzip2 data, several of them one after the other; what follows and is none is left alone.
/// Errors: internal; reading: corrupt (damaged or cut data).
Result<ByteStreamPtr> bzip2Stream(ByteStreamPtr compressed) {
    auto stream = std::make_unique<Bzip2Stream>(std::move(compressed));
    MOTE_RETURN_IF_ERROR(stream->begin());
    return ByteStreamPtr(std::move(stream));
}

/// A byte for every two digits of `text`; blanks and line ends are stepped over. Reading: corrupt where
/// something else stands, or a digit alone.
ByteStreamPtr hexStream(ByteStreamPtr text) {
    return std::make_unique<HexStream>(std::move(text));
}

constexpr std::size_t mostAxes = 16;

/// One axis of the array, fastest first.
struct NrrdAxis {
    std::uint64_t size = 0;
    std::optional<glm::dvec3> direction;  ///< one voxel's step; none: no axis of space
    double origin = 0.0;                  ///< of the first voxel's centre along it, without directions
};

/// Whether the values along an axis of this kind are samples of a space, not the parts of one value.
bool isSpatial(std::string_view said) {
    const std::string kind = lower(said);
    return kind.empty() || kind == "domain" || kind == "space" || kind == "none" || kind == "???";
}

/// The texts in quotes, or the words, of a field that has one for each axis.
std::vector<std::string> listed(std::string_view text) {
    std::vector<std::string> list;
    for (text = trim(text); !text.empty() && list.size() < mostAxes; text = trim(text)) {
        const bool quoted = text.front() == '"';
        if (quoted) text.remove_prefix(1);
        const std::size_t end = std::min(text.find(quoted ? '"' : ' '), text.size());
        list.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return list;
}

/// Reads the lines of the header into fields. Returns where they end.
Result<std::size_t> readNrrdFields(std::string_view text, HeaderFields& fields) {
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
        if (lower(line.substr(0, colon)).starts_with("data") &&
            lower(trim(line.substr(colon + 1))).starts_with("list")) {
            return at;
        }
    }
    return at;
}

class NrrdReader {
  public:
    NrrdReader(const HeaderFields& fields, NrrdHeader& header) : fields_(fields), header_(header) {}

    Status read() {
        MOTE_RETURN_IF_ERROR(readType());
        MOTE_RETURN_IF_ERROR(readEncoding());
        MOTE_RETURN_IF_ERROR(readSkips());
        MOTE_RETURN_IF_ERROR(readSizes());
        header_.shape.space = printableText(longSpace(fields_.text("space")));
        MOTE_RETURN_IF_ERROR(fields_.has("space directions") ? readDirections() : readSpacings());
        MOTE_RETURN_IF_ERROR(readOrigin());
        MOTE_RETURN_IF_ERROR(place());
        header_.shape.valueUnit = unitText(unquoted(fields_.text("sample units")));
        readUnits();
        return success();
    }

  private:
    static std::string_view unquoted(std::string_view text) {
        if (text.size() < 2 || text.front() != '"' || text.back() != '"') return text;
        return text.substr(1, text.size() - 2);
    }

    Status readType() {
        MOTE_ASSIGN_OR_RETURN(const auto type, fields_.type("type", nrrdTypes));
        header_.shape.type = type;
        return success();
    }

    Status readEncoding() {
        const std::string said = lower(fields_.text("encoding"));
        const auto* const found = std::find_if(nrrdEncodings.begin(), nrrdEncodings.end(),
                                               [&](const NrrdEncodingName& one) { return one.name == said; });
        if (found == nrrdEncodings.end()) {
            return fields_.unsupported(
                "encoding", fmt::format("\"{:.20}\" is none of raw, text, hex, gzip and bzip2", said));
        }
        header_.encoding = found->encoding;
        const std::string endian = lower(fields_.text("endian"));
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
        for (NrrdAxis& axis : axes_) {
            rest = trim(rest);
            if (lower(rest.substr(0, 4)) == "none") {
                rest.remove_prefix(4);
                continue;
            }
            MOTE_ASSIGN_OR_RETURN(auto direction, vector("space directions", rest));
            axis.direction = direction;
        }
        if (!trim(rest).empty()) return fields_.corrupt("space directions", "are more than the axes");
        return success();
    }

    Status readOrigin() {
        std::string_view text = fields_.text("space origin");
        if (text.empty() || lower(text) == "none") return success();
        MOTE_ASSIGN_OR_RETURN(const auto origin, vector("space origin", text));
        origin_ = origin;
        return success();
    }

    /// The first of the units; lengths of one voxel in several units have no common one.
    void readUnits() {
        const auto units = listed(fields_.text(fields_.has("space units") ? "space units" : "units"));
        std::string unit;
        for (const auto& one : units) {
            if (one.empty() || one == "???" || lower(one) == "none") continue;
            if (unit.empty()) unit = one;
            if (unit == one) continue;
            header_.shape.notes.push_back(fields_.where("units") +
                                          ": differ from axis to axis, and are left out");
            return;
        }
        header_.shape.worldUnit = unitText(unit);
    }

    /// "(1,2,3)" at the beginning of `text`, which loses it. A fourth number is a time's.
    Result<glm::dvec3> vector(std::string_view field, std::string_view& text) const {
        const std::size_t end = text.find(')');
        std::array<std::string_view, 5> words;
        const std::size_t count = text.starts_with('(') && end != std::string_view::npos
                                      ? splitFields(text.substr(1, end - 1), ',', words)
                                      : 0;
        if (count != 3 && count != 4) {
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
        MOTE_ASSIGN_OR_RETURN(const auto greatest, fields_.numbers("axis maxs"));
        for (const auto* list : {&spacings, &least, &greatest}) {
            if (list->empty() || list->size() == axes_.size()) continue;
            return fields_.corrupt(list == &spacings ? "spacings"
                                   : list == &least  ? "axis mins"
                                                     : "axis maxs",
                                   "are not one an axis");
        }
        const auto centers = listed(fields_.text(fields_.has("centers") ? "centers" : "centerings"));
        const auto numberOf = [](const std::vector<double>& list, std::size_t i) {
            return list.empty() ? std::numeric_limits<double>::quiet_NaN() : list[i];
        };
        const auto kinds = listed(fields_.text("kinds"));
        const bool skipsNan = axes_.size() > 3;
        int along = 0;
        for (std::size_t i = 0; i < axes_.size(); ++i) {
            const bool cell = i < centers.size() && lower(centers[i]) == "cell";
            double spacing = numberOf(spacings, i);
            const double min = numberOf(least, i), max = numberOf(greatest, i);
            const double steps = static_cast<double>(axes_[i].size) - (cell ? 0.0 : 1.0);
            if (std::isnan(spacing) && steps > 0.0 && std::isfinite(max - min)) spacing = (max - min) / steps;
            if (std::isnan(spacing) && skipsNan && !spacings.empty()) continue;
            if (i < kinds.size() && !isSpatial(kinds[i])) continue;
            if (std::isnan(spacing)) spacing = 1.0;
            glm::dvec3 direction(0.0);
            if (along < 3) direction[along] = spacing;
            axes_[i].direction = direction;
            ++along;
            if (std::isfinite(min)) axes_[i].origin = min + (cell ? 0.5 * spacing : 0.0);
        }
        return success();
    }

    bool isOfSpace(const NrrdAxis& axis, std::size_t i, const std::vector<std::string>& kinds) const {
        return axis.direction && isSpatial(i < kinds.size() ? kinds[i] : "") &&
               (!fields_.has("space directions") || *axis.direction != glm::dvec3(0.0));
    }

    /// Three axes are those of space; faster ones are the components of a voxel, slower ones several volumes.
    Status place() {
        const auto kinds = listed(fields_.text("kinds"));
        std::vector<NrrdAxis> space;
        for (std::size_t i = 0; i < axes_.size(); ++i) {
            const NrrdAxis& axis = axes_[i];
            if (isOfSpace(axis, i, kinds) && (space.size() < 3 || axis.size > 1)) {
                space.push_back(axis);
                continue;
            }
            if (axis.size == 1) continue;
            if (!space.empty() && space.size() < 3) {
                return fields_.unsupported(
                    "sizes",
                    fmt::format("says {} values between the axes of space, which are not read", axis.size));
            }
            auto& count = space.empty() ? header_.parts.components : header_.parts.volumes;
            if (axis.size > VolumeShape::maxDimension || count > VolumeShape::maxDimension) {
                return fields_.unsupported("sizes", "says more volumes than are counted");
            }
            count *= axis.size;
        }
        if (space.size() != 3) {
            return fields_.unsupported(
                "sizes", fmt::format("says {} axes of space; a volume has three", space.size()));
        }
        MOTE_RETURN_IF_ERROR(setDimensions(header_.shape, space[0].size, space[1].size, space[2].size,
                                           fields_.where("sizes")));
        const glm::dvec3 origin =
            origin_.value_or(glm::dvec3(space[0].origin, space[1].origin, space[2].origin));
        const glm::dmat3 steps(*space[0].direction, *space[1].direction, *space[2].direction);
        return setPlacement(header_.shape, steps, origin,
                            fields_.where(fields_.has("space directions") ? "space directions" : "spacings"));
    }

    const HeaderFields& fields_;
    NrrdHeader& header_;
    std::vector<NrrdAxis> axes_;
    std::optional<glm::dvec3> origin_;
};

/// The number of bytes of the first `lines` lines. Errors: corrupt (there are fewer).
Result<std::uint64_t> bytesOfLines(ByteStream& stream, std::uint64_t lines) {
    std::uint64_t bytes = 0;
    MOTE_RETURN_IF_ERROR(stream.seek(0));
    std::string block(4096, '\0');
    while (lines > 0) {
        MOTE_ASSIGN_OR_RETURN(const auto got, stream.read(block));
        if (got == 0) return corrupt(stream.name() + ": line skip", "is more than its lines");
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
    if (unwrapped && header.encoding == NrrdHeader::Encoding::bzip2) {
        unwrapped = bzip2Stream(std::move(unwrapped).value());
    }
    if (unwrapped && header.encoding == NrrdHeader::Encoding::hex) {
        unwrapped = hexStream(std::move(unwrapped).value());
    }
    if (!unwrapped) return unwrapped;
    unwrapped = skipHeader(std::move(unwrapped).value(), header.byteSkip, needed);
    if (!unwrapped || header.encoding != NrrdHeader::Encoding::text) return unwrapped;
    return numberStream(std::move(unwrapped).value());
}

Result<NrrdHeader> NrrdHeader::parse(std::string_view text, const std::string& file) {
    HeaderFields fields(file);
    MOTE_ASSIGN_OR_RETURN(const auto bytes, readNrrdFields(text, fields));
    NrrdHeader header;
    header.bytes = bytes;
    if (fields.has("data file")) {
        MOTE_ASSIGN_OR_RETURN(auto names, dataFileNames(fields.text("data file"), text.substr(bytes),
                                                        fields.where("data file")));
        header.dataFiles = std::move(names);
    }
    MOTE_RETURN_IF_ERROR(NrrdReader(fields, header).read());
    return header;
}

}  // namespace

bool beginsAsNrrd(std::string_view bytes) {
    return bytes.starts_with("NRRD00");
}

Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path, const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(const auto head, readHead(*file, NrrdHeader::maxBytes));
    MOTE_ASSIGN_OR_RETURN(auto header, NrrdHeader::parse(head, file->name()));
    SampleFormat samples;
    const bool text = header.encoding == NrrdHeader::Encoding::text;
    samples.type = text ? ScalarType::f64 : header.shape.type;
    samples.bigEndian = header.bigEndian && !text;
    MOTE_ASSIGN_OR_RETURN(const auto parts, chooseParts(field, header.parts, file->name() + ": sizes"));
    const std::uint64_t needed = header.shape.voxels() * bytesOf(samples.type) * parts.count();
    DataFiles files{path, std::move(file), header.bytes, header.dataFiles};
    MOTE_ASSIGN_OR_RETURN(
        auto data, dataStream(std::move(files), needed, [header](ByteStreamPtr stream, std::uint64_t share) {
            return unwrap(std::move(stream), header, share);
        }));
    return StreamVolume::make("nrrd", std::move(header.shape), samples, std::move(data),
                              text ? StreamVolume::Ending::exact : StreamVolume::Ending::end, parts);
}

Result<VolumeParts> partsOfNrrd(const std::filesystem::path& path) {
    return partsOfHeader<NrrdHeader>(path);
}

}  // namespace mote::prep
