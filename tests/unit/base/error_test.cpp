// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/error.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <memory>
#include <set>

#include "protocol/base/system_error.h"

namespace mote {
namespace {

TEST(Error, PathsAreNestedWithDotsButForIndices) {
    const Error error{ErrorCode::invalidArgument, "[1]", "is wrong"};
    EXPECT_EQ(error.within("volume.curve").where, "volume.curve[1]");
    EXPECT_EQ(error.within("volume.curve").within("particles").within("layers[0]").where,
              "layers[0].particles.volume.curve[1]");
    EXPECT_EQ(error.within("").where, "[1]");
    const Error whole{ErrorCode::invalidArgument, "", "is wrong"};
    EXPECT_EQ(whole.within("camera").where, "camera");
    EXPECT_EQ(whole.toString(), "is wrong");
    EXPECT_EQ(whole.within("camera").toString(), "camera: is wrong");
    EXPECT_EQ(error.within("a").code, error.code);
}

TEST(Error, CodesHaveDifferentNames) {
    std::set<std::string_view> names;
    for (int code = 0; code <= static_cast<int>(ErrorCode::internal); ++code) {
        names.insert(name(static_cast<ErrorCode>(code)));
    }
    EXPECT_EQ(names.size(), static_cast<std::size_t>(ErrorCode::internal) + 1);
    EXPECT_EQ(name(ErrorCode::invalidArgument), "invalid_argument");
}

TEST(Result, HoldsAValueOrAnError) {
    Result<int> good = 3;
    ASSERT_TRUE(good.ok());
    EXPECT_EQ(*good, 3);
    *good = 4;
    EXPECT_EQ(good.value(), 4);
    const Result<int> bad = Error{ErrorCode::notFound, "a", "b"};
    EXPECT_FALSE(bad);
    EXPECT_EQ(bad.error().where, "a");
    EXPECT_TRUE(success().ok());
}

TEST(Result, MovesWhatCannotBeCopied) {
    Result<std::unique_ptr<int>> result = std::make_unique<int>(5);
    const auto owned = *std::move(result);
    EXPECT_EQ(*owned, 5);
}

TEST(Result, AnErrorMayBeTheValue) {
    // Two alternatives of one type: the constructor decides.
    const Result<std::string> text = std::string("fine");
    EXPECT_TRUE(text.ok());
}

Status passOn(const Status& status) {
    MOTE_RETURN_IF_ERROR(status);
    return Error{ErrorCode::internal, "", "went on"};
}

TEST(Result, TheMacroReturnsTheErrorOnly) {
    EXPECT_EQ(passOn(Error{ErrorCode::cancelled, "x", "y"}).error().code, ErrorCode::cancelled);
    EXPECT_EQ(passOn(success()).error().message, "went on");
}

Status passOnFrom(const Status& status, const std::string& place) {
    MOTE_RETURN_IF_ERROR(status, place + "[2]");
    return success();
}

TEST(Result, TheMacroSaysThePlaceThatAnErrorLiesWithin) {
    EXPECT_EQ(passOnFrom(Error{ErrorCode::cancelled, "x", "y"}, "steps").error().where, "steps[2].x");
    EXPECT_TRUE(passOnFrom(success(), "steps").ok());
}

Result<int> twice(Result<std::unique_ptr<int>> first, const Result<int>& second) {
    MOTE_ASSIGN_OR_RETURN(const auto number, std::move(first));
    int other = 0;
    MOTE_ASSIGN_OR_RETURN(other, second);
    return *number + other;
}

TEST(Result, TheOtherMacroTakesTheValueToo) {
    EXPECT_EQ(*twice(std::make_unique<int>(5), 2), 7);
    const Error error{ErrorCode::notFound, "a", "b"};
    EXPECT_EQ(twice(error, 2).error().code, ErrorCode::notFound);
    EXPECT_EQ(twice(std::make_unique<int>(5), error).error().where, "a");
}

TEST(SystemError, SaysWhatTheKernelSaysUnderOurCode) {
    const auto error = systemError(ENOENT, "run.h5", "cannot be opened");
    EXPECT_EQ(error.code, ErrorCode::notFound);
    EXPECT_EQ(error.toString(), "run.h5: cannot be opened: No such file or directory");
    EXPECT_EQ(systemError(EACCES, "", "").code, ErrorCode::permissionDenied);
    EXPECT_EQ(systemError(ELOOP, "", "").code, ErrorCode::permissionDenied);
    EXPECT_EQ(systemError(EEXIST, "", "").code, ErrorCode::alreadyExists);
    EXPECT_EQ(systemError(ENOSPC, "", "").code, ErrorCode::resourceExhausted);
    EXPECT_EQ(systemError(EIO, "", "").code, ErrorCode::internal);
}

TEST(Result, TheWrongHalfIsABrokenInvariant) {
    const Result<int> good = 3;
    const Result<int> bad = Error{};
    EXPECT_THROW(static_cast<void>(good.error()), BrokenInvariant);
    EXPECT_THROW(static_cast<void>(bad.value()), BrokenInvariant);
}

}  // namespace
}  // namespace mote
