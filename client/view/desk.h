// SPDX-License-Identifier: GPL-3.0-or-later
//
// Desk: all that the user works on as one value (the panes with their views and cameras, the film, cameras
// with names), what it
// was before, what it was for each dataset, and a file of it that outlives the viewer. It looks at the value
// whenever a frame ends, so nothing that edits it need know of it. Main thread; no window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/view/film/film_model.h"
#include "client/view/hand/named_cameras.h"
#include "client/view/panes/links.h"
#include "client/view/view_model.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// History: values that one thing had, the present one, and those that were taken back. What one gesture
/// changes, as long as it lasts, is one step. A value's size() is in bytes; the oldest go when all take too
/// much.
template <class Value>
class History {
  public:
    static constexpr std::size_t mostSteps = 5000, mostBytes = std::size_t{256} << 20;

    /// The thing has this value now; gestures have ascending numbers.
    void record(Value value, std::uint64_t gesture) {
        if (!steps_.empty() && present() == value) {
            steps_[at_].value = std::move(value);  // equal, but for what does not count
            return;
        }
        while (steps_.size() > at_ + 1) drop(steps_.size() - 1);
        if (!steps_.empty() && steps_.back().gesture == gesture) drop(at_);
        if (steps_.empty() || !(steps_.back().value == value)) {
            bytes_ += value.size();
            steps_.push_back({std::move(value), gesture});
        }
        while (steps_.size() > 1 && (steps_.size() > mostSteps || bytes_ > mostBytes)) drop(0);
        at_ = steps_.size() - 1;
    }

    bool empty() const { return steps_.empty(); }
    const Value& present() const { return steps_[at_].value; }
    bool canGoBack() const { return at_ > 0; }
    bool canGoForward() const { return at_ + 1 < steps_.size(); }
    void back() { at_ -= canGoBack() ? 1 : 0; }
    void forward() { at_ += canGoForward() ? 1 : 0; }

  private:
    struct Step {
        Value value;
        std::uint64_t gesture;
    };

    void drop(std::size_t index) {
        bytes_ -= steps_[index].value.size();
        steps_.erase(steps_.begin() + static_cast<std::ptrdiff_t>(index));
    }

    std::vector<Step> steps_;
    std::size_t at_ = 0;
    std::size_t bytes_ = 0;
};

/// A window has at most so many panes.
inline constexpr std::size_t mostPanes = 4;

/// A pane of the window, as it is looked at.
struct DeskPane {
    std::uint64_t id;  ///< that no other pane has or had
    std::string subject;
    const ViewModel& model;
};

/// And as it was.
struct PaneState {
    std::uint64_t id = 0;
    std::string subject;    ///< the dataset for which it was begun
    std::string look;       ///< the view without its camera, as bytes
    std::string camera;     ///< of the view, as bytes; empty: fitted. It has a history of its own
    bool fromFile = false;  ///< the view is one that was opened
    bool jumped = false;    ///< it came in place of the state before, camera and all

    proto::View view() const;
    bool operator==(const PaneState& other) const {
        return id == other.id && subject == other.subject && look == other.look;
    }
};

struct DeskState {
    std::vector<PaneState> panes;
    Links links;
    std::shared_ptr<const FilmModel> film;
    std::shared_ptr<const NamedCameras> named;  ///< cameras

    std::size_t size() const;
    bool operator==(const DeskState& other) const {
        return panes == other.panes && links == other.links && film->revision() == other.film->revision() &&
               *named == *other.named;
    }
};

/// The cameras of all panes that there were, as bytes, by their ids; empty: fitted.
struct PaneCameras {
    std::map<std::uint64_t, std::string> all;

    std::size_t size() const;
    /// A pane that one of them does not know counts for nothing.
    bool operator==(const PaneCameras& other) const;
};

/// What a viewer that ended left behind.
struct Session {
    struct Pane {
        std::string subject;
        proto::View view;
    };
    std::string subject;                       ///< of the active pane
    std::map<std::string, proto::View> views;  ///< by the dataset for which each was begun
    std::vector<Pane> panes;                   ///< if there was more than one
    std::size_t active = 0;                    ///< which of them
    Links links;
    std::optional<proto::Script> film;
    std::filesystem::file_time_type time;
    std::filesystem::path file;
};

class Desk {
  public:
    /// Looks at how things stand, at the end of a frame that belongs to a gesture. There is a pane at least;
    /// `active` is one of them.
    void look(std::span<const DeskPane> panes, std::size_t active, const Links& links, const FilmModel& film,
              std::uint64_t gesture);
    /// Those of the state that is looked at next.
    void nameCameras(std::shared_ptr<const NamedCameras> cameras) { named_ = std::move(cameras); }

    // Each returns what is to be shown, or nothing where there is no more. What a state came to by a jump is
    // left with its camera; else the camera stays.

    std::optional<DeskState> undo();
    std::optional<DeskState> redo();
    /// The cameras that were before, or after, in one pane at least of those that there are.
    std::optional<PaneCameras> cameraBack() { return goToCameras(true); }
    std::optional<PaneCameras> cameraForward() { return goToCameras(false); }

    /// What was last seen of a dataset's view in the pane that was active.
    const proto::View* kept(const std::string& dataset) const;

    /// What the active pane shows now is in a file of the user's.
    void saved();
    void filmSaved();
    /// Datasets whose views, and "film", if it, have changed since they were opened or saved. Steps and
    /// cameras are no work.
    std::vector<std::string> unsaved() const;

    // The file, "KEY-PROCESS.session" in a folder.

    /// Keeps all in it from now on.
    void keepIn(const std::filesystem::path& folder, const std::string& key);
    /// It differs from what is there now.
    bool isStale() const { return stale_ && !file_.empty(); }
    Status writeFile();
    /// Takes what a session has, as if it had been seen here.
    void adopt(const Session& session);

  private:
    struct Kept {
        std::string subject;
        proto::View view;
        std::string mark;  // of its work, when it was opened or saved
        bool unsaved = false;
    };
    struct SeenPane : Kept {
        std::uint64_t jumps = 0;
        std::optional<std::uint64_t> jumpGesture;  // of the last
    };

    PaneState seePane(const DeskPane& pane, std::uint64_t gesture);
    bool isSeen(const DeskState& state);
    bool wasWorkedOn() const;
    void keepViews(const DeskState& state);
    DeskState withCameras(const DeskState& from, bool back) const;
    std::optional<PaneCameras> goToCameras(bool back);
    bool showsAnother(const PaneCameras& before) const;

    History<DeskState> states_;
    History<PaneCameras> cameras_;
    std::map<std::string, Kept> kept_;         // by subject
    std::map<std::uint64_t, SeenPane> panes_;  // those that there are
    std::vector<std::uint64_t> order_;         // of them
    std::size_t active_ = 0;
    Links links_;
    std::shared_ptr<const NamedCameras> named_ = std::make_shared<const NamedCameras>();
    bool adopted_ = false;  // what is seen next is as a session had it
    std::shared_ptr<const FilmModel> film_;
    std::uint64_t filmMark_ = 0;  // revision
    std::string seen_;            // all of it, when it was last looked at, as bytes
    std::filesystem::path file_;
    bool stale_ = false;
};

/// Where sessions lie: $XDG_STATE_HOME/mote, or ~/.local/state/mote.
std::filesystem::path sessionFolder();
/// A name for what a viewer is of: a connection file or a folder.
std::string sessionKey(const std::filesystem::path& of);
/// The latest that a viewer with this key left which runs no more; all but the latest few are removed.
std::optional<Session> lastSession(const std::filesystem::path& folder, const std::string& key);
/// Errors: readJsonFile's, corrupt.
Result<Session> readSession(const std::filesystem::path& file);

}  // namespace mote::client
