// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/query_parts.h"

#include <fmt/format.h>

#include "protocol/quantity/quantity.h"

namespace mote::server {

Status checkNames(const google::protobuf::RepeatedPtrField<std::string>& names) {
    constexpr int mostNames = 256;
    if (names.size() > mostNames)
        return Error{ErrorCode::invalidArgument, "names", fmt::format("there are more than {}", mostNames)};
    for (int i = 0; i < names.size(); ++i)
        MOTE_RETURN_IF_ERROR(checkColumnName(names[i], fmt::format("names[{}]", i)));
    return success();
}

Result<storage::StepNumbers> StepQuestion::numbers() const {
    MOTE_ASSIGN_OR_RETURN(auto numbers, run_->step(step_));
    if (!numbers.columns) return storage::withoutColumns("dataset");
    return numbers;
}

Result<SelectionResults::Mask> StepQuestion::chosen() const {
    auto mask = context_.selections.points(run_, step_, selection_, cancelled_);
    MOTE_RETURN_IF_ERROR(mask, "select");
    return mask;
}

Result<SelectionResults::Ids> StepQuestion::ids() const {
    auto ids = context_.selections.ids(run_, step_, selection_, cancelled_);
    MOTE_RETURN_IF_ERROR(ids, "select");
    return ids;
}

}  // namespace mote::server
