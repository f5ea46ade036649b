// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/auto/choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

namespace mote::prep {
namespace {

constexpr std::array<std::string_view, 4> kindsInOrder{"particles", "volume", "mesh", "image"};

/// A number that was found, 0 if there is none of the name.
std::uint64_t countOf(const Found& found, std::string_view name) {
    for (const Fact& fact : found.facts) {
        const auto* count = std::get_if<std::uint64_t>(&fact.value);
        if (fact.name == name && count != nullptr) return *count;
        const auto* counts = std::get_if<std::vector<std::uint64_t>>(&fact.value);
        if (fact.name != name || counts == nullptr) continue;
        // A size is a product, a count of each step stands for the largest.
        if (name != "size") return counts->empty() ? 0 : *std::max_element(counts->begin(), counts->end());
        std::uint64_t product = 1;
        for (const std::uint64_t one : *counts) product *= one;
        return product;
    }
    return 0;
}

/// How much of the thing there is, to choose among several.
std::uint64_t amountOf(const Found& found) {
    for (const char* const name : {"particles", "triangles", "size"}) {
        if (const auto count = countOf(found, name)) return count;
    }
    return 0;
}

std::string titleOf(const Found& found) {
    return found.name.empty() ? found.kind : fmt::format("{} \"{}\"", found.kind, found.name);
}

const Found* bestOf(const Look& look, AutoChoice& choice) {
    const Found* best = nullptr;
    for (const std::string_view kind : kindsInOrder) {
        for (const Found& found : look.found) {
            if (found.kind != kind || !found.refused.empty()) continue;
            if (best == nullptr || amountOf(found) > amountOf(*best)) best = &found;
        }
        if (best != nullptr) break;
    }
    if (best == nullptr) return nullptr;
    std::vector<std::string> others;
    for (const Found& found : look.found) {
        if (&found != best) others.push_back(titleOf(found));
    }
    std::string why = fmt::format("read as {}, told by {}", best->format, best->told);
    if (!others.empty()) {
        constexpr std::size_t most = 8;
        const std::string more =
            others.size() > most ? fmt::format(" and {} more", others.size() - most) : "";
        others.resize(std::min(others.size(), most));
        why += fmt::format(
            "; the file also holds {}{}: mote-prep particles, volume, mesh and image prepare them",
            fmt::join(others, ", "), more);
    }
    choice.reasons.push_back({"kind", titleOf(*best), why});
    return best;
}

struct AxesRule {
    std::array<const char*, 3> axes;
    std::array<const char*, 3> columns;  ///< which must vary for them
    const char* why;
};
constexpr std::array<AxesRule, 5> axesRules{{
    {{"x", "px", "y"}, {"x", "px", "y"}, "a beam's horizontal phase space and its cross section"},
    {{"x", "y", "zeta"},
     {"x", "y", "z"},
     "no momentum varies: where the particles are, in the bunch's frame"},
    {{"zeta", "pz", "x"}, {"z", "pz", "x"}, "y does not vary: the longitudinal phase space"},
    {{"x", "px", "zeta"}, {"x", "px", "z"}, "the horizontal phase space along the bunch"},
    {{"x", "px", "py"}, {"x", "px", "py"}, "the columns that vary"},
}};

/// A direction, and the columns of a run along it.
struct Direction {
    const char *place, *momentum;
    const char* axis;  ///< in the bunch's own frame
};
constexpr std::array<Direction, 3> directions{{{"x", "px", "x_c"}, {"y", "py", "y_c"}, {"z", "pz", "zeta"}}};

// Particles of a beam share most of their momentum; those of a plasma have any from none on.
constexpr double plasmaSpread = 0.5;

const FoundColumn* columnOf(const Found& run, std::string_view name) {
    const auto column = std::find_if(run.columns.begin(), run.columns.end(),
                                     [&](const FoundColumn& one) { return one.name == name; });
    return column == run.columns.end() ? nullptr : &*column;
}

double greatest(const FoundColumn* column) {
    return column == nullptr || std::isnan(column->low)
               ? 0.0
               : std::max(std::abs(column->low), std::abs(column->high));
}

/// The direction of the greatest momenta, the last of equals, where they are a plasma's; else null.
const Direction* plasmaDirection(const Found& run) {
    const Direction* most = nullptr;
    for (const Direction& one : directions) {
        const bool more = most == nullptr ||
                          greatest(columnOf(run, one.momentum)) >= greatest(columnOf(run, most->momentum));
        if (columnOf(run, one.place) != nullptr && columnOf(run, one.momentum) != nullptr && more)
            most = &one;
    }
    if (most == nullptr) return nullptr;
    const FoundColumn& momentum = *columnOf(run, most->momentum);
    return momentum.high - momentum.low > plasmaSpread * greatest(&momentum) ? most : nullptr;
}

}  // namespace

ChosenAxes chooseAxes(const Found& run) {
    const auto varies = [&](std::string_view name) {
        const FoundColumn* const column = columnOf(run, name);
        return column != nullptr && column->low < column->high;
    };
    const Direction* const plasma = plasmaDirection(run);
    const char* const across = plasma == &directions[0] ? "y" : "x";
    if (plasma != nullptr && varies(plasma->place) && varies(across)) {
        return {{plasma->axis, plasma->momentum, across},
                fmt::format("{} differs as much as it is large, as in a plasma: the phase space along it",
                            plasma->momentum)};
    }
    for (const AxesRule& rule : axesRules) {
        if (!std::all_of(rule.columns.begin(), rule.columns.end(), varies)) continue;
        return {{rule.axes.begin(), rule.axes.end()}, rule.why};
    }
    std::vector<std::string> axes;
    for (const bool varying : {true, false}) {
        for (const FoundColumn& column : run.columns) {
            if (column.name != "weight" && varies(column.name) == varying && axes.size() < 3)
                axes.push_back(column.name);
        }
    }
    return {std::move(axes), "the columns that vary, then those that do not"};
}

namespace {

/// What the plot's axes are, and why.
void takeAxes(const Found& run, AutoChoice& choice) {
    auto chosen = chooseAxes(run);
    for (const std::string& axis : chosen.axes) choice.request.mutable_particles()->add_axes(axis);
    choice.reasons.push_back({"axes", fmt::format("{}", fmt::join(chosen.axes, ",")), std::move(chosen.why)});
}

// Of fewer, the default curve draws each as a point, and the volume adds nothing (docs/AUTO.md).
constexpr std::uint64_t fewParticles = 50'000;

void chooseLevel(const Found& run, AutoChoice& choice) {
    const std::uint64_t largest = countOf(run, "counts");
    const bool few = largest < fewParticles;
    const unsigned level = few ? 5 : 7;
    choice.request.mutable_particles()->set_volume_level(level);
    choice.reasons.push_back(
        {"volume", fmt::format("{} cells a side", 1U << level),
         few ? fmt::format("the {} particles of a step are drawn as points, so no fine volume is needed",
                           largest)
             : fmt::format("with {} particles in a step, the dense core is drawn as a volume", largest)});
}

Status chooseParticles(const Found& run, const std::filesystem::path& input, AutoChoice& choice) {
    auto& job = *choice.request.mutable_particles();
    job.add_inputs(input.string());
    if (!run.name.empty()) job.set_species(run.name);
    if (run.columns.size() < 3) return unsupported(input.string(), "has fewer than three columns to plot");
    takeAxes(run, choice);
    chooseLevel(run, choice);
    choice.reasons.push_back({"style", "volume and points",
                              "points would hide a dense core, and a volume would lose rare particles"});
    return success();
}

// So many dots repeat beyond what a picture shows: docs/STIPPLES.md.
constexpr std::uint64_t dotsOfPlane = 50'000;

void chooseImage(const std::filesystem::path& input, AutoChoice& choice) {
    choice.request.mutable_image()->set_input(input.string());
    choice.dots.mutable_stipple()->set_points(dotsOfPlane);
    choice.dots.mutable_stipple()->set_seed(1);
    choice.reasons.push_back({"style", "stipples", "its tones become dots, evenly spread"});
}

void chooseMesh(const Found& mesh, const std::filesystem::path& input, AutoChoice& choice) {
    choice.request.mutable_mesh()->set_input(input.string());
    choice.reasons.push_back({"style", "mesh",
                              fmt::format("{} triangles are drawn as they are; \"ink\" in place of \"mesh\" "
                                          "in the view makes a drawing of them",
                                          countOf(mesh, "triangles"))});
}

/// Readers name the file, and so does the error that their sentences become.
Error nothingToPrepare(const Look& look) {
    std::vector<std::string> why = look.refused;
    for (const Found& found : look.found) why.insert(why.end(), found.refused.begin(), found.refused.end());
    const std::string name = std::filesystem::path(look.input).filename().string() + ": ";
    for (std::string& sentence : why) {
        if (sentence.starts_with(name)) sentence.erase(0, name.size());
    }
    return {ErrorCode::unsupported, look.input,
            why.empty() ? "holds nothing that can be prepared" : fmt::format("{}", fmt::join(why, "; "))};
}

}  // namespace

Result<AutoChoice> chooseAutomatically(const Look& look, const std::filesystem::path& output,
                                       const JobResources& resources, Progress& progress) {
    AutoChoice choice;
    const Found* const best = bestOf(look, choice);
    if (best == nullptr) return nothingToPrepare(look);
    const std::filesystem::path input = look.input;
    if (best->kind == "particles") MOTE_RETURN_IF_ERROR(chooseParticles(*best, input, choice));
    if (best->kind == "volume")
        MOTE_RETURN_IF_ERROR(balanceVolume(*best, input, output, resources, progress, choice));
    if (best->kind == "mesh") chooseMesh(*best, input, choice);
    if (best->kind == "image") chooseImage(input, choice);
    return choice;
}

}  // namespace mote::prep
