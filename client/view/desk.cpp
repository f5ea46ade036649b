// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/desk.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "client/shared/part_file.h"
#include "protocol/scene/json.h"

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

}  // namespace

proto::View DeskState::view() const {
    proto::View view;
    view.ParseFromString(look);
    if (!camera.empty()) view.mutable_camera()->ParseFromString(camera);
    return view;
}

void Desk::look(const ViewModel& model, const FilmModel& film, std::uint64_t gesture) {
    if (subject_.empty() && !model.isLoaded()) return;  // nothing is shown yet
    auto view = model.edited();
    auto& kept = kept_[subject_];
    if (kept.mark.empty()) kept.mark = workOf(view);
    if (!film_ || film_->revision() != film.revision()) film_ = std::make_shared<const FilmModel>(film);
    DeskState state{subject_, {}, view.camera().SerializeAsString(), model.isLoaded(), false, film_};
    if (!states_.empty() && states_.present().subject != subject_) cameras_ = {};
    if (std::exchange(jumps_, model.jumps()) != model.jumps()) jumpGesture_ = gesture;
    auto whole = view;
    view.clear_camera();
    state.look = view.SerializeAsString();
    const bool isPresent = !states_.empty() && states_.present() == state;
    state.jumped = isPresent ? states_.present().jumped : jumpGesture_ == gesture;
    cameras_.record(state.camera, gesture);
    states_.record(std::move(state), gesture);
    auto bytes = subject_ + whole.SerializeAsString() + std::to_string(film_->revision());
    if (std::exchange(seen_, bytes) == bytes) return;
    kept.view = std::move(whole);
    kept.unsaved = workOf(kept.view) != kept.mark;
    // Before the first gesture there is nothing to be kept.
    stale_ |=
        states_.canGoBack() || states_.canGoForward() || cameras_.canGoBack() || cameras_.canGoForward();
}

std::optional<DeskState> Desk::undo() {
    if (!states_.canGoBack()) return std::nullopt;
    const auto from = states_.present();
    states_.back();
    auto state = states_.present();
    if (!from.jumped) state.camera = from.camera;
    return state;
}

std::optional<DeskState> Desk::redo() {
    if (!states_.canGoForward()) return std::nullopt;
    const auto from = states_.present();
    states_.forward();
    auto state = states_.present();
    if (!state.jumped) state.camera = from.camera;
    return state;
}

std::optional<std::string> Desk::cameraBack() {
    if (!cameras_.canGoBack()) return std::nullopt;
    cameras_.back();
    return cameras_.present();
}

std::optional<std::string> Desk::cameraForward() {
    if (!cameras_.canGoForward()) return std::nullopt;
    cameras_.forward();
    return cameras_.present();
}

const proto::View* Desk::kept(const std::string& dataset) const {
    const auto found = kept_.find(dataset);
    return found != kept_.end() ? &found->second.view : nullptr;
}

void Desk::saved() {
    auto& kept = kept_[subject_];
    kept.mark = workOf(kept.view);
    kept.unsaved = false;
}

void Desk::filmSaved() {
    if (film_) filmMark_ = film_->revision();
}

std::vector<std::string> Desk::unsaved() const {
    std::vector<std::string> names;
    for (const auto& [name, kept] : kept_) {
        if (kept.unsaved) names.push_back(name);
    }
    if (film_ && !film_->empty() && film_->revision() != filmMark_) names.emplace_back("film");
    return names;
}

void Desk::keepIn(const std::filesystem::path& folder, const std::string& key) {
    file_ = folder / fmt::format("{}-{}{}", key, getpid(), sessionEnding);
}

Status Desk::writeFile() {
    stale_ = false;
    std::string text = fmt::format("{}\nsubject {}\n", sessionTitle, subject_);
    for (const auto& [name, kept] : kept_) text += fmt::format("view {}\n{}\n", name, toJsonLine(kept.view));
    if (film_ && !film_->empty()) text += fmt::format("film\n{}\n", toJsonLine(film_->saved()));
    std::error_code code;
    std::filesystem::create_directories(file_.parent_path(), code);
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(file_));
    MOTE_RETURN_IF_ERROR(part->append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
    return part->publish();
}

void Desk::adopt(const Session& session) {
    for (const auto& [name, view] : session.views) kept_[name] = {view, workOf(view), false};
    subject_ = session.subject;
    stale_ = true;
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
        } else if (line == "film" && std::getline(in, json)) {
            MOTE_RETURN_IF_ERROR(parseJson(json, session.film.emplace(), file.string()));
        } else {
            return invalid(file.string(), "a line of this session says nothing that is known");
        }
    }
    return session;
}

}  // namespace mote::client
