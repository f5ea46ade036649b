// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "protocol/scene/selection_parts.h"

namespace mote {
namespace {

constexpr int maxNamed = 64;

/// Reads one tree, and counts what it holds before it takes memory for it.
class Reader {
  public:
    explicit Reader(const NamedSelectionMessages& named) : named_(named) {}

    Result<Selection> read(const proto::Selection& message, int depth) {
        if (depth > Selection::maxDepth)
            return invalid(
                "", fmt::format("there are more than {} selections in each other", Selection::maxDepth));
        Selection selection;
        MOTE_RETURN_IF_ERROR(readRanges(message, selection));
        MOTE_RETURN_IF_ERROR(readParts(message, selection));
        MOTE_RETURN_IF_ERROR(readIds(message, selection));
        if (message.has_step()) selection.step = message.step();
        if (message.nothing()) {
            MOTE_RETURN_IF_ERROR(count(1, "nothing"));
            selection.nothing = true;
        }
        MOTE_RETURN_IF_ERROR(readList(message.all(), "all", depth, selection.all));
        MOTE_RETURN_IF_ERROR(readList(message.any(), "any", depth, selection.any));
        if (message.has_negated()) {
            auto negated = readInner(message.negated(), depth);
            MOTE_RETURN_IF_ERROR(negated, "not");
            selection.negated.push_back(*std::move(negated));
        }
        MOTE_RETURN_IF_ERROR(readNamed(message.named(), depth, selection));
        return selection;
    }

  private:
    Status count(std::size_t conditions, std::string_view field) {
        conditions_ += conditions;
        if (conditions_ <= std::size_t{Selection::maxConditions}) return success();
        return invalid(std::string(field),
                       fmt::format("a selection has at most {} conditions in all", Selection::maxConditions));
    }
    Status countValues(std::size_t values, std::string_view field) {
        values_ += values;
        if (values_ <= Selection::maxValues) return success();
        return invalid(std::string(field),
                       fmt::format("a selection has at most {} ids and points in all", Selection::maxValues));
    }

    Status readRanges(const proto::Selection& message, Selection& selection) {
        MOTE_RETURN_IF_ERROR(count(static_cast<std::size_t>(message.ranges_size()), "ranges"));
        for (int i = 0; i < message.ranges_size(); ++i) {
            auto range = parseRange(message.ranges(i));
            MOTE_RETURN_IF_ERROR(range, fmt::format("ranges[{}]", i));
            selection.ranges.push_back(*std::move(range));
        }
        return success();
    }

    template <class Message, class Value>
    Status readPart(bool there, const Message& message, Result<Value> (*parse)(const Message&),
                    std::string_view field, std::optional<Value>& value) {
        if (!there) return success();
        MOTE_RETURN_IF_ERROR(count(1, field));
        auto parsed = parse(message);
        MOTE_RETURN_IF_ERROR(parsed, field);
        value = *std::move(parsed);
        return success();
    }

    Status readParts(const proto::Selection& message, Selection& selection) {
        MOTE_RETURN_IF_ERROR(
            readPart(message.has_density(), message.density(), parseDensity, "density", selection.density));
        MOTE_RETURN_IF_ERROR(countValues(static_cast<std::size_t>(message.polygon().points_size()) +
                                             static_cast<std::size_t>(message.lasso().points_size()),
                                         message.has_polygon() ? "polygon.points" : "lasso.points"));
        MOTE_RETURN_IF_ERROR(
            readPart(message.has_polygon(), message.polygon(), parsePolygon, "polygon", selection.polygon));
        MOTE_RETURN_IF_ERROR(
            readPart(message.has_lasso(), message.lasso(), parseLasso, "lasso", selection.lasso));
        return readPart(message.has_outermost(), message.outermost(), parseOutermost, "outermost",
                        selection.outermost);
    }

    Status readIds(const proto::Selection& message, Selection& selection) {
        if (message.ids().empty()) return success();
        MOTE_RETURN_IF_ERROR(count(1, "ids"));
        MOTE_RETURN_IF_ERROR(countValues(static_cast<std::size_t>(message.ids_size()), "ids"));
        auto& ids = selection.ids;
        ids.assign(message.ids().begin(), message.ids().end());
        std::sort(ids.begin(), ids.end());
        ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
        return success();
    }

    Result<Selection> readInner(const proto::Selection& message, int depth) {
        MOTE_RETURN_IF_ERROR(count(1, ""));
        return read(message, depth + 1);
    }

    Status readList(const google::protobuf::RepeatedPtrField<proto::Selection>& messages,
                    std::string_view field, int depth, std::vector<Selection>& selections) {
        for (int i = 0; i < messages.size(); ++i) {
            auto selection = readInner(messages[i], depth);
            MOTE_RETURN_IF_ERROR(selection, fmt::format("{}[{}]", field, i));
            selections.push_back(*std::move(selection));
        }
        return success();
    }

    /// What a name stands for takes its place, or joins the other conditions.
    Status readNamed(const std::string& name, int depth, Selection& selection) {
        if (name.empty()) return success();
        const auto found =
            std::find_if(named_.begin(), named_.end(), [&](const auto& one) { return one.name() == name; });
        if (found == named_.end()) return invalid("named", notThere(name));
        if (std::find(open_.begin(), open_.end(), name) != open_.end())
            return invalid("named", fmt::format("the selection \"{}\" holds itself", name));
        open_.push_back(name);
        const bool alone = selection.everything();
        MOTE_RETURN_IF_ERROR(count(1, "named"));
        auto meant = read(found->selection(), alone ? depth : depth + 1);
        if (!meant.ok()) {
            const auto& error = meant.error();
            return invalid("named", error.where == "named"
                                        ? error.message
                                        : fmt::format("in \"{}\": {}", name, error.toString()));
        }
        open_.pop_back();
        if (alone)
            selection = *std::move(meant);
        else
            selection.all.push_back(*std::move(meant));
        return success();
    }

    std::string notThere(const std::string& name) const {
        constexpr int shown = 8;
        std::string names;
        for (int i = 0; i < std::min(named_.size(), shown); ++i)
            names += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", named_[i].name().substr(0, 64));
        if (named_.size() > shown) names += fmt::format(" and {} more", named_.size() - shown);
        return fmt::format("there is no selection \"{}\"; {}", name.substr(0, 64),
                           names.empty() ? "none has a name here" : "there are " + names);
    }

    const NamedSelectionMessages& named_;
    std::vector<std::string_view> open_;  ///< names that are being read
    std::size_t conditions_ = 0, values_ = 0;
};

Status checkName(const NamedSelectionMessages& named, int index) {
    constexpr std::size_t longest = 256;  // bytes
    const auto& name = named[index].name();
    if (name.empty()) return invalid("name", "a selection of a view needs a name");
    if (name.size() > longest) return invalid("name", fmt::format("is longer than {} bytes", longest));
    for (int i = 0; i < index; ++i) {
        if (named[i].name() == name) return invalid("name", fmt::format("\"{}\" is given twice", name));
    }
    return success();
}

}  // namespace

Result<Selection> parseSelection(const proto::Selection& message, const NamedSelectionMessages& named) {
    return Reader(named).read(message, 1);
}

Result<Selection> parseSelection(const proto::Selection& message) {
    return parseSelection(message, NamedSelectionMessages());
}

Result<std::vector<NamedSelection>> parseNamedSelections(const NamedSelectionMessages& named) {
    if (named.size() > maxNamed)
        return invalid("", fmt::format("a view has at most {} of them, not {}", maxNamed, named.size()));
    std::vector<NamedSelection> selections;
    std::size_t values = 0;
    for (int i = 0; i < named.size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkName(named, i), fmt::format("[{}]", i));
        auto selection = parseSelection(named[i].selection(), named);
        MOTE_RETURN_IF_ERROR(selection, fmt::format("[{}].selection", i));
        values += valueCount(*selection);
        if (values > Selection::maxValues)
            return invalid(
                fmt::format("[{}].selection", i),
                fmt::format("all together have more than {} ids and points", Selection::maxValues));
        selections.push_back({named[i].name(), *std::move(selection)});
    }
    return selections;
}

}  // namespace mote
