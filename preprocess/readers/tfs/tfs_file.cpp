// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/tfs/tfs_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>

#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::string_view tracks[] = {"NUMBER", "TURN", "X", "PX", "Y", "PY", "T", "PT", "S", "E"};
constexpr std::size_t tfsMaxFields = 1024;
constexpr std::size_t maxSays = 4096;

using TfsFields = std::array<std::string_view, tfsMaxFields>;

std::string upper(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return result;
}

class TfsParser {
  public:
    TfsParser(TfsFile& file, HeldNumbers& held) : file_(file), held_(held) {}

    Status line(std::string_view text, const std::string& where) {
        text = trim(text);
        if (text.empty()) return success();
        switch (text.front()) {
            case '@':
                return say(text.substr(1));
            case '*':
                return takeNames(text.substr(1), where);
            case '$':
                return success();
            case '#':
                if (text.starts_with("#segment") && !file_.values.empty())
                    file_.segments.push_back(file_.values.front().size());
                return success();
            default:
                return row(text, where);
        }
    }

  private:
    /// "NAME %05s value": the value is the rest, without quotes.
    Status say(std::string_view text) {
        text = trim(text);
        const std::size_t name = std::min(text.find_first_of(" \t"), text.size());
        std::string_view rest = trim(text.substr(name));
        if (rest.starts_with('%')) rest = trim(rest.substr(std::min(rest.find_first_of(" \t"), rest.size())));
        if (rest.size() >= 2 && rest.front() == '"' && rest.back() == '"')
            rest = rest.substr(1, rest.size() - 2);
        if (file_.says.size() < maxSays) file_.says[upper(text.substr(0, name))] = std::string(rest);
        return success();
    }

    Status takeNames(std::string_view text, const std::string& where) {
        const std::size_t count = splitFields(text, ' ', fields_);
        if (count > tfsMaxFields) return unsupported(where, "names more than 1024 columns");
        if (!file_.names.empty()) return corrupt(where, "names the columns a second time");
        columns_ = count;
        for (std::size_t i = 0; i < count; ++i) {
            std::string name = upper(fields_[i]);
            const bool kept = std::find(std::begin(tracks), std::end(tracks), name) != std::end(tracks);
            const bool twice = std::find(file_.names.begin(), file_.names.end(), name) != file_.names.end();
            if (!kept || twice) continue;
            used_.push_back(i);
            file_.names.push_back(std::move(name));
        }
        file_.values.resize(used_.size());
        return success();
    }

    Status row(std::string_view text, const std::string& where) {
        if (file_.names.empty()) return corrupt(where, "is a row before the line of names");
        const std::size_t count = splitFields(text, ' ', fields_);
        if (count < columns_) {
            return corrupt(where, "has " + std::to_string(count) + " fields where " +
                                      std::to_string(columns_) + " are named");
        }
        MOTE_RETURN_IF_ERROR(held_.add(used_.size(), where));
        for (std::size_t i = 0; i < used_.size(); ++i) {
            const auto value = parseNumber(fields_[used_[i]]);
            if (!value) return noNumber(fields_[used_[i]], where, file_.names[i]);
            file_.values[i].push_back(*value);
        }
        return success();
    }

    TfsFile& file_;
    HeldNumbers& held_;
    TfsFields fields_;
    std::size_t columns_ = 0;
    std::vector<std::size_t> used_;
};

}  // namespace

const std::vector<double>* TfsFile::find(std::string_view wanted) const {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == wanted) return &values[i];
    }
    return nullptr;
}

std::optional<double> TfsFile::number(const std::string& wanted) const {
    const auto found = says.find(wanted);
    return found == says.end() ? std::nullopt : parseNumber(found->second);
}

Result<TfsFile> TfsFile::read(const HeldFile& held) {
    TfsFile file;
    file.name = held.name();
    TfsParser parser(file, held.held);
    MOTE_RETURN_IF_ERROR(parseLines(held, parser));
    return file;
}

}  // namespace mote::prep
