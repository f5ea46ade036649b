// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/npy_header.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr int maxDepth = 8;
constexpr int maxItems = 4096;

class Parser {
  public:
    explicit Parser(std::string_view source) : rest_(source) {}

    std::optional<PythonLiteral> all() {
        auto value = one(0);
        skipBlanks();
        return rest_.empty() ? value : std::nullopt;
    }

  private:
    using Kind = PythonLiteral::Kind;

    void skipBlanks() {
        while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front())))
            rest_.remove_prefix(1);
    }
    bool take(std::string_view token) {
        skipBlanks();
        if (!rest_.starts_with(token)) return false;
        rest_.remove_prefix(token.size());
        return true;
    }

    std::optional<PythonLiteral> one(int depth) {
        skipBlanks();
        if (depth > maxDepth || ++items_ > maxItems || rest_.empty()) return std::nullopt;
        PythonLiteral value;
        if (take("None")) return value;
        if (rest_.starts_with("True") || rest_.starts_with("False")) {
            value.kind = Kind::boolean;
            value.boolean = take("True");
            if (!value.boolean) take("False");
            return value;
        }
        const char first = rest_.front();
        if (first == '\'' || first == '"') return quoted();
        if (first == '(' || first == '[' || first == '{') return group(depth);
        return number();
    }

    std::optional<PythonLiteral> quoted() {
        const char quote = rest_.front();
        const std::size_t end = rest_.find(quote, 1);
        if (end == std::string_view::npos || rest_.substr(0, end).find('\\') != std::string_view::npos) {
            return std::nullopt;
        }
        PythonLiteral value;
        value.kind = Kind::text;
        value.text = rest_.substr(1, end - 1);
        rest_.remove_prefix(end + 1);
        return value;
    }

    std::optional<PythonLiteral> number() {
        PythonLiteral value;
        value.kind = Kind::integer;
        const auto [end, code] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value.integer);
        if (code != std::errc()) return std::nullopt;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        take("L");  // Python 2 wrote long integers so
        return value;
    }

    std::optional<PythonLiteral> group(int depth) {
        const char open = rest_.front();
        rest_.remove_prefix(1);
        const std::string_view close = open == '(' ? ")" : open == '[' ? "]" : "}";
        PythonLiteral value;
        value.kind = open == '{' ? Kind::dict : Kind::sequence;
        while (!take(close)) {
            auto item = one(depth + 1);
            if (!item) return std::nullopt;
            value.items.push_back(std::move(*item));
            if (open == '{') {
                if (!take(":")) return std::nullopt;
                auto held = one(depth + 1);
                if (!held) return std::nullopt;
                value.items.push_back(std::move(*held));
            }
            if (take(",")) continue;
            if (take(close)) break;
            return std::nullopt;
        }
        return value;
    }

    std::string_view rest_;
    int items_ = 0;
};

using Kind = PythonLiteral::Kind;

constexpr std::size_t npyMaxFields = 256;
constexpr std::size_t maxItemBytes = 4096;

/// "<f8", ">i4", "|u1"; '=' is the machine's own order, which is little.
Result<NpyField> parseType(const std::string& type, const std::string& where) {
    NpyField field;
    std::string_view rest = type;
    if (!rest.empty() && std::string_view("<>|=").find(rest.front()) != std::string_view::npos) {
        field.bigEndian = rest.front() == '>';
        rest.remove_prefix(1);
    }
    static constexpr std::string_view known[] = {"f2", "f4", "f8", "i1", "i2", "i4", "i8",
                                                 "u1", "u2", "u4", "u8", "b1", "?"};
    if (std::find(std::begin(known), std::end(known), rest) != std::end(known)) {
        field.kind = rest[0] == 'b' || rest[0] == '?' ? 'u' : rest[0];
        field.bytes = rest == "?" ? 1 : static_cast<std::size_t>(rest[1] - '0');
        return field;
    }
    // Texts, complex numbers, times: a field of such a type can be stepped over.
    std::uint64_t size = 0;
    const std::string_view letters = "SUVcfMma";
    const bool sized = rest.size() > 1 && letters.find(rest[0]) != std::string_view::npos &&
                       std::from_chars(rest.data() + 1, rest.data() + rest.size(), size).ec == std::errc();
    if (!sized || size > maxItemBytes) {
        return unsupported(where,
                           "has elements of type '" + type.substr(0, 40) + "'; integers, f4 and f8 are read");
    }
    field.kind = NpyField::other;
    field.bytes = static_cast<std::size_t>(rest[0] == 'U' ? 4 * size : size);
    return field;
}

/// The name of a field; of a pair (title, name) the title where it is the name with a unit, "x [mm]".
const PythonLiteral* nameOf(const PythonLiteral& entry) {
    if (entry.kind != Kind::sequence || entry.items.size() != 2) return &entry;
    const PythonLiteral &title = entry.items[0], &name = entry.items[1];
    const bool unit = title.kind == Kind::text && name.kind == Kind::text && !name.text.empty() &&
                      title.text.starts_with(name.text + " [");
    return unit ? &title : &name;
}

/// ('x', '<f8') or ('x', '<f8', (3,)); the name may be a pair (title, name).
Result<NpyField> parseField(const PythonLiteral& entry, const std::string& where) {
    if (entry.kind != Kind::sequence || entry.items.size() < 2 || entry.items.size() > 3) {
        return corrupt(where, "has a type with a field that is no pair of name and type");
    }
    const PythonLiteral* name = nameOf(entry.items[0]);
    if (name->kind != Kind::text) return corrupt(where, "has a type with a field without a name");
    if (entry.items[1].kind == Kind::sequence) {
        return unsupported(where, "has fields within the field '" + name->text + "'");
    }
    if (entry.items[1].kind != Kind::text) return corrupt(where, "has a type with a field without a type");
    auto field = parseType(entry.items[1].text, where);
    if (!field) return field.error();
    field->name = name->text;
    if (entry.items.size() == 3) {
        const PythonLiteral& shape = entry.items[2];
        std::uint64_t count = shape.kind == Kind::integer ? shape.integer : 1;
        for (const PythonLiteral& length : shape.items) {
            count = length.integer != 0 && count > maxItemBytes / length.integer ? maxItemBytes + 1
                                                                                 : count * length.integer;
        }
        if (count > maxItemBytes) return corrupt(where, "has a field with too many numbers");
        field->count = static_cast<std::size_t>(count);
    }
    return field;
}

Status parseDescription(const PythonLiteral& description, NpyHeader& header, const std::string& where) {
    if (description.kind == Kind::text) {
        MOTE_ASSIGN_OR_RETURN(auto field, parseType(description.text, where));
        header.fields.push_back(std::move(field));
    } else if (description.kind == Kind::sequence && !description.items.empty() &&
               description.items.size() <= npyMaxFields) {
        for (const PythonLiteral& entry : description.items) {
            MOTE_ASSIGN_OR_RETURN(auto field, parseField(entry, where));
            header.fields.push_back(std::move(field));
        }
    } else {
        return corrupt(where, "has no valid type of elements");
    }
    for (NpyField& field : header.fields) {
        field.offset = header.itemBytes;
        header.itemBytes += field.bytes * field.count;
        if (header.itemBytes > maxItemBytes) return corrupt(where, "has elements of more than 4096 bytes");
    }
    return success();
}

}  // namespace

const PythonLiteral* PythonLiteral::find(std::string_view key) const {
    for (std::size_t i = 0; kind == Kind::dict && i + 1 < items.size(); i += 2) {
        if (items[i].kind == Kind::text && items[i].text == key) return &items[i + 1];
    }
    return nullptr;
}

std::optional<PythonLiteral> PythonLiteral::parse(std::string_view source) {
    return Parser(source).all();
}

std::size_t NpyHeader::bytesNeeded(std::span<const char> begin) {
    if (begin.size() < 12) return begin.size();
    const bool wide = begin[6] != 1;
    const std::uint64_t length = wide ? loadNumber<std::uint32_t>(begin.data() + 8, false)
                                      : loadNumber<std::uint16_t>(begin.data() + 8, false);
    return static_cast<std::size_t>(std::min<std::uint64_t>(length + (wide ? 12 : 10), maxBytes));
}

Result<NpyHeader> NpyHeader::parse(std::span<const char> bytes, const std::string& where) {
    const auto byte = [&](std::size_t i) {
        return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i]));
    };
    if (bytes.size() < 10 || std::string_view(bytes.data(), 6) != "\x93NUMPY") {
        return corrupt(where, "is no .npy file");
    }
    const std::uint64_t major = byte(6);
    if (major < 1 || major > 3) {
        return unsupported(where, "is of .npy version " + std::to_string(major));
    }
    const std::size_t begin = major == 1 ? 10 : 12;
    if (bytes.size() < begin) return corrupt(where, "is cut short");
    std::uint64_t length = byte(8) | byte(9) << 8;
    if (major > 1) length |= byte(10) << 16 | byte(11) << 24;
    if (length > maxBytes - 12 || length > bytes.size() - begin)
        return corrupt(where, "has a header that is cut short");
    const auto literal = PythonLiteral::parse({bytes.data() + begin, static_cast<std::size_t>(length)});
    if (!literal || literal->kind != Kind::dict) return corrupt(where, "has a header that cannot be read");
    const PythonLiteral* description = literal->find("descr");
    const PythonLiteral* order = literal->find("fortran_order");
    const PythonLiteral* shape = literal->find("shape");
    if (description == nullptr || order == nullptr || order->kind != Kind::boolean || shape == nullptr ||
        shape->kind != Kind::sequence) {
        return corrupt(where, "has a header without descr, fortran_order or shape");
    }
    NpyHeader header;
    header.fortranOrder = order->boolean;
    header.dataOffset = begin + length;
    for (const PythonLiteral& extent : shape->items) {
        if (extent.kind != Kind::integer) return corrupt(where, "has a shape that is no list of numbers");
        header.shape.push_back(extent.integer);
    }
    MOTE_RETURN_IF_ERROR(parseDescription(*description, header, where));
    return header;
}

}  // namespace mote::prep
