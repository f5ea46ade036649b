// SPDX-License-Identifier: GPL-3.0-or-later
#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/volume/byte_stream.h"
#include "preprocess/volume/header_fields.h"
#include "preprocess/volume/stream_volume.h"
#include "preprocess/volume/volume_formats.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "protocol/base/mote_check.h"

namespace mote::prep {
namespace {

// Where expat is in a document; its older functions of these are deprecated since 2.9.
#if XML_MAJOR_VERSION * 1000 + XML_MINOR_VERSION >= 2009
constexpr auto* xmlLine = XML_GetCurrentLineNumber64;
constexpr auto* xmlByte = XML_GetCurrentByteIndex64;
constexpr auto* xmlBytes = XML_GetCurrentByteCount64;
#else
constexpr auto* xmlLine = XML_GetCurrentLineNumber;
constexpr auto* xmlByte = XML_GetCurrentByteIndex;
constexpr auto* xmlBytes = XML_GetCurrentByteCount;
#endif

// VtiHeader: what the XML of a VTK image file (.vti) says of one of its arrays, checked. Parsed from bytes
// that nobody vouches for, by expat, which never sees the numbers behind the array's own tag. A value, free
// of threads.
//
// VTK image files (.vti; docs.vtk.org, "XML File Formats"): values as text, in base64 or appended,
// compressed by zlib or not. Called from one thread.

struct VtiHeader {
    enum class Encoding : std::uint8_t { ascii, base64, raw };

    VolumeShape shape;
    Encoding encoding = Encoding::base64;
    bool bigEndian = false;    ///< the values, and the sizes before them
    bool wideSizes = false;    ///< sizes have 64 bits, not 32
    bool compressed = false;   ///< in blocks, by zlib
    std::uint64_t dataAt = 0;  ///< bytes before the array's sizes and values in the file
    VolumeParts parts;         ///< values of a point, and which is read
    bool magnitude = false;    ///< of the vector that they are is read, and none of them

    /// Reads the header of the array `field`; "": the active scalars, else the first array with one value for
    /// each point, else for each cell. Of an array with several values a point, "NAME:1" is the second,
    /// "NAME:magnitude" the length of the vector that they are. Reads `file` as far as needed. Errors, at the
    /// file's name and element: corrupt, unsupported (several values, and none was asked for), notFound (no
    /// such array), cancelled, those of `file`.
    static Result<VtiHeader> parse(ByteStream& file, std::string_view field, const Progress& progress);
};

// MagnitudeVolume: the lengths of vectors whose components are volumes of one shape. One owner, one thread at
// a time.

class MagnitudeVolume : public VolumeSource {
  public:
    /// Takes one at least.
    explicit MagnitudeVolume(std::vector<std::unique_ptr<VolumeSource>> components)
        : components_(std::move(components)) {
        MOTE_CHECK(!components_.empty());
        shape_ = components_.front()->shape();
        shape_.type = ScalarType::f32;  // lengths of integers are none
        shape_.valueStep = 0.0;
    }

    std::string format() const override { return components_.front()->format(); }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return components_.front()->sequential(); }

    /// Slice by slice, so that sums take no more memory than one.
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        const auto slice = static_cast<std::size_t>(shape_.voxelsOfSlice());
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == slice * (z1 - z0));
        one_.resize(slice);
        for (std::uint32_t z = z0; z < z1; ++z) {
            sums_.assign(slice, 0.0);
            for (auto& component : components_) {
                MOTE_RETURN_IF_ERROR(component->read(z, z + 1, one_));
                for (std::size_t i = 0; i < slice; ++i) sums_[i] += static_cast<double>(one_[i]) * one_[i];
            }
            const auto made = values.subspan((z - z0) * slice, slice);
            std::transform(sums_.begin(), sums_.end(), made.begin(),
                           [](double sum) { return static_cast<float>(std::sqrt(sum)); });
        }
        return success();
    }

    std::vector<std::string> takeNotes() override {
        std::vector<std::string> notes;
        for (auto& component : components_) {
            auto some = component->takeNotes();
            std::move(some.begin(), some.end(), std::back_inserter(notes));
        }
        return notes;
    }

  private:
    std::vector<std::unique_ptr<VolumeSource>> components_;
    VolumeShape shape_;
    std::vector<float> one_;
    std::vector<double> sums_;
};

// VtiDocument: the elements of a VTK image file's XML that matter, as expat meets them. A value, free of
// threads.

/// A DataArray element.
struct VtiArray {
    HeaderFields attributes;
    bool ofCells = false;         ///< not of points
    bool active = false;          ///< the Scalars of its points or cells
    std::uint64_t contentAt = 0;  ///< bytes of the file before what follows its tag

    bool isScalar() const {
        const auto count = attributes.text("NumberOfComponents");
        return count.empty() || count == "1";
    }
    /// Which points VTK hides, and numbers that it gives them for itself.
    bool isMark() const {
        const auto name = attributes.text("Name");
        return name == "vtkGhostType" || name == "vtkGhostLevels" || name == "vtkValidPointMask" ||
               name == "vtkOriginalPointIds" || name == "vtkOriginalCellIds" || name == "GlobalPointIds" ||
               name == "GlobalCellIds" || name == "GlobalNodeId" || name == "GlobalElementId";
    }
    /// Whether no array that follows can be the one to read: it has the name `field`, or is the active one of
    /// the points if there is no name.
    bool isSurely(std::string_view field) const {
        return field.empty() ? active && !ofCells && isScalar() && !isMark()
                             : attributes.text("Name") == field;
    }
};

struct VtiDocument {
    HeaderFields vtkFile, imageData, piece, appended;  ///< attributes; none where the element is missing
    std::vector<VtiArray> arrays;
    std::uint64_t appendedAt = 0;  ///< bytes of the file before what follows AppendedData; 0: there is none

    /// Reads `file` as far as needed to find the array `field`: expat never sees appended data, nor those of
    /// an array that is surely the one. Errors, at the file's name and line: corrupt (no XML; a document
    /// type; a tag of more than 1 MiB), unsupported (several pieces), cancelled, those of `file`.
    static Result<VtiDocument> parse(ByteStream& file, std::string_view field, const Progress& progress);

    /// The one that isSurely(), else, but for marks, without a name the first scalars of points, else of
    /// cells. Null: none.
    const VtiArray* chosen(std::string_view field) const;
};

constexpr std::size_t chunkBytes = 1u << 16;
constexpr std::uint64_t longestTag = 1u << 20;  // bytes that expat holds back
constexpr std::size_t mostArrays = 4096;

class Parser {
  public:
    Parser(ByteStream& file, std::string_view field, VtiDocument& document)
        : file_(file), field_(field), document_(document) {}

    Status parse(const Progress& progress) {
        if (!parser_) return Error{ErrorCode::resourceExhausted, file_.name(), "cannot be parsed: no memory"};
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(
            parser_.get(),
            [](void* self, const char* name, const char** attributes) {
                static_cast<Parser*>(self)->start(name, attributes);
            },
            [](void* self, const char* name) { static_cast<Parser*>(self)->end(name); });
        // Nothing that VTK writes has one, and entities are a way to make much out of little.
        XML_SetStartDoctypeDeclHandler(
            parser_.get(), [](void* self, const char*, const char*, const char*, int) {
                static_cast<Parser*>(self)->fail(ErrorCode::corrupt, "has a document type of its own");
            });
        MOTE_RETURN_IF_ERROR(file_.seek(0));
        std::vector<char> chunk(chunkBytes);
        for (bool last = false; !last && !done_;) {
            if (progress.cancelled()) return wasCancelled();
            MOTE_ASSIGN_OR_RETURN(const auto got, file_.read(chunk));
            last = got < chunk.size();
            MOTE_RETURN_IF_ERROR(feed(std::span(chunk).first(got), last));
        }
        return success();
    }

  private:
    Status feed(std::span<const char> bytes, bool last) {
        const auto status = XML_Parse(parser_.get(), bytes.data(), static_cast<int>(bytes.size()), last);
        if (error_) return *error_;
        if (done_) return success();
        fed_ += bytes.size();
        const auto at =
            static_cast<std::uint64_t>(std::max(std::int64_t{xmlByte(parser_.get())}, std::int64_t{0}));
        if (status == XML_STATUS_OK && fed_ - std::min(at, fed_) <= longestTag) return success();
        const auto* const what = status == XML_STATUS_OK ? "a tag without an end"
                                                         : XML_ErrorString(XML_GetErrorCode(parser_.get()));
        return corrupt(fmt::format("{}: line {}", file_.name(), xmlLine(parser_.get())),
                       fmt::format("is no XML: {}", what));
    }

    void fail(ErrorCode code, std::string message) {
        error_ = Error{code, file_.name(), std::move(message)};
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    void finish() {
        done_ = true;
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    HeaderFields fields(const std::string& element, const char** attributes) const {
        HeaderFields fields(file_.name() + ": " + element);
        for (; attributes[0] != nullptr; attributes += 2) {
            (void)fields.add(attributes[0], attributes[1]);  // expat refuses those that stand there twice
        }
        return fields;
    }

    std::uint64_t contentAt() const {
        return static_cast<std::uint64_t>(xmlByte(parser_.get())) +
               static_cast<std::uint64_t>(xmlBytes(parser_.get()));
    }

    void start(const std::string& element, const char** attributes) {
        if (done_ || error_) return;
        if (element == "VTKFile") document_.vtkFile = fields(element, attributes);
        if (element == "ImageData") document_.imageData = fields(element, attributes);
        if (element == "Piece") {
            if (document_.piece.has("Extent")) return fail(ErrorCode::unsupported, "has more than one piece");
            document_.piece = fields(element, attributes);
        }
        if (element == "PointData" || element == "CellData") {
            inCells_ = element == "CellData";
            active_ = fields(element, attributes).text("Scalars");
        }
        if (element == "FieldData") inFieldData_ = true;
        // Values of no point and of no cell, and marks of VTK's own.
        if (element == "DataArray" && !inFieldData_) addArray(fields(element, attributes));
        if (element == "AppendedData") {
            document_.appended = fields(element, attributes);
            document_.appendedAt = contentAt();
            finish();
        }
    }

    void end(std::string_view element) {
        if (element == "FieldData") inFieldData_ = false;
    }

    void addArray(HeaderFields attributes) {
        auto& arrays = document_.arrays;
        if (arrays.size() == mostArrays) {
            return fail(ErrorCode::corrupt, fmt::format("has more than {} arrays", mostArrays));
        }
        const bool active = !active_.empty() && attributes.text("Name") == active_;
        arrays.push_back({std::move(attributes), inCells_, active, contentAt()});
        if (arrays.back().isSurely(field_) && arrays.back().attributes.text("format") != "appended") finish();
    }

    ByteStream& file_;
    std::string_view field_;
    VtiDocument& document_;
    std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_{XML_ParserCreate(nullptr),
                                                                         &XML_ParserFree};
    std::optional<Error> error_;
    bool done_ = false;
    bool inCells_ = false, inFieldData_ = false;
    std::string active_;  ///< the Scalars of the element whose arrays follow
    std::uint64_t fed_ = 0;
};

Result<VtiDocument> VtiDocument::parse(ByteStream& file, std::string_view field, const Progress& progress) {
    const HeaderFields none(file.name());
    VtiDocument document{none, none, none, none, {}, 0};
    MOTE_RETURN_IF_ERROR(Parser(file, field, document).parse(progress));
    return document;
}

const VtiArray* VtiDocument::chosen(std::string_view field) const {
    const VtiArray* best = nullptr;
    for (const VtiArray& array : arrays) {
        if (array.isSurely(field)) return &array;
        const bool better = best == nullptr || (best->ofCells && !array.ofCells);
        if (field.empty() && array.isScalar() && !array.isMark() && better) best = &array;
    }
    return best;
}

constexpr std::array<ScalarTypeName, 10> vtiTypes{{{"Int64", ScalarType::i64},
                                                   {"UInt64", ScalarType::u64},
                                                   {"Int8", ScalarType::i8},
                                                   {"UInt8", ScalarType::u8},
                                                   {"Int16", ScalarType::i16},
                                                   {"UInt16", ScalarType::u16},
                                                   {"Int32", ScalarType::i32},
                                                   {"UInt32", ScalarType::u32},
                                                   {"Float32", ScalarType::f32},
                                                   {"Float64", ScalarType::f64}}};

constexpr std::uint64_t mostComponents = 64;
constexpr std::size_t mostListed = 300;  // letters
constexpr std::string_view magnitudeName = "magnitude";

/// "velocity:1": an array, and which of its values.
struct ArrayField {
    std::string_view name, component;
};

ArrayField partsOf(std::string_view field) {
    const auto colon = field.rfind(':');
    if (colon == std::string_view::npos) return {field, ""};
    const auto component = field.substr(colon + 1);
    const bool known = component == magnitudeName || parseId(component).has_value();
    return known ? ArrayField{field.substr(0, colon), component} : ArrayField{field, ""};
}

/// The arrays that may be asked for.
std::string listOf(const VtiDocument& document) {
    std::string list;
    for (const VtiArray& array : document.arrays) {
        if (array.isMark() || list.size() > mostListed) continue;
        list += fmt::format("{}{:.40}", list.empty() ? "" : ", ", array.attributes.text("Name"));
        const auto count = array.attributes.text("NumberOfComponents");
        if (!array.isScalar()) list += fmt::format(" ({:.4} values)", count);
    }
    return list.empty() ? "; it holds none" : "; it holds " + list;
}

class VtiReader {
  public:
    /// `component`: of several values; "": of one.
    VtiReader(const VtiDocument& document, const VtiArray& array, std::string_view component,
              VtiHeader& header)
        : document_(document), array_(array), component_(component), header_(header) {}

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
        MOTE_ASSIGN_OR_RETURN(const auto extent, piece.numbers("Extent", 6));
        MOTE_ASSIGN_OR_RETURN(const auto whole, document_.imageData.numbers("WholeExtent", 6));
        if (extent != whole) return piece.unsupported("Extent", "is only a part of WholeExtent");
        std::array<std::uint64_t, 3> sizes;
        glm::dvec3 first;
        for (std::size_t i = 0; i < 3; ++i) {
            const double from = extent[2 * i], steps = extent[2 * i + 1] - from;
            if (!(std::abs(from) < 0x1p31 && steps >= 0 && steps < 0x1p31 && steps == std::floor(steps))) {
                return piece.corrupt("Extent", fmt::format("says {} to {}", from, extent[2 * i + 1]));
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
            MOTE_ASSIGN_OR_RETURN(const auto rows, image.numbers("Direction", 9));
            for (int i = 0; i < 9; ++i) steps[i % 3][i / 3] = rows[static_cast<std::size_t>(i)];
        }
        glm::dvec3 origin(0.0);
        if (image.has("Origin")) {
            MOTE_ASSIGN_OR_RETURN(const auto said, image.numbers("Origin", 3));
            origin = {said[0], said[1], said[2]};
        }
        if (image.has("Spacing")) {
            MOTE_ASSIGN_OR_RETURN(const auto said, image.numbers("Spacing", 3));
            for (int i = 0; i < 3; ++i) steps[i] *= said[static_cast<std::size_t>(i)];
        }
        return setPlacement(header_.shape, steps, origin + steps * first,
                            image.where("Spacing and Direction"));
    }

    Status readArray() {
        const HeaderFields& array = array_.attributes;
        MOTE_RETURN_IF_ERROR(chooseComponent());
        MOTE_ASSIGN_OR_RETURN(const auto type, array.type("type", vtiTypes));
        header_.shape.type = type;
        const auto format = array.text("format");
        if (format == "appended") return readAppended();
        if (format != "ascii" && format != "binary" && !format.empty()) {
            return array.corrupt("format", "is none of ascii, binary and appended");
        }
        header_.encoding = format == "binary" ? VtiHeader::Encoding::base64 : VtiHeader::Encoding::ascii;
        header_.dataAt = array_.contentAt;
        return success();
    }

    Status chooseComponent() {
        const HeaderFields& array = array_.attributes;
        MOTE_ASSIGN_OR_RETURN(header_.parts.components, array.wholeNumber("NumberOfComponents", 1));
        const auto count = header_.parts.components;
        if (count < 1 || count > mostComponents) {
            return array.unsupported("NumberOfComponents",
                                     fmt::format("is {}; 1 to {} are read", count, mostComponents));
        }
        header_.magnitude = component_ == magnitudeName;
        if (header_.magnitude || (component_.empty() && count == 1)) return success();
        const auto number = parseId(component_);
        if (number && *number < count) {
            header_.parts.component = *number;
            return success();
        }
        const auto name = array.text("Name");
        return array.unsupported("NumberOfComponents",
                                 fmt::format("is {}: ask for one as the field, {:.40}:0 to {:.40}:{}, or for "
                                             "the length of the vector, {:.40}:{}",
                                             count, name, name, count - 1, name, magnitudeName));
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
        MOTE_ASSIGN_OR_RETURN(const auto offset, array_.attributes.wholeNumber("offset", 0));
        header_.dataAt = document_.appendedAt + offset;
        return success();
    }

    const VtiDocument& document_;
    const VtiArray& array_;
    std::string_view component_;
    VtiHeader& header_;
};

/// Appended data begin behind an underscore.
Result<std::uint64_t> behindUnderscore(ByteStream& file, std::uint64_t at) {
    MOTE_RETURN_IF_ERROR(file.seek(at));
    std::string blanks(256, '\0');
    MOTE_ASSIGN_OR_RETURN(const auto got, file.read(blanks));
    blanks.resize(got);
    const std::size_t mark = blanks.find_first_not_of(" \t\r\n");
    if (mark == std::string::npos || blanks[mark] != '_') {
        return corrupt(file.name() + ": AppendedData", "does not begin with _");
    }
    return at + mark + 1;
}

constexpr std::uint64_t mostBlocks = 1u << 24;  // 512 GiB in the blocks of 32 KiB that VTK writes

/// The sizes that stand before binary values.
class Sizes {
  public:
    Sizes(ByteStream& stream, const VtiHeader& header)
        : stream_(stream), big_(header.bigEndian), width_(header.wideSizes ? 8 : 4) {}

    /// The next `count` of them. Errors: corrupt (the data end before).
    Result<std::vector<std::uint64_t>> next(std::uint64_t count) {
        std::vector<std::uint64_t> sizes;
        std::string bytes;
        // Piece by piece: memory is taken for those that are there, not for those that are declared.
        while (sizes.size() < count) {
            bytes.resize(static_cast<std::size_t>(std::min(count - sizes.size(), piece)) * width_);
            MOTE_ASSIGN_OR_RETURN(const auto got, stream_.read(bytes));
            if (got < bytes.size()) {
                return corrupt(stream_.name(), "ends within its array's sizes");
            }
            bytes_ += bytes.size();
            for (std::size_t at = 0; at < bytes.size(); at += width_) {
                sizes.push_back(width_ == 8 ? loadNumber<std::uint64_t>(&bytes[at], big_)
                                            : loadNumber<std::uint32_t>(&bytes[at], big_));
            }
        }
        return sizes;
    }

    std::uint64_t bytes() const { return bytes_; }  ///< read so far

  private:
    static constexpr std::uint64_t piece = 1u << 14;

    ByteStream& stream_;
    bool big_;
    std::size_t width_;
    std::uint64_t bytes_ = 0;
};

Error contradiction(const ByteStream& stream, std::uint64_t said, std::uint64_t needed) {
    return corrupt(stream.name(),
                   fmt::format("its array says {} bytes, and its extent needs {}", said, needed));
}

/// Reads one size, then the values.
Result<ByteStreamPtr> plainValues(ByteStreamPtr stream, const VtiHeader& header, std::uint64_t needed) {
    Sizes sizes(*stream, header);
    MOTE_ASSIGN_OR_RETURN(const auto said, sizes.next(1));
    if (said.front() != needed) return contradiction(*stream, said.front(), needed);
    return partStream(std::move(stream), sizes.bytes(), needed);
}

/// How many blocks, their bytes, those of the last one where it is shorter (else 0), the compressed bytes of
/// each; then the blocks.
Result<ByteStreamPtr> compressedValues(ByteStreamPtr stream, const VtiHeader& header, std::uint64_t needed) {
    Sizes sizes(*stream, header);
    MOTE_ASSIGN_OR_RETURN(const auto counts, sizes.next(3));
    const std::uint64_t count = counts[0], full = counts[1], last = counts[2];
    const bool whole = full > 0 && last == needed % full;
    if (!whole || count != needed / full + (last > 0 ? 1 : 0) || count > mostBlocks) {
        return corrupt(
            stream->name(),
            fmt::format(
                "its array says {} blocks of {} bytes, the last one of {}, and its extent needs {} bytes",
                count, full, last, needed));
    }
    MOTE_ASSIGN_OR_RETURN(auto compressed, sizes.next(count));
    MOTE_ASSIGN_OR_RETURN(auto data, partStream(std::move(stream), sizes.bytes()));
    return zlibBlockStream(std::move(data), {full, needed, std::move(compressed)});
}

Result<ByteStreamPtr> values(ByteStreamPtr file, const VtiHeader& header, std::uint64_t needed) {
    auto stream = partStream(std::move(file), header.dataAt);
    if (!stream) return stream.error();
    if (header.encoding == VtiHeader::Encoding::ascii) return numberStream(std::move(stream).value());
    if (header.encoding == VtiHeader::Encoding::base64) stream = base64Stream(std::move(stream).value());
    return header.compressed ? compressedValues(std::move(stream).value(), header, needed)
                             : plainValues(std::move(stream).value(), header, needed);
}

/// Opens one of the values of each point, or the only one.
Result<std::unique_ptr<VolumeSource>> openComponent(ByteStreamPtr file, VtiHeader header) {
    const bool ascii = header.encoding == VtiHeader::Encoding::ascii;
    SampleFormat samples;
    samples.type = ascii ? ScalarType::f64 : header.shape.type;
    samples.bigEndian = header.bigEndian && !ascii;
    const std::uint64_t needed = header.shape.voxels() * header.parts.components * bytesOf(samples.type);
    MOTE_ASSIGN_OR_RETURN(auto data, values(std::move(file), header, needed));
    return StreamVolume::make("vti", std::move(header.shape), samples, std::move(data),
                              StreamVolume::Ending::exact, header.parts);
}

/// Adds what of an array may be asked for.
void addFields(const VtiArray& array, std::vector<VolumeField>& fields) {
    const std::string name(array.attributes.text("Name")), type(array.attributes.text("type"));
    const auto known = [&](const VolumeField& field) {
        return field.name == name || field.name.starts_with(name + ":");
    };
    if (array.isMark() || name.empty() || std::any_of(fields.begin(), fields.end(), known)) return;
    if (array.isScalar()) return fields.push_back({name, 1, type});
    const auto count = array.attributes.wholeNumber("NumberOfComponents", 1);
    if (!count || *count > mostComponents) return;
    for (std::uint64_t i = 0; i < *count; ++i)
        fields.push_back({fmt::format("{}:{}", name, i), *count, type});
    fields.push_back({fmt::format("{}:{}", name, magnitudeName), *count, type});
}

Result<VtiHeader> VtiHeader::parse(ByteStream& file, std::string_view field, const Progress& progress) {
    // An array may have any name, "a:1" among them.
    ArrayField wanted{field, ""};
    MOTE_ASSIGN_OR_RETURN(auto document, VtiDocument::parse(file, wanted.name, progress));
    if (document.chosen(field) == nullptr && !partsOf(field).component.empty()) {
        wanted = partsOf(field);
        MOTE_ASSIGN_OR_RETURN(document, VtiDocument::parse(file, wanted.name, progress));
    }
    const VtiArray* const array = document.chosen(wanted.name);
    if (array == nullptr) {
        return notFound(file.name(),
                        (field.empty() ? "has no array with one value for each point or cell"
                                       : fmt::format("has no array of the name \"{:.40}\"", field)) +
                            listOf(document));
    }
    if (document.appendedAt > 0) {
        MOTE_ASSIGN_OR_RETURN(const auto at, behindUnderscore(file, document.appendedAt));
        document.appendedAt = at;
    }
    VtiHeader header;
    MOTE_RETURN_IF_ERROR(VtiReader(document, *array, wanted.component, header).read());
    return header;
}

}  // namespace

bool beginsAsVti(std::string_view bytes) {
    return bytes.find("<VTKFile") != std::string_view::npos;
}

Result<std::vector<VolumeField>> vtiFields(const std::filesystem::path& path, const Progress& progress) {
    constexpr std::string_view none = "\x01";  // no name of XML: all of the document is read
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(const auto document, VtiDocument::parse(*file, none, progress));
    std::vector<VolumeField> fields;
    if (const auto* const first = document.chosen(""); first != nullptr) addFields(*first, fields);
    for (const VtiArray& array : document.arrays) addFields(array, fields);
    return fields;
}

Result<std::unique_ptr<VolumeSource>> openVti(const std::filesystem::path& path, std::string_view field,
                                              const Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto file, fileStream(path));
    MOTE_ASSIGN_OR_RETURN(auto header, VtiHeader::parse(*file, field, progress));
    if (!header.magnitude) return openComponent(std::move(file), std::move(header));
    std::vector<std::unique_ptr<VolumeSource>> components;
    for (std::uint64_t i = 0; i < header.parts.components; ++i) {
        MOTE_ASSIGN_OR_RETURN(auto again, fileStream(path));
        auto one = header;
        one.parts.component = i;
        MOTE_ASSIGN_OR_RETURN(auto component, openComponent(std::move(again), std::move(one)));
        components.push_back(std::move(component));
    }
    return std::unique_ptr<VolumeSource>(std::make_unique<MagnitudeVolume>(std::move(components)));
}

}  // namespace mote::prep
