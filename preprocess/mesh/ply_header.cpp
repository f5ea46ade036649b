// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/ply_header.h"

#include <fmt/format.h>

#include <array>

#include "preprocess/mesh/mesh_text.h"

namespace mote::prep {
namespace {

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

}  // namespace

Result<PlyHeader> readPlyHeader(std::string_view bytes, const std::string& name) {
    return HeaderReader(bytes, name).read();
}

}  // namespace mote::prep
