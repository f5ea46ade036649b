// SPDX-License-Identifier: GPL-3.0-or-later
//
// Error and Result: what untrusted bytes become instead of an exception. An Error has a code, the place (a
// field's path, a file, a position) and one sentence that its reader can act on. Values, free of threads.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "protocol/base/mote_check.h"

namespace mote {

enum class ErrorCode {
    invalidArgument,    ///< a field or option is wrong
    notFound,           ///< a dataset, file, record or job does not exist
    alreadyExists,      ///< an output is there already
    permissionDenied,   ///< the kernel or the token says no
    corrupt,            ///< bytes differ from their digest, or contradict their format
    unsupported,        ///< well-formed, but not something we read or draw
    resourceExhausted,  ///< memory, disk or a stated limit
    cancelled,          ///< on request
    internal,           ///< a device or system failure
};

/// The code's name on the wire: "invalid_argument", "not_found", ...
std::string_view name(ErrorCode code);

struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string where;     ///< "views[0].layers[0].step", "run.h5:/data/3/particles", ""
    std::string message;   ///< one sentence, no full stop needed
    bool passing = false;  ///< the place is to blame, as where a disk is full: it may go well later

    /// "WHERE: MESSAGE", for people.
    std::string toString() const;
    /// The same error with a place put before its own: "views[0]" + "camera" = "views[0].camera".
    Error within(std::string_view outer) const;
};

/// The errors that are most made: their code by name, the place and one sentence.
Error invalid(std::string_view where, std::string message);
Error notFound(std::string_view where, std::string message);
Error corrupt(std::string_view where, std::string message);
Error unsupported(std::string_view where, std::string message);
Error wasCancelled(std::string message = "cancelled");

/// A value or the Error that took its place.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }

    T& value() & { return MOTE_CHECK(ok()), std::get<0>(state_); }
    const T& value() const& { return MOTE_CHECK(ok()), std::get<0>(state_); }
    T&& value() && { return MOTE_CHECK(ok()), std::get<0>(std::move(state_)); }
    const Error& error() const { return MOTE_CHECK(!ok()), std::get<1>(state_); }

    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

  private:
    std::variant<T, Error> state_;
};

/// Success without a value.
using Status = Result<std::monostate>;
inline Status success() {
    return std::monostate{};
}

}  // namespace mote

/// Returns the Error of a Result expression from the enclosing function, if it has one; with a second
/// argument, the place that it lies within.
#define MOTE_RETURN_IF_ERROR(expression, ...)                                          \
    do {                                                                               \
        if (auto&& moteStatus = (expression); !moteStatus.ok()) {                      \
            return ::mote::Error(moteStatus.error()) __VA_OPT__(.within(__VA_ARGS__)); \
        }                                                                              \
    } while (false)

/// Declares or sets what a Result expression holds, or returns its Error from the enclosing function:
/// MOTE_ASSIGN_OR_RETURN(const auto file, openRegular(path)).
#define MOTE_ASSIGN_OR_RETURN(declaration, ...) \
    MOTE_ASSIGN_OR_RETURN_BY(MOTE_RESULT_AT(__LINE__), declaration, (__VA_ARGS__))
#define MOTE_ASSIGN_OR_RETURN_BY(result, declaration, expression) \
    auto result = expression;                                     \
    if (!result.ok()) return result.error();                      \
    declaration = *std::move(result)
#define MOTE_RESULT_AT(line) MOTE_RESULT_AT_LINE(line)
#define MOTE_RESULT_AT_LINE(line) moteResult##line
