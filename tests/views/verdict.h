// SPDX-License-Identifier: GPL-3.0-or-later
//
// Verdict: what a check says of one view, and its line of text, by which a process tells another. A value.
#pragma once

#include <limits>
#include <string>

#include "protocol/base/error.h"

namespace mote::test {

struct Verdict {
    enum class Kind {
        measured,   ///< the picture is there; how good it is, `psnr` and `worst` say
        undecided,  ///< the reference leaves open what is right
        broken,     ///< an exception that is none of a device, a picture of the wrong size
        dead,       ///< the process ended
    };
    Kind kind = Kind::measured;
    double psnr = std::numeric_limits<double>::infinity();  ///< dB, of the pixels that are not in doubt
    int worst = 0;          ///< of 255, the greatest difference in a channel of these
    double doubtful = 0.0;  ///< share of the pixels
    bool blank = false;     ///< nothing is seen but background
    double samples = 0.0;   ///< a cell, of the reference
    double referenceSeconds = 0.0, deviceSeconds = 0.0;
    std::string pictures = "-";  ///< a hash of all that a device drew, where a check tells it: no spaces
    std::string text = {};       ///< what went wrong

    std::string toLine() const;
    /// Errors: invalidArgument.
    static Result<Verdict> parse(const std::string& line);
};

}  // namespace mote::test
