// SPDX-License-Identifier: GPL-3.0-or-later
//
// A QualityController decides how good a picture may be if it is to be ready in time. It learns what a point
// and a pixel cost from the pictures that were rendered, whatever device, view and data they came from. One
// per session, as views differ; used by the thread that renders.
//
// The model is t = a * points + b * pixel work: what the device was calibrated to, then fitted by least
// squares to the latest pictures (each counts less than the next).
//
// The share of points that is drawn takes few values and clings to the one it has, so that points do not come
// and go while the view turns, and what is selected for one picture serves the next. The resolution falls as
// soon as pictures take too long, and rises again only after a row of pictures that would all have been ready
// in time: each time that it rose too early, the row is twice as long.
#pragma once

#include <cstdint>

#include "server/render/device.h"
#include "server/render/plan/quality.h"

namespace mote::server {

/// What the exact picture of a view would take.
struct ViewLoad {
    double pixels = 0.0;
    double points = 0.0;  ///< of particles
    double previewShare =
        0.0;  ///< share of the points that comes from previews, at far less than its part of the cost
};

class QualityController {
  public:
    explicit QualityController(double budgetMs = 30.0) : budgetMs_(budgetMs) {}

    /// What knows the same and has another time for a picture.
    QualityController within(double budgetMs) const;

    /// What the device was found to cost; of no effect once a picture was learned from.
    void startFrom(const render::DeviceCosts& costs);

    /// The quality for a view in motion: ready within the budget, as far as we know; exact where that is so
    /// cheap.
    render::Quality quick(const ViewLoad& load);
    /// The quality between quick and exact: a few budgets, full resolution.
    render::Quality intermediate(const ViewLoad& load) const;
    /// Whether the exact picture takes so long that an intermediate one is worth its time.
    bool worthIntermediate(const ViewLoad& load) const;
    double expectedMs(const ViewLoad& load, const render::Quality& quality) const;

    /// A picture of `pixels` (of the payload) and `points` drawn at this quality took `ms`.
    void learn(double pixels, double points, const render::Quality& quality, double ms);

    double budgetMs() const { return budgetMs_; }
    double msPerMillionPoints() const { return perPoint_; }
    double msPerMillionPixels() const { return perPixel_; }

  private:
    double fractionWithin(const ViewLoad& load, const render::Quality& quality, double budgetMs) const;
    double steadyShare(double wanted, double previewShare);
    std::uint32_t divisorWithin(double pixelMs) const;
    std::uint32_t steadyLevel(std::uint32_t wanted);
    std::uint32_t lightDivisor(const ViewLoad& load, double wanted) const;
    void solve();

    double budgetMs_;
    /// Of the last quick picture: what its width and height are divided by for its time; 0: it was exact.
    std::uint32_t level_ = 1;
    std::uint32_t patience_ = 0;      ///< pictures that a finer level must have fitted before it is taken
    std::uint32_t calm_ = 0;          ///< pictures in a row that it has fitted
    std::uint32_t over_ = 0;          ///< quick pictures in a row that took longer than the budget
    std::uint32_t lightDivisor_ = 1;  ///< as the level, for its points' light
    render::Quality lastQuick_;
    double lastPoints_ = 0.0;  // that were drawn
    double lastShare_ = 0.0;   // the last quick picture with fewer points had it; 0: there was none
    bool learned_ = false;
    double perPoint_ = 25.0;  // ms a million points
    double perPixel_ = 40.0;  // ms a million pixels of exact work
    // Sums of the normal equations: points^2, points * work, work^2, points * t, work * t.
    double pp_ = 0.0, pw_ = 0.0, ww_ = 0.0, pt_ = 0.0, wt_ = 0.0;
};

}  // namespace mote::server
