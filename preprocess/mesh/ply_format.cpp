// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/mesh/mesh_formats.h"
#include "preprocess/mesh/mesh_text.h"
#include "preprocess/readers/text/stored_number.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

// PlyValues: the numbers behind the header of a PLY file, one after the other, whatever their encoding. A
// view of the file's bytes, which must outlive it; one thread.
//
// The header of a PLY file: its elements and their properties, in the file's order. A value and the function
// that reads it.

enum class PlyEncoding { ascii, littleEndian, bigEndian };

struct PlyProperty {
    std::string name;
    StoredNumber type = StoredNumber::float32;  ///< of the value, or of each in the list
    std::optional<StoredNumber> countType;      ///< of a list; an integer
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;  ///< no more than the bytes behind the header, where it has a property
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<PlyElement> elements;
    std::size_t bytes = 0;    ///< of the header: where the values begin
    std::uint64_t lines = 0;  ///< of the header
};

constexpr std::size_t mostElements = 64;
constexpr std::size_t mostProperties = 256;

struct TypeName {
    std::string_view name;
    StoredNumber type;
};
constexpr std::array<TypeName, 16> typeNames{{{"char", StoredNumber::int8},
                                              {"int8", StoredNumber::int8},
                                              {"uchar", StoredNumber::uint8},
                                              {"uint8", StoredNumber::uint8},
                                              {"short", StoredNumber::int16},
                                              {"int16", StoredNumber::int16},
                                              {"ushort", StoredNumber::uint16},
                                              {"uint16", StoredNumber::uint16},
                                              {"int", StoredNumber::int32},
                                              {"int32", StoredNumber::int32},
                                              {"uint", StoredNumber::uint32},
                                              {"uint32", StoredNumber::uint32},
                                              {"float", StoredNumber::float32},
                                              {"float32", StoredNumber::float32},
                                              {"double", StoredNumber::float64},
                                              {"float64", StoredNumber::float64}}};

std::optional<StoredNumber> typeOf(std::string_view word) {
    for (const auto& [name, type] : typeNames) {
        if (name == word) return type;
    }
    return std::nullopt;
}

class HeaderReader {
  public:
    HeaderReader(std::string_view bytes, const std::string& name)
        : text_(bytes, name), name_(name), size_(bytes.size()) {}

    Result<PlyHeader> read() {
        if (!text_.nextLine() || text_.word() != "ply") return text_.error("does not begin with \"ply\"");
        bool encoded = false;
        while (text_.nextLine()) {
            const auto key = text_.word();
            Status done = success();
            if (key == "end_header") return finish(encoded);
            if (key == "format") {
                done = readEncoding();
                encoded = true;
            } else if (key == "element") {
                done = addElement();
            } else if (key == "property") {
                done = addProperty();
            } else if (key != "comment" && key != "obj_info") {
                done = text_.error(fmt::format("\"{}\" belongs in no header", key.substr(0, 40)));
            }
            if (!done.ok()) return done.error();
        }
        return text_.error("the header does not end");
    }

  private:
    Status readEncoding() {
        const auto word = text_.word();
        if (word == "ascii") {
            header_.encoding = PlyEncoding::ascii;
        } else if (word == "binary_little_endian") {
            header_.encoding = PlyEncoding::littleEndian;
        } else if (word == "binary_big_endian") {
            header_.encoding = PlyEncoding::bigEndian;
        } else {
            return unsupported(name_,
                               fmt::format("is encoded as \"{}\", which is not read", word.substr(0, 40)));
        }
        return success();
    }

    Status addElement() {
        PlyElement element;
        element.name = text_.word();
        const auto count = MeshText::integer(text_.word());
        if (!count || *count < 0) return text_.error("an element needs its name and number");
        if (header_.elements.size() == mostElements) return text_.error("has too many elements");
        element.count = static_cast<std::uint64_t>(*count);
        header_.elements.push_back(std::move(element));
        return success();
    }

    Status addProperty() {
        if (header_.elements.empty()) return text_.error("a property stands before the first element");
        auto& properties = header_.elements.back().properties;
        if (properties.size() == mostProperties) return text_.error("has too many properties");
        PlyProperty property;
        auto word = text_.word();
        if (word == "list") {
            property.countType = typeOf(text_.word());
            if (!property.countType || isFraction(*property.countType)) {
                return text_.error("the length of a list must be a whole number");
            }
            word = text_.word();
        }
        const auto type = typeOf(word);
        if (!type) return text_.error(fmt::format("there is no type \"{}\"", word.substr(0, 40)));
        property.type = *type;
        property.name = text_.word();
        properties.push_back(std::move(property));
        return success();
    }

    Result<PlyHeader> finish(bool encoded) {
        if (!encoded) return text_.error("the header has no format");
        header_.bytes = text_.offset();
        header_.lines = text_.line();
        for (auto& element : header_.elements) {
            // Each value takes at least a byte, or a character and a blank.
            if (element.properties.empty()) element.count = 0;
            if (element.count > size_ - header_.bytes) {
                return text_.error(fmt::format("says {} of {}, and only {} bytes follow", element.count,
                                               element.name.substr(0, 40), size_ - header_.bytes));
            }
        }
        return std::move(header_);
    }

    MeshText text_;
    std::string name_;
    std::size_t size_;
    PlyHeader header_;
};

/// Errors: corrupt with the line, unsupported (an encoding that we do not know).
Result<PlyHeader> readPlyHeader(std::string_view bytes, const std::string& name) {
    return HeaderReader(bytes, name).read();
}

class PlyValues {
  public:
    PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& name)
        : bytes_(bytes), encoding_(header.encoding), at_(header.bytes), text_(bytes, name), name_(name) {
        for (std::uint64_t line = 0; text_.line() < header.lines && text_.nextLine(); ++line) {
        }
        if (encoding_ == PlyEncoding::ascii) text_.nextLine();
    }

    /// Exact for every type that there is. Errors: corrupt (the end of the file, no number).
    Result<double> next(StoredNumber type) {
        return encoding_ == PlyEncoding::ascii ? nextText() : nextBinary(type);
    }
    /// Whether `count` more values of a type may still come.
    bool mayHold(std::uint64_t count, StoredNumber type) const {
        const bool text = encoding_ == PlyEncoding::ascii;
        const std::size_t left =
            text ? bytes_.size() - text_.offset() + text_.restOfLine().size() : bytes_.size() - at_;
        return count <= left / (text ? 1 : bytesOf(type));
    }

    /// corrupt, at the line or byte that was reached.
    Error error(std::string message) const {
        if (encoding_ == PlyEncoding::ascii) return text_.error(std::move(message));
        return corrupt(fmt::format("{}: byte {}", name_, at_), std::move(message));
    }

  private:
    Result<double> nextText() {
        const auto word = text_.wordAcrossLines();
        if (word.empty()) return error("ends before the values that its header says");
        const auto value = MeshText::number(word);
        if (!value) return error(fmt::format("\"{}\" is no number", word.substr(0, 40)));
        return *value;
    }

    Result<double> nextBinary(StoredNumber type) {
        const auto size = bytesOf(type);
        if (bytes_.size() - at_ < size) return error("ends before the values that its header says");
        at_ += size;
        return loadStored<double>(bytes_.data() + at_ - size, type, encoding_ == PlyEncoding::bigEndian);
    }

    std::string_view bytes_;
    PlyEncoding encoding_;
    std::size_t at_;
    MeshText text_;
    std::string name_;
};

enum class Meaning { nothing, x, y, z, polygon, strips };

Meaning meaningOf(const PlyElement& element, const PlyProperty& property) {
    const bool indices = property.name == "vertex_indices" || property.name == "vertex_index";
    if (property.countType) {
        if (element.name == "face" && indices) return Meaning::polygon;
        return element.name == "tristrips" && indices ? Meaning::strips : Meaning::nothing;
    }
    if (element.name != "vertex") return Meaning::nothing;
    if (property.name == "x") return Meaning::x;
    if (property.name == "y") return Meaning::y;
    return property.name == "z" ? Meaning::z : Meaning::nothing;
}

class PlyParser {
  public:
    PlyParser(std::string_view bytes, PlyHeader header, const std::string& name)
        : header_(std::move(header)), values_(bytes, header_, name), name_(name) {}

    Result<TriangleMesh> parse() {
        MOTE_RETURN_IF_ERROR(checkMeanings());
        for (const auto& element : header_.elements) {
            for (std::uint64_t i = 0; i < element.count; ++i) MOTE_RETURN_IF_ERROR(read(element));
        }
        MOTE_RETURN_IF_ERROR(addWaiting());
        return toFloats(std::move(mesh_));
    }

  private:
    /// Vertices have a place. What names them may stand before them, and waits then until they are there.
    Status checkMeanings() {
        int axes = 0;
        bool indexed = false;
        for (const auto& element : header_.elements) {
            for (const auto& property : element.properties) {
                const auto meaning = meaningOf(element, property);
                if (meaning == Meaning::x || meaning == Meaning::y || meaning == Meaning::z) ++axes;
                const bool indices = meaning == Meaning::polygon || meaning == Meaning::strips;
                if (indices && isFraction(property.type)) {
                    return corrupt(name_, "its faces name vertices by fractions");
                }
                indexed = indexed || indices;
            }
            if (element.name != "vertex") continue;
            mesh_.positions.reserve(element.count);
            vertices_ = element.count;
        }
        if (axes != 3) return corrupt(name_, "its vertices have not one x, y and z each");
        if (indexed) return success();
        return unsupported(name_, "has no faces: a cloud of points is no mesh");
    }

    Status read(const PlyElement& element) {
        glm::dvec3 position(0.0);
        for (const auto& property : element.properties) {
            const auto meaning = meaningOf(element, property);
            if (property.countType) {
                MOTE_RETURN_IF_ERROR(readList(property, meaning));
                continue;
            }
            MOTE_ASSIGN_OR_RETURN(const auto value, values_.next(property.type));
            if (meaning == Meaning::x) position.x = value;
            if (meaning == Meaning::y) position.y = value;
            if (meaning == Meaning::z) position.z = value;
        }
        if (element.name == "vertex") mesh_.positions.push_back(position);
        return success();
    }

    Status readList(const PlyProperty& property, Meaning meaning) {
        MOTE_ASSIGN_OR_RETURN(const auto count, values_.next(*property.countType));
        if (!(count >= 0.0) || count != std::floor(count) || count > 4294967295.0 ||
            !values_.mayHold(static_cast<std::uint64_t>(count), property.type)) {
            return values_.error(fmt::format("a list of {} values does not fit the file", count));
        }
        corners_.clear();
        const auto length = static_cast<std::uint64_t>(count);
        for (std::uint64_t i = 0; i < length; ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto value, values_.next(property.type));
            if (meaning == Meaning::nothing) continue;
            if (meaning == Meaning::strips && value == -1.0) {
                addStrip();
                continue;
            }
            if (!(value >= 0.0) || value >= static_cast<double>(vertices_) || value != std::floor(value)) {
                return values_.error(fmt::format("a face names vertex {} of {}", value, vertices_));
            }
            corners_.push_back(static_cast<std::uint32_t>(value));
        }
        if (meaning == Meaning::polygon && mesh_.positions.size() < vertices_) {
            waiting_.insert(waiting_.end(), corners_.begin(), corners_.end());
            waitingCounts_.push_back(static_cast<std::uint32_t>(corners_.size()));
        } else if (meaning == Meaning::polygon) {
            addPolygon(mesh_, corners_);
        }
        if (meaning == Meaning::strips) addStrip();
        return success();
    }

    /// Polygons that stood before their vertices.
    Status addWaiting() {
        if (mesh_.positions.size() < vertices_) return values_.error("has fewer vertices than it says");
        std::span<const std::uint32_t> left(waiting_);
        for (const auto count : waitingCounts_) {
            addPolygon(mesh_, left.first(count));
            left = left.subspan(count);
        }
        return success();
    }

    /// Every other triangle of a strip turns the other way round.
    void addStrip() {
        for (std::size_t i = 2; i < corners_.size(); ++i) {
            const auto a = corners_[i - 2];
            const auto b = corners_[i - 1];
            if (i % 2 == 0) {
                mesh_.triangles.push_back({a, b, corners_[i]});
            } else {
                mesh_.triangles.push_back({b, a, corners_[i]});
            }
        }
        corners_.clear();
    }

    PlyHeader header_;
    PlyValues values_;
    std::string name_;
    ExactMesh mesh_;
    std::uint64_t vertices_ = 0;
    std::vector<std::uint32_t> corners_, waiting_, waitingCounts_;
};

}  // namespace

Result<TriangleMesh> parsePly(std::string_view bytes, const std::string& name) {
    MOTE_ASSIGN_OR_RETURN(auto header, readPlyHeader(bytes, name));
    return PlyParser(bytes, std::move(header), name).parse();
}

}  // namespace mote::prep
