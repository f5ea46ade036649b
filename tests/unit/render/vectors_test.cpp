// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/vectors.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cctype>
#include <string>

#include "server/render/device.h"

namespace mote::render {
namespace {

/// The environment's own choice comes back with the end of a test.
class VectorsTest : public testing::Test {
  protected:
    VectorsTest() {
        if (const char* asked = ::getenv("MOTE_VECTORS")) asked_ = asked;
    }
    ~VectorsTest() override {
        asked_ ? ::setenv("MOTE_VECTORS", asked_->c_str(), 1) : ::unsetenv("MOTE_VECTORS");
        useVectorsOfEnvironment();
    }

    std::optional<std::string> asked_;
};

TEST_F(VectorsTest, EachKindThatIsHereCanBeNamedAndUsed) {
    ASSERT_FALSE(vectorNames().empty());
    for (const auto& name : vectorNames()) {
        ::setenv("MOTE_VECTORS", name.c_str(), 1);
        useVectorsOfEnvironment();
        EXPECT_EQ(vectorName(), name);
    }
    ::unsetenv("MOTE_VECTORS");
    useVectorsOfEnvironment();
    EXPECT_EQ(vectorName(), vectorNames().front());
}

TEST_F(VectorsTest, CaseIsNothing) {
    for (const auto& name : vectorNames()) {
        std::string lower = name;
        for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        ASSERT_TRUE(vectorsNamed(name));
        EXPECT_EQ(vectorsNamed(lower), vectorsNamed(name));
    }
}

TEST_F(VectorsTest, WhatIsNotHereIsSaidWithWhatIs) {
    ::setenv("MOTE_VECTORS", "abacus", 1);
    try {
        useVectorsOfEnvironment();
        FAIL();
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("abacus"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find(vectorNames().front()), std::string::npos);
    }
}

}  // namespace
}  // namespace mote::render
