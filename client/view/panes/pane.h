// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pane: a part of the window with a view of its own: what is shown in it, what of that was asked for, and the
// picture that came. Panes: those of a window. Owned by the viewer; main thread; with the window's context
// current once there is a picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "client/view/desk.h"
#include "client/view/over_picture.h"
#include "client/view/panes/links.h"
#include "client/view/view_model.h"
#include "client/view/window.h"

namespace mote::client {

class Pane {
  public:
    explicit Pane(std::uint64_t number) : id(number) {}

    /// Wants what is shown, which differs from what was asked for last, or is as large no more, or is held no
    /// more. True if it asks.
    bool needs(const PictureArea& area, bool moving) const;
    void ask(Connection& line, proto::View view, const PictureArea& area, bool moving);
    /// Something was asked for over this line.
    bool isAsked() const { return firstView_ != 0; }
    /// What is said of a view is said of what this pane asked for.
    bool hears(std::uint64_t view) const { return firstView_ != 0 && view >= firstView_; }
    /// Shows it from now on, if it is of a view of its own.
    void take(ReceivedFrame frame);
    /// The line is another one: what was asked for does not come.
    void forgetAsked();
    /// The picture on the screen is of the latest view; and is the exact one.
    bool isSeen() const { return frame && frame->view_id() == askedView_; }
    bool isStill() const { return isSeen() && frame->final() && !dirty; }
    void drawPicture(const PictureArea& area) const;
    /// Shows the same as another.
    void copy(const Pane& other);

    const std::uint64_t id;  ///< that no other pane has or had
    std::string subject;     ///< the dataset for which its view was begun
    ViewModel model;
    std::shared_ptr<const proto::Description> shown;  ///< of the dataset of the chosen layer
    std::shared_ptr<const proto::Frame> frame;        ///< header of the picture on the screen
    FramePixels picture;                              ///< that picture
    std::optional<Camera> fitted;                     ///< what F made
    std::string failure;                              ///< why there is no picture of the latest view
    bool dirty = true;                                ///< the model differs from what was asked for

  private:
    std::unique_ptr<PictureTexture> texture_;
    std::uint64_t askedView_ = 0;  // id of the latest
    std::uint64_t firstView_ = 0;  // and of the first over this line; 0: none was asked for
    bool askedMoving_ = false;     // it was announced as moving
    bool askedFitted_ = false;     // it left the camera to the server
    std::uint32_t askedColumns_ = 0, askedRows_ = 0;
};

class Panes {
  public:
    /// One pane, over the first line. `further` makes another line.
    Panes(Connection& first, std::function<std::unique_ptr<Connection>()> further);

    std::size_t size() const { return panes_.size(); }
    Pane& operator[](std::size_t index) { return *panes_[index]; }
    const Pane& operator[](std::size_t index) const { return *panes_[index]; }
    Pane& active() { return *panes_[active_]; }
    const Pane& active() const { return *panes_[active_]; }
    std::size_t activeIndex() const { return active_; }
    /// `index` is below size().
    void activate(std::size_t index) { active_ = index; }
    /// Whose steps are played: the active one, or the first that has several.
    Pane& timed() { return *panes_[timedIndex()]; }
    const Pane& timed() const { return *panes_[timedIndex()]; }
    /// Null: there is no such pane.
    Pane* find(std::uint64_t id);

    /// There are so many, 1 to mostPanes: new ones show what the active one shows, which stays.
    void setCount(std::size_t count);
    /// There are those of a state, in its order; new ones show nothing yet.
    void setIds(const std::vector<PaneState>& state);

    /// The line over which a pane's pictures come.
    Connection& line(std::size_t index);
    /// Their callbacks run; a failure of a view is the pane's.
    void pollFurther();
    void reconnectFurther();

    /// The active one's edits are the others' too, as far as links say; those that change are dirty.
    void follow();
    /// What links say holds from now on.
    void setLinks(const Links& links);
    /// The same, of a state in which each pane has its own part of it.
    void restoreLinks(const Links& links) { links_ = links; }
    const Links& links() const { return links_; }
    std::vector<DeskPane> looked() const;

  private:
    std::size_t timedIndex() const;
    std::vector<ViewModel*> others(std::size_t than, std::vector<Pane*>& of) const;
    void keepLines(const std::vector<std::uint64_t>& before);

    Connection& first_;
    const std::function<std::unique_ptr<Connection>()> makeLine_;
    std::vector<std::unique_ptr<Pane>> panes_;
    std::vector<std::unique_ptr<Connection>> further_;  // of the second pane and those after it
    std::uint64_t ids_ = 0;                             // that were given
    std::size_t active_ = 0;
    Links links_;
    LinkedViews linked_, linkedTime_;  // the other one: of a pane that is played and not active
};

/// What bounds the stream on a line that is paid for: pictures of half the size each way, at rest too, and no
/// more than a few a second while a hand moves them.
class DataSaver {
  public:
    static constexpr double shareOfSide = 0.5, pause = 0.25;  // seconds between two views that are asked for

    bool on = false;

    /// What a pane's pictures are asked for at.
    PictureArea asked(PictureArea area) const;
    /// Lengths that a view says in pixels stay as large as they are seen.
    void scale(proto::View& view) const;
    /// Whether it is too soon for another picture of a view in motion; all panes are asked for at one time.
    bool waits(double now, bool moving) const { return on && moving && now != last_ && now < last_ + pause; }
    void note(double now) { last_ = now; }
    /// What it does, and `bytes` that have come so far.
    std::string said(const PictureArea& area, std::uint64_t bytes) const;

  private:
    double last_ = -1.0;  // seconds, when a picture was asked for
};

/// Letters that grow with the picture stay large enough in a small one to be read on the screen.
void keepLettersReadable(proto::View& view, const PictureArea& area);
/// Where a pane lies of so many in the picture, a thin line apart; 2 side by side, 4 as 2 x 2.
PictureArea paneArea(const PictureArea& whole, std::size_t index, std::size_t count);
/// Draws what tells panes apart: a frame around the active one, and what of a pane cannot go along with it.
void drawPaneFrames(const Panes& panes, const PictureArea& whole);

}  // namespace mote::client
