// SPDX-License-Identifier: GPL-3.0-or-later
//
// How many particles a species has, and which of its records do not fit that.
#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "preprocess/readers/openpmd/species.h"

namespace mote::prep {
namespace {

// Where every component is a constant, nothing in the file's size bears out the number of particles.
constexpr std::uint64_t maxConstantRows = 1ull << 22;

}  // namespace

/// What cannot be read is missing, and said so: one odd record is no reason to give up a run. Where nothing
/// else is there, its error is that of the step.
Status OpenpmdSpecies::drop(const std::string& record, const Error& error) {
    if (error.code == ErrorCode::cancelled) return error;
    if (!problem_) problem_ = error;
    notes_.push_back("record '" + record + "' is left out: " + error.message);
    constexpr std::pair<std::string_view, Column> columns[] = {
        {"position/x", Column::x},  {"position/y", Column::y},  {"position/z", Column::z},
        {"momentum/x", Column::px}, {"momentum/y", Column::py}, {"momentum/z", Column::pz},
        {"time", Column::t}};
    for (const auto& [name, column] : columns) {
        if (name == record) broken_[static_cast<std::size_t>(column)] = true;
    }
    return success();
}

/// How many rows most records have, empty ones left out; equally many of two lengths are a contradiction.
Result<std::uint64_t> OpenpmdSpecies::mostRows(const std::vector<Member>& all) const {
    std::map<std::uint64_t, std::size_t> lengths;
    for (const Member& member : all) {
        if (member.get().constant()) continue;
        ++lengths[*member.get().rows()];
    }
    std::uint64_t rows = 0;
    std::size_t most = 0;
    for (const auto& [length, count] : lengths) {
        if (length == 0 || count <= most) continue;
        most = count;
        rows = length;
    }
    const auto rival = std::find_if(lengths.begin(), lengths.end(), [&](const auto& other) {
        return other.first != 0 && other.first != rows && other.second == most;
    });
    if (rival == lengths.end()) return rows;
    for (const Member& member : all) {
        if (member.get().constant() || *member.get().rows() != rival->first) continue;
        return Error{
            ErrorCode::corrupt, member.get().where(),
            "has " + std::to_string(rival->first) + " values where others have " + std::to_string(rows)};
    }
    return rows;
}

std::vector<OpenpmdSpecies::Member> OpenpmdSpecies::members() {
    std::vector<Member> all;
    const auto add = [&](std::string name, std::optional<OpenpmdComponent>& component, Quantity* quantity) {
        if (component) all.push_back({std::move(name), &component, quantity});
    };
    std::vector<Quantity*> quantities;
    for (auto* group : {&position_, &momentum_}) {
        for (Quantity& quantity : *group) quantities.push_back(&quantity);
    }
    quantities.insert(quantities.end(), {&positionT_, &momentumT_, &timeRecord_, &total_});
    for (Quantity* quantity : quantities) {
        add(quantity->name, quantity->value, quantity);
        add(quantity->name, quantity->offset, quantity);
    }
    add("weighting", weighting_, nullptr);
    add("weight", charge_, nullptr);
    add("particleStatus", status_, nullptr);
    add("id", id_, nullptr);
    add("mass", massRecord_, nullptr);
    add("charge", chargeRecord_, nullptr);
    return all;
}

/// The number of particles. A constant has its value whatever its shape says, so shapes count only where
/// nothing else does. A record that is longer or shorter than the others is left out.
Status OpenpmdSpecies::checkRows() {
    const std::vector<Member> all = members();
    if (all.empty() && problem_) return *problem_;
    const bool constants =
        std::all_of(all.begin(), all.end(), [](const Member& member) { return member.get().constant(); });
    if (constants) return takeConstantRows(all);
    MOTE_ASSIGN_OR_RETURN(rows_, mostRows(all));
    for (const Member& member : all) {
        if (!member.component->has_value() || member.get().constant()) continue;
        const std::uint64_t rows = *member.get().rows();
        if (rows == rows_) continue;
        const Error error{ErrorCode::corrupt, member.get().where(),
                          rows == 0 ? "is empty"
                                    : "has " + std::to_string(rows) + " values where there are " +
                                          std::to_string(rows_) + " particles"};
        MOTE_RETURN_IF_ERROR(drop(member.name, error));
        if (member.quantity != nullptr)
            *member.quantity = {};
        else
            member.component->reset();
    }
    return success();
}

Status OpenpmdSpecies::takeConstantRows(const std::vector<Member>& all) {
    const OpenpmdComponent* longest = nullptr;
    for (const Member& member : all) {
        if (!member.get().rows()) continue;
        if (longest == nullptr || *member.get().rows() > *longest->rows()) longest = &member.get();
    }
    if (longest == nullptr) return success();
    rows_ = *longest->rows();
    if (rows_ <= maxConstantRows) return success();
    return corrupt(longest->where(),
                   "declares " + std::to_string(rows_) + " particles, but every record is a constant");
}

}  // namespace mote::prep
