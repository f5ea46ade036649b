// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/hand/named_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <utility>

#include "client/shared/part_file.h"
#include "protocol/base/json.h"
#include "protocol/base/utf8.h"
#include "protocol/scene/film/camera_path.h"
#include "protocol/scene/film/easing.h"

namespace mote::client {
namespace {

constexpr std::string_view camerasTitle = "mote-view cameras 1";

bool isName(const std::string& name) {
    const bool oneLine =
        std::ranges::none_of(name, [](char letter) { return static_cast<unsigned char>(letter) < 0x20; });
    return !name.empty() && name.size() <= NamedCamera::maxNameBytes && oneLine && isUtf8(name);
}

/// "camera 3", the first that no other has.
std::string freeName(const std::vector<NamedCamera>& others) {
    for (std::size_t number = 1;; ++number) {
        auto name = fmt::format("camera {}", number);
        if (std::ranges::find(others, name, &NamedCamera::name) == others.end()) return name;
    }
}

}  // namespace

CameraShelf::CameraShelf() : all_(std::make_shared<const NamedCameras>()) {}

Status CameraShelf::keepIn(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (in) {
        std::ostringstream text;
        text << in.rdbuf();
        MOTE_ASSIGN_OR_RETURN(auto read, readCameras(text.str(), file.string()));
        all_ = std::make_shared<const NamedCameras>(std::move(read));
    }
    file_ = file;
    return success();
}

std::span<const NamedCamera> CameraShelf::of(const std::string& dataset) const {
    const auto found = all_->find(dataset);
    return found != all_->end() ? std::span<const NamedCamera>(found->second)
                                : std::span<const NamedCamera>();
}

Status CameraShelf::apply(const std::string& dataset, const CameraWish& wish, const Camera& present) {
    using What = CameraWish::What;
    auto all = *all_;
    auto& cameras = all[dataset];
    const bool names = wish.what == What::keep || wish.what == What::rename;
    const auto name = names && wish.name.empty() ? freeName(cameras) : wish.name;
    if (names && !isName(name))
        return invalid("camera",
                       fmt::format("a name has 1 to {} bytes and one line", NamedCamera::maxNameBytes));
    if (wish.what == What::keep) {
        const auto same = std::ranges::find(cameras, name, &NamedCamera::name);
        if (same == cameras.end()) {
            cameras.push_back({name, present});
        } else {
            same->camera = present;
        }
    } else if (wish.index < cameras.size()) {
        auto& camera = cameras[wish.index];
        if (wish.what == What::replace) camera.camera = present;
        if (wish.what == What::rename) camera.name = name;
        if (wish.what == What::remove)
            cameras.erase(cameras.begin() + static_cast<std::ptrdiff_t>(wish.index));
    }
    return restore(std::make_shared<const NamedCameras>(std::move(all)));
}

Status CameraShelf::restore(std::shared_ptr<const NamedCameras> state) {
    const auto has = [](const NamedCameras& all, const std::string& dataset) {
        const auto found = all.find(dataset);
        return found != all.end() ? found->second : std::vector<NamedCamera>();
    };
    for (const auto* side : {all_.get(), state.get()}) {
        for (const auto& [dataset, cameras] : *side) {
            if (has(*all_, dataset) != has(*state, dataset)) changed_.insert(dataset);
        }
    }
    all_ = std::move(state);
    return write();
}

/// What another viewer has kept meanwhile of other datasets stays.
Status CameraShelf::write() {
    if (file_.empty() || changed_.empty()) return success();
    CameraShelf there;
    MOTE_RETURN_IF_ERROR(there.keepIn(file_));
    auto merged = *there.all_;
    for (const auto& dataset : changed_) {
        const auto cameras = of(dataset);
        merged[dataset].assign(cameras.begin(), cameras.end());
    }
    const auto text = writtenCameras(merged);
    std::error_code code;
    std::filesystem::create_directories(file_.parent_path(), code);
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(file_));
    MOTE_RETURN_IF_ERROR(part->append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
    MOTE_RETURN_IF_ERROR(part->publish());
    changed_.clear();
    return success();
}

std::string writtenCameras(const NamedCameras& cameras) {
    auto text = fmt::format("{}\n", camerasTitle);
    for (const auto& [dataset, named] : cameras) {
        if (!named.empty()) text += fmt::format("dataset {}\n", dataset);
        for (const auto& each : named)
            text += fmt::format("camera {}\n{}\n", each.name, toJsonLine(toProto(each.camera)));
    }
    return text;
}

Result<NamedCameras> readCameras(const std::string& text, const std::string& source) {
    std::istringstream in(text);
    std::string line, json;
    if (!std::getline(in, line) || line != camerasTitle)
        return corrupt(source, "this is no file of cameras of mote-view");
    NamedCameras all;
    std::vector<NamedCamera>* of = nullptr;
    while (std::getline(in, line)) {
        if (line.starts_with("dataset ")) {
            of = &all[line.substr(8)];
            continue;
        }
        if (of == nullptr || !line.starts_with("camera ") || !isName(line.substr(7)) ||
            !std::getline(in, json))
            return corrupt(source, "a line of it says nothing that is known");
        proto::Camera message;
        MOTE_RETURN_IF_ERROR(parseJson(json, message, source));
        MOTE_ASSIGN_OR_RETURN(const auto camera, parseCamera(message));
        of->push_back({line.substr(7), camera});
    }
    return all;
}

void CameraGlide::begin(const Camera& from, const Camera& to, double now) {
    way_ = Way{from, to, from, now};
}

std::optional<Camera> CameraGlide::next(double now, const Camera& seen) {
    if (!way_) return std::nullopt;
    if (!(seen == way_->last)) {
        end();
        return std::nullopt;
    }
    const double share = (now - way_->begun) / seconds;
    if (!(share < 1.0) || way_->from == way_->to) return std::exchange(way_, {})->to;
    const std::array<CameraPath::Stop, 2> stops{{{0.0, way_->from}, {1.0, way_->to}}};
    way_->last = CameraPath(stops).at(0, eased(Easing::smooth, std::max(share, 0.0)));
    return way_->last;
}

}  // namespace mote::client
