// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointHits: which points, dots, surfaces and strokes touch which pixels, at what depth and opacity
// (docs/PICTURE.md, "Points", "Dots", "Meshes", "Strokes"). Made once for a picture; immutable, safe on any
// number of threads.
#pragma once

#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "server/render/layers/ink/lower_ink.h"
#include "server/render/layers/scene.h"
#include "tests/reference/hit.h"
#include "tests/reference/image_hits.h"
#include "tests/reference/mesh_hits.h"
#include "tests/reference/reference_renderer.h"
#include "tests/reference/sight_hits.h"
#include "tests/reference/stroke_hits.h"

namespace mote::reference {

/// The hits of one row of pixels.
class RowHits {
  public:
    /// Front to back; equal depths by layer, then surfaces, strokes, images last.
    std::span<const Hit> of(std::uint32_t column) const {
        return std::span(hits_).subspan(begin_[column], begin_[column + 1] - begin_[column]);
    }

  private:
    friend class PointHits;
    std::vector<Hit> hits_;
    std::vector<std::size_t> begin_;  // of each pixel's hits, and the end
};

class PointHits {
  public:
    /// Both must outlive it.
    PointHits(const render::Scene& scene, const Options& options);

    RowHits row(std::uint32_t row) const;
    /// One a pixel: see Picture::ambiguous.
    const std::vector<std::uint8_t>& ambiguous() const { return ambiguous_; }

  private:
    /// A point or a dot on the screen.
    struct Spot {
        std::uint32_t layer;  ///< or, after all layers, the dot
        double depth;
        double alpha;         ///< before coverage
        double layerOpacity;  ///< of a point's layer; of a dot's it is in `alpha`
        glm::dvec3 color;
        double value;       ///< of a point by which it is coloured, a share of the map; NaN: none
        bool highlighted;   ///< a point that is drawn over the others of its layer
        double x, y;        ///< pixels
        double reach;       ///< beyond which, across and down, nothing is covered; 0: within one pixel
        double tau = -1.0;  ///< of a lit point: optical depth where it covers all; below 0: it has `alpha`

        /// Of a pixel of which so much is covered, before its layer fades.
        double depthOf(double covered) const;
    };

    void addLayer(const render::Scene& scene, std::uint32_t layer);
    void addDots(const render::Scene& scene);
    void addInk(const render::Scene& scene, std::uint32_t layer);
    /// The look of one of a layer's points.
    struct Look {
        double size, opacity;
        glm::dvec3 color;
        double area =
            0.0;  ///< of a lit point of the mean weight: its optical area, square units of the world
    };
    static Look lookOf(const View& view, const glm::dmat4& transform, const ParticlesStyle& style);
    void addHighlight(const render::Scene& scene, std::uint32_t layer);
    void addPaths(const render::Scene& scene, std::uint32_t layer);
    void addContrast(const render::Scene& scene);
    /// `depth`: where it stands; absent: at its own. `value`: as Spot's.
    void addPoint(const View& view, std::uint32_t layer, const Look& look, const glm::dvec3& inEye,
                  std::optional<double> depth, double value, double weight = 1.0);
    /// How a layer's points have their colours, if they have values.
    struct LayerColors {
        ColorMap map = ColorMap::standard();
        bool nearest = false;
    };
    /// The colours of the points of a row's pixels, by what their values are.
    class RowColors;
    void markAmbiguous(double px, double py);
    void markHalfCovered(double px, double py, double radius);
    void sort();
    static double coverage(const Spot& spot, double column, double row);

    std::uint32_t width_, height_;
    const View& view_;
    const PlaceOf& placeOf_;                        // may be empty
    std::vector<LayerColors> colors_;               // by layer
    std::vector<Spot> spots_;                       // front to back
    std::vector<std::vector<std::uint32_t>> rows_;  // of each row, the spots that may touch it, front to back
    std::vector<MeshHits> meshes_;
    std::vector<SightHits> sights_;
    std::vector<ImageHits> images_;        // the last in front
    std::deque<render::InkDrawing> inks_;  // of the scene's layers
    std::deque<render::Strokes> paths_;    // likewise
    render::Fragments contrast_;
    std::vector<StrokeHits> strokes_;
    std::vector<std::uint8_t> ambiguous_;
};

}  // namespace mote::reference
