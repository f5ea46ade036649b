// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/odd_steps.h"

#include <string>

namespace mote::prep {

Status OddSteps::add(const Status& opened) {
    if (opened.ok()) return opened;
    const ErrorCode code = opened.error().code;
    if (code != ErrorCode::corrupt && code != ErrorCode::unsupported && code != ErrorCode::notFound) {
        return opened;
    }
    if (!first_) first_ = opened.error();
    ++count_;
    return success();
}

Status OddSteps::finish(bool anyRead, Progress& progress) const {
    if (!first_) return success();
    if (!anyRead) return *first_;
    progress.note((count_ == 1 ? std::string("a step cannot be read and is left out: ")
                               : std::to_string(count_) +
                                     " steps cannot be read and are left out, the first of them: ") +
                  first_->toString());
    return success();
}

}  // namespace mote::prep
