// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/statistic.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace mote {
namespace {

using Names = std::vector<std::string>;

constexpr std::array<std::string_view, 13> spreads{"x",      "y",     "z", "t",  "px", "py",   "pz",
                                                   "energy", "gamma", "p", "xp", "yp", "delta"};
constexpr std::array<std::string_view, 8> paired{"x", "px", "y", "py", "z", "pz", "t", "energy"};
constexpr std::array<std::string_view, 4> kindsOfOne{"mean", "sigma", "min", "max"};
constexpr std::string_view covariance = "cov_", between = "__";

std::string unitOfProduct(std::string_view a, std::string_view b) {
    if (a.empty() || b.empty()) return {};
    if (a == "1") return std::string(b);
    if (b == "1") return std::string(a);
    if (a != b) return fmt::format("{} {}", a, b);
    return a.find('/') == std::string_view::npos ? fmt::format("{}^2", a) : fmt::format("({})^2", a);
}

class StatisticTable {
  public:
    std::vector<Statistic> make() {
        for (const auto* name : {"n_particle", "n_finite", "n_slope", "n_lost"}) add(name, "1", {}, {});
        add("charge", "C", {}, {});
        for (const auto name : spreads) {
            for (const auto kind : kindsOfOne) addOf(fmt::format("{}_{}", kind, name), {name});
        }
        for (std::size_t i = 0; i < paired.size(); ++i) {
            for (std::size_t j = i + 1; j < paired.size(); ++j)
                addOf(fmt::format("cov_{}__{}", paired[i], paired[j]), {paired[i], paired[j]});
        }
        addEmittances();
        addTransverse("x");
        addTransverse("y");
        addLongitudinal();
        for (const std::string plane : {"x", "y", "z"}) {
            for (const auto* kind : {"halo_h_", "halo_H_"})
                add(kind + plane, "1", {plane}, {plane, "p" + plane});
        }
        return std::move(all_);
    }

  private:
    void add(std::string name, std::string_view unit, Names of, Names columns) {
        all_.push_back({std::move(name), std::string(unit), std::move(of), std::move(columns)});
    }
    /// In the unit of one quantity, or the product of two.
    void addOf(std::string name, const std::vector<std::string_view>& quantities) {
        Names columns;
        for (const auto quantity : quantities) {
            for (const auto column : findKnownQuantity(quantity)->columns) columns.emplace_back(column);
        }
        const std::string_view unit = findKnownQuantity(quantities.front())->unit;
        add(std::move(name),
            quantities.size() == 1 ? std::string(unit)
                                   : unitOfProduct(unit, findKnownQuantity(quantities.back())->unit),
            Names(quantities.begin(), quantities.end()), std::move(columns));
    }
    void addTwiss(const std::string& ending, const std::string& plane, const Names& columns) {
        add("twiss_alpha_" + ending, "1", {plane}, columns);
        add("twiss_beta_" + ending, "m", {plane}, columns);
        add("twiss_gamma_" + ending, "1/m", {plane}, columns);
    }
    void addEmittances() {
        const Names planes{"x", "y", "z"};
        for (const auto& plane : planes) add("norm_emit_" + plane, "m", {plane}, {plane, "p" + plane});
        add("norm_emit_4d", "m^2", {"x", "y"}, {"x", "px", "y", "py"});
        for (const auto& plane : planes) {
            for (const int percent : {90, 95, 99})
                add(fmt::format("emit{}_action_{}", percent, plane), "m", {plane}, {plane, "p" + plane});
        }
    }
    void addTransverse(const std::string& plane) {
        const Names columns{plane, "p" + plane, "pz"};
        const auto ending = plane + "_no_dispersion";
        add("emit_" + plane, "m", {plane}, columns);
        addTwiss(plane, plane, columns);
        add("twiss_eta_" + plane, "m", {plane}, columns);
        add("twiss_etap_" + plane, "1", {plane}, columns);
        add("emit_" + ending, "m", {plane}, columns);
        addTwiss(ending, plane, columns);
    }
    void addLongitudinal() {
        const Names columns{"z", "px", "py", "pz"};
        add("emit_z", "m", {"z"}, columns);
        addTwiss("z", "z", columns);
    }

    std::vector<Statistic> all_;
};

}  // namespace

std::span<const Statistic> statistics() {
    static const auto all = StatisticTable().make();
    return all;
}

std::optional<std::size_t> findStatistic(std::string_view name) {
    const auto all = statistics();
    const auto place = [&](std::string_view wanted) -> std::optional<std::size_t> {
        const auto found = std::ranges::find(all, wanted, &Statistic::name);
        if (found == all.end()) return std::nullopt;
        return static_cast<std::size_t>(found - all.begin());
    };
    if (const auto found = place(name)) return found;
    const auto middle = name.find(between, covariance.size());
    if (!name.starts_with(covariance) || middle == std::string_view::npos) return std::nullopt;
    return place(fmt::format("cov_{}__{}", name.substr(middle + between.size()),
                             name.substr(covariance.size(), middle - covariance.size())));
}

std::optional<QuantityStatistic> parseQuantityStatistic(std::string_view name) {
    const auto middle = name.find(between, covariance.size());
    if (name.starts_with(covariance) && middle != std::string_view::npos) {
        const auto first = name.substr(covariance.size(), middle - covariance.size());
        const auto second = name.substr(middle + between.size());
        if (first.empty() || second.empty()) return std::nullopt;
        return QuantityStatistic{"cov", {std::string(first), std::string(second)}};
    }
    for (const auto kind : kindsOfOne) {
        if (name.size() > kind.size() + 1 && name.starts_with(kind) && name[kind.size()] == '_')
            return QuantityStatistic{kind, {std::string(name.substr(kind.size() + 1))}};
    }
    return std::nullopt;
}

void setMeans(const std::function<double(std::string_view name)>& statistic, BeamContext& context) {
    for (std::size_t i = 0; i < context.mean.size(); ++i)
        context.mean[i] = statistic(fmt::format("mean_{}", knownQuantities()[i].name));
    context.meanMomentum = statistic("mean_p");
}

std::string QuantityStatistic::unit(std::span<const std::string> units) const {
    return units.size() == 1 ? units[0] : unitOfProduct(units[0], units[1]);
}

}  // namespace mote
