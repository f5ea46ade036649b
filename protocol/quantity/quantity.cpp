// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/quantity.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/base/near_names.h"

namespace mote {
namespace {

std::optional<std::size_t> columnNamed(std::string_view name, const RunColumns& run) {
    const auto found = std::ranges::find(run.columns, name, &RunColumns::Column::name);
    if (found == run.columns.end()) return std::nullopt;
    return static_cast<std::size_t>(found - run.columns.begin());
}

std::string whatItHas(const RunColumns& run) {
    std::string names;
    for (const auto& column : run.columns)
        names += fmt::format("{}{}", names.empty() ? "" : ", ", column.name);
    return fmt::format("; it has {}", names.empty() ? "none" : names);
}

Error missing(std::string message, const RunColumns& run) {
    return notFound("", std::move(message) + whatItHas(run));
}

Error unknown(std::string_view name, const RunColumns& run) {
    std::vector<std::string_view> all;
    for (const auto& column : run.columns) all.emplace_back(column.name);
    for (const auto& known : knownQuantities()) all.push_back(known.name);
    return missing(
        fmt::format("is neither a column of the {} nor derived from one{}", run.what, nearNames(name, all)),
        run);
}

bool massKnown(const KnownQuantity& known, const RunColumns& run) {
    using enum KnownQuantity::Need;
    if (known.need == massOrPhotons && run.photons) return true;
    return (known.need != mass && known.need != massOrPhotons) || run.mass > 0.0;
}

/// Where particles differ in their mass.
std::optional<std::size_t> columnOfMasses(const RunColumns& run) {
    const auto column = columnNamed("mass", run);
    return column && run.columns[*column].unit == "eV/c^2" ? column : std::nullopt;
}

constexpr std::size_t longestColumn = 64;  // bytes of a plain name

}  // namespace

Status Quantity::checkForm(std::string_view name) {
    if (!Expression::looksLikeOne(name)) return success();
    MOTE_RETURN_IF_ERROR(Expression::parse(name));
    return success();
}

Result<Quantity> Quantity::make(std::string_view name, const RunColumns& run) {
    Quantity quantity;
    quantity.name_ = std::string(name);
    // A column of the source may have a name of any form.
    if (columnNamed(name, run) || !Expression::looksLikeOne(name)) {
        MOTE_ASSIGN_OR_RETURN(auto part, quantity.makePart(name, run));
        quantity.unit_ = part.unit;
        quantity.parts_.push_back(std::move(part));
        return quantity;
    }
    MOTE_ASSIGN_OR_RETURN(quantity.expression_, Expression::parse(name));
    MOTE_RETURN_IF_ERROR(quantity.makeExpression(run));
    return quantity;
}

Status Quantity::makeExpression(const RunColumns& run) {
    std::vector<std::string> units;
    for (const auto& [text, position] : expression_->names()) {
        auto part = makePart(text, run);
        if (!part.ok()) {
            return Error{part.error().code, "",
                         fmt::format("at {}: \"{}\" {}", position + 1, text, part.error().message)};
        }
        units.push_back(part->unit);
        parts_.push_back(*std::move(part));
    }
    unit_ = expression_->unit(units);
    return success();
}

std::size_t Quantity::need(std::size_t column) {
    const auto found = std::ranges::find(columns_, column);
    const auto at = static_cast<std::size_t>(found - columns_.begin());
    if (found == columns_.end()) columns_.push_back(column);
    return at;
}

Result<Quantity::Part> Quantity::makePart(std::string_view name, const RunColumns& run) {
    Part part;
    if (const auto column = columnNamed(name, run)) {
        part.columns.push_back(need(*column));
        part.unit = run.columns[*column].unit;
        return part;
    }
    const auto* const known = findKnownQuantity(name);
    if (known == nullptr) return unknown(name, run);
    std::string lacks;
    for (const auto source : known->columns) {
        const auto column = columnNamed(source, run);
        if (column) part.columns.push_back(need(*column));
        if (!column) lacks += fmt::format("{}{}", lacks.empty() ? "" : ", ", source);
    }
    if (!lacks.empty())
        return missing(fmt::format("needs {}, which the {} does not have", lacks, run.what), run);
    if (!massKnown(*known, run)) {
        const auto masses = columnOfMasses(run);
        if (!masses) {
            return missing(fmt::format("needs the particles' mass, which the {} does not give{}", run.what,
                                       run.massHint),
                           run);
        }
        part.columns.push_back(need(*masses));
    }
    part.known = known;
    part.unit = std::string(known->unit);
    return part;
}

bool Quantity::needsMeans() const {
    using enum KnownQuantity::Need;
    return std::ranges::any_of(parts_, [](const Part& part) {
        return part.known != nullptr && (part.known->need == meanMomentum || part.known->need == means);
    });
}

void Quantity::evaluatePart(const Part& part, KnownQuantity::Columns columns, const BeamContext& context,
                            Scratch& scratch, std::span<double> out) {
    if (part.known == nullptr) {
        std::ranges::copy(columns[part.columns.front()], out.begin());
        return;
    }
    scratch.columns.clear();
    for (const auto column : part.columns) scratch.columns.push_back(columns[column]);
    part.known->formula(scratch.columns, context, out);
}

void Quantity::evaluate(KnownQuantity::Columns columns, const BeamContext& context, Scratch& scratch,
                        std::span<double> out) const {
    if (!expression_) return evaluatePart(parts_.front(), columns, context, scratch, out);
    scratch.parts.resize(std::max(scratch.parts.size(), parts_.size()));
    scratch.operands.clear();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        if (parts_[i].known == nullptr) {
            scratch.operands.push_back(columns[parts_[i].columns.front()]);
            continue;
        }
        auto& values = scratch.parts[i];
        values.resize(std::max(values.size(), out.size()));
        const auto made = std::span(values).first(out.size());
        evaluatePart(parts_[i], columns, context, scratch, made);
        scratch.operands.push_back(made);
    }
    expression_->evaluate(scratch.operands, scratch.expression, out);
}

std::string unitOfQuantity(std::string_view name, const RunColumns& run) {
    const auto made = Quantity::make(name, run);
    return made.ok() ? made->unit() : std::string();
}

std::vector<std::string> splitNames(std::string_view text) {
    std::vector<std::string> names(1);
    int depth = 0;
    char quote = '\0';
    for (const char c : text) {
        if (quote != '\0') {
            if (c == quote) quote = '\0';
        } else if (c == '\'' || c == '"') {
            quote = c;
        } else if (c == '(' || c == ')') {
            depth += c == '(' ? 1 : -1;
        } else if (c == ',' && depth == 0) {
            names.emplace_back();
            continue;
        }
        names.back() += c;
    }
    return names;
}

Result<std::string> checkColumnName(const std::string& name, std::string_view field) {
    if (name.empty()) return invalid(field, "the name of a column is missing");
    const auto longest = Expression::looksLikeOne(name) ? Expression::longest : longestColumn;
    if (name.size() > longest) return invalid(field, fmt::format("is longer than {} bytes", longest));
    for (const unsigned char c : name) {
        if (c < 0x20 || c == 0x7f) return invalid(field, "holds a control character");
    }
    return name;
}

}  // namespace mote
