// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/depth_sections.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mote::render {
namespace {

// Neighbours whose slabs differ by no more are cut alike, the coarser one more finely than it needs: a
// section costs more than some slabs do.
constexpr double alike = 2.0;

/// A part of the depth, and the thickest slabs that what lies in it allows.
struct Part {
    double nearDepth, farDepth, thickness;
};

bool longEnough(const DepthRange& range) {
    return range.farDepth - range.nearDepth > 1e-300;
}

std::vector<double> bordersOf(std::span<const DepthRange> contents) {
    std::vector<double> borders;
    for (const auto& range : contents) {
        if (!longEnough(range)) continue;
        borders.push_back(range.nearDepth);
        borders.push_back(range.farDepth);
    }
    std::sort(borders.begin(), borders.end());
    borders.erase(std::unique(borders.begin(), borders.end()), borders.end());
    return borders;
}

/// Infinite where nothing is; where nothing needs cuts, all of it.
double thicknessWithin(std::span<const DepthRange> contents, double nearDepth, double farDepth) {
    double thickness = std::numeric_limits<double>::infinity();
    for (const auto& range : contents) {
        if (range.nearDepth > nearDepth || range.farDepth < farDepth || !longEnough(range)) continue;
        const double own = range.slabs > 0 ? (range.farDepth - range.nearDepth) / range.slabs
                                           : std::numeric_limits<double>::max();
        thickness = std::min(thickness, own);
    }
    return thickness;
}

std::vector<Part> partsOf(std::span<const DepthRange> contents) {
    std::vector<Part> parts;
    const auto borders = bordersOf(contents);
    for (std::size_t i = 1; i < borders.size(); ++i) {
        const Part part{borders[i - 1], borders[i], thicknessWithin(contents, borders[i - 1], borders[i])};
        if (!std::isfinite(part.thickness)) continue;
        const bool joined = !parts.empty() && parts.back().farDepth == part.nearDepth &&
                            parts.back().thickness <= alike * part.thickness &&
                            part.thickness <= alike * parts.back().thickness;
        if (joined) {
            parts.back().farDepth = part.farDepth;
            parts.back().thickness = std::min(parts.back().thickness, part.thickness);
        } else {
            parts.push_back(part);
        }
    }
    return parts;
}

/// Slabs of a part, each `coarser` times as thick as it allows.
double slabsOf(const Part& part, double coarser) {
    // A little less, so that rounding makes no further one.
    return std::max(1.0, std::ceil((part.farDepth - part.nearDepth) / (part.thickness * coarser) - 1e-6));
}

double slabsOf(const std::vector<Part>& parts, double coarser) {
    double sum = 0.0;
    for (const auto& part : parts) sum += slabsOf(part, coarser);
    return sum;
}

}  // namespace

std::vector<DepthSection> depthSections(std::span<const DepthRange> contents) {
    const auto parts = partsOf(contents);
    double coarser = 1.0;
    while (slabsOf(parts, coarser) > mostSlabs) coarser *= 1.25;
    std::vector<DepthSection> sections;
    std::uint32_t first = 0;
    for (const auto& part : parts) {
        const auto slabs = static_cast<std::uint32_t>(slabsOf(part, coarser));
        sections.push_back({part.nearDepth, part.farDepth, first, slabs});
        first += slabs;
    }
    return sections;
}

float SlabBends::steepest() const {
    float most = 1.0F;
    for (const auto& bend : bends) most = std::max(most, bend.slope);
    return most;
}

SlabBends slabBends(std::span<const DepthSection> sections, double nearDepth, double farDepth) {
    std::size_t begin = 0;
    while (begin + 1 < sections.size() && sections[begin].farDepth <= nearDepth) ++begin;
    std::size_t end = begin + 1;
    while (end < sections.size() && sections[end].nearDepth < farDepth) ++end;
    const DepthSection& first = sections[begin];
    SlabBends result{first, sections[end - 1].endSlab() - first.firstSlab, {}};
    for (std::size_t i = begin + 1; i < end; ++i) {
        result.bends.push_back(
            {static_cast<float>((sections[i].nearDepth - first.nearDepth) / first.thickness()),
             static_cast<float>(sections[i].firstSlab - first.firstSlab),
             static_cast<float>(first.thickness() / sections[i].thickness())});
    }
    return result;
}

double slabOf(std::span<const DepthSection> sections, double depth) {
    for (const auto& section : sections) {
        if (depth < section.nearDepth) return section.firstSlab;
        if (depth <= section.farDepth) return section.slabOf(depth);
    }
    return sections.back().endSlab();
}

double depthAt(std::span<const DepthSection> sections, double slab) {
    const auto* section = &sections.front();
    for (const auto& next : sections.subspan(1)) {
        if (slab >= next.firstSlab) section = &next;
    }
    const double within = std::clamp(slab - section->firstSlab, 0.0, static_cast<double>(section->slabs));
    return section->nearDepth + within * section->thickness();
}

}  // namespace mote::render
