// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/vti_document.h"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

namespace mote::prep {
namespace {

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
            static_cast<std::uint64_t>(std::max<XML_Index>(XML_GetCurrentByteIndex(parser_.get()), 0));
        if (status == XML_STATUS_OK && fed_ - std::min(at, fed_) <= longestTag) return success();
        const auto* const what = status == XML_STATUS_OK ? "a tag without an end"
                                                         : XML_ErrorString(XML_GetErrorCode(parser_.get()));
        return corrupt(fmt::format("{}: line {}", file_.name(), XML_GetCurrentLineNumber(parser_.get())),
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
        return static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser_.get())) +
               static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
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

}  // namespace

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

}  // namespace mote::prep
