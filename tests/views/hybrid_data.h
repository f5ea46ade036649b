// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hybrid steps of generated views: machine parts, heads, noise, constants, sheets and single samples, with
// corrections or without, in boxes of every size. Pure functions.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "tests/support/hybrid_scene.h"

namespace mote::test {

std::span<const std::string_view> hybridForms();

/// What a step is made to; the same for all steps of a dataset. `form`: one of hybridForms().
HybridShape hybridShape(const std::string& form, std::uint32_t number);
std::shared_ptr<const render::GridField> hybridStep(const std::string& form, std::uint32_t number,
                                                    std::uint32_t step);

}  // namespace mote::test
