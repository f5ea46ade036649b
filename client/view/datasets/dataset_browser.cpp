// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/dataset_browser.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "client/view/panel_widgets.h"

namespace mote::client {
namespace {

constexpr float browserWidth = 1060.0F, browserHeight = 560.0F, pictureWidth = 80.0F, pictureHeight = 45.0F;
constexpr const char* browserTitles[] = {"Open a dataset", "Draw a dataset as well",
                                         "Let the layer draw another dataset"};

/// Less than 0 where one comes before the other.
int compareBy(DatasetIndex::Column column, const proto::Catalogue::Entry& one,
              const proto::Catalogue::Entry& other) {
    const auto order = [](auto a, auto b) { return a < b ? -1 : a > b ? 1 : 0; };
    switch (column) {
        case DatasetIndex::Column::kind:
            return one.kind().compare(other.kind());
        case DatasetIndex::Column::steps:
            return order(one.steps(), other.steps());
        case DatasetIndex::Column::particles:
            return order(one.particles(), other.particles());
        case DatasetIndex::Column::size:
            return order(one.bytes(), other.bytes());
        case DatasetIndex::Column::prepared:
            return order(one.prepared_ms(), other.prepared_ms());
        case DatasetIndex::Column::title:
            return one.title().compare(other.title());
        default:
            return one.name().compare(other.name());
    }
}

}  // namespace

void DatasetIndex::setCatalogue(const proto::Catalogue& catalogue) {
    entries_.assign(catalogue.datasets().begin(), catalogue.datasets().end());
    rows_.clear();
    for (const auto& entry : entries_) rows_.add(entry.name() + ' ' + entry.kind() + ' ' + entry.title());
}

const std::vector<int>& DatasetIndex::find(std::string_view typed, Column column, bool descending) {
    const auto compare = [this](int by, int one, int other) {
        return compareBy(static_cast<Column>(by), entries_[static_cast<std::size_t>(one)],
                         entries_[static_cast<std::size_t>(other)]);
    };
    return rows_.find(typed, static_cast<int>(column), descending, compare);
}

void DatasetBrowser::open(Use use) {
    use_ = use;
    opening_ = true;
    showPage(false);
}

void DatasetBrowser::openFiles() {
    open(Use::open);
    showPage(true);
}

void DatasetBrowser::showPage(bool files) {
    if (filesShown_ && !files) files_.rest();
    if (!filesShown_ && files) files_.begin();
    if (filesShown_ && !files) focus_ = true;
    filesShown_ = files;
}

void DatasetBrowser::setCatalogue(const proto::Catalogue& catalogue) {
    catalogue_ = catalogue;
    index_.setCatalogue(catalogue);
}

std::optional<DatasetBrowser::Choice> DatasetBrowser::draw(const PictureArea& area) {
    const bool begins = std::exchange(opening_, false);
    if (begins) {
        typed_.fill('\0');
        row_ = 0;
        focus_ = true;
        ImGui::OpenPopup("datasets");
    }
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({area.left + area.width / 2.0F, display.y / 2.0F}, ImGuiCond_Always,
                            {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(browserWidth * area.scale, area.width - 10.0F),
                              std::min(browserHeight * area.scale, display.y - 20.0F)});
    ImGui::SetNextWindowBgAlpha(1.0F);
    if (!ImGui::BeginPopup("datasets")) {
        if (!std::exchange(open_, false)) return std::nullopt;
        thumbnails_.rest();
        files_.rest();
        return std::nullopt;
    }
    open_ = true;
    drawPages();
    auto choice = filesShown_ ? drawFiles(area.scale) : drawDatasets(area.scale);
    if (choice || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
    return choice;
}

/// What the list is for, and the way to its other page.
void DatasetBrowser::drawPages() {
    constexpr const char* labels[] = {"Datasets", "Prepare a file..."};
    for (const bool files : {false, true}) {
        if (files) ImGui::SameLine();
        const bool chosen = filesShown_ == files;
        if (chosen) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
        if (ImGui::Button(labels[files ? 1 : 0])) showPage(files);
        if (chosen) ImGui::PopStyleColor();
    }
    ImGui::SameLine();
    dim(filesShown_ ? "A file of the server becomes a dataset"
                    : browserTitles[static_cast<std::size_t>(use_)]);
}

std::optional<DatasetBrowser::Choice> DatasetBrowser::drawFiles(float scale) {
    auto choice = files_.draw(scale);
    if (!choice) return std::nullopt;
    return Choice{use_, choice->dataset, std::move(choice->job)};
}

std::optional<DatasetBrowser::Choice> DatasetBrowser::drawDatasets(float scale) {
    chosen_.reset();
    if (std::exchange(focus_, false)) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1.0F);
    const bool entered =
        ImGui::InputTextWithHint("##typed", "type a part of a name, a kind, a title", typed_.data(),
                                 typed_.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    drawList(scale);
    if (entered && row_ < static_cast<int>(found_.size()))
        chosen_ = catalogue_.datasets(found_[static_cast<std::size_t>(row_)]).name();
    thumbnails_.show(seen_);
    return chosen_ ? std::optional(Choice{use_, *chosen_, {}}) : std::nullopt;
}

void DatasetBrowser::drawList(float scale) {
    seen_.clear();
    constexpr auto flags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_Sortable | ImGuiTableFlags_RowBg |
                           ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_Resizable;
    const float below = ImGui::GetTextLineHeightWithSpacing();
    if (!ImGui::BeginTable("list", 8, flags, {0.0F, -below})) return;
    constexpr auto fixed = ImGuiTableColumnFlags_WidthFixed;
    const auto column = [&](const char* name, ImGuiTableColumnFlags flag, float width) {
        ImGui::TableSetupColumn(name, flag, width);
    };
    column("##picture", fixed | ImGuiTableColumnFlags_NoSort | ImGuiTableColumnFlags_NoResize,
           pictureWidth * scale);
    column("name", ImGuiTableColumnFlags_WidthStretch | ImGuiTableColumnFlags_DefaultSort, 3.0F);
    column("kind", fixed, 70.0F * scale);
    column("steps", fixed, 75.0F * scale);
    column("particles", fixed, 95.0F * scale);
    column("size", fixed, 65.0F * scale);
    column("prepared", fixed, 115.0F * scale);
    column("title", ImGuiTableColumnFlags_WidthStretch, 2.0F);
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableHeadersRow();
    if (auto* sorted = ImGui::TableGetSortSpecs(); sorted != nullptr && sorted->SpecsCount > 0) {
        column_ = static_cast<DatasetIndex::Column>(sorted->Specs[0].ColumnIndex);
        descending_ = sorted->Specs[0].SortDirection == ImGuiSortDirection_Descending;
    }
    const std::string before = std::exchange(sought_, typed_.data());
    found_ = index_.find(typed_.data(), column_, descending_);
    if (before != sought_) row_ = 0;
    const int count = static_cast<int>(found_.size());
    const float height = pictureHeight * scale + 2.0F * ImGui::GetStyle().CellPadding.y;
    moveRow(row_, count, height);
    ImGuiListClipper clipper;
    clipper.Begin(count, height);
    while (clipper.Step()) {
        for (int row = clipper.DisplayStart; row < clipper.DisplayEnd; ++row)
            drawRow(row, pictureHeight * scale);
    }
    ImGui::EndTable();
    const int all = catalogue_.datasets_size();
    dim(all == 0 ? "The server has no datasets."
                 : fmt::format("{} of {}   Enter takes the marked one", count, all));
}

void DatasetBrowser::drawRow(int row, float height) {
    const auto& entry = catalogue_.datasets(found_[static_cast<std::size_t>(row)]);
    seen_.push_back(&entry);
    ImGui::PushID(row);
    ImGui::TableNextRow(ImGuiTableRowFlags_None, height);
    ImGui::TableNextColumn();
    const ImVec2 at = ImGui::GetCursorPos();
    if (ImGui::Selectable("##row", row == row_,
                          ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_DontClosePopups,
                          {0.0F, height}))
        chosen_ = entry.name();
    if (auto* picture = thumbnails_.handle(entry)) {
        ImGui::SetCursorPos(at);
        ImGui::Image(picture, {height * pictureWidth / pictureHeight, height});
    }
    const auto cell = [height](const std::string& words) {
        ImGui::TableNextColumn();
        ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 0.5F * (height - ImGui::GetTextLineHeight()));
        text(words);
        if (ImGui::IsItemHovered() && ImGui::GetContentRegionAvail().x < ImGui::GetItemRectSize().x)
            ImGui::SetTooltip("%s", words.c_str());
    };
    cell(entry.name());
    cell(entry.kind());
    const char* more = entry.live() ? ", live" : "";
    cell(entry.steps() > 0 ? fmt::format("{}{}", entry.steps(), more) : "");
    cell(entry.particles() > 0 ? metric(static_cast<double>(entry.particles()), "") : "");
    cell(entry.bytes() > 0 ? metric(static_cast<double>(entry.bytes()), "B") : "");
    cell(dateOf(entry.prepared_ms()));
    cell(entry.title());
    ImGui::PopID();
}

}  // namespace mote::client
