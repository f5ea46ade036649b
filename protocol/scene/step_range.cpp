// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/step_range.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string>

namespace mote {
namespace {

struct StepRange {
    std::size_t first = 0;
    std::optional<std::size_t> last;
    std::size_t stride = 1;
};

std::optional<std::size_t> parseNumber(std::string_view text) {
    std::size_t number = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

Result<StepRange> parse(std::string_view text) {
    const Error wrong =
        invalid("steps", fmt::format("\"{}\" is not FIRST:LAST:STRIDE of step indices", text.substr(0, 60)));
    std::vector<std::optional<std::size_t>> numbers;
    std::string_view rest = text;
    while (true) {
        const auto colon = rest.find(':');
        const auto part = rest.substr(0, colon);
        numbers.push_back(parseNumber(part));
        if ((!part.empty() && !numbers.back()) || numbers.size() > 3) return wrong;
        if (colon == std::string_view::npos) break;
        rest.remove_prefix(colon + 1);
    }
    StepRange range{numbers[0].value_or(0), std::nullopt, 1};
    if (numbers.size() == 1) {
        if (!numbers[0]) return wrong;
        range.last = numbers[0];
    } else {
        range.last = numbers[1];
    }
    if (numbers.size() == 3) range.stride = numbers[2].value_or(1);
    if (range.stride == 0) return invalid("steps", "the stride must be at least 1");
    if (range.last && *range.last < range.first)
        return invalid("steps", "the last step lies before the first");
    return range;
}

}  // namespace

Status checkStepRange(std::string_view text) {
    if (text.empty()) return success();
    const auto parsed = parse(text);
    return parsed.ok() ? success() : Status(parsed.error());
}

bool meansStep(std::string_view text, std::size_t step) {
    if (text.empty()) return true;
    const auto range = parse(text);
    return range.ok() && step >= range->first && (!range->last || step <= *range->last) &&
           (step - range->first) % range->stride == 0;
}

std::optional<std::size_t> lastStepMeant(std::string_view text) {
    if (text.empty()) return std::nullopt;
    const auto range = parse(text);
    return range.ok() ? range->last : std::nullopt;
}

Result<std::vector<std::size_t>> selectSteps(std::string_view text, std::size_t available) {
    StepRange range;
    if (!text.empty()) {
        MOTE_ASSIGN_OR_RETURN(range, parse(text));
    }
    if (available == 0) return Error{ErrorCode::notFound, "steps", "the run has no steps"};
    const std::size_t last = range.last.value_or(available - 1);
    if (last >= available || range.first >= available) {
        return invalid("steps", fmt::format("{} reaches beyond the run's {} step{}, 0 to {}", text, available,
                                            available == 1 ? "" : "s", available - 1));
    }
    std::vector<std::size_t> steps;
    for (std::size_t step = range.first; step <= last; step += range.stride) {
        steps.push_back(step);
        if (range.stride > last - step) break;
    }
    return steps;
}

}  // namespace mote
