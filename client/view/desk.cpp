// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/desk.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>

#include "client/shared/part_file.h"
#include "protocol/base/json.h"

namespace mote::client {
namespace {

constexpr std::string_view sessionTitle = "mote-view session 1";
constexpr std::string_view sessionEnding = ".session";
constexpr std::size_t keptSessions = 5;
constexpr std::uintmax_t largestSession = std::uintmax_t{256} << 20;

/// What of a view is work: not where one looks from, at which step and how large.
std::string workOf(proto::View view) {
    view.clear_camera();
    view.clear_width();
    view.clear_height();
    for (auto& layer : *view.mutable_layers()) {
        layer.clear_step();
        layer.clear_towards();
    }
    return view.SerializeAsString();
}

/// What panes do together, each by its word.
std::vector<std::pair<std::string_view, bool Links::*>> linkWords() {
    return {{"steps", &Links::steps}, {"selections", &Links::selections}, {"cameras", &Links::cameras}};
}

std::string wordsOf(const Links& links) {
    std::string words;
    for (const auto& [word, link] : linkWords()) {
        if (links.*link) words += (words.empty() ? "" : " ") + std::string(word);
    }
    return words;
}

/// Nothing of other words.
std::optional<Links> linksOf(const std::string& words) {
    Links links{false, false, false};
    std::istringstream in(words);
    for (std::string read; in >> read;) {
        const auto known = linkWords();
        const auto found = std::ranges::find(known, read, &decltype(known)::value_type::first);
        if (found == known.end()) return std::nullopt;
        links.*(found->second) = true;
    }
    return links;
}

}  // namespace

proto::View PaneState::view() const {
    proto::View view;
    view.ParseFromString(look);
    if (!camera.empty()) view.mutable_camera()->ParseFromString(camera);
    return view;
}

std::size_t DeskState::size() const {
    std::size_t bytes = sizeof(DeskState);
    for (const auto& pane : panes) bytes += sizeof(PaneState) + pane.look.size();
    return bytes;
}

std::size_t PaneCameras::size() const {
    std::size_t bytes = sizeof(PaneCameras);
    for (const auto& [id, camera] : all) bytes += 64 + camera.size();
    return bytes;
}

bool PaneCameras::operator==(const PaneCameras& other) const {
    return std::ranges::all_of(all, [&](const auto& each) {
        const auto found = other.all.find(each.first);
        return found == other.all.end() || found->second == each.second;
    });
}

PaneState Desk::seePane(const DeskPane& pane, std::uint64_t gesture) {
    auto& seen = panes_[pane.id];
    auto view = pane.model.edited();
    if (seen.mark.empty() || std::exchange(seen.subject, pane.subject) != pane.subject) {
        const auto known = kept_.find(pane.subject);
        seen.mark = known != kept_.end() ? known->second.mark : workOf(view);
    }
    seen.subject = pane.subject;
    if (std::exchange(seen.jumps, pane.model.jumps()) != pane.model.jumps()) seen.jumpGesture = gesture;
    seen.view = view;
    PaneState state{pane.id, pane.subject, {}, view.camera().SerializeAsString(), pane.model.isLoaded()};
    view.clear_camera();
    state.look = view.SerializeAsString();
    return state;
}

void Desk::look(std::span<const DeskPane> panes, std::size_t active, const Links& links,
                const FilmModel& film, std::uint64_t gesture) {
    if (panes[active].subject.empty() && !panes[active].model.isLoaded()) return;  // nothing is shown yet
    if (!film_ || film_->revision() != film.revision()) film_ = std::make_shared<const FilmModel>(film);
    for (const auto& pane : panes) {
        const auto known = panes_.find(pane.id);
        if (known != panes_.end() && known->second.subject != pane.subject) cameras_ = {};
    }
    std::erase_if(panes_, [&](const auto& seen) {
        return std::ranges::none_of(panes, [&](const auto& pane) { return pane.id == seen.first; });
    });
    DeskState state{{}, links, film_, named_};
    PaneCameras cameras = cameras_.empty() ? PaneCameras() : cameras_.present();
    for (const auto& pane : panes) {
        state.panes.push_back(seePane(pane, gesture));
        cameras.all[pane.id] = state.panes.back().camera;
    }
    const bool isPresent = !states_.empty() && states_.present() == state;
    for (std::size_t i = 0; i < state.panes.size(); ++i) {
        auto& pane = state.panes[i];
        pane.jumped = isPresent ? states_.present().panes[i].jumped : panes_[pane.id].jumpGesture == gesture;
    }
    cameras_.record(std::move(cameras), gesture);
    states_.record(state, gesture);
    active_ = active;
    if (isSeen(state)) return;
    keepViews(state);
    // Before the first gesture there is nothing to be kept.
    stale_ |= wasWorkedOn();
}

bool Desk::wasWorkedOn() const {
    return states_.canGoBack() || states_.canGoForward() || cameras_.canGoBack() || cameras_.canGoForward();
}

/// All of it is as it was when it was last looked at.
bool Desk::isSeen(const DeskState& state) {
    auto bytes = fmt::format("{} {}{}{} {}", active_, state.links.steps, state.links.selections,
                             state.links.cameras, film_->revision());
    for (const auto& pane : state.panes)
        bytes += fmt::format(" {} ", pane.id) + pane.subject + pane.look + pane.camera;
    return std::exchange(seen_, bytes) == bytes;
}

void Desk::keepViews(const DeskState& state) {
    order_.clear();
    for (const auto& pane : state.panes) {
        order_.push_back(pane.id);
        auto& seen = panes_[pane.id];
        const auto work = workOf(seen.view);
        if (adopted_) seen.mark = work;
        seen.unsaved = work != seen.mark;
    }
    adopted_ = false;
    links_ = state.links;
    const auto& active = panes_[order_[active_]];
    kept_[active.subject] = active;
}

/// Cameras stay where they are, but for what came with one of its own.
DeskState Desk::withCameras(const DeskState& from, bool back) const {
    auto state = states_.present();
    const auto& cameras = cameras_.present().all;
    for (auto& pane : state.panes) {
        const auto before = std::ranges::find(from.panes, pane.id, &PaneState::id);
        if (before != from.panes.end()) {
            if (!(back ? before->jumped : pane.jumped)) pane.camera = before->camera;
        } else if (const auto known = cameras.find(pane.id); known != cameras.end()) {
            pane.camera = known->second;
        }
    }
    return state;
}

std::optional<DeskState> Desk::undo() {
    if (!states_.canGoBack()) return std::nullopt;
    const auto from = states_.present();
    states_.back();
    return withCameras(from, true);
}

std::optional<DeskState> Desk::redo() {
    if (!states_.canGoForward()) return std::nullopt;
    const auto from = states_.present();
    states_.forward();
    return withCameras(from, false);
}

/// What differs in panes that are gone is not to be seen.
bool Desk::showsAnother(const PaneCameras& before) const {
    const auto& now = cameras_.present().all;
    return std::ranges::any_of(order_, [&](std::uint64_t id) {
        const auto one = before.all.find(id), other = now.find(id);
        return one != before.all.end() && other != now.end() && one->second != other->second;
    });
}

/// Where nothing else is to be seen, it stays where it is.
std::optional<PaneCameras> Desk::goToCameras(bool back) {
    if (cameras_.empty()) return std::nullopt;
    const auto step = [this](bool backwards) { backwards ? cameras_.back() : cameras_.forward(); };
    const auto before = cameras_.present();
    int steps = 0;
    for (; back ? cameras_.canGoBack() : cameras_.canGoForward(); ++steps) {
        step(back);
        if (showsAnother(before)) return cameras_.present();
    }
    for (; steps > 0; --steps) step(!back);
    return std::nullopt;
}

const proto::View* Desk::kept(const std::string& dataset) const {
    const auto found = kept_.find(dataset);
    return found != kept_.end() ? &found->second.view : nullptr;
}

void Desk::saved() {
    if (order_.empty()) return;
    const auto& active = panes_[order_[active_]];
    const auto work = workOf(active.view), subject = active.subject;
    for (auto& [id, pane] : panes_) {
        if (pane.subject != subject || workOf(pane.view) != work) continue;
        pane.mark = work;
        pane.unsaved = false;
    }
    kept_[subject] = active;
}

void Desk::filmSaved() {
    if (film_) filmMark_ = film_->revision();
}

std::vector<std::string> Desk::unsaved() const {
    std::set<std::string> datasets;
    for (const auto& [name, kept] : kept_) {
        if (kept.unsaved) datasets.insert(name);
    }
    for (const auto& [id, pane] : panes_) {
        if (pane.unsaved) datasets.insert(pane.subject);
    }
    std::vector<std::string> names(datasets.begin(), datasets.end());
    if (film_ && !film_->empty() && film_->revision() != filmMark_) names.emplace_back("film");
    return names;
}

void Desk::keepIn(const std::filesystem::path& folder, const std::string& key) {
    file_ = folder / fmt::format("{}-{}{}", key, getpid(), sessionEnding);
}

Status Desk::writeFile() {
    stale_ = false;
    const auto subject = order_.empty() ? std::string() : panes_.at(order_[active_]).subject;
    std::string text = fmt::format("{}\nsubject {}\n", sessionTitle, subject);
    for (const auto& [name, kept] : kept_) text += fmt::format("view {}\n{}\n", name, toJsonLine(kept.view));
    if (order_.size() > 1) text += fmt::format("panes {}\n{}\n", active_, wordsOf(links_));
    for (std::size_t i = 0; i < order_.size() && order_.size() > 1; ++i) {
        const auto& pane = panes_.at(order_[i]);
        text += fmt::format("pane {}\n{}\n", pane.subject, toJsonLine(pane.view));
    }
    if (film_ && !film_->empty()) text += fmt::format("film\n{}\n", toJsonLine(film_->saved()));
    std::error_code code;
    std::filesystem::create_directories(file_.parent_path(), code);
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(file_));
    MOTE_RETURN_IF_ERROR(part->append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
    return part->publish();
}

void Desk::adopt(const Session& session) {
    if (!wasWorkedOn()) kept_.clear();
    for (const auto& [name, view] : session.views) kept_[name] = {name, view, workOf(view)};
    adopted_ = stale_ = true;
    seen_.clear();
}

std::filesystem::path sessionFolder() {
    const char* state = std::getenv("XDG_STATE_HOME");
    if (state != nullptr && state[0] == '/') return std::filesystem::path(state) / "mote";
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : ".") / ".local/state/mote";
}

std::string sessionKey(const std::filesystem::path& of) {
    std::error_code code;
    auto path = std::filesystem::weakly_canonical(of, code);
    if (code) path = of;
    std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
    for (const char letter : path.string())
        hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211ULL;
    return fmt::format("{:016x}", hash);
}

std::optional<Session> lastSession(const std::filesystem::path& folder, const std::string& key) {
    std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> ended;
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {
        const auto name = entry.path().filename().string();
        if (!name.starts_with(key + "-") || !name.ends_with(sessionEnding)) continue;
        pid_t process = 0;
        std::from_chars(name.data() + key.size() + 1, name.data() + name.size(), process);
        if (process > 0 && process != getpid() && kill(process, 0) == 0) continue;  // it is at work
        ended.emplace_back(entry.last_write_time(code), entry.path());
    }
    std::ranges::sort(ended, std::greater<>());
    for (std::size_t i = keptSessions; i < ended.size(); ++i) std::filesystem::remove(ended[i].second, code);
    for (const auto& each : ended) {
        if (auto session = readSession(each.second); session.ok() && !session->views.empty()) return *session;
    }
    return std::nullopt;
}

Result<Session> readSession(const std::filesystem::path& file) {
    std::error_code code;
    if (std::filesystem::file_size(file, code) > largestSession || code)
        return invalid(file.string(), "this cannot be read as a session of mote-view");
    std::ifstream in(file, std::ios::binary);
    std::string line, json;
    if (!std::getline(in, line) || line != sessionTitle)
        return invalid(file.string(), "this is no session of mote-view");
    Session session;
    session.file = file;
    session.time = std::filesystem::last_write_time(file, code);
    while (std::getline(in, line)) {
        if (line.starts_with("subject ")) {
            session.subject = line.substr(8);
        } else if (line.starts_with("view ") && std::getline(in, json)) {
            MOTE_RETURN_IF_ERROR(parseJson(json, session.views[line.substr(5)], file.string()));
        } else if (line.starts_with("panes ") && std::getline(in, json)) {
            const auto end = line.data() + line.size();
            const auto read = std::from_chars(line.data() + 6, end, session.active);
            const auto links = linksOf(json);
            if (read.ec != std::errc() || read.ptr != end || !links)
                return invalid(file.string(), "its panes are not said as mote-view says them");
            session.links = *links;
        } else if (line.starts_with("pane ") && std::getline(in, json)) {
            auto& pane = session.panes.emplace_back(Session::Pane{line.substr(5), {}});
            MOTE_RETURN_IF_ERROR(parseJson(json, pane.view, file.string()));
        } else if (line == "film" && std::getline(in, json)) {
            MOTE_RETURN_IF_ERROR(parseJson(json, session.film.emplace(), file.string()));
        } else {
            return invalid(file.string(), "a line of this session says nothing that is known");
        }
    }
    const auto count = session.panes.size();
    if (count > mostPanes || session.active >= std::max<std::size_t>(count, 1))
        return invalid(file.string(), "it has other panes than a window of mote-view");
    return session;
}

}  // namespace mote::client
