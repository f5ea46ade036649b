// SPDX-License-Identifier: GPL-3.0-or-later
//
// An exposure is what one frame of a film is made from: one view, or several whose pictures are averaged in
// linear light, as by a shutter that stays open (motion blur) and by samples within a pixel. Values; any
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/shared/decode.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/film/film.h"

namespace mote::client {

struct ExposureSettings {
    unsigned samples = 1;  ///< of a pixel: 1, 4, 9 or 16, on a square grid
    double shutterDegrees =
        0.0;                 ///< of the time from one frame to the next, of 360, that the shutter is open
    unsigned subframes = 8;  ///< pictures of the time that it is open, 1 to 64

    bool blurs() const { return shutterDegrees > 0.0 && subframes > 1; }
    /// Views of one frame.
    std::size_t views() const { return blurs() ? subframes : 1; }
    /// The root of samples.
    unsigned side() const;
};

/// Errors: invalidArgument, with the name of the field: samples that are no such square, a shutter outside
/// [0, 360], subframes outside [1, 64].
Status checkExposure(const ExposureSettings& settings);

/// The views that make a frame, settings.views() of them. Errors: invalidArgument, unsupported (motion blur
/// of a script of single views; a view that is too large with so many samples).
Result<std::vector<proto::View>> viewsOf(const Film& film, std::size_t frame,
                                         const ExposureSettings& settings);

/// Pixels as SRGB8; alpha is 255.
FramePixels asBytes(FramePixels pixels);

/// The pictures of one frame's views become its picture.
class Exposure {
  public:
    /// `side`: pixels of a picture that become one, along each axis.
    explicit Exposure(unsigned side) : side_(side) {}

    /// Takes pictures of one size, that is a multiple of `side`, and of one format (our own invariants).
    void add(FramePixels pixels);
    /// The mean, in the format of what was added; a single picture of one sample as it came. Once, after
    /// add().
    FramePixels take();

  private:
    void begin(const FramePixels& pixels);
    void accumulate(const FramePixels& pixels);

    unsigned side_;
    std::size_t count_ = 0;
    FramePixels first_;        // while it is the only one
    std::vector<float> sums_;  // linear RGB of the frame's pixels
};

}  // namespace mote::client
