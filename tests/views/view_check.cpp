// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/view_check.h"

#include <exception>
#include <stdexcept>

#include "tests/views/bytes_check.h"
#include "tests/views/difference_check.h"
#include "tests/views/dissolve_check.h"
#include "tests/views/survival_check.h"

namespace mote::test {

Verdict ViewCheck::check(const proto::View& view) {
    try {
        return examine(view);
    } catch (const std::exception& failure) {
        Verdict verdict{.kind = Verdict::Kind::broken};
        verdict.text = failure.what();
        return verdict;
    }
}

std::unique_ptr<ViewCheck> viewCheckOf(const std::string& check, const std::string& device) {
    if (check == "difference") return std::make_unique<DifferenceCheck>(drawerOf(device));
    if (check == "survival") return std::make_unique<SurvivalCheck>(drawerOf(device));
    if (check == "bytes") return std::make_unique<BytesCheck>();
    if (check == "dissolve") return std::make_unique<DissolveCheck>(drawerOf(device));
    throw std::invalid_argument("there are no checks but difference, survival, bytes and dissolve");
}

}  // namespace mote::test
