// SPDX-License-Identifier: GPL-3.0-or-later
//
// A hierarchy of five points with known moves, and datasets of it. Values and plain functions of one test.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::test {

/// Points 0 to 4 on a line at x = 0.1, 0.3, ..., removed in the order 2, 0, 4, 1, 3. Point 1 moves by 0.1
/// when 2 goes (in x), when 0 goes (in y) and when 4 goes (in x); point 3 when 2 goes (in -x) and when 1 goes
/// (in y).
storage::StippleHierarchy smallHierarchy();

/// A manifest of kind "stipple" for it.
proto::Manifest manifestOf(const storage::StippleHierarchy& hierarchy);

/// side x side points of a jittered grid in random order, which never move: even enough for pictures.
storage::StippleHierarchy jitteredGrid(int side);

/// Publishes "NAME.mote"; throws StorageError.
void writeDataset(const std::filesystem::path& output, const storage::StippleHierarchy& hierarchy,
                  const proto::Manifest& manifest);

}  // namespace mote::test
