// SPDX-License-Identifier: GPL-3.0-or-later
//
// Quantity: a number that each particle of a run has, made ready from the name that people give: a column of
// the run, a row of the table (known_quantity.h) or an expression over these (expression.h). Wherever numbers
// of particles are named, they are found and made here. An immutable value; any number of threads, each with
// a Scratch of its own.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/quantity/expression.h"
#include "protocol/quantity/known_quantity.h"

namespace mote {

/// What there is to make quantities from.
struct RunColumns {
    struct Column {
        std::string name, unit;
    };
    std::vector<Column> columns;
    double mass = 0.0;              ///< as BeamContext::mass
    bool photons = false;           ///< as BeamContext::photons
    std::string_view what = "run";  ///< for messages: "run" or "dataset"
    std::string_view massHint;      ///< how to give a mass that is missing, in brackets
};

class Quantity {
  public:
    /// A thread's memory.
    struct Scratch {
        std::vector<std::vector<double>> parts;
        std::vector<std::span<const double>> columns, operands;
        Expression::Scratch expression;
    };

    /// A name that is an expression in its form alone is checked; what it names the run knows. Errors:
    /// invalidArgument, at no place.
    static Status checkForm(std::string_view name);
    /// Errors, at no place: notFound (a column that the run does not have, a mass that is not known; in an
    /// expression with the position), invalidArgument (no expression).
    static Result<Quantity> make(std::string_view name, const RunColumns& run);

    const std::string& name() const { return name_; }  ///< as it was given
    const std::string& unit() const { return unit_; }  ///< "" where it cannot be told
    /// Indices into the run's columns that it is made from, each once.
    const std::vector<std::size_t>& columns() const { return columns_; }
    /// Whether its values are a column as it is.
    bool isColumn() const { return !expression_ && !parts_.front().known; }
    /// Whether BeamContext's means are needed.
    bool needsMeans() const;

    /// `columns` as columns() names them, all of `out`'s size.
    void evaluate(KnownQuantity::Columns columns, const BeamContext& context, Scratch& scratch,
                  std::span<double> out) const;

  private:
    struct Part {
        const KnownQuantity* known = nullptr;  ///< null: a column as it is
        std::vector<std::size_t> columns;      ///< indices into columns_
        std::string unit;
    };
    Result<Part> makePart(std::string_view name, const RunColumns& run);
    Status makeExpression(const RunColumns& run);
    std::size_t need(std::size_t column);
    static void evaluatePart(const Part& part, KnownQuantity::Columns columns, const BeamContext& context,
                             Scratch& scratch, std::span<double> out);

    std::string name_, unit_;
    std::vector<std::size_t> columns_;
    std::vector<Part> parts_;  ///< one, or those that the expression names
    std::optional<Expression> expression_;
};

/// The unit of a quantity of the run; "" where there is none of this name or it cannot be told.
std::string unitOfQuantity(std::string_view name, const RunColumns& run);

/// "x,hypot(x,y),'a,b'" between commas that lie within no parenthesis and no quote.
std::vector<std::string> splitNames(std::string_view text);

/// The name of a quantity as a message gives it. Errors: invalidArgument at the field: empty, too long, with
/// a control character, or the form of an expression and none.
Result<std::string> checkColumnName(const std::string& name, std::string_view field);

}  // namespace mote
