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
        addCounts();
        for (const auto name : spreads) {
            add("mean_Q", name, "weighted mean");
            add("sigma_Q", name, "sqrt(<(Q - mean)²>)");
            add("min_Q", name, "least value of the particles that count, whatever their weight");
            add("max_Q", name, "greatest value of the particles that count, whatever their weight");
        }
        for (std::size_t i = 0; i < paired.size(); ++i) {
            for (std::size_t j = i + 1; j < paired.size(); ++j) addCovariance(paired[i], paired[j]);
        }
        addEmittances();
        for (const std::string plane : {"x", "y"}) addTransverse(plane, {plane, "p" + plane, "pz"});
        addLongitudinal();
        for (const std::string plane : {"x", "y", "z"}) {
            const Names columns{plane, "p" + plane};
            add("halo_h_U", plane, "1", columns, "<U⁴>/<U²>² - 2");
            add("halo_H_U", plane, "1", columns,
                "sqrt(3 I4)/(2 I2) - 2, I2 = <U²><pU²> - <U pU>², I4 = <U⁴><pU⁴> + 3 "
                "<U² pU²>² - 4 <U pU³><U³ pU>");
        }
        return std::move(all_);
    }

  private:
    /// "norm_emit_U" of x, made from columns of the run.
    void add(std::string_view family, const std::string& plane, std::string_view unit, Names columns,
             std::string_view definition) {
        std::string name(family);
        const auto at = name.find_first_of("QUV");
        if (at != std::string::npos) name.replace(at, 1, plane);
        Names of;
        if (at != std::string::npos) of.push_back(plane);
        all_.push_back(
            {std::move(name), std::string(unit), std::move(of), std::move(columns), family, definition});
    }
    /// Of one quantity, in its unit.
    void add(std::string_view family, std::string_view quantity, std::string_view definition) {
        const auto& known = *findKnownQuantity(quantity);
        add(family, std::string(quantity), known.unit, Names(known.columns.begin(), known.columns.end()),
            definition);
    }
    void addCovariance(std::string_view first, std::string_view second) {
        const auto &a = *findKnownQuantity(first), &b = *findKnownQuantity(second);
        Names columns(a.columns.begin(), a.columns.end());
        columns.insert(columns.end(), b.columns.begin(), b.columns.end());
        all_.push_back({fmt::format("cov_{}__{}", first, second), unitOfProduct(a.unit, b.unit),
                        Names{std::string(first), std::string(second)}, std::move(columns), "cov_A__B",
                        "<(A - mean)(B - mean)>; `cov_B__A` is the same"});
    }
    void addCounts() {
        add("n_particle", "", "1", {}, "particles that take part");
        add("n_finite", "", "1", {},
            "of these, those that count: every number rests on them, except those of the next line");
        add("n_slope", "", "1", {},
            "of these, those whose slopes are finite (pz is not 0): `xp`, `yp`, `emit_x`, `emit_y`, and "
            "Twiss "
            "parameters and dispersion in x and y rest on them");
        add("n_lost", "", "1", {}, "particles that the source marks as lost, whether they take part or not");
        add("charge", "", "C", {},
            "sum of the weights; if weights count real particles, times the magnitude of a particle's charge "
            "(`particleCharge` of the manifest; 0 for photons, neutrons and other neutral `species`; "
            "otherwise e); null if their unit is not known");
    }
    void addEmittances() {
        const Names planes{"x", "y", "z"};
        for (const auto& plane : planes)
            add("norm_emit_U", plane, "m", {plane, "p" + plane},
                "normalised rms emittance, sqrt(<U²><pU²> - <U pU>²)/m");
        add("norm_emit_4d", "", "m^2", {"x", "px", "y", "py"},
            "sqrt(det Σ)/m², Σ the covariances of x px y py");
        all_.back().of = {"x", "y"};
        constexpr std::pair<std::string_view, std::string_view> shares[]{
            {"emit90_action_U",
             "normalised rms emittance of the particles of smallest single-particle action that hold 90% of "
             "the weight"},
            {"emit95_action_U", "the same for 95% of the weight"},
            {"emit99_action_U", "the same for 99% of the weight"}};
        for (const auto& plane : planes) {
            for (const auto& [family, definition] : shares)
                add(family, plane, "m", {plane, "p" + plane}, definition);
        }
    }
    void addTransverse(const std::string& plane, const Names& columns) {
        add("emit_V", plane, "m", columns,
            "geometric, with slopes: sqrt(<V²><Vp²> - <V Vp>²). openPMD-beamphysics: "
            "`twiss_emit_x` in its table");
        add("twiss_alpha_V", plane, "1", columns, "-<V Vp>/`emit_V`, including dispersion");
        add("twiss_beta_V", plane, "m", columns, "<V²>/`emit_V`, including dispersion");
        add("twiss_gamma_V", plane, "1/m", columns, "<Vp²>/`emit_V`, including dispersion");
        add("twiss_eta_V", plane, "m", columns,
            "dispersion: <V delta>/<delta²>, with delta relative to the mean momentum of these particles");
        add("twiss_etap_V", plane, "1", columns, "dispersion of the slope: <Vp delta>/<delta²>");
        add("emit_V_no_dispersion", plane, "m", columns,
            "sqrt(B G - A²), where B = <V²> - <V delta>²/<delta²>, G = <Vp²> - <Vp "
            "delta>²/<delta²>, A = <V Vp> - <V delta><Vp delta>/<delta²>");
        add("twiss_alpha_V_no_dispersion", plane, "1", columns, "-A/`emit_V_no_dispersion`");
        add("twiss_beta_V_no_dispersion", plane, "m", columns, "B/`emit_V_no_dispersion`");
        add("twiss_gamma_V_no_dispersion", plane, "1/m", columns, "G/`emit_V_no_dispersion`");
    }
    void addLongitudinal() {
        const Names columns{"z", "px", "py", "pz"};
        const auto add = [&](std::string_view family, std::string_view unit, std::string_view definition) {
            this->add(family, "z", unit, columns, definition);
            all_.back().of = {"z"};
        };
        add("emit_z", "m", "sqrt(<z²><delta²> - <z delta>²)");
        add("twiss_alpha_z", "1", "-<z delta>/`emit_z`");
        add("twiss_beta_z", "m", "<z²>/`emit_z`");
        add("twiss_gamma_z", "1/m", "<delta²>/`emit_z`");
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
