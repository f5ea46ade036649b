// SPDX-License-Identifier: GPL-3.0-or-later
//
// NamedCameras: places to look from that the user gave names, by dataset: a value, which the desk takes back
// as any other. CameraShelf: those of a viewer, and the file of them that outlives it. CameraGlide: the short
// way from one camera to another. Main thread; no window.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/camera.h"

namespace mote::client {

struct NamedCamera {
    static constexpr std::size_t maxNameBytes = 64;

    std::string name;  ///< one line of UTF-8, not empty
    Camera camera;

    bool operator==(const NamedCamera&) const = default;
};

/// By the dataset for which a view was begun, in the user's order.
using NamedCameras = std::map<std::string, std::vector<NamedCamera>>;

/// What is to be done with one of them, or with the camera that is seen by.
struct CameraWish {
    enum class What { keep, go, replace, rename, remove } what;
    std::size_t index = 0;  ///< of all but `keep`
    std::string name = {};  ///< of `keep` and `rename`; empty: one that is free
};

class CameraShelf {
  public:
    CameraShelf();

    /// Keeps them in a file from now on, and takes what it has. Errors: invalidArgument, corrupt; the file
    /// then stays as it is, and nothing is kept.
    Status keepIn(const std::filesystem::path& file);

    std::span<const NamedCamera> of(const std::string& dataset) const;
    /// All but `go`. Errors: invalidArgument (a name that is none), as PartFile's (what was wished is done,
    /// but not kept).
    Status apply(const std::string& dataset, const CameraWish& wish, const Camera& present);

    // As a state of the desk.

    std::shared_ptr<const NamedCameras> state() const { return all_; }
    /// Errors: PartFile's.
    Status restore(std::shared_ptr<const NamedCameras> state);

  private:
    Status write();

    std::shared_ptr<const NamedCameras> all_;
    std::set<std::string> changed_;  // datasets that the file has otherwise
    std::filesystem::path file_;     // empty: none
};

/// A file's content, and back. Errors: corrupt, as parseJson's and parseCamera's.
std::string writtenCameras(const NamedCameras& cameras);
Result<NamedCameras> readCameras(const std::string& text, const std::string& source);

class CameraGlide {
  public:
    static constexpr double seconds = 0.35;

    void begin(const Camera& from, const Camera& to, double now);
    void end() { way_.reset(); }
    bool underWay() const { return way_.has_value(); }
    /// The camera at `now` seconds, at last exactly where it goes. `seen`: the present one; if it is not what
    /// this returned last, somebody else moves it, and the glide ends. Nothing: there is none.
    std::optional<Camera> next(double now, const Camera& seen);

  private:
    struct Way {
        Camera from, to, last;
        double begun;  // seconds
    };
    std::optional<Way> way_;
};

}  // namespace mote::client
