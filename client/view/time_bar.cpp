// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/time_bar.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "client/shared/numbers.h"
#include "client/view/numbers/plot_frame.h"

namespace mote::client {
namespace {

constexpr int mostTicks = 200;
constexpr std::string_view evenly = "step";
constexpr ImU32 loadedColor = IM_COL32(70, 170, 120, 255);

/// Every so many steps there is a tick, so that they can be told apart.
int tickStride(int steps, float width) {
    const int most = std::clamp(static_cast<int>(width / 5.0F), 2, mostTicks);
    int stride = 1;
    for (int factor = 0; steps / stride > most; ++factor) stride *= factor % 3 == 1 ? 5 : 2;
    return stride;
}

bool tellsApart(const std::vector<double>& values) {
    return values.size() > 1 &&
           std::ranges::all_of(values, [](double value) { return std::isfinite(value); }) &&
           (std::ranges::adjacent_find(values, std::greater_equal<>()) == values.end() ||
            std::ranges::adjacent_find(values, std::less_equal<>()) == values.end());
}

/// A statistic of each step; none where a step lacks it.
std::vector<double> statisticOfSteps(const proto::ParticlesManifest& plot, std::string_view name) {
    const auto found = std::ranges::find(plot.statistic_names(), name);
    const int at = static_cast<int>(found - plot.statistic_names().begin());
    std::vector<double> values;
    for (const auto& step : plot.steps()) {
        if (at >= step.statistics_size()) return {};
        values.push_back(step.statistics(at));
    }
    return values;
}

/// Where the steps lie on the track, 0 to 1.
struct StepPlaces {
    const TimeScale* scale;  // null: evenly
    int steps;

    double first() const { return scale != nullptr ? scale->values.front() : 0.0; }
    double last() const { return scale != nullptr ? scale->values.back() : steps - 1.0; }
    double shareOf(double value) const { return (value - first()) / (last() - first()); }
    double share(int step) const {
        return shareOf(scale != nullptr ? scale->values[static_cast<std::size_t>(step)] : step);
    }
    int nearest(double share) const {
        int best = 0;
        for (int step = 1; step < steps; ++step) {
            if (std::abs(this->share(step) - share) < std::abs(this->share(best) - share)) best = step;
        }
        return best;
    }
};

/// Round numbers above the ticks; the last one says their unit.
void drawNumbers(const StepPlaces& places, const std::function<float(double)>& across, float top,
                 float width) {
    const auto* scale = places.scale;
    const bool whole = scale == nullptr || scale->unit == "1";
    const Interval ends{std::min(places.first(), places.last()), std::max(places.first(), places.last())};
    const double room = width / (3.5F * ImGui::GetFontSize()),
                 most = whole ? std::min(room, ends.high - ends.low) : room;
    const auto ticks =
        ticksOf(ends, scale != nullptr ? scale->unit : "1", std::clamp(static_cast<int>(most), 1, 20));
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    for (std::size_t i = 0; i < ticks.at.size(); ++i) {
        if (whole && ticks.at[i] != std::round(ticks.at[i])) continue;
        auto label = ticks.labels[i];
        if (!whole && i + 1 == ticks.at.size()) label += " " + ticks.unit;
        const float half = 0.5F * ImGui::CalcTextSize(label.c_str()).x;
        const float middle = std::clamp(across(places.shareOf(ticks.at[i])), across(0.0) + half - 3.0F,
                                        std::max(across(1.0) - half + 3.0F, across(0.0)));
        draw.AddText({std::round(middle - half), top}, IM_COL32(255, 255, 255, 150), label.c_str());
    }
}

}  // namespace

std::string TimeScale::said(std::size_t step) const {
    const double value = values[step];
    const char* letter = name == "time" ? "t = " : name == "position" ? "z = " : "iteration ";
    if (unit == "1") return fmt::format("{}{:.15g}", letter, value);
    const auto scaled = scaledUnit(std::max(std::abs(values.front()), std::abs(values.back())), unit);
    return fmt::format("{}{:.4g} {}", letter, value / scaled.scale, scaled.name);
}

std::vector<TimeScale> timeScales(const proto::Manifest& manifest) {
    const auto& plot = manifest.particles();
    std::vector<double> iterations, times, numbers;
    for (const auto& step : plot.steps()) {
        iterations.push_back(static_cast<double>(step.iteration()));
        times.push_back(step.time());
    }
    for (const auto& step : manifest.hybrid().steps()) {
        numbers.push_back(static_cast<double>(numbers.size()));
        times.push_back(step.time());
    }
    if (times == numbers) times.clear();  // of a source without time
    std::vector<TimeScale> scales{{"iteration", "1", std::move(iterations)},
                                  {"time", "s", std::move(times)},
                                  {"position", "m", statisticOfSteps(plot, "mean_z")}};
    std::erase_if(scales, [](const TimeScale& scale) { return !tellsApart(scale.values); });
    return scales;
}

void LoadedSteps::look(double now, const std::string& dataset, const proto::Frame* picture, const Ask& ask) {
    if (dataset != dataset_) {
        dataset_ = dataset;
        steps_.clear();
        due_ = true;
    }
    if (picture == nullptr || dataset.empty()) return;
    if (std::pair(view_, sequence_) != std::pair(picture->view_id(), picture->sequence())) due_ = true;
    view_ = picture->view_id();
    sequence_ = picture->sequence();
    if (!due_ || waiting_ || now - askedAt_ < pause) return;
    due_ = false;
    waiting_ = true;
    askedAt_ = now;
    ask(dataset, [this, dataset](const Result<proto::Loaded>& loaded) {
        waiting_ = false;
        if (!loaded.ok() || dataset != dataset_) return;
        steps_.assign(loaded->steps().begin(), loaded->steps().end());
        std::ranges::sort(steps_);
    });
}

void LoadedSteps::look(double now, const std::string& dataset, const proto::Frame* picture,
                       Connection& connection) {
    if (connection.welcome().minor() < filesFromMinor) return;
    look(now, dataset, picture, [&](const std::string& of, Connection::Reply<proto::Loaded> reply) {
        connection.listLoaded(of, std::move(reply));
    });
}

bool LoadedSteps::holds(std::uint32_t step) const {
    return std::ranges::binary_search(steps_, step);
}

/// Draws a line along the bottom of the track where steps are in the server's memory.
void TimeBar::drawLoaded(int steps, const std::function<float(int)>& across, float bottom) const {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float half = 0.15F * ImGui::GetFontSize();
    for (const auto index : loaded.steps()) {
        const int step = static_cast<int>(index);
        if (step >= steps) break;  // it is not known here yet
        // Half of the way to either neighbour, and at the ends no further.
        const float at = across(step);
        const float from = step > 0 ? 0.5F * (across(step - 1) + at) : at - half;
        const float to = step + 1 < steps ? 0.5F * (at + across(step + 1)) : at + half;
        draw.AddRectFilled({std::min(from, to), bottom - half}, {std::max(from, to), bottom}, loadedColor);
    }
}

void TimeBar::drawTrack(ViewModel& model, const TimeScale* chosen, float width, PanelActions& actions) const {
    const StepPlaces places{chosen, model.timedSteps()};
    const ImVec2 window = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
    const float letter = ImGui::GetFontSize(), edge = 0.5F * letter, top = window.y + 1.0F;
    const ImVec2 origin{ImGui::GetCursorScreenPos().x, top};
    const float height = size.y - 2.0F, bottom = top + height, tick = bottom - 0.45F * letter;
    const float room = std::max(width - 2.0F * edge, 1.0F);
    ImGui::SetCursorScreenPos(origin);
    ImGui::InvisibleButton("track", {width, height});
    note(actions, false);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const auto across = [&](double share) { return origin.x + edge + room * static_cast<float>(share); };
    draw.AddRectFilled(origin, {origin.x + width, bottom}, IM_COL32(24, 30, 42, 255), 4.0F);
    const auto shown = std::min(static_cast<int>(model.timedLayer().step()), places.steps - 1);
    const float at = across(places.share(shown));
    draw.AddRectFilled({at - 0.4F * edge, origin.y}, {at + 0.4F * edge, bottom}, IM_COL32(90, 160, 255, 255),
                       3.0F);
    drawLoaded(
        places.steps, [&](int step) { return across(places.share(step)); }, bottom);
    const int stride = tickStride(places.steps, room);
    for (int step = 0; step < places.steps; step += stride) {
        const float x = std::round(across(places.share(step)));
        draw.AddLine({x, tick}, {x, bottom}, IM_COL32(255, 255, 255, 110));
    }
    drawNumbers(places, across, top + 0.5F * (tick - top - letter), room);
    const double pointed = (ImGui::GetIO().MousePos.x - across(0.0)) / room;
    if (ImGui::IsItemHovered() && !ImGui::IsItemActive()) {
        const int step = places.nearest(pointed);
        auto what = fmt::format("step {}", step);
        if (chosen != nullptr) what += ", " + chosen->said(static_cast<std::size_t>(step));
        if (loaded.holds(static_cast<std::uint32_t>(step)))
            what += "\nin the server's memory: shown without its disk";
        // Above the bar, whose ends it would cover.
        const float half = 0.5F * ImGui::CalcTextSize(what.c_str()).x + letter;
        const float middle = std::max(ImGui::GetIO().MousePos.x, half);
        ImGui::SetNextWindowPos({middle, window.y}, ImGuiCond_Always, {0.5F, 1.0F});
        ImGui::SetTooltip("%s", what.c_str());
    }
    if (!ImGui::IsItemActive()) return;
    const int nearest = places.nearest(pointed);
    if (nearest == static_cast<int>(model.timedLayer().step())) return;
    model.setTimedStep(static_cast<std::uint32_t>(nearest));
    actions.viewChanged = true;
}

/// How it is played, and by what ticks lie.
void TimeBar::drawPlaying(Playback& playback, const std::vector<TimeScale>& scales, float density) {
    const float gap = 6.0F * density;
    ImGui::Checkbox("back", &playback.backwards);
    helpAtRest("play from the last step to the first");
    ImGui::SameLine(0.0F, gap);
    ImGui::Checkbox("loop", &playback.loop);
    helpAtRest("begin again at the other end");
    ImGui::SameLine(0.0F, gap);
    ImGui::SetNextItemWidth(42.0F * density);
    ImGui::DragInt("##stride", &playback.stride, 0.1F, 1, 1000, "x%d", ImGuiSliderFlags_AlwaysClamp);
    helpAtRest("steps at a time, while it is played");
    ImGui::SameLine(0.0F, gap);
    ImGui::SetNextItemWidth(62.0F * density);
    ImGui::DragFloat("##speed", &playback.stepsPerSecond, 0.1F, 0.5F, 60.0F, "%.1f/s",
                     ImGuiSliderFlags_AlwaysClamp);
    helpAtRest("steps a second");
    ImGui::SameLine(0.0F, gap);
    std::vector<std::string_view> names{evenly};
    for (const auto& each : scales) names.push_back(each.name);
    std::string chosen(std::ranges::find(names, scale) != names.end() ? std::string_view(scale) : evenly);
    ImGui::SetNextItemWidth(85.0F * density);
    if (chooseName("##scale", chosen, names)) scale = chosen;
    helpAtRest("what the bar is an axis of: ticks lie where the steps lie in it");
}

void TimeBar::drawButtons(const Playback& playback, float density, PanelActions& actions) {
    const auto button = [&](const char* label, const char* command) {
        if (ImGui::Button(label)) actions.command = command;
        helpAtRest(command);
        ImGui::SameLine(0.0F, 4.0F * density);
    };
    button("|<##time", "First step");
    button("<##time", "Step before");
    button(playback.playing ? "Pause" : "Play", "Play or pause");
    button(">##time", "Next step");
    button(">|##time", "Last step");
}

/// Without room, what is asked for least gives way.
void TimeBar::drawRow(ViewModel& model, Playback& playback, const std::vector<TimeScale>& scales,
                      float density, PanelActions& actions) {
    const auto steps = static_cast<std::size_t>(model.timedSteps());
    const auto find = [&](std::string_view name) -> const TimeScale* {
        const auto found = std::ranges::find(scales, name, &TimeScale::name);
        return found != scales.end() && found->values.size() == steps ? &*found : nullptr;
    };
    const auto* chosen = find(scale);
    const auto* told = chosen != nullptr ? chosen : find("time");
    const auto shown = static_cast<std::size_t>(model.timedLayer().step());
    std::string said = fmt::format("step {} of {}", shown, steps - 1);
    if (told != nullptr && shown < steps) said += ", " + told->said(shown);
    const float playing = 326.0F * density, least = 150.0F * density;
    const float left =
        ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(said.c_str()).x - 16.0F * density;
    const bool plays = left - playing >= least;
    if (left >= least) {
        ImGui::AlignTextToFramePadding();
        text(said);
        const float behind = ImGui::GetItemRectMax().x - ImGui::GetWindowPos().x;
        ImGui::SameLine(std::max(plays ? 300.0F * density : 0.0F, behind + 8.0F * density));
    }
    const ImVec2 row = ImGui::GetCursorPos();
    const float rest = plays ? playing : 36.0F * density;
    const float width = std::max(ImGui::GetContentRegionAvail().x - rest, 40.0F);
    drawTrack(model, chosen, width, actions);
    ImGui::SetCursorPos({row.x + width + ImGui::GetStyle().ItemSpacing.x, row.y});
    if (plays) return drawPlaying(playback, scales, density);
    if (ImGui::Button("...##time")) ImGui::OpenPopup("playing");
    if (!ImGui::BeginPopup("playing")) return;
    endByEscape();
    drawPlaying(playback, scales, density);
    ImGui::EndPopup();
}

void TimeBar::draw(ViewModel& model, Playback& playback, const std::vector<TimeScale>& scales,
                   const TimeBarPlace& place, PanelActions& actions) {
    ImGui::SetNextWindowPos({place.left, place.top});
    ImGui::SetNextWindowSize({place.width, height(place.scale)});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8.0F * place.scale, 6.0F * place.scale});
    ImGui::Begin("time", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::PopStyleVar();
    drawButtons(playback, place.scale, actions);
    drawRow(model, playback, scales, place.scale, actions);
    ImGui::End();
}

}  // namespace mote::client
