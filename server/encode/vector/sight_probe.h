// SPDX-License-Identifier: GPL-3.0-or-later
//
// SightProbe finds a Sight by pictures: where a pixel is probed at a depth by something black that covers it
// whole, it shows the light that lies before it; by something white, what comes through besides. One place of
// a pixel can be probed at a time, so it takes a few pairs of pictures: of the deepest place, of the nearest,
// then between two that differ. One owner, one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/encode/vector/sight.h"
#include "server/render/plan/picture.h"

namespace mote::server {

class SightProbe {
  public:
    /// `places` in any order. `width`: of the picture.
    SightProbe(std::uint32_t width, std::vector<SightPlace> places);

    /// What is to be probed next, at most one place a pixel; empty: all is known.
    const std::vector<SightPlace>& wanted() const { return wanted_; }
    /// The pictures, linear, of black and white at all wanted places. Then others are wanted.
    void learn(const render::Picture& black, const render::Picture& white);
    /// All that is known. Once.
    Sight take();
    std::uint64_t bytes() const;

  private:
    std::size_t endOfPixel(std::size_t begin) const;
    void choose();
    bool fill(std::size_t begin, std::size_t end);
    void guess(std::size_t begin, std::size_t end);

    std::uint32_t width_;
    std::vector<SightPlace> places_;
    std::vector<InFront> inFront_;     // of each place
    std::vector<std::uint8_t> known_;  // likewise
    std::vector<SightPlace> wanted_;
    std::vector<std::size_t> indices_;  // of those that are wanted
    int pictures_ = 0;                  // pairs, so far
};

}  // namespace mote::server
