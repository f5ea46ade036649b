// SPDX-License-Identifier: GPL-3.0-or-later
//
// Images for tests: even, smooth, noisy, of one pixel, of high range, of odd shapes and averaged down. Pure
// functions.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "storage/image/image_file.h"

namespace mote::test {

std::span<const std::string_view> imageForms();

/// `form`: one of imageForms(). The same in every step.
std::shared_ptr<const storage::ColorImage> imageOf(const std::string& form, std::uint32_t number);

}  // namespace mote::test
