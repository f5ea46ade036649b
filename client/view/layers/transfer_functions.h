// SPDX-License-Identifier: GPL-3.0-or-later
//
// TransferFunctions: the two curves that the user drags. Linked, an edit of one is the opposite edit of the
// other (section 3.3.3 of the dissertation). Until the user edits them they are the plot's own, which a view
// leaves out. A value, free of any window.
#pragma once

#include <cstddef>
#include <vector>

#include "client/view/knot_curve.h"
#include "protocol/mote.pb.h"

namespace mote::client {

class TransferFunctions {
  public:
    enum class Which { volume, points };

    TransferFunctions();

    /// Volume opacity or point fraction over scaled log density, as drawn.
    const std::vector<Curve::Knot>& knots(Which which) const {
        return which == Which::volume ? volume_.knots() : points_.knots();
    }
    bool linked() const { return linked_; }
    /// Whether a view says them: they were edited, or read from one that does.
    bool chosen() const { return chosen_; }
    /// Those that the plot has where nobody has chosen any; otherwise nothing changes.
    void setOfPlot(const Curve& volume, const Curve& points);
    /// Takes both as chosen, and unlinks them.
    void take(std::vector<Curve::Knot> volume, std::vector<Curve::Knot> points);
    /// What was chosen is so no more; setOfPlot() says what there is then.
    void leaveToPlot() { chosen_ = false; }
    /// Linking makes the points follow the volume; unlinked again, they have the curve of their own that they
    /// had before, if there was one.
    void setLinked(bool linked);

    /// Moves a knot, held between its neighbours and within [0, 1].
    void move(Which which, std::size_t knot, Curve::Knot to);
    /// Adds a knot on either curve and returns its index.
    std::size_t insert(Which which, Curve::Knot at);
    /// Removes a knot; the last one stays.
    void remove(Which which, std::size_t knot);

    /// Fills curves and `linked`; leaves colours, sizes and opacities alone.
    void write(proto::ParticlesStyle& style) const;
    /// Takes the curves of a style that has been parsed without error.
    void read(const proto::ParticlesStyle& style);

    bool operator==(const TransferFunctions&) const = default;

  private:
    /// An edit of the points is one of the volume while they are linked.
    KnotCurve& edited(Which which) { return linked_ || which == Which::volume ? volume_ : points_; }
    bool isOpposite(Which which) const { return linked_ && which == Which::points; }
    void moveOpposite(std::size_t knot, Curve::Knot to);
    void follow();

    KnotCurve volume_;
    KnotCurve points_;
    std::vector<Curve::Knot> ownPoints_;  // while they are linked: those before, or none
    bool linked_ = true;
    bool chosen_ = false;
};

}  // namespace mote::client
