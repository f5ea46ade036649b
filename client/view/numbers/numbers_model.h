// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumbersModel: what the user sets of a view's numbers: its named selections, which of them is highlighted or
// shown alone, by what points are coloured, whose paths are drawn, what is written beside the picture. Read
// out of a view and written into one, like a layer's editor. A value that is free of any window; what it
// writes is valid.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/view/numbers/selection_edits.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// By what points and volume are coloured, as controls hold it.
struct ColorByControls {
    std::string column;     ///< empty: as the layer says
    bool ownRange = false;  ///< else what most of the column over all steps lies in
    double low = 0.0, high = 1.0;
    std::string colorMap = "viridis";
    std::string ofPixel;  ///< of a pixel's points "nearest" or "mean"; empty: by how opaque they are
};

/// The named selections, and which of them is highlighted, how: what views of one dataset have together.
struct SelectionsShown {
    NamedSelectionMessages named;
    std::string highlighted;  ///< a name; empty: none
    std::array<float, 3> color{};
    float size = 0.0F, opacity = 1.0F;
};
bool operator==(const SelectionsShown& one, const SelectionsShown& other);

class NumbersModel {
  public:
    /// Every default.
    NumbersModel();

    /// Takes a view that has been parsed without error. The chosen selection stays, if there is one of its
    /// name.
    void read(const proto::View& view, int layer = 0);
    /// Selections and annotations of the view; the rest of the layer that was read, which has it where it
    /// is of particles; and what a user has shown of a selection, in all layers of its dataset.
    void write(proto::View& view) const;
    /// Shows another dataset: what it has no columns or ids for is not shown of it.
    void setDataset(const proto::ParticlesManifest& manifest);

    const NamedSelectionMessages& selections() const { return selections_; }
    /// That the panel edits; none if there are none.
    std::optional<std::size_t> chosen() const { return chosen_; }
    const proto::NamedSelection* chosenSelection() const;
    void choose(std::size_t index);
    /// Without names: what a query can ask. None if none is chosen.
    std::optional<proto::Selection> chosenWhole() const;

    // Each edit that would leave no valid list is refused, and nothing changes. Errors as
    // parseNamedSelections().

    /// A gesture's, alone or with the chosen one. If it is a new one it is highlighted, its name begins as
    /// `wish`.
    Status take(const proto::Selection& gesture, Combine how, const std::string& wish);
    Status replace(std::size_t index, const proto::Selection& selection);
    Status rename(std::size_t index, const std::string& name);
    /// Errors: also invalidArgument if another selection names it.
    Status remove(std::size_t index);

    // Which of them is shown, by name; empty: none.

    const std::string& highlighted() const { return highlighted_; }
    const std::string& alone() const { return alone_; }
    void highlight(const std::string& name);
    void showAlone(const std::string& name);

    SelectionsShown shown() const;
    /// Takes over what changed in another view of the dataset; what that leaves alone stays. False where
    /// nothing changes, also because something else here needs a selection that went.
    bool follow(const SelectionsShown& before, const SelectionsShown& now);

    std::array<float, 3> highlightColor{};  ///< sRGB-encoded
    float highlightSize = 0.0F;             ///< pixels; 0: the layer's
    float highlightOpacity = 1.0F;

    ColorByControls colorBy;
    proto::Annotations annotations;

    const std::vector<std::uint64_t>& pathIds() const { return pathIds_; }
    /// Errors: invalidArgument if there are as many as a layer may have.
    Status addPath(std::uint64_t id);
    void forgetPaths() { pathIds_.clear(); }
    float pathWidth = 0.0F;  ///< pixels

  private:
    Status accept(NamedSelectionMessages edited);
    std::string keepNamed(const proto::Selection& selection, const std::string& wish);
    /// A layer's own still: it was given a name here, and nothing else goes by that.
    bool isUnnamed(const std::string& name) const;
    /// As a layer says it.
    proto::Selection selectionOf(const std::string& name) const;
    void writeLayer(proto::Layer& layer) const;
    void writeShown(proto::Layer& layer) const;

    int layer_ = 0;  // of the view, that it is about
    NamedSelectionMessages selections_;
    std::optional<std::size_t> chosen_;
    std::string highlighted_, alone_;
    std::set<std::string> given_;  // names of selections that layers hold themselves
    bool shownByUser_ = false;     // of the two, since the view was read
    std::vector<std::uint64_t> pathIds_;
    std::optional<std::array<float, 3>> pathColor_;
};

}  // namespace mote::client
