// SPDX-License-Identifier: GPL-3.0-or-later
//
// Expression: a formula over named columns as people write it, "hypot(x, y)*1e3", checked once and then made
// for block after block of particles: numbers, names, + - * / % ^, comparisons, and/or/not and the functions
// of docs/NUMBERS.md. There is nothing in it that loops, assigns or reads, and its size is bounded, so that
// whoever sends one can do no harm. An immutable value; any number of threads, each with a Scratch of its
// own.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace mote {

class Expression {
  public:
    static constexpr std::size_t longest = 512;  ///< bytes
    static constexpr std::size_t deepest = 32;   ///< of parentheses and the like within each other
    static constexpr std::size_t mostNames = 16;

    enum class Operation : std::uint8_t;
    /// A name, and where it first stands, counted from 0.
    struct Name {
        std::string text;
        std::size_t position = 0;
    };
    /// A thread's memory.
    using Scratch = std::vector<double>;

    /// Errors: invalidArgument, with the position and what is wrong there, at no place.
    static Result<Expression> parse(std::string_view text);

    /// Whether the text is more than a name: has a sign in it that no plain name has.
    static bool looksLikeOne(std::string_view text);

    const std::vector<Name>& names() const { return names_; }  ///< in their order
    const std::string& text() const { return text_; }
    /// Its unit where the names have these: of sums, ratios and the like; "" where that cannot be told, as of
    /// "energy*1e-9".
    std::string unit(std::span<const std::string> units) const;

    /// `columns` by name, all of `out`'s size.
    void evaluate(std::span<const std::span<const double>> columns, Scratch& scratch,
                  std::span<double> out) const;

    /// One step: operands and result are the names, then the constants, then what was made before.
    struct Step {
        Operation operation;
        std::uint16_t a = 0, b = 0, c = 0, to = 0;
    };

  private:
    friend class ExpressionParser;
    std::string text_;
    std::vector<Name> names_;
    std::vector<double> constants_;
    std::vector<Step> steps_;  ///< those of names and constants count from 0 on, in this order
    std::uint16_t result_ = 0;
    std::uint16_t made_ = 0;  ///< places for what steps make
};

}  // namespace mote
