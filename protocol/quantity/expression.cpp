// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <optional>

#include "protocol/base/near_names.h"
#include "protocol/quantity/expression_kernel.h"

namespace mote {
namespace {

using Op = Expression::Operation;
using Place = std::uint16_t;

// Which of the three kinds a place counts, in its highest bits.
constexpr Place kindBits = 0xc000, nameKind = 0, constantKind = 0x4000, madeKind = 0x8000;

constexpr std::size_t pieceRows = 1024;

struct Function {
    std::string_view name;
    Op operation;
    int arguments;
};
constexpr std::array functions{
    Function{"abs", Op::abs, 1},      Function{"sqrt", Op::sqrt, 1},   Function{"exp", Op::exp, 1},
    Function{"log", Op::log, 1},      Function{"log10", Op::log10, 1}, Function{"sin", Op::sin, 1},
    Function{"cos", Op::cos, 1},      Function{"tan", Op::tan, 1},     Function{"asin", Op::asin, 1},
    Function{"acos", Op::acos, 1},    Function{"atan", Op::atan, 1},   Function{"sinh", Op::sinh, 1},
    Function{"cosh", Op::cosh, 1},    Function{"tanh", Op::tanh, 1},   Function{"floor", Op::floor, 1},
    Function{"ceil", Op::ceil, 1},    Function{"round", Op::round, 1}, Function{"sign", Op::sign, 1},
    Function{"hypot", Op::hypot, 2},  Function{"atan2", Op::atan2, 2}, Function{"min", Op::least, 2},
    Function{"max", Op::greatest, 2}, Function{"where", Op::where, 3}};

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

bool beginsName(char c) {
    // Bytes beyond ASCII are letters of some language.
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
           static_cast<unsigned char>(c) >= 0x80;
}

}  // namespace

/// Reads from left to right and writes the steps as it goes: what is made lies on a stack of places.
class ExpressionParser {
  public:
    explicit ExpressionParser(std::string_view text) : text_(text) { made_.text_ = std::string(text); }

    Result<Expression> run() {
        if (text_.size() > Expression::longest)
            return fail(Expression::longest, fmt::format("is longer than {} bytes", Expression::longest));
        MOTE_ASSIGN_OR_RETURN(made_.result_, either());
        if (peek() != '\0')
            return fail(at_, fmt::format("\"{}\" does not belong there", text_.substr(at_, 1)));
        if (made_.names_.empty()) return fail(0, "no column is named");
        return std::move(made_);
    }

  private:
    using Read = Result<Place>;

    static Error fail(std::size_t position, std::string_view what) {
        return invalid("", fmt::format("at {}: {}", position + 1, what));
    }

    char peek() {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool take(std::string_view sign) {
        if (peek() == '\0' || text_.substr(at_, sign.size()) != sign) return false;
        at_ += sign.size();
        return true;
    }
    bool takeWord(std::string_view word) {
        peek();
        const auto end = at_ + word.size();
        if (text_.substr(at_, word.size()) != word) return false;
        if (end < text_.size() && (beginsName(text_[end]) || isDigit(text_[end]))) return false;
        at_ = end;
        return true;
    }

    Place emit(Op operation, Place a, Place b = 0, Place c = 0, int arguments = 2) {
        const auto frees = [](Place place, bool taken) {
            return static_cast<Place>(taken && (place & kindBits) == madeKind ? 1 : 0);
        };
        live_ = static_cast<Place>(live_ - frees(a, true) - frees(b, arguments > 1 && b != a) -
                                   frees(c, arguments > 2));
        const auto to = static_cast<Place>(live_++ | madeKind);
        made_.made_ = std::max(made_.made_, live_);
        made_.steps_.push_back({operation, a, b, c, to});
        return to;
    }

    Place constant(double value) {
        made_.constants_.push_back(value);
        return static_cast<Place>((made_.constants_.size() - 1) | constantKind);
    }

    Read either() {
        if (++depth_ > Expression::deepest) return fail(at_, "too much lies within each other");
        MOTE_ASSIGN_OR_RETURN(Place left, both());
        while (takeWord("or")) {
            MOTE_ASSIGN_OR_RETURN(const Place right, both());
            left = emit(Op::either, left, right);
        }
        --depth_;
        return left;
    }
    Read both() {
        MOTE_ASSIGN_OR_RETURN(Place left, inverse());
        while (takeWord("and")) {
            MOTE_ASSIGN_OR_RETURN(const Place right, inverse());
            left = emit(Op::both, left, right);
        }
        return left;
    }
    Read inverse() {
        if (!takeWord("not")) return comparison();
        if (++depth_ > Expression::deepest) return fail(at_, "too much lies within each other");
        MOTE_ASSIGN_OR_RETURN(const Place inner, inverse());
        --depth_;
        return emit(Op::notTrue, inner, 0, 0, 1);
    }
    std::optional<Op> takeComparison() {
        static constexpr std::array<std::pair<std::string_view, Op>, 6> signs{{{"<=", Op::lessEqual},
                                                                               {">=", Op::greaterEqual},
                                                                               {"==", Op::equal},
                                                                               {"!=", Op::unequal},
                                                                               {"<", Op::less},
                                                                               {">", Op::greater}}};
        for (const auto& [sign, operation] : signs) {
            if (take(sign)) return operation;
        }
        return std::nullopt;
    }
    Read comparison() {
        MOTE_ASSIGN_OR_RETURN(const Place left, sum());
        const auto operation = takeComparison();
        if (!operation) return left;
        MOTE_ASSIGN_OR_RETURN(const Place right, sum());
        const auto place = at_;
        if (takeComparison()) return fail(place, "comparisons make no chain; write a < b and b < c");
        return emit(*operation, left, right);
    }
    Read sum() {
        MOTE_ASSIGN_OR_RETURN(Place left, product());
        while (true) {
            const bool adds = take("+");
            if (!adds && !take("-")) return left;
            MOTE_ASSIGN_OR_RETURN(const Place right, product());
            left = emit(adds ? Op::add : Op::subtract, left, right);
        }
    }
    Read product() {
        MOTE_ASSIGN_OR_RETURN(Place left, withSign());
        while (true) {
            const char sign = peek();
            if ((sign != '*' && sign != '/' && sign != '%') || !take({&text_[at_], 1})) return left;
            MOTE_ASSIGN_OR_RETURN(const Place right, withSign());
            left = emit(sign == '*' ? Op::multiply : sign == '/' ? Op::divide : Op::modulo, left, right);
        }
    }
    Read withSign() {
        const bool minus = peek() == '-';
        if (!take("-") && !take("+")) return power();
        if (++depth_ > Expression::deepest) return fail(at_, "too much lies within each other");
        MOTE_ASSIGN_OR_RETURN(const Place inner, withSign());
        --depth_;
        return minus ? emit(Op::negate, inner, 0, 0, 1) : inner;
    }
    /// The exponent may have a sign and a power of its own: 2^-x^2 is 2^(-(x^2)).
    Read power() {
        MOTE_ASSIGN_OR_RETURN(const Place base, atom());
        if (!take("^") && !take("**")) return base;
        if (++depth_ > Expression::deepest) return fail(at_, "too much lies within each other");
        MOTE_ASSIGN_OR_RETURN(const Place exponent, withSign());
        --depth_;
        const bool square =
            (exponent & kindBits) == constantKind && made_.constants_[exponent & ~kindBits] == 2.0;
        return square ? emit(Op::multiply, base, base) : emit(Op::power, base, exponent);
    }

    Read atom() {
        const char first = peek();
        if (first == '\0') return fail(at_, "something is missing");
        if (isDigit(first) || first == '.') return number();
        if (first == '\'' || first == '"') return quoted(first);
        if (beginsName(first)) return word();
        const auto open = at_;
        if (!take("(")) return fail(at_, fmt::format("\"{}\" does not belong there", first));
        MOTE_ASSIGN_OR_RETURN(const Place inner, either());
        if (!take(")")) return fail(open, "this parenthesis is not closed");
        return inner;
    }
    Read number() {
        double value = 0.0;
        const auto* const begin = text_.data() + at_;
        const auto [end, code] = std::from_chars(begin, text_.data() + text_.size(), value);
        if (code != std::errc()) return fail(at_, "is no number");
        at_ += static_cast<std::size_t>(end - begin);
        if (at_ < text_.size() && beginsName(text_[at_]))
            return fail(at_, "a sign is missing after the number");
        return constant(value);
    }
    Read quoted(char quote) {
        const auto begin = at_ + 1, end = text_.find(quote, begin);
        if (end == std::string_view::npos) return fail(at_, "this quote is not closed");
        const auto name = text_.substr(begin, end - begin);
        const auto place = std::exchange(at_, end + 1);
        if (name.empty()) return fail(place, "a name is missing");
        return this->name(name, place);
    }
    Read word() {
        const auto begin = at_;
        while (at_ < text_.size() && (beginsName(text_[at_]) || isDigit(text_[at_]))) ++at_;
        const auto word = text_.substr(begin, at_ - begin);
        if (peek() == '(') return call(word, begin);
        if (word == "pi") return constant(std::numbers::pi);
        return name(word, begin);
    }
    Read name(std::string_view name, std::size_t place) {
        auto& names = made_.names_;
        const auto found = std::ranges::find(names, name, &Expression::Name::text);
        const auto index = static_cast<Place>(found - names.begin());
        if (found != names.end()) return static_cast<Place>(index | nameKind);
        if (names.size() == Expression::mostNames)
            return fail(place, fmt::format("more than {} columns are named", Expression::mostNames));
        names.push_back({std::string(name), place});
        return static_cast<Place>(index | nameKind);
    }
    Read call(std::string_view name, std::size_t place) {
        const auto* const function = std::ranges::find(functions, name, &Function::name);
        if (function == functions.end()) {
            std::vector<std::string_view> all;
            for (const auto& each : functions) all.push_back(each.name);
            return fail(place, fmt::format("there is no function \"{}\"{}", name, nearNames(name, all)));
        }
        take("(");
        std::array<Place, 3> arguments{};
        for (int i = 0; i < function->arguments; ++i) {
            if (i > 0 && !take(",")) return fail(at_, wanted(*function));
            MOTE_ASSIGN_OR_RETURN(arguments.at(static_cast<std::size_t>(i)), either());
        }
        if (!take(")")) return fail(at_, wanted(*function));
        return emit(function->operation, arguments[0], arguments[1], arguments[2], function->arguments);
    }
    static std::string wanted(const Function& function) {
        return fmt::format("{} is of {} value{} and ends with \")\"", function.name, function.arguments,
                           function.arguments == 1 ? "" : "s");
    }

    std::string_view text_;
    std::size_t at_ = 0, depth_ = 0;
    Place live_ = 0;
    Expression made_;
};

Result<Expression> Expression::parse(std::string_view text) {
    return ExpressionParser(text).run();
}

bool Expression::looksLikeOne(std::string_view text) {
    return !std::ranges::all_of(text, [](char c) { return beginsName(c) || isDigit(c); });
}

namespace {

/// Nothing: a number, which has the unit of what it is added to or compared with.
using UnitOfPart = std::optional<std::string>;

std::string plainUnit(const UnitOfPart& unit) {
    return unit.value_or("1");
}

/// The one unit of two; "" where they differ.
UnitOfPart commonUnit(const UnitOfPart& a, const UnitOfPart& b) {
    if (!a || !b) return a ? a : b;
    return *a == *b ? a : "";
}

UnitOfPart unitAfter(Op operation, const UnitOfPart& a, const UnitOfPart& b, const UnitOfPart& c) {
    switch (operation) {
        case Op::add:
        case Op::subtract:
        case Op::modulo:
        case Op::least:
        case Op::greatest:
        case Op::hypot:
            return commonUnit(a, b);
        case Op::negate:
        case Op::abs:
        case Op::floor:
        case Op::ceil:
        case Op::round:
            return a;
        case Op::where:
            return commonUnit(b, c);
        case Op::divide:
            return plainUnit(a) == plainUnit(b) && !plainUnit(a).empty() ? "1" : "";
        case Op::multiply:
        case Op::power:
            return plainUnit(a) == "1" && plainUnit(b) == "1" ? "1" : "";
        case Op::atan2:
            return commonUnit(a, b) == UnitOfPart("") ? "" : "rad";
        case Op::asin:
        case Op::acos:
        case Op::atan:
            return plainUnit(a) == "1" ? "rad" : "";
        case Op::sqrt:
            return plainUnit(a) == "1" ? "1" : "";
        default:  // comparisons, and functions whose values are numbers
            return "1";
    }
}

}  // namespace

std::string Expression::unit(std::span<const std::string> units) const {
    std::vector<UnitOfPart> made(made_);
    const auto of = [&](Place place) -> UnitOfPart {
        const auto index = static_cast<std::size_t>(place & ~kindBits);
        if ((place & kindBits) == constantKind) return std::nullopt;
        return (place & kindBits) == madeKind ? made[index] : UnitOfPart(units[index]);
    };
    for (const auto& step : steps_) {
        const auto result = unitAfter(step.operation, of(step.a), of(step.b), of(step.c));
        made[static_cast<std::size_t>(step.to & ~kindBits)] = result;
    }
    return plainUnit(of(result_));
}

void Expression::evaluate(std::span<const std::span<const double>> columns, Scratch& scratch,
                          std::span<double> out) const {
    scratch.resize(std::max(scratch.size(), (constants_.size() + made_) * pieceRows));
    const auto place = [&](std::size_t i) { return scratch.data() + i * pieceRows; };
    for (std::size_t i = 0; i < constants_.size(); ++i) std::fill_n(place(i), pieceRows, constants_[i]);
    for (std::size_t begin = 0; begin < out.size(); begin += pieceRows) {
        const auto count = std::min(pieceRows, out.size() - begin);
        const auto from = [&](Place of) -> const double* {
            const auto index = static_cast<std::size_t>(of & ~kindBits);
            if ((of & kindBits) == nameKind) return columns[index].data() + begin;
            return place((of & kindBits) == constantKind ? index : constants_.size() + index);
        };
        for (const auto& step : steps_) {
            const auto index = static_cast<std::size_t>(step.to & ~kindBits);
            double* const to =
                &step == &steps_.back() ? out.data() + begin : place(constants_.size() + index);
            runOperation(step.operation, from(step.a), from(step.b), from(step.c), to, count);
        }
        if (steps_.empty()) std::copy_n(from(result_), count, out.data() + begin);
    }
}

}  // namespace mote
