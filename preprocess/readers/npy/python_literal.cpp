// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/python_literal.h"

#include <cctype>
#include <charconv>

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

}  // namespace mote::prep
