// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumbersControls: what the panel of numbers remembers that is no part of the view. A value; main thread.
#pragma once

#include <array>
#include <string>

#include "client/view/numbers/histogram_view.h"
#include "client/view/numbers/picture_tool.h"
#include "client/view/numbers/selection_edits.h"
#include "protocol/scene/error.h"

namespace mote::client {

struct NumbersControls {
    PictureTool tool;
    Combine combine = Combine::fresh;
    bool follow = true;  ///< what is made now holds its particles in all steps, where they have ids
    HistogramView histogram;
    bool histogramShown = false;
    bool allStatistics = false;
    std::string series = "norm_emit_x";  ///< the statistic that is plotted
    std::string message;                 ///< the last failure, one sentence
    std::array<char, 257> typedName{};   ///< of the chosen selection
    std::string typedFor;                ///< the name that it was typed for

    void say(const Status& status) { message = status.ok() ? std::string() : status.error().toString(); }
};

}  // namespace mote::client
