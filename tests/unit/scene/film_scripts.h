// SPDX-License-Identifier: GPL-3.0-or-later
//
// Scripts of films that nobody chose, and small ones written in a test. Pure functions.
#pragma once

#include <cstdint>
#include <string_view>

#include "protocol/mote.pb.h"
#include "protocol/scene/film/film.h"
#include "tests/support/random.h"

namespace mote::test {

/// A legal view with every field of the schema: generatedView() (tests/views), and what that leaves out.
proto::View anyView(std::uint64_t seed, std::uint64_t number);

/// Keyframes of views of one size, whose layers partly are the same with other styles, places and steps,
/// partly come and go. Steps are alike where they do not blend. Never more layers than a view may have.
proto::Script anyKeyframes(std::uint64_t seed, std::uint64_t number);
/// A view and its moves.
proto::Script anyMoves(std::uint64_t seed, std::uint64_t number);

/// Keyframes of a camera around things of size one, without layers, each from anywhere.
proto::Script anyCameraWay(Random& random, int keyframes);
/// The same, of a camera that goes round, up and down, nearer and farther.
proto::Script anyJourney(Random& random, int keyframes);

/// All that a script shows, with as many steps.
FilmDatasets datasetsFor(const proto::Script& script, int steps = 3);

/// Apostrophes stand for quotation marks. Throws std::invalid_argument where it is no JSON of a script.
proto::Script scriptOf(std::string_view json);

/// Throws std::invalid_argument, with the error, where there is no such film.
Film filmOf(const proto::Script& script, int steps = 3);

/// The camera at a time.
Camera cameraAt(const Film& film, double seconds);

}  // namespace mote::test
