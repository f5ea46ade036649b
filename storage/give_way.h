// SPDX-License-Identifier: GPL-3.0-or-later
//
// Threads that load ahead give way to those that draw. Any thread, of itself.
#pragma once

namespace mote::storage {

/// The calling thread gets about a tenth of what one gets that draws. Where that is refused, they are equals.
void giveWay();

}  // namespace mote::storage
