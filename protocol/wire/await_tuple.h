// SPDX-License-Identifier: GPL-3.0-or-later
//
// awaitTuple: how coroutines wait for Asio: what is waited for returns its error code and values, and throws
// nothing. Its name moved between the versions that are built with (1.22 and 1.30). A constant.
#pragma once

#include <asio/experimental/as_tuple.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/version.hpp>

namespace mote::wire {

#if ASIO_VERSION >= 102400
inline constexpr auto awaitTuple = asio::as_tuple(asio::use_awaitable);
#else
inline constexpr auto awaitTuple = asio::experimental::as_tuple(asio::use_awaitable);
#endif

}  // namespace mote::wire
