// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/file_browser.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "client/view/panel_widgets.h"
#include "client/view/replot.h"

namespace mote::client {
namespace {

constexpr double restOfMark = 0.3;  // seconds; before that the arrows go on
constexpr float listShare = 0.47F;  // of the width
constexpr float mostForm = 0.67F;   // of the height, the form's

bool pressed(ImGuiKey key) {
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key));
}

/// A line that is typed in; true as it is edited.
bool typeLine(const char* label, std::string& line, const std::string& hint) {
    std::array<char, 4096> typed{};  // as long as a path may be
    std::copy_n(line.begin(), std::min(line.size(), typed.size() - 1), typed.begin());
    if (!ImGui::InputTextWithHint(label, hint.c_str(), typed.data(), typed.size())) return false;
    line = typed.data();
    return true;
}

void wrapped(const std::string& line) {
    ImGui::PushTextWrapPos(0.0F);
    text(line);
    ImGui::PopTextWrapPos();
}

/// A word in faint letters, which is not wrapped.
void faint(const std::string& word) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    text(word);
    ImGui::PopStyleColor();
}

void warn(const std::string& sentence) {
    pushWarningColor();
    wrapped(sentence);
    ImGui::PopStyleColor();
}

/// "particles 'electrons', openpmd"
std::string titleOf(const proto::Look::Found& found) {
    const auto name = found.name().empty() ? std::string() : fmt::format(" '{}'", found.name());
    return fmt::format("{}{}, {}", found.kind(), name, found.format());
}

/// "x,px,y" as three names; nothing of other texts.
std::optional<AxisNames> splitAxes(const std::string& text) {
    const auto first = text.find(','), second = text.find(',', first + 1);
    if (first == std::string::npos || second == std::string::npos ||
        text.find_first_of("( ,", second + 1) != std::string::npos)
        return std::nullopt;
    return AxisNames{text.substr(0, first), text.substr(first + 1, second - first - 1),
                     text.substr(second + 1)};
}

std::string joinAxes(const AxisNames& axes) {
    return fmt::format("{},{},{}", axes[0], axes[1], axes[2]);
}

std::string lastPart(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

}  // namespace

FileLine fileLineOf(Connection& connection, std::function<void(const google::protobuf::Message&)> learn) {
    const auto learning = [learn = std::move(learn)](auto reply) {
        return [learn, reply = std::move(reply)](auto answer) {
            if (answer.ok()) learn(*answer);
            reply(std::move(answer));
        };
    };
    FileLine line;
    line.list = [&connection, learning](const std::string& folder, std::uint64_t first,
                                        FileLine::Reply<proto::Folder> reply) {
        connection.listFolder(folder, first, learning(std::move(reply)));
    };
    line.look = [&connection, learning](const proto::LookAtFile& wanted, FileLine::Reply<proto::Look> reply) {
        return connection.lookAtFile(wanted, learning(std::move(reply)));
    };
    line.cancel = [&connection](std::uint64_t look) { connection.cancelQuery(look); };
    line.whyNot = [&connection]() -> std::string {
        if (connection.state() != Connection::State::connected) return "There is no server at the moment.";
        const auto welcome = connection.welcome();
        if (welcome.minor() >= filesFromMinor) return {};
        return fmt::format(
            "{} is older than this viewer and does not list its files; mote-prep prepares them on its "
            "machine.",
            welcome.server());
    };
    return line;
}

// -------------------------------------------------------------------------------------------- a folder

void FolderList::take(const proto::Folder& page) {
    if (page.first() == 0) {
        folder_ = page.folder();
        entries_.clear();
        rows_.clear();
    }
    if (page.folder() != folder_ || page.first() != entries_.size()) return;
    for (const auto& entry : page.entries()) {
        rows_.add(entry.name());
        entries_.push_back(entry);
    }
    total_ = page.entries().empty() ? entries_.size() : page.total();
    notes_.assign(page.notes().begin(), page.notes().end());
}

const std::vector<int>& FolderList::find(std::string_view typed, Column column, bool descending) {
    const auto compare = [this](int by, int one, int other) {
        const auto& left = entries_[static_cast<std::size_t>(one)];
        const auto& right = entries_[static_cast<std::size_t>(other)];
        const auto order = [](auto a, auto b) { return a < b ? -1 : a > b ? 1 : 0; };
        if (by == static_cast<int>(Column::size)) return order(left.bytes(), right.bytes());
        if (by == static_cast<int>(Column::changed)) return order(left.changed_ms(), right.changed_ms());
        return order(one, other);  // as the server has sorted them
    };
    return rows_.find(typed, static_cast<int>(column), descending, compare);
}

void FileBrowser::begin() {
    focus_ = true;
    emptyBefore_ = false;
    go(wanted_);
}

void FileBrowser::rest() {
    if (looking_) input_.clear();
    endLook();
}

void FileBrowser::go(const std::string& folder) {
    if (folder != wanted_ || folder != list_.folder()) {
        typed_.fill('\0');
        row_.reset();
        input_.clear();
        endLook();
        look_.reset();
        lookError_.clear();
    }
    wanted_ = folder;
    focus_ = true;
    listError_.clear();
    ++asked_;
    askPage(0);
}

void FileBrowser::askPage(std::uint64_t first) {
    listing_ = true;
    line_.list(wanted_, first, [this, asked = asked_](Result<proto::Folder> page) {
        if (asked != asked_) return;
        listing_ = false;
        if (!page.ok()) {
            listError_ = page.error().toString();
            proto::Folder none;  // what was there is not shown under another name
            none.set_folder(wanted_);
            return list_.take(none);
        }
        list_.take(*page);
        // Of one root nobody chooses.
        if (std::exchange(first_, false) && wanted_.empty() && page->entries_size() == 1)
            return go(page->entries(0).name());
        if (!list_.complete()) askPage(list_.entries().size());
    });
}

void FileBrowser::goUp() {
    if (wanted_.empty()) return;
    const auto slash = wanted_.rfind('/');
    go(slash == std::string::npos ? "" : wanted_.substr(0, slash));
}

std::string FileBrowser::pathOf(const std::string& name) const {
    return list_.folder().empty() ? name : list_.folder() + "/" + name;
}

/// As far as this folder is known; what lies elsewhere the server checks.
bool FileBrowser::isTaken(const std::string& path) const {
    return std::ranges::any_of(list_.entries(),
                               [&](const auto& entry) { return pathOf(entry.name()) == path; });
}

/// Above the files that are listed: the way up and the folder as a whole, or what was found as a whole.
std::vector<FileBrowser::Above> FileBrowser::rowsAbove() const {
    if (typed_[0] == '\0')
        return list_.folder().empty() ? std::vector<Above>() : std::vector{Above::up, Above::folder};
    const auto isFile = [this](int at) {
        return list_.entries()[static_cast<std::size_t>(at)].kind() == proto::Folder::FILE;
    };
    const bool files = found_.size() > 1 && std::ranges::all_of(found_, isFile);
    return files ? std::vector{Above::files} : std::vector<Above>();
}

/// Null: the row is one of those above, or there is none.
const proto::Folder::Entry* FileBrowser::entryOf(int row) const {
    const auto at = static_cast<std::size_t>(row) - above_.size();
    return at < found_.size() ? &list_.entries()[static_cast<std::size_t>(found_[at])] : nullptr;
}

/// What a row would be looked at as; none: nothing. Several are one run, in the order of their names.
std::vector<std::string> FileBrowser::inputsOf(int row) const {
    std::vector<std::string> inputs;
    if (const auto* const entry = entryOf(row)) {
        if (entry->kind() == proto::Folder::FILE) inputs.push_back(pathOf(entry->name()));
    } else if (static_cast<std::size_t>(row) >= above_.size()) {
        return inputs;
    } else if (above_[static_cast<std::size_t>(row)] == Above::folder) {
        inputs.push_back(list_.folder());
    } else if (above_[static_cast<std::size_t>(row)] == Above::files) {
        auto found = found_;
        std::ranges::sort(found);
        for (const int at : found)
            inputs.push_back(pathOf(list_.entries()[static_cast<std::size_t>(at)].name()));
    }
    return inputs;
}

std::string FileBrowser::nameOf(int row) const {
    if (const auto* const entry = entryOf(row))
        return entry->name() + (entry->kind() == proto::Folder::FOLDER ? "/" : "");
    switch (above_[static_cast<std::size_t>(row)]) {
        case Above::up:
            return "..";
        case Above::folder:
            return "(this folder, as one run)";
        default:
            return fmt::format("(these {} files, as one run)", found_.size());
    }
}

/// What Enter and a click do.
void FileBrowser::enter(int row) {
    const auto* const found = entryOf(row);
    if (found == nullptr && static_cast<std::size_t>(row) >= above_.size()) return;
    if (found == nullptr && above_[static_cast<std::size_t>(row)] == Above::up) return goUp();
    if (found == nullptr || found->kind() == proto::Folder::FILE) return lookAt(inputsOf(row));
    const auto path = pathOf(found->name());
    if (found->kind() == proto::Folder::FOLDER) return go(path);
    choice_ = Choice{path.substr(0, path.size() - std::string_view(".mote").size())};
}

// -------------------------------------------------------------------------------------------- a file

void FileBrowser::endLook() {
    if (looking_) line_.cancel(*looking_);
    looking_.reset();
    lookWaits_ = false;
    ++looks_;
}

/// Of several the first: the others of a run are as it is.
void FileBrowser::lookAt(const std::vector<std::string>& inputs) {
    const auto input = inputs.empty() ? std::string() : inputs.front();
    if (input == input_ && inputs.size() == inputs_.size() && (look_ || looking_)) return;
    endLook();
    input_ = input;
    inputs_ = inputs;
    look_.reset();
    lookError_.clear();
    formError_.clear();
    becomings_.clear();
    if (input.empty()) return;
    proto::LookAtFile wanted;
    wanted.set_input(input);
    looking_ = line_.look(wanted, [this, look = looks_](Result<proto::Look> answer) {
        if (look != looks_) return;
        looking_.reset();
        if (!answer.ok()) {
            lookError_ = answer.error().toString();
            return;
        }
        take(*answer);
    });
}

void FileBrowser::take(const proto::Look& look) {
    look_ = look;
    int best = 0;
    while (best < look.found_size() && !look.found(best).refused().empty()) ++best;
    chooseFound(best < look.found_size() ? best : 0);
}

void FileBrowser::chooseFound(int found) {
    chosenFound_ = found;
    becomings_.clear();
    if (found < look_->found_size()) becomings_ = becomings(inputs_, look_->found(found));
    if (becomings_.empty()) return;
    const auto name = look_->found_size() > 1 ? look_->found(found).name() : std::string();
    form_.output = outputFor(inputs_, name, [this](const std::string& path) { return isTaken(path); });
    form_.title.clear();
    chooseBecoming(0);
}

void FileBrowser::chooseBecoming(int becoming) {
    chosenBecoming_ = becoming;
    form_.begin(becomings_[static_cast<std::size_t>(becoming)].request);
    formError_.clear();
}

void FileBrowser::prepare() {
    const auto request = form_.request();
    formError_ = request.ok() ? "" : request.error().toString();
    if (request.ok()) choice_ = Choice{"", *request};
}

// -------------------------------------------------------------------------------------------- drawing

std::optional<FileBrowser::Choice> FileBrowser::draw(float scale) {
    choice_.reset();
    if (const auto why = line_.whyNot(); !why.empty()) {
        warn(why);
        return std::nullopt;
    }
    const float width = listShare * ImGui::GetContentRegionAvail().x;
    ImGui::BeginChild("files", {width, 0.0F});
    drawWay();
    drawList(scale);
    ImGui::EndChild();
    ImGui::SameLine();
    ImGui::BeginChild("content");
    drawContent();
    ImGui::EndChild();
    return choice_;
}

/// The folders that lead here, each a button.
void FileBrowser::drawWay() {
    const float end = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
    std::optional<std::string> wanted;
    if (ImGui::SmallButton("server")) wanted = "";
    for (std::size_t begin = 0; begin < wanted_.size();) {
        const auto slash = std::min(wanted_.find('/', begin), wanted_.size());
        const auto part = wanted_.substr(begin, slash - begin);
        const float room = end - ImGui::GetItemRectMax().x - 2.0F * ImGui::GetStyle().ItemSpacing.x;
        if (ImGui::CalcTextSize((" / " + part).c_str()).x < room) ImGui::SameLine();
        ImGui::PushID(static_cast<int>(begin));
        if (ImGui::SmallButton(("/ " + part).c_str())) wanted = wanted_.substr(0, slash);
        ImGui::PopID();
        begin = slash + 1;
    }
    if (wanted) go(*wanted);
    if (std::exchange(focus_, false)) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1.0F);
    const bool entered = ImGui::InputTextWithHint("##typed", "type a part of a name", typed_.data(),
                                                  typed_.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    const bool here = ImGui::IsItemActive();
    const bool empty = typed_[0] == '\0';
    if (here && empty && emptyBefore_ && pressed(ImGuiKey_Backspace)) goUp();
    emptyBefore_ = empty;
    focus_ |= entered;
    entered_ = entered && !ImGui::GetIO().KeyCtrl;  // with Ctrl it prepares
}

void FileBrowser::drawList(float scale) {
    if (!listError_.empty()) warn(listError_);
    for (const auto& note : list_.notes()) dim(note + ".");
    constexpr auto flags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_Sortable | ImGuiTableFlags_RowBg |
                           ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_Resizable;
    const std::string before = std::exchange(sought_, typed_.data());
    if (before != sought_) row_.reset();
    const float below = ImGui::GetTextLineHeightWithSpacing();
    if (!ImGui::BeginTable("list", 3, flags, {0.0F, -below})) return;
    constexpr auto fixed = ImGuiTableColumnFlags_WidthFixed;
    ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch | ImGuiTableColumnFlags_DefaultSort);
    ImGui::TableSetupColumn("size", fixed, 65.0F * scale);
    ImGui::TableSetupColumn("changed", fixed, 115.0F * scale);
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableHeadersRow();
    if (auto* sorted = ImGui::TableGetSortSpecs(); sorted != nullptr && sorted->SpecsCount > 0) {
        column_ = static_cast<FolderList::Column>(sorted->Specs[0].ColumnIndex);
        descending_ = sorted->Specs[0].SortDirection == ImGuiSortDirection_Descending;
    }
    found_ = list_.find(typed_.data(), column_, descending_);
    above_ = rowsAbove();
    const int above = static_cast<int>(above_.size()), count = static_cast<int>(found_.size()) + above;
    if (!row_ && !listing_) {
        row_ = found_.empty() ? 0 : above;  // the first of what is listed
        ImGui::SetScrollY(0.0F);
    }
    int row = row_.value_or(0);
    const float height = ImGui::GetTextLineHeight() + 2.0F * ImGui::GetStyle().CellPadding.y;
    moveRow(row, count, height);
    if (row_ && row != *row_) {
        row_ = row;
        markedAt_ = ImGui::GetTime();
        lookWaits_ = true;
    }
    if (lookWaits_ && ImGui::GetTime() - markedAt_ >= restOfMark) {
        lookWaits_ = false;
        // Many files, only on request.
        if (const auto inputs = inputsOf(row); !inputs.empty() && row >= above) lookAt(inputs);
    }
    // Of the list that is searched by all that was typed before it.
    if (std::exchange(entered_, false) && row_) enter(*row_);
    ImGuiListClipper clipper;
    clipper.Begin(count, height);
    std::optional<int> clicked;
    while (clipper.Step()) {
        for (int at = clipper.DisplayStart; at < clipper.DisplayEnd; ++at) {
            drawRow(at);
            if (ImGui::IsItemClicked()) clicked = at;
        }
    }
    ImGui::EndTable();
    const auto all = list_.entries().size();
    const auto said = listing_ ? std::string("listing ...") : fmt::format("{} of {}", found_.size(), all);
    dim(said + "   Enter opens, Backspace goes up");
    if (!clicked) return;
    row_ = *clicked;
    enter(*clicked);
    focus_ = true;
}

void FileBrowser::drawRow(int row) {
    ImGui::PushID(row);
    ImGui::TableNextRow();
    const auto cell = [](int column, const std::string& words) {
        ImGui::TableSetColumnIndex(column);
        text(words);
    };
    if (const auto* const entry = entryOf(row)) {
        cell(1, entry->kind() == proto::Folder::FILE      ? metric(static_cast<double>(entry->bytes()), "B")
                : entry->kind() == proto::Folder::DATASET ? "dataset"
                                                          : "");
        cell(2, dateOf(entry->changed_ms()));
    }
    ImGui::TableSetColumnIndex(0);
    // Last: it is the item that is asked whether it was clicked.
    ImGui::Selectable((nameOf(row) + "###row").c_str(), row == row_.value_or(0),
                      ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_DontClosePopups);
    ImGui::PopID();
}

void FileBrowser::drawContent() {
    if (input_.empty()) {
        return dim(
            "Choose a file: what it holds is shown here before anything is made of it. A folder of a run's "
            "files, "
            "of pictures or of DICOM is looked at as a whole by the row in its brackets.");
    }
    text(lastPart(input_));
    if (inputs_.size() > 1)
        dim(fmt::format("the first of {} files; that the others are like it, the job checks",
                        inputs_.size()));
    if (looking_) {
        ImGui::SameLine();
        if (ImGui::SmallButton("Stop")) {
            endLook();
            lookError_ = "It was not looked at to its end.";
        }
        return dim("looking at it ...");
    }
    if (!lookError_.empty()) return warn(lookError_);
    if (!look_) return;
    for (const auto& sentence : look_->refused()) warn(sentence);
    if (look_->found_size() > 1) {
        std::vector<std::string> titles;
        for (const auto& found : look_->found()) titles.push_back(titleOf(found));
        std::vector<std::string_view> names(titles.begin(), titles.end());
        auto chosen = titles[static_cast<std::size_t>(chosenFound_)];
        ImGui::SetNextItemWidth(-1.0F);
        if (chooseName("##found", chosen, names))
            chooseFound(static_cast<int>(std::ranges::find(names, chosen) - names.begin()));
        helpAtRest("what of the file's content");
    }
    if (chosenFound_ >= look_->found_size()) return;
    const auto& found = look_->found(chosenFound_);
    const bool offered = !becomings_.empty() && found.refused().empty();
    // The form is as high as it needs, up to two thirds of the room, in which it scrolls.
    const float room = ImGui::GetContentRegionAvail().y;
    const float form = formHeight_ > 0.0F ? formHeight_ : 8.0F * ImGui::GetFrameHeightWithSpacing();
    const float below = offered ? std::min(form, mostForm * room) : 0.0F;
    ImGui::BeginChild("found", {0.0F, room - below});
    drawFound(found);
    ImGui::EndChild();
    if (!offered) return;
    ImGui::BeginChild("form");
    const float top = ImGui::GetCursorPosY();
    drawForm();
    drawOutput();
    formHeight_ = ImGui::GetCursorPosY() - top + ImGui::GetStyle().ItemSpacing.y;
    ImGui::EndChild();
}

void FileBrowser::drawFound(const proto::Look::Found& found) {
    if (look_->found_size() == 1) dim(titleOf(found) + " (" + found.told_by() + ")");
    for (const auto& sentence : found.refused()) warn(sentence);
    const auto rows = [](const char* id, int columns, const auto& draw) {
        if (!ImGui::BeginTable(id, columns, ImGuiTableFlags_SizingFixedFit)) return;
        draw();
        ImGui::EndTable();
    };
    rows("lines", 2, [&] {
        ImGui::TableSetupColumn("label");
        ImGui::TableSetupColumn("text", ImGuiTableColumnFlags_WidthStretch);
        for (const auto& line : found.lines()) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            faint(line.label());
            ImGui::TableNextColumn();
            wrapped(line.text());
        }
    });
    rows("columns", 4, [&] {
        for (const char* const head : {"column", "from", "to", "unit"}) ImGui::TableSetupColumn(head);
        for (const auto& column : found.columns()) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            text(column.name().empty() ? "values" : column.name());
            ImGui::TableNextColumn();
            text(column.has_min() ? fmt::format("{:.5g}", column.min()) : "no finite value");
            ImGui::TableNextColumn();
            text(column.has_max() ? fmt::format("{:.5g}", column.max()) : "");
            ImGui::TableNextColumn();
            const auto invalid = column.invalid() > 0 ? fmt::format(", {} not finite", column.invalid()) : "";
            text((column.unit() == "1" ? "" : column.unit()) + invalid);
        }
    });
    for (const auto& note : found.notes()) dim(note);
}

void FileBrowser::drawForm() {
    ImGui::Separator();
    ImGui::PushItemWidth(0.6F * ImGui::GetContentRegionAvail().x);
    std::vector<std::string_view> names;
    for (const auto& each : becomings_) names.push_back(each.label);
    std::string chosen(names[static_cast<std::size_t>(chosenBecoming_)]);
    if (names.size() > 1 && chooseName("becomes", chosen, names))
        chooseBecoming(static_cast<int>(std::ranges::find(names, chosen) - names.begin()));
    const bool more = std::ranges::any_of(form_.fields(), [](const auto& field) { return !field.first; });
    for (auto& field : form_.fields()) {
        if (field.label == "axes" && drawAxes(field)) continue;
        if (field.first) drawField(field);
    }
    if (more && ImGui::TreeNode("more options")) {
        for (auto& field : form_.fields()) {
            if (!field.first || field.label == "axes") drawField(field);
        }
        ImGui::TreePop();
    }
    ImGui::PopItemWidth();
}

/// Three lists of names, of the quantities that all know and the file's own; expressions are typed below.
bool FileBrowser::drawAxes(JobForm::Field& field) const {
    auto axes = splitAxes(field.text);
    if (!axes) return false;
    std::vector<std::string_view> names(plotAxes().begin(), plotAxes().end());
    for (const auto& column : look_->found(chosenFound_).columns()) {
        const std::string_view name = column.name();
        if (name != "weight" && std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
    const float width = (ImGui::CalcItemWidth() - 2.0F * gap) / 3.0F;
    for (std::size_t i = 0; i < axes->size(); ++i) {
        ImGui::SetNextItemWidth(width);
        if (chooseName(fmt::format("##axis{}", i).c_str(), (*axes)[i], names)) field.text = joinAxes(*axes);
        helpAtRest(field.help);
        ImGui::SameLine(0.0F, gap);
    }
    text(field.label);
    return true;
}

void FileBrowser::drawField(JobForm::Field& field) const {
    std::string path;
    for (const auto* const part : field.path) path += part->name() + ".";
    ImGui::PushID(path.c_str());
    if (field.isSwitch) {
        bool on = !field.text.empty();
        if (ImGui::Checkbox(field.label.c_str(), &on)) field.text = on ? "true" : "";
    } else if (!field.words.empty()) {
        std::vector<std::string_view> names(field.words.begin(), field.words.end());
        auto chosen = field.text.empty() ? field.usual : field.text;
        if (chooseName(field.label.c_str(), chosen, names)) field.text = chosen == field.usual ? "" : chosen;
    } else {
        typeLine(field.label.c_str(), field.text, field.usual.empty() ? field.help : field.usual);
    }
    helpAtRest(field.help);
    ImGui::PopID();
}

/// What is made, and the button that makes it.
void FileBrowser::drawOutput() {
    ImGui::PushItemWidth(0.6F * ImGui::GetContentRegionAvail().x);
    typeLine("dataset", form_.output, "ROOT/NAME");
    helpAtRest("where it is to lie, and its name; nothing that is there is replaced");
    typeLine("title", form_.title, "what viewers show beside its name");
    ImGui::PopItemWidth();
    if (!formError_.empty()) warn(formError_);
    const bool keys = ImGui::GetIO().KeyCtrl && (pressed(ImGuiKey_Enter) || pressed(ImGuiKey_KeyPadEnter));
    if (ImGui::Button("Prepare (Ctrl+Enter)") || keys) prepare();
}

}  // namespace mote::client
