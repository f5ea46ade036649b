// SPDX-License-Identifier: GPL-3.0-or-later
//
// JSON files of columns as runs: xsuite's particles, and others of named lists.
#include <cctype>
#include <charconv>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "preprocess/readers/table/held_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

/// The objects of a JSON text that hold lists of numbers, as Python's json writes them (NaN and
/// Infinity too). All else is checked and stepped over. A function without state.
/// One object: its members that are numbers or lists of numbers (also of lists, row by row).
struct JsonNumbers {
    std::map<std::string, std::vector<double>> lists;
    std::map<std::string, double> numbers;

    /// All objects of a text with a list in them, in the order in which they end. Errors, with `name` and the
    /// byte: corrupt (no JSON, nested deeper than 32), resourceExhausted (more than 2^27 numbers).
    static Result<std::vector<JsonNumbers>> parse(std::string_view text, const std::string& name);
};

constexpr int maxDepth = 32;
constexpr std::size_t maxKeyBytes = 1024;
constexpr std::size_t maxObjects = 100'000;

class Parser {
  public:
    Parser(std::string_view text, const std::string& name) : text_(text), name_(name) {}

    Result<std::vector<JsonNumbers>> run() {
        MOTE_RETURN_IF_ERROR(value(nullptr, "", 0));
        blanks();
        if (at_ != text_.size()) return wrong("goes on behind its end");
        return std::move(objects_);
    }

  private:
    Error wrong(const std::string& why) const {
        return {ErrorCode::corrupt, name_ + ": byte " + std::to_string(at_), "is no JSON: it " + why};
    }

    void blanks() {
        while (at_ < text_.size() &&
               (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
            ++at_;
    }

    bool take(std::string_view word) {
        if (!text_.substr(at_).starts_with(word)) return false;
        at_ += word.size();
        return true;
    }

    /// A value that is the member `key` of `owner`, or of nothing.
    Status value(JsonNumbers* owner, const std::string& key, int depth) {
        if (depth > maxDepth) return wrong("is nested deeper than 32");
        blanks();
        if (at_ == text_.size()) return wrong("ends too early");
        const char c = text_[at_];
        if (c == '{') return object(depth);
        if (c == '[') {
            std::vector<double> list;
            bool plain = true;
            MOTE_RETURN_IF_ERROR(array(list, plain, depth));
            if (owner != nullptr && plain) owner->lists[key] = std::move(list);
            return success();
        }
        if (c == '"') {
            MOTE_ASSIGN_OR_RETURN(const auto text, string());
            return success();
        }
        if (take("true") || take("false") || take("null")) return success();
        MOTE_ASSIGN_OR_RETURN(const auto found, number());
        if (owner != nullptr) owner->numbers[key] = found;
        return success();
    }

    Status object(int depth) {
        ++at_;
        JsonNumbers mine;
        for (bool first = true;; first = false) {
            blanks();
            if (take("}")) break;
            if (!first && !take(",")) return wrong("lacks a comma between members");
            blanks();
            if (at_ == text_.size() || text_[at_] != '"') return wrong("lacks a member's name");
            MOTE_ASSIGN_OR_RETURN(const auto key, string());
            blanks();
            if (!take(":")) return wrong("lacks a colon behind a name");
            MOTE_RETURN_IF_ERROR(value(&mine, key, depth + 1));
        }
        if (mine.lists.empty()) return success();
        if (objects_.size() >= maxObjects) return wrong("holds more than 100000 tables");
        objects_.push_back(std::move(mine));
        return success();
    }

    /// Numbers are kept; `plain` becomes false where there is anything else but lists of numbers.
    Status array(std::vector<double>& list, bool& plain, int depth) {
        if (depth > maxDepth) return wrong("is nested deeper than 32");
        ++at_;
        for (bool first = true;; first = false) {
            blanks();
            if (take("]")) return success();
            if (!first && !take(",")) return wrong("lacks a comma in a list");
            blanks();
            if (at_ == text_.size()) return wrong("ends within a list");
            const char c = text_[at_];
            if (c == '[') {
                MOTE_RETURN_IF_ERROR(array(list, plain, depth + 1));
            } else if (c == '{' || c == '"') {
                plain = false;
                MOTE_RETURN_IF_ERROR(value(nullptr, "", depth + 1));
            } else if (take("true") || take("false")) {
                list.push_back(text_[at_ - 2] == 'u' ? 1.0 : 0.0);
            } else if (take("null")) {
                list.push_back(std::numeric_limits<double>::quiet_NaN());
            } else {
                MOTE_ASSIGN_OR_RETURN(const auto found, number());
                list.push_back(found);
                MOTE_RETURN_IF_ERROR(held_.add(1, name_));
            }
        }
    }

    Result<double> number() {
        if (take("NaN")) return std::numeric_limits<double>::quiet_NaN();
        if (take("Infinity")) return std::numeric_limits<double>::infinity();
        if (take("-Infinity")) return -std::numeric_limits<double>::infinity();
        double found = 0.0;
        const char* begin = text_.data() + at_;
        const auto [end, code] = std::from_chars(begin, text_.data() + text_.size(), found);
        if (code == std::errc::invalid_argument || end == begin)
            return wrong("has neither value nor name here");
        at_ += static_cast<std::size_t>(end - begin);
        return found;
    }

    /// A text; escapes are kept as they stand, for no name that is known has any.
    Result<std::string> string() {
        const std::size_t begin = ++at_;
        for (; at_ < text_.size(); ++at_) {
            if (text_[at_] == '\\') {
                ++at_;
            } else if (text_[at_] == '"') {
                const std::string_view found = text_.substr(begin, at_ - begin);
                ++at_;
                return std::string(found.substr(0, maxKeyBytes));
            }
        }
        at_ = text_.size();
        return wrong("has a text without an end");
    }

    std::string_view text_;
    const std::string& name_;
    std::size_t at_ = 0;
    HeldNumbers held_;
    std::vector<JsonNumbers> objects_;
};

Result<std::vector<JsonNumbers>> JsonNumbers::parse(std::string_view text, const std::string& name) {
    return Parser(text, name).run();
}

bool isQuantity(const std::string& name) {
    const auto meaning = tableMeaning(name, "");
    return !meaning || meaning->has_value();
}

/// An object as a table; nothing where its lists are no columns of particles.
std::optional<HeldTable> tableOfJson(JsonNumbers object, const std::string& name) {
    HeldTable table;
    table.where = name;
    std::size_t places = 0;
    for (auto& [key, list] : object.lists) {
        if (!isQuantity(key)) continue;
        if (key == "x" || key == "y" || key == "z" || key == "zeta" || key == "px") ++places;
        table.add(key, std::move(list));
    }
    if (places < 2) return std::nullopt;
    for (auto& [key, list] : object.lists) {
        if (!isQuantity(key)) table.addUnknown(key, std::move(list));
    }
    for (const auto& [key, value] : object.numbers) {
        const auto meaning = tableMeaning(key, "");
        if (!meaning || !meaning->has_value()) continue;
        const TableMeaning& it = **meaning;
        // A single number beside lists says something of all rows: a mass, a momentum, a weight.
        if (it.relative || it.inMass || it.quantity == TableQuantity::id) continue;
        table.constants.push_back({it.quantity, value * it.factor});
    }
    return table;
}

Result<std::vector<HeldTable>> tablesOfJson(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(const auto text, file.text());
    MOTE_ASSIGN_OR_RETURN(auto objects, JsonNumbers::parse(text, file.name()));
    std::vector<HeldTable> tables;
    for (JsonNumbers& object : objects) {
        if (auto table = tableOfJson(std::move(object), file.name())) tables.push_back(std::move(*table));
    }
    if (!tables.empty()) return tables;
    return unsupported(
        file.name(),
        "is JSON without lists x, px, y, py, zeta, delta, ... (as xsuite's Particles.to_dict() writes)");
}

}  // namespace

extern const ParticleReader jsonReader;
constinit const ParticleReader jsonReader{
    "json", "JSON with lists of numbers", ParticleReader::Kind::text,
    [](const AskedFile& file) -> Result<bool> {
        return file.words().starts_with('{') || file.words().starts_with('[');
    },
    [](const AskedRun& run, Progress& progress) { return openHeld("json", tablesOfJson, run, progress); }};

}  // namespace mote::prep
