// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a program says on stderr. All that may hold a text of others (of a server, a dataset, a file's name)
// goes through here, so that none of it is obeyed by the terminal. Any thread.
#pragma once

#include <exception>
#include <string_view>

namespace mote {

/// One line, "PROGRAM: SENTENCE", its control characters shown and not written.
void complain(std::string_view program, std::string_view sentence);

/// What a program ends with where an exception reached its main(). Takes no memory where `failure` says that
/// there is none. Call it within the handler.
void complainAtEnd(const char* program, const std::exception& failure) noexcept;

}  // namespace mote
