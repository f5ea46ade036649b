// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/json/json_numbers.h"

#include <cctype>
#include <charconv>
#include <limits>
#include <utility>

#include "preprocess/readers/table/held_source.h"

namespace mote::prep {
namespace {

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

}  // namespace

Result<std::vector<JsonNumbers>> JsonNumbers::parse(std::string_view text, const std::string& name) {
    return Parser(text, name).run();
}

}  // namespace mote::prep
