// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particle steps of generated views: from none to some thousand particles, with volumes that no particles
// would make. Pure functions.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "tests/support/memory_step.h"

namespace mote::test {

std::span<const std::string_view> particleForms();

/// `form`: one of particleForms().
std::shared_ptr<const MemoryStep> particleStep(const std::string& form, std::uint32_t number,
                                               std::uint32_t step);

}  // namespace mote::test
