// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/run_steps.h"

namespace mote::storage {

Error withoutColumns(std::string where) {
    return {
        ErrorCode::notFound, std::move(where),
        "the dataset was made without columns, so there are no numbers beside its points; making it again "
        "with mote-prep particles keeps them"};
}

Error withoutIds(std::string where) {
    return {
        ErrorCode::notFound, std::move(where),
        "the dataset has no ids of particles, as its source has none, so that particles cannot be told from "
        "each other or followed from step to step"};
}

}  // namespace mote::storage
